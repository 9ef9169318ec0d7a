# SPDX-License-Identifier: MIT
"""Gain design and theorem margins, in numpy."""

from gyrostat.design.compensation import (
    CompensationMargin,
    compensation_margin,
    critical_effectiveness,
    effectiveness_range,
    scenario_margin,
)

__all__ = [
    "CompensationMargin",
    "compensation_margin",
    "critical_effectiveness",
    "effectiveness_range",
    "scenario_margin",
]
