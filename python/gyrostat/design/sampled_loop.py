# SPDX-License-Identifier: MIT
"""How much effectiveness the sampled loop needs and bears, measured on the compiled stack itself.

What an observer finds is fed back: subtracted as a torque, or divided by as an effectiveness. Actuators that deliver
another share `m` of their command than flight believes put that share into the loop, and below or above some `m` law
and observer swing against each other. Where these limits lie depends on every part of the stack and on the period, so
they are not derived for each observer but flown: the vehicle starts at rest, a little off a reference at rest, without
faults, noise and disturbances, its axes multiplied by `m`; an error that does not die out is an unstable loop. Several
sizes of the error serve laws and observers that are steeper near zero. The hold of the command, the order of things in
a sample and whole samples of sensor delay are those of the scenario. Limits of the actuators are met only by an error
that grows.

The closed forms in `compensation`, `iterative_learning`, `learning_disturbance` and `learning_loop` are what this is
tested against.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gyrostat import _core
from gyrostat.components import Component
from gyrostat.design.compensation import effectiveness_eigenvalues, effectiveness_range
from gyrostat.design.finding import Finding
from gyrostat.design.idle import faults_alone
from gyrostat.scenario import Scenario

Array = NDArray[np.float64]

SIZES = (0.2, 0.02, 0.002)
"""rad, errors that a trial starts with."""

WEAKEST = 0.05
"""Below it an actuator counts as dead, by default, for observers and allocators."""

STRONGEST = 4.0
"""Beyond it no margin is looked for."""

GONE = 0.05
"""Share of an error that counts as nothing; laws with powers below one are left with a chatter at each sample."""

GROWN = 1.2
"""Share of an error at which it counts as growing; what stays between this and `GONE` to the end is a limit cycle."""

_axis = np.array([1.0, -0.7, 0.5]) / np.linalg.norm([1.0, -0.7, 0.5])
_longest = 40_000  # samples of a trial


@dataclass(frozen=True)
class Trial:
    """What became of an error that was left to the loop."""

    settles: bool
    """It dies out, or falls still."""
    time: float
    """s, until it stays below `GONE` of its start; infinite when the trial was too short for that."""


@dataclass(frozen=True)
class LoopMargin:
    """Between which effectiveness of all actuators, the same for each, the sampled loop is stable."""

    lowest: float
    """`WEAKEST` when everything down to there is stable."""
    highest: float
    """`STRONGEST` when everything up to there is stable."""
    healthy: Trial
    """With full effectiveness, from the largest of `SIZES`."""

    def __str__(self) -> str:
        low = f"{self.lowest:.2g}" + (" or less" if self.lowest <= WEAKEST else "")
        high = f"{self.highest:.2g}" + (" or more" if self.highest >= STRONGEST else "")
        return f"stable for an effectiveness from {low} to {high}"


def trial(scenario: Scenario, effectiveness: Sequence[float] | float, size: float = SIZES[0]) -> Trial:
    """Leave an attitude error to the loop of a scenario whose actuators deliver a share of their commands.

    Parameters
    ----------
    scenario
        Its flight stack, true inertia and axes, and sensor delays are flown.
    effectiveness
        Delivered over commanded, one for all actuators or one each; it lasts for all of the trial.
    size
        rad.
    """
    still = scenario.replace(**quiet(scenario, effectiveness, size))
    samples = 1000
    while True:
        flown = still.replace(duration=samples * still.dt).run(channels=["error.angle", "truth.omega_BN_B"])
        if not flown.completed:
            return Trial(False, math.inf)
        angle, rate = flown["error.angle"], np.linalg.norm(flown["truth.omega_BN_B"], axis=1)
        turn = angle.max() / max(float(rate.max()), 1e-300)  # s, about one over the frequency of the motion
        swing = np.maximum(angle, still.dt * rate) / size  # what turns back within a sample shows in the rate alone
        third = len(swing) // 3
        before, after = swing[third : 2 * third].max(), swing[2 * third :].max()
        long_enough = samples * still.dt > 15.0 * turn
        if samples >= _longest or (long_enough and not GONE < after < GROWN):
            break
        samples = min(_longest, 4 * samples)
    above = np.flatnonzero(swing > GONE)
    over = 0 if not above.size else above[-1] + 1
    time = float(over * still.dt) if over < len(swing) else math.inf
    return Trial(bool(after < GONE or after < min(GROWN, 0.97 * before)), time)


def quiet(scenario: Scenario, effectiveness: Sequence[float] | float, size: float) -> dict[str, object]:
    """Changes of a scenario that leave only its loop, and an error at the start."""
    D = scenario.axes_B
    given = {} if scenario.truth is None else scenario.truth.to_dict()
    true = D + (np.asarray(given["dD_B"], dtype=float) if "dD_B" in given else 0.0)
    share = np.broadcast_to(np.asarray(effectiveness, dtype=float), D.shape[1])
    truth = {"dD_B": (true * share - D).tolist()} | ({"dJ_B": given["dJ_B"]} if "dJ_B" in given else {})
    sensors = [s for s in scenario.sensors if isinstance(s, Component)]
    delays = [Component.of(s.type, {"delay": s.params["delay"]}) for s in sensors if s.params.get("delay")]
    return {
        "truth": truth,
        "initial": {"mrp": (math.tan(size / 4.0) * _axis).tolist()},
        "reference": None,
        "integrator": "rk4" if scenario.flexible is None else "cvode",
        "desaturation": None,
        "faults": [],
        "disturbances": [],
        "drives": {},
        "sensors": delays,
        "shadows": [],
        "record": None,
        "allow_unstable": True,
        **({} if scenario.thrusters is None else {"thrusters.modulator": "proportional"}),  # without valves' dead band
    }


def settles(scenario: Scenario, effectiveness: Sequence[float] | float) -> bool:
    """Whether errors of all `SIZES` die out."""
    return all(trial(scenario, effectiveness, size).settles for size in SIZES)


def loop_margin(scenario: Scenario) -> LoopMargin:
    """The limits of a scenario's loop, to a tenth; some dozens of trials, a second or two.

    What is stable is taken to be one range of effectiveness that holds 1. Both limits are nan when the healthy loop
    does not settle.
    """
    scenario = scenario.standing()
    healthy = trial(scenario, 1.0)
    if not settles(scenario, 1.0):
        return LoopMargin(math.nan, math.nan, healthy)

    def stable(m: float) -> bool:
        return settles(scenario, m)

    return LoopMargin(_limit(stable, WEAKEST), _limit(stable, STRONGEST), healthy)


def _limit(stable: Callable[[float], bool], end: float) -> float:
    """The stable value nearest to `end`, from 1 on, by bisection of the logarithm to a tenth."""
    if stable(end):
        return end
    good, bad = 0.0, math.log(end)
    while abs(good - bad) > 0.1:
        middle = 0.5 * (good + bad)
        good, bad = (middle, bad) if stable(math.exp(middle)) else (good, middle)
    return math.exp(good)


def left_by_faults(scenario: Scenario, most: int = 3) -> Array:
    """States of effectiveness that the faults of a scenario leave and that still produce torque about every axis.

    Returns
    -------
    NDArray
        Shape (k, n), k at most `most`, the weakest first; empty without faults.
    """
    D = scenario.axes_B
    if not scenario.faults:
        return np.empty((0, D.shape[1]))
    rows = np.unique(faults_alone(scenario, ["truth.effectiveness"])["truth.effectiveness"], axis=0)
    rows = rows[(rows != 1.0).any(axis=1)]
    least = effectiveness_eigenvalues(D, rows)[:, 0]
    weakest_first = np.argsort(least, kind="stable")
    rows = rows[weakest_first[least[weakest_first] > 1e-2]]
    chosen: list[Array] = []
    while len(rows) and len(chosen) < most:
        chosen.append(rows[0])
        rows = rows[np.abs(rows - rows[0]).max(axis=1) >= 0.01]  # a fault that varies leaves many states that are alike
    return np.array(chosen).reshape(-1, D.shape[1])


def closes_a_loop(scenario: Scenario) -> bool:
    """Whether an estimate is made and a controller regulates the attitude; a Python component is taken to do so."""
    observer, controller = scenario.observer, scenario.controller
    if observer is None or (isinstance(observer, Component) and not _trait("observer", observer, "estimates")):
        return False
    return not isinstance(controller, Component) or bool(_trait("controller", controller, "regulates"))


def _trait(family: str, component: Component, name: str) -> object:
    return _core.describe(family, component.type)["traits"][name]


def findings(scenario: Scenario, effectiveness: tuple[float, float] | None = None) -> list[Finding]:
    """What ``gyrostat check`` says about the loop that the estimate closes.

    It fails where the healthy loop, or the loop with what the faults leave, does not settle.

    Parameters
    ----------
    scenario
        Faults are flown as they are at their weakest.
    effectiveness
        A range to hold the loop against instead.
    """
    if not closes_a_loop(scenario):
        return []
    where = "sampled loop"
    margin = loop_margin(scenario)
    if math.isnan(margin.lowest):
        text = f"an error of {np.rad2deg(SIZES[0]):.2g} deg or less does not die out with healthy actuators"
        return [Finding(where, "healthy", text, False)]
    found = [_healthy(where, margin.healthy, scenario.duration)]
    D = scenario.axes_B
    left = left_by_faults(scenario)
    low, high = effectiveness or (effectiveness_range(D, left) if len(left) else (1.0, 1.0))
    inside = margin.lowest <= low and high <= margin.highest
    text = f"{margin}; " + (f"asked are {low:.3g} to {high:.3g}" if effectiveness else f"the faults leave {low:.3g}")
    verdict = True if inside else False if effectiveness else None  # what the faults leave is flown below
    found.append(Finding(where, "effectiveness", text, verdict, low, margin.lowest))
    for row in left:
        good = settles(scenario, row.tolist())
        text = f"effectiveness {', '.join(f'{e:.3g}' for e in row)}, as the faults leave it: "
        text += "errors die out" if good else "an error does not die out, estimate and law swing against each other"
        found.append(Finding(where, "faults", text, good, float(effectiveness_range(D, row[None])[0]), margin.lowest))
    return found


def _healthy(where: str, healthy: Trial, duration: float) -> Finding:
    start = np.rad2deg(SIZES[0])
    if math.isinf(healthy.time):
        return Finding(
            where, "healthy", f"an error of {start:.2g} deg falls, not to {100.0 * GONE:.2g} % within the trial", None
        )
    late = ", longer than the run" if healthy.time > duration else ""
    text = f"an error of {start:.2g} deg is down to {100.0 * GONE:.2g} % after {healthy.time:.3g} s{late}"
    return Finding(where, "healthy", text, None, healthy.time, duration)


__all__ = [
    "SIZES",
    "STRONGEST",
    "WEAKEST",
    "LoopMargin",
    "Trial",
    "closes_a_loop",
    "findings",
    "left_by_faults",
    "loop_margin",
    "settles",
    "trial",
]
