# SPDX-License-Identifier: MIT
"""Margins of the convergence theorem of the printed learning observer (Cao, Gong, Han 2022, theorem 1).

    c1 = min M - a7/2 - k - 1 - b3 |H1|^2 B > 0      c2 = 1 - b2 l^2 B >= 0
    c3 = 1 - b4 |H2|^2 B >= 0                        c4 = n - d_m >= 0
    B  = 1 + chi + u_max^2 |D|^2 / (2 a7)            b2, b3, b4 > 1, chi, a7, k > 0 free

``b`` and ``B`` come arbitrarily near to 1 only with ``a7`` without bound, which c1 pays for. What no choice exceeds is
``sup c1 = min M - 1 - |H1|^2`` and ``sup c3 = 1 - |H2|^2``; c2 >= 0 alone asks for
``a7 >= u_max^2 |D|^2 / (2 (1/l^2 - 1))``.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from gyrostat.components import Matrix
from gyrostat.design.finding import Finding
from gyrostat.scenario import Scenario
from gyrostat.vehicle import all_actuators


@dataclass(frozen=True)
class LearningMargins:
    """Least upper bounds of the theorem's margins over everything that it leaves free."""

    c1_sup: float
    """of c1, every free constant at its best for c1 alone"""
    c3_sup: float
    """of c3, likewise"""
    a7_least: float
    """that c2 >= 0 asks for; infinite when l = 1"""
    c1_with_c2: float
    """of c1, once c2 >= 0 holds"""

    @property
    def feasible(self) -> bool:
        """False when no free constant can satisfy the theorem; true does not prove that one does."""
        return self.c1_sup > 0.0 and self.c3_sup >= 0.0 and self.c1_with_c2 > 0.0


def learning_margins(
    M: Matrix, H1: Matrix, H2: Matrix, *, kept: float, u_max: float, D_norm: float = 1.0
) -> LearningMargins:
    """Margins of theorem 1 at their best.

    Parameters
    ----------
    M, H1, H2
        Diagonals of the gains, shape (3,), or matrices.
    kept
        l, share of the earlier estimate that is kept.
    u_max
        N m, largest command.
    D_norm
        Spectral norm of the actuator axes.
    """
    h1, h2 = _norm(H1), _norm(H2)
    least = _smallest(M)
    drive = (u_max * D_norm) ** 2
    room = 1.0 / kept**2 - 1.0 if kept > 0.0 else math.inf
    a7 = drive / (2.0 * room) if room > 0.0 else math.inf
    spread = drive / (2.0 * a7) if 0.0 < a7 < math.inf else 0.0
    return LearningMargins(
        c1_sup=least - 1.0 - h1**2,
        c3_sup=1.0 - h2**2,
        a7_least=a7,
        c1_with_c2=least - a7 / 2.0 - 1.0 - h1**2 * (1.0 + spread),
    )


def findings(scenario: Scenario) -> list[Finding]:
    """What ``gyrostat check`` says about the printed learning observer; nothing for another one."""
    observer = scenario.resolve()["observer"]
    if observer.get("type") != "learning_effectiveness_printed":
        return []
    limits = np.asarray(all_actuators(scenario.resolve()).get("u_max") or math.inf, dtype=float)
    D_norm = float(np.linalg.norm(scenario.axes_B, 2))
    m = learning_margins(
        observer["M"],
        observer["H1"],
        observer["H2"],
        kept=observer["l"],
        u_max=float(np.max(limits)),
        D_norm=D_norm,
    )
    where = "observer learning_effectiveness_printed"
    return [
        Finding(
            where,
            "c1",
            f"theorem 1: c1 <= min M - 1 - |H1|^2 = {m.c1_sup:.6g}, must be > 0",
            m.c1_sup > 0.0,
            m.c1_sup,
            0.0,
        ),
        Finding(
            where, "c3", f"theorem 1: c3 <= 1 - |H2|^2 = {m.c3_sup:.6g}, must be >= 0", m.c3_sup >= 0.0, m.c3_sup, 0.0
        ),
        Finding(
            where,
            "c1 with c2",
            f"theorem 1: c2 >= 0 asks for a7 >= {m.a7_least:.6g}, which leaves c1 <= {m.c1_with_c2:.6g}, must be > 0",
            m.c1_with_c2 > 0.0,
            m.c1_with_c2,
            0.0,
        ),
        Finding(
            where,
            "leak",
            f"without a rate error the estimate falls by the factor l = {observer['l']:.3g} a delay",
            bool(observer["l"] >= 1.0),
            observer["l"],
            1.0,
        ),
    ]


def _norm(gain: Matrix) -> float:
    a = np.asarray(gain, dtype=float)
    return float(np.max(np.abs(a))) if a.ndim == 1 else float(np.linalg.norm(a, 2))


def _smallest(gain: Matrix) -> float:
    a = np.asarray(gain, dtype=float)
    return float(np.min(a)) if a.ndim == 1 else float(np.min(np.linalg.eigvalsh(a)))


__all__ = ["LearningMargins", "findings", "learning_margins"]
