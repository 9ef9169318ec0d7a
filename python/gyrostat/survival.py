# SPDX-License-Identifier: MIT
"""Which faults a flight stack survives, beside which faults anybody could: ``gyrostat survive``.

Every actuator fails in every kind and severity, and if asked a second one after it. What was flown is set beside what
the attainable set says: whether the actuators that are left have, in every direction, more torque than disturbs the
vehicle. Page: docs/campaigns.md
"""

from __future__ import annotations

import io
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import groupby
from pathlib import Path
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from gyrostat.design.feasibility import attainable_after_faults
from gyrostat.errors import InputError, input_errors, suggestion
from gyrostat.experiment import Experiment
from gyrostat.files import replacing, write_text
from gyrostat.scenario import Scenario
from gyrostat.vehicle import Thrusters, all_actuators

Verdict = Literal["saved", "lost though possible", "impossible", "saved though impossible"]
VERDICTS: tuple[Verdict, ...] = ("saved", "lost though possible", "impossible", "saved though impossible")
COLORS = ("#2b8a3e", "#e8890c", "#868e96", "#0b6bcb")
"""Of the verdicts."""

_severity_of: dict[str, str | None] = {
    "loss_of_effectiveness": "remaining",
    "bias": "torque",
    "leak": "fraction",
    "stuck": "torque",
    "hard_over": None,
    "dead": None,
    "lock": None,
}
KINDS = tuple(_severity_of)
"""Kinds of faults, the severity of which is a share: of the effectiveness that is lost, or of the actuator's limit.

Thrusters leak where other actuators have a bias.
"""
SEVERITIES = (0.2, 0.4, 0.6, 0.8, 1.0)
NONE = "none"


@dataclass(frozen=True)
class Strike:
    """One fault: its kind (``none``), actuator, and severity from 0 to 1."""

    kind: str = NONE
    actuator: int = -1
    severity: float = 0.0

    @property
    def name(self) -> str:
        """In words."""
        if self.kind == NONE:
            return NONE
        size = "" if _severity_of[self.kind] is None else f" {self.severity:.3g}"
        return f"{self.kind.replace('_', ' ')}{size}, {self.actuator}"

    def table(self, u_max: NDArray[np.float64], t_on: float) -> dict[str, Any]:
        """As it stands in a scenario."""
        parameter = _severity_of[self.kind]
        size = self.severity
        if parameter == "remaining":
            size = 1.0 - size
        elif parameter == "torque":
            size *= float(u_max[self.actuator])
        return {"type": self.kind, "actuator": self.actuator, "t_on": t_on} | ({parameter: size} if parameter else {})


@dataclass(frozen=True)
class Case:
    """What became of a stack under one or two faults.

    Attributes
    ----------
    stack
        Its label.
    first, second
        The faults.
    status
        How the flight ended.
    error
        Largest pointing error over the last tenth, rad.
    torque
        That the faults leave in every direction, N m; negative where zero torque is out of reach.
    verdict
        One of `VERDICTS`.
    """

    stack: str
    first: Strike
    second: Strike
    status: str
    error: float
    torque: float
    verdict: Verdict


@dataclass(frozen=True)
class Survival:
    """The map of a vehicle and some stacks.

    Attributes
    ----------
    cases
        All of them, stack by stack.
    limit
        Pointing error that counts as saved, rad.
    needed
        Torque that is needed in every direction, N m.
    """

    cases: tuple[Case, ...]
    limit: float
    needed: float

    @property
    def stacks(self) -> list[str]:
        """Labels, in order."""
        return list(dict.fromkeys(case.stack for case in self.cases))

    def counts(self, stack: str) -> dict[Verdict, int]:
        """How many cases of a stack have which verdict."""
        found = Counter(case.verdict for case in self.cases if case.stack == stack)
        return {verdict: found[verdict] for verdict in VERDICTS}

    def columns(self) -> dict[str, list[Any]]:
        """As a table."""
        parts: dict[str, list[Any]] = {"stack": [c.stack for c in self.cases]}
        for name, strikes in (("first", [c.first for c in self.cases]), ("second", [c.second for c in self.cases])):
            parts |= {f"{name}.{key}": [getattr(s, key) for s in strikes] for key in ("kind", "actuator", "severity")}
        return parts | {key: [getattr(c, key) for c in self.cases] for key in ("status", "error", "torque", "verdict")}

    def save(self, folder: Path) -> list[Path]:
        """Write ``survival.csv``, ``survival.parquet`` and the picture ``survival.png`` into a folder that is there."""
        import pyarrow as pa
        from pyarrow import csv, parquet

        table = pa.table(self.columns())
        text = io.BytesIO()
        csv.write_csv(table, text)
        paths = [folder / f"survival.{ending}" for ending in ("csv", "parquet", "png")]
        write_text(paths[0], text.getvalue().decode())
        with replacing(paths[1]) as temporary:
            parquet.write_table(table, temporary)
        self.draw(paths[2])
        return paths

    def draw(self, path: Path) -> None:
        """Bands: an actuator and kind a row over severity, or, with second faults, the first fault over the second."""
        from matplotlib.figure import Figure
        from matplotlib.patches import Patch

        pairs = any(case.second.kind != NONE for case in self.cases)
        boards = [_board([c for c in self.cases if c.stack == stack], pairs=pairs) for stack in self.stacks]
        rows, columns = len(boards[0][0]), len(boards[0][1])
        size = (2.6 + max(0.22 * columns, 2.6) * len(boards), 1.6 + 0.19 * rows + (1.6 if pairs else 0.0))
        figure = Figure(figsize=size, layout="constrained")
        for i, (axes, (names, across, verdicts)) in enumerate(
            zip(figure.subplots(1, len(boards), squeeze=False)[0], boards, strict=True)
        ):
            picture = np.ones((len(names), len(across), 3))
            for k, color in enumerate(COLORS):
                picture[verdicts == k] = [int(color[n : n + 2], 16) / 255 for n in (1, 3, 5)]
            axes.imshow(picture, aspect="auto", interpolation="none")
            axes.set_title(self.stacks[i], fontsize=9)
            axes.set_yticks(range(len(names)), names if i == 0 else [""] * len(names), fontsize=6)
            axes.set_xticks(range(len(across)), across, fontsize=6, rotation=90 if pairs else 0)
            axes.set_xlabel("second fault, actuator" if pairs else "severity", fontsize=7)
            axes.set_yticks(np.arange(0.5, len(names) - 1), minor=True)
            axes.grid(which="minor", axis="y", color="white", lw=0.8)
            axes.tick_params(which="both", length=0)
        patches = [Patch(color=color, label=verdict) for verdict, color in zip(VERDICTS, COLORS, strict=True)]
        figure.legend(handles=patches, loc="outside lower center", ncols=2, fontsize=7, frameon=False)
        with replacing(path) as temporary:
            figure.savefig(temporary, dpi=130, format="png")


def survive(
    scenario: Scenario,
    stacks: Mapping[str, Mapping[str, Any] | Scenario] | None = None,
    *,
    kinds: Sequence[str] = KINDS,
    severities: Sequence[float] = SEVERITIES,
    second: bool = False,
    limit: float = 8.7e-3,
    torque: float | None = None,
    jobs: int | None = None,
    progress: Callable[[float], None] | None = None,
) -> Survival:
    """Fly every actuator in every fault, and hold what was saved against what could be.

    Parameters
    ----------
    scenario
        Vehicle, start, disturbances, noise, duration. Its own faults are left out.
    stacks
        By label: what each sets in the scenario, or a whole scenario; the scenario's own if absent.
    kinds, severities
        Of the faults; severities from 0 to 1. `dead`, `lock` and `hard_over` have one. A thruster has no `bias`, and
        it alone may `leak`.
    second
        Let every other actuator fail too, after a further fifth of the flight.
    limit
        Largest pointing error over the last tenth of a flight that is saved, rad.
    torque
        N m that are needed in every direction; absent: the largest external torque on a flight without faults.
    jobs
        Threads.
    progress
        Called with the finished fraction.

    Returns
    -------
    Survival
        A flight without fault first, then one a fault, or pair of faults; all stacks fly the same ones.

    Raises
    ------
    InputError
        An unknown kind, severities outside their range, or a vehicle whose actuators have no limit.

    Examples
    --------
    >>> import gyrostat as gs
    >>> short = gs.Scenario.load("wheel2_degraded").replace(duration=20.0, dt=0.05, integrator="rk4")
    >>> found = gs.survive(short, kinds=["dead"])
    >>> len(found.cases)
    5
    """
    _check(kinds, severities, limit, torque)
    flown = {
        label: (made if isinstance(made, Scenario) else scenario.replace(**made)).replace(faults=[])
        for label, made in (stacks or {"": {}}).items()
    }
    n = scenario.actuators
    for label, one in flown.items():
        with input_errors(f"stack '{label}'" if label else ""):
            if attainable_after_faults(_brief(one, [])) is None:
                raise InputError("survive: an actuator without limit can give any torque; write vehicle.u_max")
    u_max = np.broadcast_to(np.asarray(all_actuators(scenario.resolve())["u_max"], float), n)
    needed = _disturbance(next(iter(flown.values()))) if torque is None else float(torque)
    strikes = list(_strikes(kinds, severities, n, n - _valves(scenario)))
    if not strikes:
        raise InputError(f"survive: no actuator can have {' or '.join(kinds)}")
    pairs = [(Strike(), Strike()), *((a, Strike()) for a in strikes)]
    if second:
        pairs += [(a, b) for a in strikes for b in strikes if a.actuator != b.actuator]
    cases: list[Case] = []
    for k, (label, one) in enumerate(flown.items()):
        tell = None if progress is None else _part(progress, k, len(flown))
        cases += _flown(label, one, pairs, u_max=u_max, limit=limit, needed=needed, jobs=jobs, progress=tell)
    return Survival(tuple(cases), limit, needed)


def _check(kinds: Sequence[str], severities: Sequence[float], limit: float, torque: float | None) -> None:
    for kind in kinds:
        if kind not in KINDS:
            raise InputError(f"survive: no kind '{kind}'{suggestion(kind, KINDS)}; there are: {', '.join(KINDS)}")
    if not kinds or not severities or not all(0.0 <= s <= 1.0 for s in severities):
        raise InputError("survive: kinds, and severities from 0 to 1, belong here")
    if not limit > 0.0 or (torque is not None and not torque >= 0.0):
        raise InputError("survive: limit must be above 0 rad, torque 0 N m or more")


def _valves(scenario: Scenario) -> int:
    """Thrusters; they stand behind all other actuators."""
    given = scenario.resolve().get("thrusters")
    return Thrusters(**given).torque.size if given else 0


def _strikes(kinds: Sequence[str], severities: Sequence[float], actuators: int, valve: int) -> Iterator[Strike]:
    """Of each actuator what it can have; from `valve` on they are thrusters."""
    for kind in dict.fromkeys(kinds):
        who = {"bias": range(valve), "leak": range(valve, actuators)}.get(kind, range(actuators))
        for actuator in who:
            for severity in sorted(set(severities)) if _severity_of[kind] else (1.0,):
                yield Strike(kind, actuator, float(severity))


def _flown(
    label: str,
    scenario: Scenario,
    pairs: Sequence[tuple[Strike, Strike]],
    *,
    u_max: NDArray[np.float64],
    limit: float,
    needed: float,
    jobs: int | None,
    progress: Callable[[float], None] | None,
) -> list[Case]:
    """All pairs of faults; those of the same kinds are one experiment."""
    measure = {"error": {"metric": "window_max", "signal": "error.angle", "last": 0.1 * scenario.duration}}
    onsets = (0.2 * scenario.duration, 0.4 * scenario.duration)
    cases: list[Case] = []
    for _, group in groupby(pairs, key=lambda pair: (pair[0].kind, pair[1].kind)):
        mine = list(group)
        tables = [[s.table(u_max, t) for s, t in zip(p, onsets, strict=True) if s.kind != NONE] for p in mine]
        varied = [f"faults.{i}.{key}" for i, t in enumerate(tables[0]) for key in t if key not in ("type", "t_on")]
        experiment = Experiment(scenario.replace(faults=tables[0]), vary=varied, measure=measure)
        values = [[t[key] for t in row for key in t if key not in ("type", "t_on")] for row in tables]
        flights = experiment.fly(values, threads=jobs) if varied else experiment.fly(runs=1, threads=jobs)
        for k, (a, b) in enumerate(mine):
            left = attainable_after_faults(_brief(scenario, tables[k]))
            assert left is not None  # refused before
            status, error, torque = str(flights.status[k]), float(flights["error"][k]), left[1].in_every_direction
            saved = status == "completed" and error < limit
            cases.append(Case(label, a, b, status, error, torque, _verdict(saved, torque, left[0], needed)))
        if progress is not None:
            progress(len(cases) / len(pairs))
    return cases


def _verdict(saved: bool, torque: float, healthy: Any, needed: float) -> Verdict:
    possible = torque > max(needed, 1e-12 * healthy.in_every_direction)
    if possible:
        return "saved" if saved else "lost though possible"
    return "saved though impossible" if saved else "impossible"


def _brief(scenario: Scenario, faults: Sequence[Mapping[str, Any]]) -> Scenario:
    """As long as it takes to see what the faults leave: they last."""
    return scenario.replace(faults=[{**f, "t_on": 0.0} for f in faults], duration=4.0 * scenario.dt)


def _disturbance(scenario: Scenario) -> float:
    torques = scenario.run(channels=["truth.external_B"])["truth.external_B"]
    return float(np.linalg.norm(torques, axis=1).max())


def _part(progress: Callable[[float], None], k: int, parts: int) -> Callable[[float], None]:
    return lambda fraction: progress((k + fraction) / parts)


def _board(cases: Sequence[Case], *, pairs: bool) -> tuple[list[str], list[str], NDArray[np.int_]]:
    """Names of rows and columns, and the number of the verdict of each field; -1 where nothing was flown."""
    if pairs:
        rows = list(dict.fromkeys(c.first.name for c in cases))
        columns = list(dict.fromkeys(c.second.name for c in cases))
        places = [([c.first.name], [c.second.name]) for c in cases]
    else:
        severities = sorted({c.first.severity for c in cases if _severity_of.get(c.first.kind)}) or [1.0]
        columns = [f"{s:g}" for s in severities]
        bands = [(c.first.kind, c.first.actuator) for c in cases]
        rows = list(dict.fromkeys(_band(*band) for band in bands))
        places = [
            ([_band(*band)], [f"{c.first.severity:g}"] if _severity_of.get(c.first.kind) else columns)
            for c, band in zip(cases, bands, strict=True)
        ]
    board = np.full((len(rows), len(columns)), -1)
    for case, (down, across) in zip(cases, places, strict=True):
        for row in down:
            for column in across:
                board[rows.index(row), columns.index(column)] = VERDICTS.index(case.verdict)
    return rows, columns, board


def _band(kind: str, actuator: int) -> str:
    return NONE if kind == NONE else f"{kind.replace('_', ' ')}, {actuator}"


__all__ = ["KINDS", "SEVERITIES", "VERDICTS", "Case", "Strike", "Survival", "survive"]
