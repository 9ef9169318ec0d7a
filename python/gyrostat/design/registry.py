# SPDX-License-Identifier: MIT
"""What ``gyrostat design`` offers: each design is options, a function of them, and what a scenario says about them."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from gyrostat.design.finding import Finding
from gyrostat.design.linear_loop import Axis
from gyrostat.model import Model
from gyrostat.plots import Figure
from gyrostat.scenario import Scenario


@dataclass(frozen=True)
class DesignReport:
    """What a design found."""

    components: dict[str, dict[str, Any]]
    """By role, as a scenario writes it; empty when there is no usable design."""
    findings: list[Finding]
    """Every condition with its number."""
    axes: tuple[Axis, ...] = ()
    """Margins about each principal axis of the inertia, where the design is one of a linear loop."""
    figures: Callable[[], Mapping[str, Figure]] = dict
    """Draws what there is to see, by name."""

    @property
    def ok(self) -> bool:
        """Whether there are gains and no condition fails."""
        return bool(self.components) and all(f.ok is not False for f in self.findings)

    def to_dict(self) -> dict[str, Any]:
        """As ``gyrostat design --json`` prints it."""
        axes = {"axes": [vars(a) for a in self.axes]} if self.axes else {}
        return {"ok": self.ok, "components": self.components, "findings": [vars(f) for f in self.findings], **axes}


@dataclass(frozen=True)
class Design:
    """One entry of ``gyrostat design``."""

    summary: str
    options: type[Model]
    """Its fields are the keys of ``--set``."""
    run: Callable[[Any], DesignReport]
    """Takes the options."""
    of_scenario: Callable[[Scenario], dict[str, Any]]
    """Options that a scenario decides."""
