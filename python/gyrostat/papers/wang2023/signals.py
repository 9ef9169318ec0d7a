# SPDX-License-Identifier: MIT
"""Quantities of the wang2023 claims that are computed from channels."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from gyrostat.results import Result

Array = NDArray[np.float64]


def fault_error(result: Result) -> Array:
    """Torque fault less what the observer has learnt, N m. The actuators lie along the body axes."""
    return np.asarray(result["truth.bias"] - result["estimate.d_B"])


def vector(result: Result) -> Array:
    """Vector part of the attitude quaternion; the target is zero."""
    return np.asarray(result["truth.q_NB"][:, 1:])


def vector_norm(result: Result) -> Array:
    """Its Euclidean norm, one column."""
    return np.asarray(np.linalg.norm(vector(result), axis=1, keepdims=True))


def vector_norm_error(result: Result) -> Array:
    """How far the quaternion is from unit length."""
    return np.asarray(np.abs(np.linalg.norm(result["truth.q_NB"], axis=1, keepdims=True) - 1.0))


def _late(result: Result, x: Array, window: tuple[float, float]) -> Array:
    return np.asarray(x[(result.t >= window[0] - 1e-9) & (result.t <= window[1] + 1e-9)])


def deviation(result: Result, *, signal: Array, against: Result, other: Array, window: tuple[float, float]) -> float:
    """Standard deviation of the difference to another case in a window."""
    del against
    return float(np.std(_late(result, signal - other, window)))


def step_rms(result: Result, *, signal: Array, window: tuple[float, float]) -> float:
    """Root mean square of the change from one sample to the next in a window."""
    return float(np.sqrt(np.mean(np.diff(_late(result, signal, window), axis=0) ** 2)))


def step_rms_ratio(
    result: Result, *, signal: Array, against: Result, other: Array, window: tuple[float, float]
) -> float:
    """`step_rms` over that of another case."""
    return step_rms(result, signal=signal, window=window) / step_rms(against, signal=other, window=window)


SIGNALS = {
    "fault_error": fault_error,
    "vector": vector,
    "vector_norm": vector_norm,
    "norm_error": vector_norm_error,
}
METRICS = {f.__name__: f for f in (deviation, step_rms, step_rms_ratio)}
