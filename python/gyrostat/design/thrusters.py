# SPDX-License-Identifier: MIT
"""On/off thrusters under a stack: what their smallest pulse leaves of the pointing, and who knows one-sided limits."""

from __future__ import annotations

import numpy as np

from gyrostat.design.finding import Finding
from gyrostat.scenario import Scenario
from gyrostat.vehicle import all_actuators

_knows_no_bounds = "pseudo_inverse"


def findings(scenario: Scenario) -> list[Finding]:
    """What is to be known of thrusters; nothing of a vehicle without them.

    Parameters
    ----------
    scenario
        Vehicle, thrusters and allocator.
    """
    if scenario.thrusters is None:
        return []
    found = []
    plain = scenario.resolve()
    vehicle = scenario.compiled.flight_model()["vehicle"] if not scenario.python_components() else None
    low = np.asarray(all_actuators(plain)["u_min"], dtype=float)
    if plain["allocator"].get("type") == _knows_no_bounds and (low == 0.0).any():
        text = (
            "asks for torque below zero of actuators that give none, and takes it for delivered; an allocator that "
            "knows limits: weighted_least_squares, lexicographic"
        )
        found.append(Finding(f"allocator {_knows_no_bounds}", "one-sided limits", text))
    if vehicle is None or not vehicle["u_quantum"]:
        return found
    axes, smallest = np.asarray(vehicle["D_B"], dtype=float), np.asarray(vehicle["u_dead"], dtype=float)
    step = (
        scenario.dt
        * np.linalg.norm(np.linalg.solve(np.asarray(vehicle["J_B"], dtype=float), axes * smallest), axis=0).max()
    )
    text = (
        f"{1e3 * smallest.max():.3g} mN m as a mean of a sample, a step of the rate of {1e6 * step:.3g} urad/s: "
        "the attitude ends in a limit cycle of that"
    )
    found.append(Finding("thrusters", "smallest pulse", text, None, float(smallest.max())))
    return found


__all__ = ["findings"]
