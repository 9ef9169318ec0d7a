# SPDX-License-Identifier: MIT
"""Quantities of the li2018 claims that are computed from channels."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from gyrostat import metrics
from gyrostat.results import Result

Array = NDArray[np.float64]


def inertia(result: Result) -> Array:
    """Nominal inertia of the vehicle, kg m^2."""
    return np.array(result.description["vehicle"]["J_B"], dtype=float)


def z2(result: Result) -> Array:
    """Error of the observer's integral, ``J^-1 dbar - eta``, rad/s^2 (eq. 10).

    At a sample: with the command held over the interval just ended and the faults just before it.
    """
    return np.linalg.solve(inertia(result), result["truth.lumped_B"].T).T - result["observer.eta"]


def lyapunov(result: Result) -> Array:
    """Lyapunov function of the nominal law (eq. 21), J."""
    gains = result.description["controller"]
    power = 1.0 + gains["beta1"]
    omega = result["truth.omega_BN_B"]
    kinetic = 0.5 * np.einsum("ki,ij,kj->k", omega, inertia(result), omega)
    attitude: Array = np.sum(np.abs(result["truth.mrp"]) ** power, axis=1)
    return np.asarray(kinetic + gains["k1"] / power * attitude)


def utilisation(result: Result) -> Array:
    """Command that wheel 2 needs at rest, over its limit: after 10 s of Table 2 three wheels are left, so it is unique.

    At rest the wheels must give minus the disturbance; what wheel 2 adds on its own is no help, and a command arrives
    only in part.
    """
    vehicle = result.description["vehicle"]
    D_B = np.array(vehicle["D_B"], dtype=float)
    dead = D_B[:, 3] * result["truth.bias"][-1, 3]
    share = np.linalg.solve(D_B[:, :3], -_disturbance_at_rest(result) - dead)[2]
    needed = (share - result["truth.bias"][:, 2]) / result["truth.effectiveness"][:, 2]
    return np.asarray(np.abs(needed) / vehicle["u_max"])


def _disturbance_at_rest(result: Result) -> Array:
    """The rate-driven disturbance at zero rate, N m: (-1.5, 3.75, 2.25) mN m."""
    (law,) = result.description["disturbances"]
    torque_B = np.array(law["offset_B"], dtype=float)
    for axis, amplitude, phase in zip(law["axis"], law["amplitude"], law["phase"], strict=True):
        torque_B[int(axis)] += amplitude * np.sin(phase)
    return torque_B


def settling_difference(result: Result, *, signal: Array, against: Result, other: Array, band: float) -> float:
    """Settling time to a band less that of another case, s."""
    return metrics.settling_time(result.t, signal, band) - metrics.settling_time(against.t, other, band)


def largest_increase(result: Result, *, signal: Array) -> float:
    """Largest growth from one sample to the next; negative when the signal only falls."""
    del result
    return float(np.max(np.diff(signal)))


SIGNALS = {"z2": z2, "V2": lyapunov, "utilisation": utilisation}
METRICS = {f.__name__: f for f in (settling_difference, largest_increase)}
