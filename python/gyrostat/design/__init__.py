# SPDX-License-Identifier: MIT
"""Gain design and theorem margins, in numpy.

`CHECKS` is what ``gyrostat check`` asks besides the components themselves: each takes a scenario and returns its
findings, none when the scenario does not fly what it knows about.
"""

from collections.abc import Callable

from gyrostat.design.compensation import (
    CompensationMargin,
    compensation_margin,
    critical_effectiveness,
    effectiveness_range,
    scenario_margin,
)
from gyrostat.design.feasibility import attainable_after_faults, torque_findings
from gyrostat.design.finding import Finding
from gyrostat.scenario import Scenario

CHECKS: tuple[Callable[[Scenario], list[Finding]], ...] = ()

__all__ = [
    "CHECKS",
    "CompensationMargin",
    "Finding",
    "attainable_after_faults",
    "compensation_margin",
    "critical_effectiveness",
    "effectiveness_range",
    "scenario_margin",
    "torque_findings",
]
