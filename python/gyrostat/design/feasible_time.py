# SPDX-License-Identifier: MIT
"""The smallest time that the actuators can keep, by simulation and bisection."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

from gyrostat.design.finding import Finding
from gyrostat.errors import InputError


@dataclass(frozen=True)
class FeasibleTime:
    """The smallest time for which a manoeuvre keeps inside the torque limits, as a bracket.

    Demands need not fall strictly with time: this is the boundary between feasible and not that the bracket closed on.
    """

    time: float
    """s; does not saturate."""
    saturating: float
    """s, the largest time tried that saturates."""
    runs: int
    """Simulated manoeuvres."""


def smallest_feasible_time(
    saturates: Callable[[float], bool], start: float, *, tolerance: float = 1e-3, within: float = 64.0
) -> FeasibleTime:
    """Bracket and bisect the time at which a manoeuvre begins to saturate.

    Parameters
    ----------
    saturates
        Whether the manoeuvre that takes this time, s, meets a limit.
    start
        s, a first guess.
    tolerance
        Relative width of the bracket at which to stop.
    within
        The answer is looked for between ``start / within`` and ``start * within``.

    Raises
    ------
    InputError
        No time in that range saturates, or all do.
    """
    runs = 0

    def limited(time: float) -> bool:
        nonlocal runs
        runs += 1
        return saturates(time)

    low = high = start
    if limited(start):
        while limited(high := 2.0 * high):
            low = high
            if high >= within * start:
                raise InputError(f"every time up to {high:.3g} s asks for more than the torque limits")
    else:
        while not limited(low := 0.5 * low):
            high = low
            if low <= start / within:
                raise InputError(f"even {low:.3g} s does not reach the torque limits")
    while high > (1.0 + tolerance) * low:
        middle = math.sqrt(low * high)
        low, high = (middle, high) if limited(middle) else (low, middle)
    return FeasibleTime(high, low, runs)


def feasible_time_finding(where: str, what: str, asked: float, search: Callable[[], FeasibleTime]) -> Finding:
    """Hold the time that a scenario asks for, s, against the smallest feasible one; `what` names it, and what acts."""
    try:
        least = search()
    except InputError as error:
        return Finding(where, "feasible_time", str(error), None)
    text = (
        f"smallest {what} without saturation from this initial state: {least.time:.3g} s "
        f"({least.runs} simulated manoeuvres); set: {asked:.3g} s"
    )
    return Finding(where, "feasible_time", text, least.time <= asked, asked, least.time)


__all__ = ["FeasibleTime", "feasible_time_finding", "smallest_feasible_time"]
