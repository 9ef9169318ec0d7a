# SPDX-License-Identifier: MIT
"""How long wheels take what turns a vehicle from outside, and what empties them again."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from gyrostat.design.finding import Finding
from gyrostat.scenario import Scenario

_samples = 20_000  # of the loop without faults, at most


def findings(scenario: Scenario) -> list[Finding]:
    """What ``gyrostat check`` says of wheels that can fill; nothing where none can, or nothing fills them.

    The torque from outside is averaged in inertial axes over one orbit, or the scenario, of the loop without faults.

    Parameters
    ----------
    scenario
        Vehicle, orbit and disturbances.
    """
    room = capacity(scenario)
    if not scenario.disturbances or not 0.0 < room < math.inf:
        return []
    torque, share = means(scenario)
    mean = float(np.linalg.norm(torque))
    if mean * scenario.duration < 1e-3 * room:
        return []
    lasts = room / mean
    text = f"a mean torque of {mean:.2g} N m from outside fills the first of them in {_time(lasts)}"
    if scenario.desaturation is None:
        text += "; nothing empties them"
        return [
            Finding("momentum", "wheels", text, None if lasts > scenario.duration else False, lasts, scenario.duration)
        ]
    gain = scenario.desaturation.gain
    rate = scenario.compiled.orbit_rate() * (2.0 if gain is None else gain) * share
    if rate <= 0.0:
        return [Finding("momentum", "wheels", f"{text}; a gain of 0 empties nothing", False, lasts, scenario.duration)]
    level = mean / rate
    text += f"; magnetorquers hold them near {level:.2g} of {room:.2g} N m s"
    return [Finding("momentum", "wheels", text, level < room, level, room)]


def capacity(scenario: Scenario) -> float:
    """Momentum, N m s, that the wheels hold in every direction, shared by least norm; infinite without a limit."""
    vehicle, truth = scenario.vehicle, scenario.truth
    D = vehicle.torque_axes
    inertia = np.broadcast_to(np.asarray(vehicle.wheel_inertia or 0.0, dtype=float), D.shape[1])
    given = truth.momentum_max if truth is not None and truth.momentum_max is not None else vehicle.momentum_max
    most = np.broadcast_to(np.asarray(math.inf if given is None else given, dtype=float), D.shape[1])
    wheels = inertia > 0.0
    if not wheels.any() or np.linalg.matrix_rank(D[:, wheels]) < 3:
        return math.inf
    share = np.linalg.norm(np.linalg.pinv(D[:, wheels]), axis=1)
    return float(np.min(most[wheels] / share))


def means(scenario: Scenario) -> tuple[NDArray[np.float64], float]:
    """What holds on the average over one orbit, or the scenario, in inertial axes.

    Returns
    -------
    NDArray
        (3,) N m, torque of the disturbances.
    float
        Share of a momentum that lies across the field, in the direction that has least of it; 1 without an orbit.
    """
    rate = scenario.compiled.orbit_rate()
    length = min(scenario.duration, 2.0 * math.pi / rate) if rate > 0.0 else scenario.duration
    samples = max(1, min(_samples, round(length / scenario.dt)))
    channels = ["truth.q_NB", "truth.external_B", *(["truth.field_B"] if scenario.orbit else [])]
    alone = scenario.replace(
        faults=[], sensors=[], shadows=[], record=None, navigator=None, duration=samples * scenario.dt
    )
    flown = alone.run(channels=channels)
    torque = _turned(flown["truth.q_NB"], flown["truth.external_B"]).mean(axis=0)
    if scenario.orbit is None:
        return torque, 1.0
    b = _turned(flown["truth.q_NB"], flown["truth.field_B"])
    b /= np.linalg.norm(b, axis=1, keepdims=True)
    return torque, float(1.0 - np.linalg.eigvalsh(b.T @ b / len(b))[2])


def _turned(q_NB: NDArray[np.float64], v_B: NDArray[np.float64]) -> NDArray[np.float64]:
    """Rows of body vectors in inertial axes."""
    across = 2.0 * np.cross(q_NB[:, 1:], v_B)
    return np.asarray(v_B + q_NB[:, :1] * across + np.cross(q_NB[:, 1:], across))


def _time(seconds: float) -> str:
    return f"{seconds:.3g} s" if seconds < 600.0 else f"{seconds / 3600.0:.2g} h"
