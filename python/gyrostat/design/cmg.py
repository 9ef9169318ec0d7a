# SPDX-License-Identifier: MIT
"""Gimbals against the period of the loop, and against the singularities of their arrangement."""

from __future__ import annotations

import numpy as np

from gyrostat.design.finding import Finding
from gyrostat.scenario import Scenario

LARGEST_TURN = 0.2
"""rad of a gimbal in a sample, above which a command acts along axes that have moved on meanwhile."""

SINGULAR = 0.1
"""Of sqrt det(D D'), below which gyros are called singular."""


def findings(scenario: Scenario) -> list[Finding]:
    """What is to be known of a vehicle with control moment gyros; nothing of any other.

    Parameters
    ----------
    scenario
        Gyros, period and allocator.
    """
    if scenario.cmg is None:
        return []
    found = []
    D = scenario.cmg.axes_B()
    m = float(np.sqrt(max(np.linalg.det(D @ D.T), 0.0)))
    text = f"singularity measure {m:.3g} at the start"
    if m < SINGULAR:
        text += f"; below {SINGULAR:g} there is an axis about which the gyros give no torque"
    found.append(Finding("cmg", "angles", text, True if m >= SINGULAR else None, m, SINGULAR))
    turn = float(np.max(np.asarray(scenario.cmg.rate_max, dtype=float))) * scenario.dt
    if turn > LARGEST_TURN:
        text = f"{turn:.3g} rad in a sample: above {LARGEST_TURN:g} axes move on while a command holds"
        found.append(Finding("cmg", "rate_max", text, None, turn, LARGEST_TURN))
    allocator = scenario.allocator
    steering = "pseudo_inverse" if allocator is None else getattr(allocator, "type", None)  # None: a Python object
    if steering is not None and steering != "singularity_robust":
        text = f"{steering} gives up an axis that is weak, and does not leave a singularity; singularity_robust does"
        found.append(Finding("cmg", "allocator", text))
    return found
