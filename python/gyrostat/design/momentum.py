# SPDX-License-Identifier: MIT
"""How long wheels take what turns a vehicle from outside, and what empties them again."""

from __future__ import annotations

import math

import numpy as np

from gyrostat.design.finding import Finding
from gyrostat.scenario import Scenario

_samples = 2000  # of the loop without faults, at most


def findings(scenario: Scenario) -> list[Finding]:
    """What ``gyrostat check`` says of the momentum of wheels that can fill; nothing where none can, or nothing fills them.

    The torque from outside is averaged in inertial axes over one orbit, or the scenario, of the loop without faults.

    Parameters
    ----------
    scenario
        Vehicle, orbit and disturbances.
    """
    room = capacity(scenario)
    if not scenario.disturbances or not 0.0 < room < math.inf:
        return []
    mean = float(np.linalg.norm(mean_torque(scenario)))
    if mean * scenario.duration < 1e-3 * room:
        return []
    lasts = room / mean
    text = f"a mean torque of {mean:.2g} N m from outside fills the first of them in {_time(lasts)}"
    if scenario.desaturation is None:
        text += "; nothing empties them"
        return [
            Finding("momentum", "wheels", text, None if lasts > scenario.duration else False, lasts, scenario.duration)
        ]
    rate = scenario.compiled.orbit_rate() * float(scenario.resolve()["desaturation"].get("gain", 2.0))
    level = mean / (rate * _share) if rate > 0.0 else math.inf
    if level == math.inf:
        return [Finding("momentum", "wheels", f"{text}; a gain of 0 empties nothing", False, lasts, scenario.duration)]
    text += f"; magnetorquers hold them near {level:.2g} of {room:.2g} N m s"
    return [Finding("momentum", "wheels", text, level < room, level, room)]


_share = 0.5  # of the gain, in the direction that the field leaves least over an orbit


def capacity(scenario: Scenario) -> float:
    """Momentum, N m s, that the wheels of a scenario hold in every direction, shared by least norm; infinite without a limit."""
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


def mean_torque(scenario: Scenario) -> np.ndarray:
    """(3,) N m, of the disturbances, inertial axes, over one orbit or the scenario."""
    rate = scenario.compiled.orbit_rate()
    length = min(scenario.duration, 2.0 * math.pi / rate) if rate > 0.0 else scenario.duration
    samples = max(1, min(_samples, round(length / scenario.dt)))
    flown = scenario.replace(
        faults=[], sensors=[], shadows=[], record=None, navigator=None, duration=samples * scenario.dt
    ).run(channels=["truth.q_NB", "truth.external_B"])
    q, torque = flown["truth.q_NB"], flown["truth.external_B"]
    v = q[:, 1:]
    across = 2.0 * np.cross(v, torque)
    return np.asarray((torque + q[:, :1] * across + np.cross(v, across)).mean(axis=0))


def _time(seconds: float) -> str:
    return f"{seconds:.3g} s" if seconds < 600.0 else f"{seconds / 3600.0:.2g} h"
