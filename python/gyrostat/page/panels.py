# SPDX-License-Identifier: MIT
"""What is drawn over time: the panels of one run, and those that lay several runs over each other."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from gyrostat.metrics import DEFAULT_BAND
from gyrostat.results import Result

Array = NDArray[np.float64]
Style = Literal["solid", "true", "lower", "upper"]

_axes = ("x", "y", "z")
_nobody = "the observer of this run estimates none"


@dataclass(frozen=True)
class Line:
    """One line of a panel."""

    label: str
    x: Array
    """Shape (n,)."""
    color: int
    """Place in the palette of the page."""
    style: Style = "solid"
    """``true``: wide and pale, under what was estimated of it; ``lower`` and ``upper``: ends of a band."""
    run: int = 0


@dataclass(frozen=True)
class Panel:
    """Lines over a common time axis."""

    name: str
    title: str
    unit: str
    lines: Sequence[Line]
    levels: Sequence[tuple[float, str]] = ()
    log: bool = False
    note: str = ""


@dataclass(frozen=True)
class _Kind:
    """A panel, the channels without which there is none, and how it is made."""

    name: str
    needs: tuple[str, ...]
    of_run: Callable[[Result], Panel | None]
    of_runs: Callable[[Sequence[Result]], Panel | None]


def of_run(result: Result) -> list[Panel]:
    """The panels of a run, of what was recorded."""
    made = (kind.of_run(result) for kind in _kinds if all(n in result.channels for n in kind.needs))
    return [panel for panel in made if panel is not None]


def of_runs(results: Sequence[Result]) -> list[Panel]:
    """The panels of several runs: a colour a run, vectors by their size; each of the runs that recorded it."""
    made = (kind.of_runs(results) for kind in _kinds)
    return [panel for panel in made if panel is not None]


def missing(results: Iterable[Result]) -> dict[str, str]:
    """What is not drawn of the first runs that lack it, by the channel that was not recorded."""
    wanted = {need: kind.name for kind in _kinds for need in kind.needs}
    return {need: name for need, name in wanted.items() if any(need not in r.channels for r in results)}


def _columns(x: Array, labels: Sequence[str], style: Style = "solid", kept: Iterable[int] | None = None) -> list[Line]:
    chosen = range(x.shape[1]) if kept is None else kept
    return [Line(labels[i], x[:, i], i, style) for i in chosen]


def _numbers(x: Array) -> list[str]:
    return [f"{i}" for i in range(x.shape[1])]


def _overlay(
    results: Sequence[Result],
    needs: Sequence[str],
    value: Callable[[Result], Array],
    *,
    name: str,
    title: str,
    unit: str,
    log: bool = False,
    levels: Sequence[tuple[float, str]] = (),
) -> Panel | None:
    """One line a run."""
    lines = [
        Line("", value(r), i, run=i) for i, r in enumerate(results) if all(channel in r.channels for channel in needs)
    ]
    return Panel(name, title, unit, lines, levels, log=log and _has_logarithm(lines)) if lines else None


def _has_logarithm(lines: Sequence[Line]) -> bool:
    return any(np.any(line.x > 0.0) for line in lines)


def _error(result: Result) -> Array:
    return np.degrees(result["error.angle"])


def _pointing(result: Result) -> Panel:
    line = Line("pointing error", _error(result), 0)
    return Panel("pointing", "Pointing error", "deg", [line], _band, log=_has_logarithm([line]))


def _pointings(results: Sequence[Result]) -> Panel | None:
    return _overlay(
        results,
        ["error.angle"],
        _error,
        name="pointing",
        title="Pointing error",
        unit="deg",
        log=True,
        levels=_band,
    )


_band = [(math.degrees(DEFAULT_BAND), "settled below")]


def _rate(result: Result) -> Panel:
    return Panel("rate", "Body rate", "rad/s", _columns(result["truth.omega_BN_B"], _axes))


def _rates(results: Sequence[Result]) -> Panel | None:
    channel = "truth.omega_BN_B"
    return _overlay(results, [channel], _norm(channel), name="rate", title="Size of the body rate", unit="rad/s")


def _norm(channel: str) -> Callable[[Result], Array]:
    return lambda result: np.linalg.norm(result[channel], axis=1)


def _largest(channel: str) -> Callable[[Result], Array]:
    return lambda result: np.abs(result[channel]).max(axis=1)


def _command(result: Result) -> Panel:
    u = result["allocation.u"]
    vehicle = result.description["vehicle"]
    unit = "N m; magnetorquers A m^2" if vehicle.get("magnetorquers") else "N m"
    return Panel("command", "Command of each actuator", unit, _columns(u, _numbers(u)), _limits(vehicle))


def _limits(vehicle: Mapping[str, Any]) -> list[tuple[float, str]]:
    """Each limit that flight knows once, as levels; without a lower limit it is the upper one mirrored."""
    upper, lower = vehicle.get("u_max"), vehicle.get("u_min")
    found: dict[float, str] = {}
    below = ("-u_max", -1.0, upper) if lower is None else ("u_min", 1.0, lower)
    for name, sign, ends in (("u_max", 1.0, upper), below):
        for end in [] if ends is None else np.unique(np.asarray(ends, dtype=float)):
            if math.isfinite(end):
                found.setdefault(float(sign * end), name)
    return sorted(found.items())


def _commands(results: Sequence[Result]) -> Panel | None:
    channel = "allocation.u"
    return _overlay(results, [channel], _largest(channel), name="command", title="Largest command", unit="N m")


def _effectiveness(result: Result) -> Panel:
    true = result["truth.effectiveness"]
    labels = _numbers(true)
    lines = _columns(true, labels, "true")
    estimate = result.channels.get("estimate.effectiveness")
    if estimate is None or np.all(estimate == 1.0):
        note = "no estimate was recorded" if estimate is None else _nobody
        return Panel("effectiveness", "Effectiveness of each actuator", "", lines, note=note)
    bounds = result.channels.get("estimate.effectiveness_bound")
    band: list[Line] = []
    if bounds is not None:
        known = [i for i in range(true.shape[1]) if np.any(np.isfinite(bounds[:, i]) & (bounds[:, i] > 0.0))]
        width = np.where(np.isfinite(bounds), np.abs(estimate * bounds), np.nan)
        for i in known:
            low, high = (np.clip(estimate[:, i] + sign * width[:, i], -0.5, 1.5) for sign in (-1.0, 1.0))
            band += [Line(labels[i], low, i, "lower"), Line(labels[i], high, i, "upper")]
    return Panel("effectiveness", "Effectiveness of each actuator", "", [*band, *lines, *_columns(estimate, labels)])


def _effectivenesses(results: Sequence[Result]) -> Panel | None:
    """Estimates of those actuators that fail or are taken for failed; a truth that runs share is drawn once."""
    lines: list[Line] = []
    for k, result in enumerate(results):
        true, estimate = (result.channels.get(f"{group}.effectiveness") for group in ("truth", "estimate"))
        for i in _affected(true, estimate):
            if true is not None and not any(
                line.style == "true" and np.array_equal(line.x, true[:, i]) for line in lines
            ):
                lines.append(Line(f"{i}", true[:, i], k, "true", k))
            if estimate is not None and np.any(estimate != 1.0):
                lines.append(Line(f"{i}", estimate[:, i], k, "solid", k))
    return Panel("effectiveness", "Effectiveness of actuators that lose some", "", lines) if lines else None


def _affected(true: Array | None, estimate: Array | None) -> list[int]:
    """Actuators that lose something, or of which the estimate says so by more than a tenth."""
    found = set() if true is None else set(np.flatnonzero(np.any(true != 1.0, axis=0)))
    found |= set() if estimate is None else set(np.flatnonzero(np.any(np.abs(estimate - 1.0) > 0.1, axis=0)))
    return sorted(int(i) for i in found)


def _lumped(result: Result) -> Panel:
    estimate, true = result["estimate.d_B"], result.channels.get("truth.lumped_B")
    lines = [] if true is None else _columns(true, _axes, "true")
    note = "its true value was not recorded" if true is None else ""
    if true is None or estimate.any():
        lines += _columns(estimate, _axes)
    else:
        note = _nobody
    return Panel("lumped", "Lumped torque", "N m", lines, note=note)


def _lumpeds(results: Sequence[Result]) -> Panel | None:
    def miss(result: Result) -> Array:
        size: Array = np.linalg.norm(result["estimate.d_B"] - result["truth.lumped_B"], axis=1)
        return size

    needs, title = ["estimate.d_B", "truth.lumped_B"], "Error of the estimated lumped torque"
    return _overlay(results, needs, miss, name="lumped", title=title, unit="N m", log=True)


def _momentum(result: Result) -> Panel | None:
    h = result["truth.h_w"]
    if not h.any():
        return None  # ideal torque actuators store none
    blocks = [result.description.get(block) or {} for block in ("truth", "vehicle")]
    most = next((b["momentum_max"] for b in blocks if b.get("momentum_max") is not None), None)
    ends = [] if most is None else [float(v) for v in np.unique(np.asarray(most, dtype=float)) if math.isfinite(v)]
    levels = [(sign * end, "momentum_max" if sign > 0.0 else "-momentum_max") for end in ends for sign in (1.0, -1.0)]
    return Panel("momentum", "Momentum of each wheel", "N m s", _columns(h, _numbers(h)), levels)


def _momenta(results: Sequence[Result]) -> Panel | None:
    if not any(r.channels["truth.h_w"].any() for r in results if "truth.h_w" in r.channels):
        return None
    channel = "truth.h_w"
    return _overlay(
        results, [channel], _largest(channel), name="momentum", title="Largest wheel momentum", unit="N m s"
    )


_kinds = (
    _Kind("pointing error", ("error.angle",), _pointing, _pointings),
    _Kind("body rate", ("truth.omega_BN_B",), _rate, _rates),
    _Kind("commands", ("allocation.u",), _command, _commands),
    _Kind("effectiveness", ("truth.effectiveness",), _effectiveness, _effectivenesses),
    _Kind("lumped torque", ("estimate.d_B",), _lumped, _lumpeds),
    _Kind("wheel momentum", ("truth.h_w",), _momentum, _momenta),
)
