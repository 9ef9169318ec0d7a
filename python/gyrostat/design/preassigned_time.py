# SPDX-License-Identifier: MIT
"""The preassigned time: its path, and the smallest time that the actuators can keep."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from gyrostat.design import feasible_time
from gyrostat.design.feasible_time import FeasibleTime
from gyrostat.design.finding import Finding
from gyrostat.errors import InputError
from gyrostat.scenario import Scenario

Array = NDArray[np.float64]

_law = "preassigned_time_sliding_mode"


def quintic_coefficients() -> Array:
    """Coefficients ``a_ij`` of the path, solved from ``p = p' = p'' = 0`` at the end; shape (3, 3)."""
    powers = np.arange(3, 6)
    ends = np.array([np.ones(3), powers, powers * (powers - 1)], dtype=float)
    starts = np.array([[1.0, 1.0, 0.5], [0.0, 1.0, 1.0], [0.0, 0.0, 1.0]])
    return np.linalg.solve(ends, -starts)


def quintic(t: ArrayLike, T: float, d0: float, d1: float, d2: float) -> Array:
    """Path and its two derivatives, shape (len(t), 3): starts with `d0`, `d1`, `d2`, is zero from `T` on."""
    if not T > 0.0:
        raise InputError(f"T = {T:g} s must be positive")
    x = np.atleast_1d(np.asarray(t, dtype=float)) / T
    scaled = np.array([d0, d1 * T, d2 * T * T])
    c = np.concatenate([scaled * [1.0, 1.0, 0.5], quintic_coefficients() @ scaled])
    path = np.polynomial.Polynomial(c)
    out = np.stack([path(x), path.deriv()(x) / T, path.deriv(2)(x) / T**2], axis=1)
    out[x >= 1.0] = 0.0
    return out


def saturates(scenario: Scenario, T: float) -> bool:
    """Whether a run with preassigned time `T`, s, kept as it is, asks for more than the commands can give.

    An actuator at a limit is none as long as the others make up for it: one-sided ones rest at theirs. A run that ends
    early counts as one that asks for too much.
    """
    channels = ["demand.tau_B", "allocation.achieved_B"]
    run = scenario.replace(**{"controller.T": T, "controller.stretch": 0.0}).run(channels=channels)
    asked = run["demand.tau_B"]
    short = np.linalg.norm(run["allocation.achieved_B"] - asked, axis=1)
    return not run.completed or bool((short > 1e-6 * np.linalg.norm(asked, axis=1).max()).any())


def smallest_feasible_time(scenario: Scenario, tolerance: float = 1e-3) -> FeasibleTime:
    """The smallest preassigned time whose demand the commands can give from a scenario's initial state.

    Parameters
    ----------
    scenario
        Flies ``preassigned_time_sliding_mode`` on a vehicle with limits; its faults and disturbances act.
    tolerance
        Relative width of the bracket at which to stop.

    Raises
    ------
    InputError
        Another controller, or no time from a 64th to 64 times the present one brackets the limit.
    """
    law = scenario.resolve()["controller"]
    if law.get("type") != _law:
        raise InputError(f"the scenario does not fly controller '{_law}'")
    return feasible_time.smallest_feasible_time(lambda T: saturates(scenario, T), float(law["T"]), tolerance=tolerance)


def findings(scenario: Scenario) -> list[Finding]:
    """What ``gyrostat check`` says about a preassigned time; nothing without limits, with thrusters or for another law.

    The smallest feasible time flies some twenty manoeuvres.
    """
    plain = scenario.resolve()
    law, limit = plain["controller"], None if scenario.thrusters is not None else plain["vehicle"].get("u_max")
    if law.get("type") != _law or limit is None or not np.all(np.isfinite(np.asarray(limit, dtype=float))):
        return []
    where = f"controller {_law}"
    return [feasible_time.feasible_time_finding(where, "T", float(law["T"]), lambda: smallest_feasible_time(scenario))]


__all__ = ["findings", "quintic", "quintic_coefficients", "saturates", "smallest_feasible_time"]
