# SPDX-License-Identifier: MIT
"""What happened at instants of a run: faults, declarations, changes of mode, jumps of the reference, counters."""

from __future__ import annotations

import math
from collections import Counter
from dataclasses import dataclass
from typing import Literal

import numpy as np

from gyrostat.detection import declarations
from gyrostat.results import Result

Kind = Literal["fault", "declared", "mode", "reference", "guard", "counter"]

_most_rows = 40
_most_ticks = 3000
"""Drawn of a run; longer rows are thinned, evenly over the time of the run."""


@dataclass(frozen=True)
class Mark:
    """An instant, or a stretch of time when it has an end."""

    kind: Kind
    t: float
    text: str
    end: float | None = None


def faults(result: Result) -> list[Mark]:
    """Every fault that begins before the run ends, with the time for which it lasts."""
    marks = []
    for fault in result.known_faults:
        onset, end = float(fault.get("t_on", 0.0)), min(float(fault.get("t_off", math.inf)), result.end_time)
        if onset <= end:
            marks.append(Mark("fault", onset, f"{fault['type'].replace('_', ' ')}, actuator {fault['actuator']}", end))
    return sorted(marks, key=lambda m: m.t)


def declared(result: Result) -> list[Mark]:
    """Every declaration of the loop's detector, with the actuators that it names where they were recorded."""
    if any(name in result for name in ("detector.declared", "detection.changed")):
        return [
            Mark("declared", t, f"declared: actuator {', '.join(named)}" if (named := _bits(mask)) else "declared")
            for t, mask in declarations(result)
        ]
    return [Mark("declared", e.t, "declared") for e in result.events if e.name == "detector.event"]


def _bits(mask: int) -> list[str]:
    return [str(i) for i in range(mask.bit_length()) if mask >> i & 1]


def others(result: Result) -> list[Mark]:
    """Every other event of a run."""
    return [
        Mark(_kind(e.name), e.t, f"{e.name} {e.what or e.count}") for e in result.events if _kind(e.name) != "declared"
    ]


def _kind(name: str) -> Kind:
    group, _, last = name.partition(".")
    if name == "detector.event":
        return "declared"
    if "mode" in (group, last):
        return "mode"
    return "reference" if group == "reference" else "guard" if group == "guard" else "counter"


def rows(result: Result) -> list[tuple[str, Kind, list[float], int]]:
    """Rows of ticks: name, kind, instants that are drawn, and how many there are."""
    found: dict[tuple[str, Kind], list[float]] = {}
    if marks := faults(result):
        found["fault", "fault"] = [m.t for m in marks]
    for event in result.events:
        kind = _kind(event.name)
        found.setdefault(("declared" if kind == "declared" else event.name, kind), []).append(event.t)
    share = _most_ticks // min(max(len(found), 1), _most_rows)
    drawn = list(found.items())[:_most_rows]
    return [(name, kind, _spread(times, min(share, 400)), len(times)) for (name, kind), times in drawn]


def _spread(times: list[float], most: int) -> list[float]:
    """At most so many instants that fill the same stretches of time."""
    if len(times) <= most:
        return times
    t = np.asarray(times)
    bins = np.floor((t - t[0]) / max(float(t[-1] - t[0]), 1e-300) * (most - 1))
    return [float(v) for v in t[np.unique(bins, return_index=True)[1]]]


def counts(result: Result) -> list[tuple[str, int, float, float]]:
    """Of each event: name, how often, first and last instant."""
    number = Counter(e.name for e in result.events)
    first: dict[str, float] = {}
    last: dict[str, float] = {}
    for e in result.events:
        first.setdefault(e.name, e.t)
        last[e.name] = e.t
    return [(name, n, first[name], last[name]) for name, n in number.items()]
