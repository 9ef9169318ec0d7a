# SPDX-License-Identifier: MIT
"""Bending modes of the appendages against the loop that turns the vehicle.

A mode is seen at the frequency of the free body, which lies above that of the body held. A law whose bandwidth comes
near the lowest of them drives the mode instead of damping it; a factor of three or more between the two is common.
"""

from __future__ import annotations

import math

import numpy as np

from gyrostat.design.finding import Finding
from gyrostat.design.sampled_loop import quiet
from gyrostat.scenario import Scenario

APART = 3.0
"""Lowest frequency of the appendages over the bandwidth, from which the two are called apart."""

LARGE = 0.2
"""Of the lowest frequency: a body that turns faster stiffens its appendages, which the model leaves out."""

_size = 0.002  # rad, the error that the bandwidth is measured with: far from every limit
_longest_step = 0.5  # rad of the quickest mode in a step of rk4, below which its error does not show


def findings(scenario: Scenario) -> list[Finding]:
    """What is to be known of a vehicle that bends; nothing of a rigid one.

    Parameters
    ----------
    scenario
        Vehicle, truth, appendages, initial state, stack and integrator.
    """
    if scenario.flexible is None:
        return []
    frequencies = scenario.compiled.free_frequencies()
    lowest, quickest = frequencies[0], frequencies[-1]
    shown = ", ".join(f"{w:.4g}" for w in frequencies)
    found = []
    width = bandwidth(scenario)
    if width is None:
        text = f"{shown} rad/s; a small error does not die out"
        found.append(Finding("flexible", "free frequencies", text, None, lowest))
    else:
        apart = lowest / width
        text = f"{shown} rad/s, the lowest {apart:.3g} times the loop's bandwidth of {width:.3g} rad/s"
        if apart < APART:
            text += f"; below {APART:g} the loop drives the mode"
        found.append(Finding("flexible", "free frequencies", text, True if apart >= APART else None, apart, APART))
    rate = float(np.linalg.norm((scenario.initial and scenario.initial.omega_BN_B) or (0.0, 0.0, 0.0)))
    if rate > LARGE * lowest:
        text = f"{rate:.3g} rad/s at the start, above {LARGE:g} of the lowest mode: what turning stiffens is left out"
        found.append(Finding("flexible", "initial rate", text, None, rate, LARGE * lowest))
    for k, row in enumerate(np.atleast_2d(np.asarray(scenario.flexible.delta, dtype=float))):
        if not row.any():
            found.append(Finding("flexible", "delta", f"mode {k} is not coupled to the body"))
    integrator = scenario.resolve()["integrator"]
    if integrator["type"] == "rk4":
        passed = quickest * scenario.dt / int(integrator.get("substeps", 1))
        if passed > _longest_step:
            text = f"{passed:.3g} rad of the quickest mode in a step: its amplitude errs by {passed**6 / 144:.1g} each"
            found.append(Finding("integrator rk4", "modes", text, None, passed, _longest_step))
    return found


def bandwidth(scenario: Scenario) -> float | None:
    """Natural frequency of the closed loop of a scenario, rad/s; None when a small error does not fall.

    Measured on the rigid vehicle: of a critically damped loop ``(1 + w t) exp(-w t)`` an error has fallen to 1/e at
    ``w t = 2.146``, of one with less damping a little earlier.
    """
    rigid = scenario.replace(**(quiet(scenario, 1.0, _size) | {"flexible": None}))
    samples = 1000
    while samples <= 64_000:
        flown = rigid.replace(duration=samples * rigid.dt).run(channels=["error.angle"])
        if not flown.completed:
            return None
        below = np.flatnonzero(flown["error.angle"] < _size / math.e)
        if below.size:
            return float(2.146 / max(below[0] * rigid.dt, rigid.dt))
        samples *= 4
    return None
