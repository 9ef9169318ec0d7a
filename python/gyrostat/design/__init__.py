# SPDX-License-Identifier: MIT
"""Gain design, theorem margins and feasibility, in numpy: a module for each law or question.

`CHECKS` is what ``gyrostat check`` asks besides the components themselves: each takes a scenario and returns its
findings, none when the scenario does not fly what it knows about. `findings` is all of them, with the questions that
take an option. `FIGURES` is what ``gyrostat check --out`` draws, by name. `DESIGNS` is what ``gyrostat design`` offers.
"""

from collections.abc import Callable, Sequence

from gyrostat.design import (
    bandwidth,
    bandwidth_rules,
    cmg,
    compensation,
    estimate_use,
    feasibility,
    feasible_time,
    flexible,
    identifiability,
    iterative_learning,
    learning_disturbance,
    learning_effectiveness,
    learning_loop,
    linear_loop,
    mixed_learning,
    mixed_learning_tool,
    momentum,
    preassigned_time,
    predefined_time,
    sampled_loop,
    thrusters,
    time_constants,
)
from gyrostat.design.compensation import (
    CompensationMargin,
    compensation_margin,
    critical_effectiveness,
    effectiveness_range,
    scenario_margin,
)
from gyrostat.design.feasibility import attainable_after_faults, torque_findings
from gyrostat.design.finding import Finding
from gyrostat.design.registry import Design, DesignReport
from gyrostat.design.sampled_loop import LoopMargin, loop_margin
from gyrostat.plots import Figure
from gyrostat.scenario import Scenario

CHECKS: tuple[Callable[[Scenario], list[Finding]], ...] = (
    estimate_use.findings,
    flexible.findings,
    identifiability.findings,
    iterative_learning.findings,
    learning_disturbance.findings,
    learning_effectiveness.findings,
    mixed_learning_tool.findings,
    momentum.findings,
    preassigned_time.findings,
    predefined_time.findings,
    thrusters.findings,
    time_constants.findings,
)

FIGURES: tuple[Callable[[Scenario], dict[str, Figure]], ...] = (learning_disturbance.figures,)


def findings(
    scenario: Scenario,
    *,
    effectiveness: tuple[float, float] | None = None,
    torque_B: Sequence[float] | None = None,
    fly: bool = False,
) -> list[Finding]:
    """Everything that ``gyrostat check`` finds out about a scenario besides the components' own checks.

    Parameters
    ----------
    scenario
        What is looked at.
    effectiveness
        As in `compensation.findings` and `sampled_loop.findings`.
    torque_B, fly
        As in `torque_findings`.

    Returns
    -------
    list of Finding
        Of a vehicle with control moment gyros, what is asked of its axes is asked of those at the start.
    """
    gimbals, scenario = cmg.findings(scenario), scenario.standing()
    return [
        *gimbals,
        *(finding for look in CHECKS for finding in look(scenario)),
        *compensation.findings(scenario, effectiveness),
        *sampled_loop.findings(scenario, effectiveness),
        *torque_findings(scenario, torque_B, fly=fly),
    ]


DESIGNS: dict[str, Design] = {
    **bandwidth.DESIGNS,
    "mixed_learning": mixed_learning_tool.DESIGN,
    "mixed_learning_six_steps": mixed_learning_tool.SIX_STEPS,
}

__all__ = [
    "CHECKS",
    "DESIGNS",
    "FIGURES",
    "CompensationMargin",
    "Design",
    "DesignReport",
    "Finding",
    "LoopMargin",
    "attainable_after_faults",
    "bandwidth",
    "bandwidth_rules",
    "cmg",
    "compensation",
    "compensation_margin",
    "critical_effectiveness",
    "effectiveness_range",
    "estimate_use",
    "feasibility",
    "feasible_time",
    "findings",
    "identifiability",
    "iterative_learning",
    "learning_disturbance",
    "learning_effectiveness",
    "learning_loop",
    "linear_loop",
    "loop_margin",
    "mixed_learning",
    "mixed_learning_tool",
    "momentum",
    "preassigned_time",
    "predefined_time",
    "sampled_loop",
    "scenario_margin",
    "time_constants",
    "torque_findings",
]
