# SPDX-License-Identifier: MIT
"""The truth's own time constants against the period: how many steps a sample they ask of the integrator."""

from __future__ import annotations

import math

from gyrostat.design.finding import Finding
from gyrostat.scenario import Scenario


def findings(scenario: Scenario) -> list[Finding]:
    """What asks for more than the chosen steps a sample; nothing when nothing does.

    Turning and precession are those at the start; a vehicle that speeds up, or whose wheels fill, is quicker later.

    Parameters
    ----------
    scenario
        Vehicle, truth, initial state, period and integrator.
    """
    plain = scenario.resolve()
    dt, integrator = float(plain["dt"]), plain["integrator"]
    rates = scenario.compiled.inner_rates()
    passed = dt * (rates["turning"] + rates["friction"])
    chosen = int(integrator.get("substeps", 1))
    steps = math.ceil(passed / rates["longest_step"])
    if steps <= chosen:
        return []
    most = rates["most_in_a_sample"]
    which = "viscous friction" if rates["friction"] > rates["turning"] else "turning and precession"
    text = f"{passed:.3g} time constants of the truth in a sample of {dt:g} s, mostly of {which}"
    if passed > most:
        text += f"; beyond {most:g} the run ends"
    elif integrator["type"] == "rk4":
        text += f"; rk4 takes {steps} steps for them instead of {chosen}"
    else:
        text += f"; {integrator['type']} takes about {steps} steps for them"
    return [Finding(f"integrator {integrator['type']}", "time constants", text, passed <= most, passed, most)]
