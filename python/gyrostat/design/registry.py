# SPDX-License-Identifier: MIT
"""What ``gyrostat design`` offers: each design is options, a function of them, and what a scenario says about them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from gyrostat.design.finding import Finding
from gyrostat.model import Model
from gyrostat.scenario import Scenario


@dataclass(frozen=True)
class DesignReport:
    """What a design found."""

    components: dict[str, dict[str, Any]]
    """By role, as a scenario writes it; empty when there is no usable design."""
    findings: list[Finding]
    """Every condition with its number."""

    @property
    def ok(self) -> bool:
        """Whether there are gains and no condition fails."""
        return bool(self.components) and all(f.ok is not False for f in self.findings)

    def to_dict(self) -> dict[str, Any]:
        """As ``gyrostat design --json`` prints it."""
        return {"ok": self.ok, "components": self.components, "findings": [vars(f) for f in self.findings]}


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
