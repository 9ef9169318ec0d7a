# SPDX-License-Identifier: MIT
"""What is drawn over time: the panels of one run, and those that lay several runs over each other."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

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
    note: str = field(default="")


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
    name: str,
    title: str,
    unit: str,
    results: Sequence[Result],
    value: Callable[[Result], Array],
    needs: Sequence[str],
    *,
    log: bool = False,
) -> Panel | None:
    """One line a run."""
    lines = [
        Line("", value(r), i, run=i) for i, r in enumerate(results) if all(channel in r.channels for channel in needs)
    ]
    return Panel(name, title, unit, lines, log=log and _has_logarithm(lines)) if lines else None


def _has_logarithm(lines: Sequence[Line]) -> bool:
    return any(np.any(line.x > 0.0) for line in lines)


def _error(result: Result) -> Array:
    return np.degrees(result["error.angle"])


def _pointing(result: Result) -> Panel:
    line = Line("pointing error", _error(result), 0)
    return Panel("pointing", "Pointing error", "deg", [line], _band, log=_has_logarithm([line]))


def _pointings(results: Sequence[Result]) -> Panel | None:
    panel = _overlay("pointing", "Pointing error", "deg", results, _error, ["error.angle"], log=True)
    return panel and Panel(panel.name, panel.title, panel.unit, panel.lines, _band, log=panel.log)


_band = [(math.degrees(DEFAULT_BAND), "settled below")]


def _rate(result: Result) -> Panel:
    return Panel("rate", "Body rate", "rad/s", _columns(result["truth.omega_BN_B"], _axes))


def _rates(results: Sequence[Result]) -> Panel | None:
    return _overlay("rate", "Size of the body rate", "rad/s", results, _norm("truth.omega_BN_B"), ["truth.omega_BN_B"])


def _norm(channel: str) -> Callable[[Result], Array]:
    return lambda result: np.linalg.norm(result[channel], axis=1)


def _largest(channel: str) -> Callable[[Result], Array]:
    return lambda result: np.abs(result[channel]).max(axis=1)


def _command(result: Result) -> Panel:
    u = result["allocation.u"]
    vehicle = result.description["vehicle"]
    return Panel("command", "Command of each actuator", "N m", _columns(u, _numbers(u)), _limits(vehicle.get("u_max"), vehicle))


def _limits(upper: ArrayLike | None, vehicle: dict[str, object]) -> list[tuple[float, str]]:
    """Each limit that flight knows once, as levels."""
    found: dict[float, str] = {}
    for key, ends, sign in (("u_max", upper, 1.0), ("u_min", vehicle.get("u_min"), 1.0), ("u_max", upper, -1.0)):
        if ends is None or (sign < 0.0 and vehicle.get("u_min") is not None):
            continue
        for value in np.unique(np.asarray(ends, dtype=float)):
            if math.isfinite(value):
                found.setdefault(float(sign * value), key if sign > 0.0 else f"-{key}")
    return sorted(found.items())


def _commands(results: Sequence[Result]) -> Panel | None:
    return _overlay("command", "Largest command", "N m", results, _largest("allocation.u"), ["allocation.u"])


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
    """Of every run the estimates of those actuators that ever differ from 1, and the truth."""
    lines = []
    for k, result in enumerate(results):
        for channel, style in _sides:
            x = result.channels.get(channel)
            if x is not None:
                moved = [i for i in range(x.shape[1]) if np.any(x[:, i] != 1.0)]
                lines += [Line(f"actuator {i}", x[:, i], k, style, k) for i in moved]
    return Panel("effectiveness", "Effectiveness that differs from 1", "", lines) if lines else None


_sides: tuple[tuple[str, Style], ...] = (("truth.effectiveness", "true"), ("estimate.effectiveness", "solid"))


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
        return np.linalg.norm(result["estimate.d_B"] - result["truth.lumped_B"], axis=1)

    needs = ["estimate.d_B", "truth.lumped_B"]
    return _overlay("lumped", "Error of the estimated lumped torque", "N m", results, miss, needs, log=True)


def _momentum(result: Result) -> Panel | None:
    h = result["truth.h_w"]
    if not h.any():
        return None  # ideal torque actuators store none
    most = (result.description.get("truth") or {}).get("momentum_max")
    ends = [] if most is None else [float(v) for v in np.unique(np.asarray(most, dtype=float)) if math.isfinite(v)]
    levels = [(sign * end, "momentum_max" if sign > 0.0 else "-momentum_max") for end in ends for sign in (1.0, -1.0)]
    return Panel("momentum", "Momentum of each wheel", "N m s", _columns(h, _numbers(h)), levels)


def _momenta(results: Sequence[Result]) -> Panel | None:
    if not any(r.channels["truth.h_w"].any() for r in results if "truth.h_w" in r.channels):
        return None
    return _overlay("momentum", "Largest wheel momentum", "N m s", results, _largest("truth.h_w"), ["truth.h_w"])


_kinds = (
    _Kind("the pointing error", ("error.angle",), _pointing, _pointings),
    _Kind("the body rate", ("truth.omega_BN_B",), _rate, _rates),
    _Kind("the commands", ("allocation.u",), _command, _commands),
    _Kind("the effectiveness", ("truth.effectiveness",), _effectiveness, _effectivenesses),
    _Kind("the lumped torque", ("estimate.d_B",), _lumped, _lumpeds),
    _Kind("the wheel momentum", ("truth.h_w",), _momentum, _momenta),
)
