# SPDX-License-Identifier: MIT
"""Quantities of the cao2022 claims that are computed from channels."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from gyrostat.results import Result

Array = NDArray[np.float64]

FAULTS = (5.0, 8.0, 10.0)
"""s, onset of the fault of each wheel."""


def effectiveness_now(result: Result) -> Array:
    """True effectiveness over the interval just ended; healthy at the first sample."""
    e = result["truth.effectiveness"].copy()
    e[0] = 1.0
    return e


def effectiveness_error(result: Result) -> Array:
    """Effectiveness less its estimate."""
    return effectiveness_now(result) - result["estimate.effectiveness"]


def shadow_error(result: Result) -> Array:
    """Effectiveness less the estimate of the observer that only looks on."""
    return effectiveness_now(result) - result["shadow0.estimate.effectiveness"]


def inertia_error(result: Result) -> Array:
    """Estimate less the effectiveness over 1.1: what an inertia 10 % larger than known looks like."""
    return result["estimate.effectiveness"] - effectiveness_now(result) / 1.1


def breach(result: Result) -> Array:
    """1 where the error is larger than the bound the observer gives for it, 0 where it is not, or no bound is given."""
    bound = result["estimate.effectiveness_bound"] * result["estimate.effectiveness"]
    return (np.abs(effectiveness_error(result)) > bound).astype(float)


def unknown(result: Result) -> Array:
    """1 where the observer says that it does not know an actuator."""
    return np.isinf(result["estimate.effectiveness_bound"]).astype(float)


def attitude(result: Result) -> Array:
    """|sigma| of the short way, one column."""
    return np.asarray(np.linalg.norm(result["truth.mrp"], axis=1, keepdims=True), dtype=np.float64)


def rate(result: Result) -> Array:
    """|omega|, rad/s, one column."""
    return np.asarray(np.linalg.norm(result["truth.omega_BN_B"], axis=1, keepdims=True), dtype=np.float64)


def disturbance(result: Result) -> Array:
    """The printed disturbance, N m, from time and true rate."""
    t = result.t
    waves = np.column_stack([np.sin(0.8 * t), np.cos(0.5 * t), np.cos(0.3 * t)])
    return np.asarray(0.01 * (np.sum(result["truth.omega_BN_B"] ** 2, axis=1, keepdims=True) + 0.05) * waves)


SIGNALS = {
    f.__name__: f
    for f in (effectiveness_error, shadow_error, inertia_error, breach, unknown, attitude, rate, effectiveness_now)
}
