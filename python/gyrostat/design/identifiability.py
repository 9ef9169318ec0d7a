# SPDX-License-Identifier: MIT
"""What an observer cannot tell about the actuators of a vehicle, whatever its gains: three torques, n unknowns."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gyrostat.components import Component
from gyrostat.design.finding import Finding
from gyrostat.detection import identifiability
from gyrostat.scenario import Scenario

Array = NDArray[np.float64]

_gates = {
    "adaptive_iterative_learning": "u_gate",
    "iterative_learning": "u_gate",
    "learning_effectiveness": "u_exc",
    "learning_effectiveness_printed": "u_exc",
    "adaptive_sliding_mode_effectiveness": None,
}
"""Observers of effectiveness, with the parameter below which they do not listen."""


def findings(scenario: Scenario) -> list[Finding]:
    """How many effectiveness values show in the torques, and which combinations do not.

    For an observer of effectiveness; for one of a lumped torque when a `threshold` detector maps it onto the actuators.
    """
    resolved = scenario.resolve()
    observer, detector = resolved.get("observer", {}), resolved["detector"]
    name = observer.get("type")
    if name in _gates:
        return [_finding(scenario, f"observer {name}", observer, "frozen", _gates[name])]
    if name not in {None, "passthrough"} and detector["type"] == "threshold" and detector["use_torque"]:
        return [_finding(scenario, "detector threshold", detector, "unwatched", "u_gate")]
    return []


def _finding(scenario: Scenario, where: str, plain: Mapping[str, Any], left_out: str, gate: str | None) -> Finding:
    D = scenario.axes_B
    ignored = {int(i) for i in plain.get(left_out, [])}
    ignored |= set(scenario.vehicle.magnetorquers or ())
    learned = [i for i in range(D.shape[1]) if i not in ignored]
    commands, what = _commands(scenario, learned)
    report = identifiability(D[:, learned], commands, gate=float(plain[gate]) if gate else 0.0)
    names = f" (of actuators {', '.join(map(str, learned))})" if ignored else ""
    complete = report.rank == len(learned)
    return Finding(where, "identifiable", f"{what}: {report}{names}", True if complete else None, float(report.rank))


def _commands(scenario: Scenario, learned: list[int]) -> tuple[Array, str]:
    """The commands of an open loop; else one command of all actuators at once, which is the least that a loop gives."""
    controller = scenario.controller
    if isinstance(controller, Component) and controller.type == "open_loop":
        quiet = scenario.replace(
            observer="passthrough", detector="none", faults=[], sensors=[], shadows=[], record=None
        )
        flown = quiet.run(channels=["allocation.u"], every=max(1, round(quiet.duration / quiet.dt / 2000)))
        return flown["allocation.u"][:, learned], "over the open-loop commands"
    return np.full((1, len(learned)), 1e9), "by one command of all actuators"


__all__ = ["findings"]
