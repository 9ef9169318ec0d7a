# SPDX-License-Identifier: MIT
"""Whether what an observer estimates is used once: a torque is subtracted, an effectiveness divided by."""

from __future__ import annotations

from gyrostat.design.finding import Finding
from gyrostat.scenario import Scenario


def findings(scenario: Scenario) -> list[Finding]:
    """What ``gyrostat check`` says of each estimate: who makes up for it; it fails when two components do.

    Nothing is known of Python components: an estimate that one might use is not judged.
    """
    resolved = scenario.resolve()
    flow = scenario.compiled.estimate_flow()
    if not {"observer", "controller", "allocator"} <= set(flow):
        return []
    where, found = f"observer {resolved['observer']['type']}", []
    for estimate in flow["observer"]:
        users = [role for role in ("controller", "allocator") if estimate in flow[role]]
        watched = estimate in flow.get("detector", [])
        if len(users) == 1:
            found.append(Finding(where, estimate, f"{estimate} is used by the {users[0]}", True, 1.0, 1.0))
        elif users:
            text = f"{estimate} is made up for twice, by the {' and the '.join(users)}"
            found.append(Finding(where, estimate, text, False, float(len(users)), 1.0))
        else:
            reached = "the detector alone" if watched else "no consumer"
            text = f"{estimate} reaches {reached}, the loop points as without this observer; {_remedy(estimate)}"
            found.append(Finding(where, estimate, text, None, 0.0, 1.0))
    return found


def _remedy(estimate: str) -> str:
    if estimate == "d_B":
        return "controller.compensate = true, or a law that subtracts d_B, uses it"
    return "allocator.use_effectiveness = true, or an allocator that divides by it, uses it"


__all__ = ["findings"]
