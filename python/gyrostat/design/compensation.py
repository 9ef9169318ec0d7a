# SPDX-License-Identifier: MIT
"""Stability limit of feeding a finite-time disturbance estimate forward through weakened actuators.

The command contains minus the estimate, and the lumped disturbance contains ``D (E - I) u``: the estimate acts on
itself. With an effectiveness `m` (an eigenvalue of ``M = D E D+``), unit inertia and a correction of slope `r`, the
loop has

    x^3 + m (r + l1) x^2 + m (l1 r + l2) x + m l2 r,    l1, l2: local slopes of the observer at its amplitude

which is stable if and only if ``m > l2 r / ((r + l1) (l1 r + l2))``. The worst `r` gives
``m_crit = kappa / (1 + sqrt(kappa))^2`` with ``kappa = lambda2 / lambda1^2``, at every amplitude. The linear loop
explains what nonlinear runs do, it does not prove it: below the limit some amplitude is unstable, and whether a
trajectory visits it depends on the case. Derived for the observer of Li et al. 2018; the publication does not mention
the limit.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from gyrostat import _core
from gyrostat.components import Matrix
from gyrostat.design.finding import Finding
from gyrostat.design.idle import faults_alone
from gyrostat.errors import InputError
from gyrostat.scenario import Scenario


@dataclass(frozen=True)
class CompensationMargin:
    """The verdict on a range of effectiveness, with the number it was held to."""

    verdict: Literal["stable", "unproven", "unstable"]
    """`stable`: the whole range lies above the limit; `unstable`: all of it below; else `unproven`."""
    critical: float
    """Effectiveness below which some amplitude is unstable."""
    lowest: float
    """Lower end of the range."""
    highest: float
    """Upper end of the range."""

    def __str__(self) -> str:
        relation = {"stable": ">", "unproven": "reaches below", "unstable": "<"}[self.verdict]
        return (
            f"{self.verdict}: effectiveness [{self.lowest:.3g}, {self.highest:.3g}] {relation} "
            f"critical effectiveness {self.critical:.3g}"
        )


def critical_effectiveness(lambda1: float, lambda2: float) -> float:
    """Effectiveness below which compensation by a finite-time observer can become unstable.

    Parameters
    ----------
    lambda1, lambda2
        Gains of the observer, positive.
    """
    if not (lambda1 > 0.0 and lambda2 > 0.0):
        raise InputError(f"lambda1 = {lambda1:g} and lambda2 = {lambda2:g} must be positive")
    return _core.critical_effectiveness(lambda1, lambda2)


def compensation_margin(lambda1: float, lambda2: float, effectiveness: tuple[float, float]) -> CompensationMargin:
    """Hold a range of effectiveness against the limit.

    Parameters
    ----------
    lambda1, lambda2
        Gains of the observer.
    effectiveness
        Smallest and largest eigenvalue of ``D E D+`` that may occur; for one value for all actuators, that value.
    """
    lowest, highest = effectiveness
    if not lowest <= highest:
        raise InputError(f"effectiveness range [{lowest:g}, {highest:g}] is empty")
    critical = critical_effectiveness(lambda1, lambda2)
    verdict: Literal["stable", "unproven", "unstable"] = (
        "stable" if lowest > critical else "unstable" if highest < critical else "unproven"
    )
    return CompensationMargin(verdict, critical, lowest, highest)


def effectiveness_range(D_B: Matrix, effectiveness: Matrix) -> tuple[float, float]:
    """Smallest and largest eigenvalue of ``D E D+`` over rows of effectiveness.

    Parameters
    ----------
    D_B
        Actuator axes, shape (3, n).
    effectiveness
        One row a sample, one column an actuator, shape (k, n).
    """
    found = effectiveness_eigenvalues(D_B, np.unique(np.asarray(effectiveness, dtype=float), axis=0))
    return float(found.min()), float(found.max())


def effectiveness_eigenvalues(D_B: Matrix, effectiveness: Matrix) -> NDArray[np.float64]:
    """Eigenvalues of ``D E D+`` for each row of effectiveness, ascending, shape (k, 3); arguments as above."""
    D = np.asarray(D_B, dtype=float)
    values, vectors = np.linalg.eigh(D @ D.T)
    weighted = vectors / np.sqrt(values) @ vectors.T @ D  # (D D')^(-1/2) D: makes M symmetric, same eigenvalues
    return np.linalg.eigvalsh(np.einsum("in,kn,jn->kij", weighted, np.asarray(effectiveness, dtype=float), weighted))


def scenario_margin(scenario: Scenario, effectiveness: tuple[float, float] | None = None) -> CompensationMargin | None:
    """The margin of a scenario, or None when its observer is not the finite-time disturbance observer.

    Parameters
    ----------
    scenario
        Gains come from its observer; the range from its faults, by letting them pass over an idle vehicle.
    effectiveness
        A range to use instead.
    """
    observer = scenario.resolve().get("observer", {})
    if observer.get("type") != "finite_time_disturbance":
        return None
    if effectiveness is None:
        passed = faults_alone(scenario, ["truth.effectiveness"])
        effectiveness = effectiveness_range(scenario.axes_B, passed["truth.effectiveness"])
    return compensation_margin(observer["lambda1"], observer["lambda2"], effectiveness)


def findings(scenario: Scenario, effectiveness: tuple[float, float] | None = None) -> list[Finding]:
    """What ``gyrostat check`` says about the compensation: it fails where the whole range is below the limit.

    Parameters
    ----------
    scenario, effectiveness
        As in `scenario_margin`.
    """
    margin = scenario_margin(scenario, effectiveness)
    if margin is None:
        return []
    ok = {"stable": True, "unproven": None, "unstable": False}[margin.verdict]
    where = f"observer {scenario.resolve()['observer']['type']}"
    return [Finding(where, "compensation", str(margin), ok, margin.lowest, margin.critical)]
