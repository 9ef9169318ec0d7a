# SPDX-License-Identifier: MIT
"""Labelled flights for fault detection, and a score for whoever detects: ``gyrostat dataset``.

What a detector may read (measurements and commands), which actuator failed, how, how much and from when on; from one
seed, so that the same set is made anywhere. Page: docs/campaigns.md
"""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gyrostat import detection
from gyrostat._core import catalogue
from gyrostat.campaign import Campaign
from gyrostat.errors import InputError, suggestion
from gyrostat.files import file_errors, replacing_folder, write_text
from gyrostat.old_names import current
from gyrostat.scenario import Scenario, shipped
from gyrostat.vehicle import all_actuators

CHANNELS = (
    "measurement.q_NB",
    "measurement.omega_BN_B",
    "measurement.h_w",
    "measurement.attitude_valid",
    "measurement.rate_valid",
    "measurement.momentum_valid",
    "allocation.u",
)
"""What a detector may read: measurements, and the command."""
REFUSED = "refused"
"""Status of a run whose draws no vehicle can have; it has no samples."""
_labels = ("run", "actuator", "kind", "severity", "t_on", "t_off")


def source(name: str | Path) -> Campaign:
    """A campaign by file or name; a scenario is one whose flights differ in their noise alone."""
    from gyrostat import toml
    from gyrostat.campaign import shipped as campaigns

    if str(name) in campaigns():
        return Campaign.load(name)
    path = Path(name)
    if str(name) in shipped() or (path.suffix == ".toml" and "base" not in toml.read(path)):
        scenario = Scenario.load(str(name))
        return Campaign(scenario, seed=int(scenario.resolve()["seed"]))
    return Campaign.load(name)


def make(
    campaign: Campaign,
    runs: int,
    out: str | Path,
    *,
    cell: str | None = None,
    every: int = 1,
    progress: Callable[[float], None] | None = None,
) -> Path:
    """Fly runs and write them with their labels.

    Parameters
    ----------
    campaign
        What is flown.
    runs
        0 to runs - 1.
    out
        A new or empty folder; it appears when it is complete.
    cell
        Where there is a grid: which.
    every
        Write every so many samples.
    progress
        Called with the finished fraction.

    Returns
    -------
    Path
        The folder: ``samples.parquet`` (a row a sample, a row group a flight), ``labels.parquet`` (a row a fault),
        ``flights.parquet`` (a row a flight), ``dataset.json``.

    Raises
    ------
    InputError
        No runs, Python components, or more than half of the runs refused; fewer are flights of status ``refused``.
    """
    import pyarrow as pa
    from pyarrow import parquet

    if runs < 1 or every < 1:
        raise InputError(f"runs = {runs}, every = {every}: whole numbers from 1 on belong here")
    if campaign.base.python_components():
        raise InputError("a data set is scored by flying it again; Python components cannot be written down")
    labels: list[dict[str, Any]] = []
    flights: list[dict[str, Any]] = []
    with replacing_folder(Path(out)) as folder:
        writer: Any = None
        try:
            for run in range(runs):
                try:
                    scenario = campaign.scenario(run, cell)
                except InputError as error:  # drawn faults that contradict each other, as in a campaign
                    flights.append({"run": run, "status": REFUSED, "t_end": 0.0, "cause": str(error)})
                    continue
                flown = scenario.run(channels=list(CHANNELS), every=every)
                table = pa.table(_samples(flown, run))
                writer = writer or parquet.ParquetWriter(folder / "samples.parquet", table.schema, compression="zstd")
                writer.write_table(table)
                labels += _labelled(scenario, run, flown.end_time)
                flights.append({"run": run, "status": flown.status, "t_end": flown.end_time, "cause": flown.cause})
                if progress is not None:
                    progress((run + 1) / runs)
        finally:
            if writer is not None:
                writer.close()
        refused = [row for row in flights if row["status"] == REFUSED]
        if 2 * len(refused) > runs:
            raise InputError(f"{len(refused)} of {runs} flights are refused, the first because: {refused[0]['cause']}")
        types = [pa.int64(), pa.int64(), pa.string(), pa.float64(), pa.float64(), pa.float64()]
        schema = pa.schema(list(zip(_labels, types, strict=True)))
        parquet.write_table(pa.Table.from_pylist(labels, schema=schema), folder / "labels.parquet")
        parquet.write_table(pa.Table.from_pylist(flights), folder / "flights.parquet")
        about = {
            "campaign": campaign.standalone(),
            "cell": cell,
            "runs": runs,
            "every": every,
            "channels": list(CHANNELS),
        }
        write_text(folder / "dataset.json", json.dumps(about, indent=1) + "\n")
    return Path(out)


@dataclass(frozen=True)
class Score:
    """How one detector did on all flights.

    Attributes
    ----------
    name
        Of the observer and detector, or of who declared.
    changes
        Every labelled fault with its answer.
    false_alarms
        Their number.
    hours
        Flown.
    isolation
        As in `gyrostat.detection.DetectionReport`, over all flights.
    refused
        Why it did not run; None where it did.
    """

    name: str
    changes: tuple[detection.Change, ...]
    false_alarms: int
    hours: float
    isolation: NDArray[np.int_]
    refused: str | None = None

    @property
    def false_alarms_per_hour(self) -> float:
        """Of flight."""
        return self.false_alarms / self.hours

    @property
    def delay(self) -> float:
        """Median over the detected faults, s; nan where none was."""
        found = [c.delay for c in self.changes if c.delay is not None]
        return float(np.median(found)) if found else math.nan

    def count(self, answer: detection.Answer) -> int:
        """Faults with this answer."""
        return sum(c.answer == answer for c in self.changes)


@dataclass(frozen=True)
class Scores:
    """Of all detectors, and what none of them could have told.

    Attributes
    ----------
    scores
        One a detector.
    faults
        Labelled.
    silent
        Faults whose actuator was hardly commanded within the horizon after the onset.
    confused
        Faults whose trace within the horizon was that of another actuator's.
    """

    scores: tuple[Score, ...]
    faults: int
    silent: int
    confused: int


def score(
    folder: str | Path,
    *,
    observers: Sequence[str] | None = None,
    detectors: Sequence[str] | None = None,
    declared: Mapping[str, Iterable[tuple[int, float, int]]] | None = None,
    horizon: float = 4.0,
    progress: Callable[[float], None] | None = None,
) -> Scores:
    """Score the catalogue's observers and detectors, or declarations of one's own, against the labels.

    Parameters
    ----------
    folder
        Of `make`. Its flights are flown again, bit for bit, with the observers beside them.
    observers, detectors
        By name; all pairs are scored. All of the catalogue when absent.
    declared
        By name instead: (run, time s, bit mask of the actuators that are named).
    horizon
        s, how long after an onset a declaration still belongs to it.

    Raises
    ------
    InputError
        No data set, or an unknown name.
    """
    about, labels = _read(Path(folder))
    campaign = Campaign.from_dict(about["campaign"])
    runs, cell = int(about["runs"]), about["cell"]
    n = campaign.base.actuators
    flights = _flights(Path(folder))
    flew = [run for run in range(runs) if flights[run]["status"] != REFUSED]
    by_run = {run: [c for r, *c in labels if r == run] for run in flew}
    silent, confused = _hidden(Path(folder), campaign, labels, flew, horizon)
    said: dict[str, list[list[tuple[float, int]]]] = {}
    refused: dict[str, str] = {}
    if declared is not None:
        for name, given in declared.items():
            entries = sorted(given)
            said[name] = [[(t, mask) for r, t, mask in entries if r == run] for run in flew]
    else:
        pairs = _pairs(observers, detectors)
        refused = _refused(campaign.scenario(flew[0], cell), pairs)
        flying = {label: pair for label, pair in pairs.items() if label not in refused}
        said = {label: [] for label in flying}
        for run in flew if flying else ():
            for label, found in _declared(campaign.scenario(run, cell), flying).items():
                said[label].append(found)
            if progress is not None:
                progress((run + 1) / runs)
    hours = sum(float(row["t_end"]) for row in flights) / 3600.0
    scores = [_scored(name, by_run, given, n, hours, horizon) for name, given in said.items()]
    scores += [Score(name, (), 0, hours, np.zeros((n, n + 2), int), why) for name, why in refused.items()]
    return Scores(tuple(scores), len(labels), silent, confused)


def _scored(
    name: str,
    by_run: Mapping[int, list[Any]],
    declarations: Sequence[list[tuple[float, int]]],
    n: int,
    *how: float,
) -> Score:
    hours, horizon = how
    changes: list[detection.Change] = []
    false, isolation = 0, np.zeros((n, n + 2), int)
    for run, given in zip(by_run, declarations, strict=True):
        wanted = [(t, actuator, -severity) for t, actuator, severity in sorted(by_run[run])]
        found, alarms, told = detection.evaluate(wanted, given, n, horizon)
        changes += found
        false += len(alarms)
        isolation += told
    return Score(name, tuple(changes), false, hours, isolation)


def _pairs(observers: Sequence[str] | None, detectors: Sequence[str] | None) -> dict[str, tuple[str, str]]:
    known = catalogue()
    chosen = {
        "observer": [current(name) for name in observers or ()]
        or [name for name in known["observer"] if name != "passthrough"],
        "detector": detectors or [name for name in known["detector"] if name != "none"],
    }
    for family, names in chosen.items():
        for name in names:
            if name not in known[family]:
                raise InputError(f"no {family} '{name}'{suggestion(name, known[family])}")
    return {f"{o} + {d}": (o, d) for o in chosen["observer"] for d in chosen["detector"]}


def _beside(scenario: Scenario, pairs: Mapping[str, tuple[str, str]]) -> Scenario:
    return scenario.replace(shadows=[{"observer": o, "detector": d} for o, d in pairs.values()], record=None)


def _refused(scenario: Scenario, pairs: Mapping[str, tuple[str, str]]) -> dict[str, str]:
    """Pairs that do not fit the vehicle or the period, with the reason."""
    found = {}
    for label, pair in pairs.items():
        try:
            _beside(scenario.replace(duration=2.0 * scenario.dt), {label: pair}).run(channels=["truth.q_NB"])
        except InputError as error:
            found[label] = str(error)
    return found


def _declared(scenario: Scenario, pairs: Mapping[str, tuple[str, str]]) -> dict[str, list[tuple[float, int]]]:
    """What each pair declares on one flight."""
    beside = _beside(scenario, pairs)
    names = {c["name"] for c in beside.channel_names()}
    parts = ("detection.event", "detection.changed", "detector.declared")
    roles = {label: f"shadow{k}" for k, label in enumerate(pairs)}
    flown = beside.run(channels=[f"{r}.{p}" for r in roles.values() for p in parts if f"{r}.{p}" in names])
    return {label: detection.declarations(flown, role) for label, role in roles.items()}


def _samples(flown: Any, run: int) -> dict[str, Any]:
    columns: dict[str, Any] = {"run": np.full(len(flown), run, dtype=np.int64), "t": np.asarray(flown.t)}
    for name in CHANNELS:
        x = np.asarray(flown[name])
        columns |= (
            {name: x} if x.ndim == 1 else {f"{name}.{i}": np.ascontiguousarray(x[:, i]) for i in range(x.shape[1])}
        )
    return columns


def _labelled(scenario: Scenario, run: int, t_end: float) -> list[dict[str, Any]]:
    tables = scenario.resolve()
    limits = all_actuators(tables).get("u_max", math.inf)
    u_max = np.broadcast_to(np.asarray(limits, float), scenario.actuators)
    return [
        {
            "run": run,
            "actuator": int(f["actuator"]),
            "kind": str(f["type"]),
            "severity": _severity(f, float(u_max[int(f["actuator"])])),
            "t_on": float(f.get("t_on", 0.0)),
            "t_off": float(f.get("t_off", math.inf)),
        }
        for f in tables.get("faults", [])
        if float(f.get("t_on", 0.0)) < t_end
    ]


def _severity(fault: Mapping[str, Any], u_max: float) -> float:
    """Share of the effectiveness that is lost, or of the limit that is added; 1 of what has no size."""
    if "remaining" in fault:
        return 1.0 - float(fault["remaining"])
    if "fraction" in fault:
        return float(fault["fraction"])
    return abs(float(fault["torque"])) / u_max if "torque" in fault else 1.0


def _read(folder: Path) -> tuple[dict[str, Any], list[tuple[int, float, int, float]]]:
    """What a data set is, and its labels: run, onset, actuator, severity."""
    from pyarrow import parquet

    path = folder / "dataset.json"
    with file_errors(path, "cannot be read"):
        text = path.read_text(encoding="utf-8")
    try:
        about = dict(json.loads(text))
    except ValueError:
        raise InputError(f"{path}: is not what gyrostat dataset wrote") from None
    if not {"campaign", "cell", "runs"} <= about.keys():
        raise InputError(f"{path}: is not what gyrostat dataset wrote")
    with file_errors(folder / "labels.parquet", "cannot be read"):
        rows = parquet.read_table(folder / "labels.parquet").to_pylist()
    return about, [(r["run"], r["t_on"], r["actuator"], r["severity"]) for r in rows]


def _flights(folder: Path) -> list[dict[str, Any]]:
    from pyarrow import parquet

    with file_errors(folder / "flights.parquet", "cannot be read"):
        return list(parquet.read_table(folder / "flights.parquet").to_pylist())


def _hidden(
    folder: Path,
    campaign: Campaign,
    labels: Sequence[tuple[int, float, int, float]],
    flew: Sequence[int],
    horizon: float,
) -> tuple[int, int]:
    """Faults that the commands after them leave without a trace, or with that of another actuator."""
    from pyarrow import parquet

    D = campaign.base.axes_B
    names = [f"allocation.u.{i}" for i in range(D.shape[1])]
    silent = confused = 0
    with file_errors(folder / "samples.parquet", "cannot be read"):
        file = parquet.ParquetFile(folder / "samples.parquet")
        for run in sorted({run for run, *_ in labels}):
            rows = file.read_row_group(flew.index(run), columns=["t", *names])
            t, u = rows.column("t").to_numpy(), np.column_stack([rows.column(name).to_numpy() for name in names])
            for _, t_on, actuator, _ in (label for label in labels if label[0] == run):
                within = u[(t >= t_on) & (t <= t_on + horizon)]
                told = detection.identifiability(D, within if len(within) else np.zeros((1, D.shape[1])))
                silent += actuator in told.silent
                confused += any(actuator in pair for pair in told.confused)
    return silent, confused


__all__ = ["CHANNELS", "Score", "Scores", "make", "score", "source"]
