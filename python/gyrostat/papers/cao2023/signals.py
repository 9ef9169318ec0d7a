# SPDX-License-Identifier: MIT
"""Quantities of the cao2023 claims that are computed from channels."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from gyrostat import metrics
from gyrostat.results import Result

Array = NDArray[np.float64]


def fault(result: Result) -> Array:
    """Lumped angular acceleration ``f``, rad/s^2: what faults and disturbance do beyond the known motion."""
    J = np.array(result.description["vehicle"]["J_B"], dtype=float)
    matrix = np.diag(J) if J.ndim == 1 else J
    return np.linalg.solve(matrix, result["truth.lumped_B"].T).T


def estimation_error(result: Result) -> Array:
    """``ft = f - fhat``, rad/s^2."""
    return fault(result) - result["observer.f_hat"]


def path_error(result: Result) -> Array:
    """``z - p``, rad: distance of the attitude error from its preassigned path."""
    return result["error.euler"] - result["controller.p"]


def unmet(result: Result) -> Array:
    """Demand that the allocation leaves, N m."""
    return result["demand.tau_B"] - result["allocation.achieved_B"]


def all_one_sided(result: Result) -> Array:
    """1 where every command is positive or zero: a sample that one-sided actuators could fly."""
    return np.asarray((result["allocation.u"] >= 0.0).all(axis=1), dtype=np.float64)


def rate_deception(result: Result) -> Array:
    """What the rate sensor shows less the truth, rad/s."""
    return result["measurement.omega_BN_B"] - result["truth.omega_BN_B"]


def at(result: Result, *, signal: Array, instant: float) -> float:
    """Largest ``|signal|`` at one sample."""
    row = round(instant / float(result.description["dt"]))
    if row >= len(result.t):
        raise ValueError(f"the run ended at {result.end_time:g} s: {result.cause or result.status}")
    return float(np.abs(signal[row]).max())


def stays_below(result: Result, *, signal: Array, band: float, after: float = 0.0, until: float = np.inf) -> float:
    """Time from `after` until the norm of the signal stays below `band`, as far as `until`, s."""
    part = (result.t >= after - 1e-9) & (result.t <= until + 1e-9)
    return metrics.settling_time(result.t[part], np.linalg.norm(signal[part], axis=1), band, after)


def mean(result: Result, *, signal: Array) -> float:
    """Mean of a signal of one column."""
    del result
    return float(np.mean(signal))


def rms_ratio(
    result: Result, *, signal: Array, against: Result, other: Array, window: tuple[float, float] = (10.5, 15.0)
) -> float:
    """Root mean square of the norm over that of another case."""
    return metrics.window_rms(result.t, signal, *window) / metrics.window_rms(against.t, other, *window)


SIGNALS = {
    "f": fault,
    "ft": estimation_error,
    "path_error": path_error,
    "unmet": unmet,
    "all_one_sided": all_one_sided,
    "rate_deception": rate_deception,
}
METRICS = {f.__name__: f for f in (at, stays_below, mean, rms_ratio)}
