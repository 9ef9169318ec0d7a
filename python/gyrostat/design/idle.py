# SPDX-License-Identifier: MIT
"""A scenario's faults without its loop."""

from __future__ import annotations

from collections.abc import Sequence

from gyrostat.results import Result
from gyrostat.scenario import Scenario


def faults_alone(scenario: Scenario, channels: Sequence[str]) -> Result:
    """Let the faults of a scenario pass over an idle vehicle; every sample is kept, evenly spaced ones beyond 200 000.

    Parameters
    ----------
    scenario
        Vehicle, truth, faults, duration and period are kept.
    channels
        What to record.
    """
    idle = scenario.replace(
        observer="passthrough",
        detector="none",
        controller="open_loop",
        integrator="rk4",
        initial={},
        disturbances=[],
        sensors=[],
        shadows=[],
        record=None,
    )
    samples = round(idle.duration / idle.dt)
    return idle.run(channels=list(channels), every=-(-samples // 200_000))
