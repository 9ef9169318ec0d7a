# SPDX-License-Identifier: MIT
"""Iterative learning observers of effectiveness: their sampled error loop, and a published condition.

With full excitation the rate error and the effectiveness error of one axis obey (period h, delay of L samples)

    z^(L+1) + (h k4 - 1 + h k1) z^L - k3 z + (1 - h k1) k3 + h k5
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from gyrostat.design.finding import Finding
from gyrostat.scenario import Scenario

Array = NDArray[np.float64]

_observers = ("adaptive_iterative_learning", "iterative_learning")


def learning_roots(
    h: float, k1: float, k3: float, k4: float, *, k5: float = 0.0, delay: int = 1
) -> NDArray[np.complex128]:
    """Roots of the sampled error loop; stable when all lie inside the unit circle.

    Parameters
    ----------
    h
        Period, s.
    k1, k4, k5
        Gains, 1/s.
    k3
        Memory of the effectiveness.
    delay
        Learning interval, samples.
    """
    p = np.zeros(delay + 2)  # highest power first
    p[0] = 1.0
    p[1] += h * k4 - 1.0 + h * k1
    p[delay] += -k3
    p[delay + 1] += (1.0 - h * k1) * k3 + h * k5
    return np.asarray(np.roots(p))


def leak_bias(k1: float, k3: float, k4: float, k5: float = 0.0) -> float:
    """Relative bias of the effectiveness that a memory k3 < 1 costs, ``k1 (1 - k3) / (k4 + k5 + k1 (1 - k3))``."""
    leak = k1 * (1.0 - k3)
    return leak / (leak + k4 + k5) if leak > 0.0 else 0.0


def theorem_slack(k1: float, k3: float, k4: float, k5: float = 0.0) -> float:
    """Largest left-hand side of condition (10) of Yang et al. 2023 for the best choice of its free constants.

    Negative: the published sufficient condition holds, with its first inequality read as "< 0" and its constants
    zeta and sigma zero. The gains enter in the units of the paper, which mixes them.
    """
    a = np.geomspace(1e-4, 1e2, 601)[:, None, None]  # a1 = a2 = a3; a5, a6 -> 0 are the best
    a7 = np.geomspace(1e-3, 1e4, 701)[None, :, None]
    a4 = np.geomspace(1e-4, 1e2, 41)[None, None, :] if k5 > 0.0 else np.zeros((1, 1, 1))
    b1 = (1.0 + 3.0 * a) * k3**2
    b2 = (1.0 + 1.0 / a + a4) * k4**2
    b3 = (1.0 + 1.0 / a + 1.0 / np.where(a4 > 0.0, a4, 1.0)) * k5**2
    grow = 1.0 + 1.0 / (2.0 * a7)
    worst = np.maximum(a7 / 2.0 - k1 + 1.0 + grow * b2, np.maximum(grow * b1 - 1.0, grow * b3 - 1.0))
    return float(worst.min())


def findings(scenario: Scenario) -> list[Finding]:
    """Speed of the error loop at both ends of the gains, the published condition, bias of the memory."""
    resolved = scenario.resolve()
    observer = resolved.get("observer", {})
    name = observer.get("type")
    if name not in _observers:
        return []
    where, found = f"observer {name}", []
    suffixes = ("_0", "_max") if name == _observers[0] else ("",)
    for suffix in suffixes:
        k1, k4 = observer[f"k1{suffix}"], observer[f"k4{suffix}"]
        roots = learning_roots(scenario.dt, k1, observer["k3"], k4, k5=observer["k5"], delay=int(observer["delay"]))
        radius = float(np.abs(roots).max())
        text = f"largest root {radius:.3g} at k1{suffix}, k4{suffix}"
        if 0.0 < radius < 1.0:
            text += f", an error falls to 37 % in {-scenario.dt / np.log(radius):.3g} s"
        found.append(Finding(where, f"error loop{suffix}", text, radius < 1.0, radius, 1.0))
    first = [observer[f"k1{suffixes[0]}"], observer["k3"], observer[f"k4{suffixes[0]}"], observer["k5"]]
    slack = theorem_slack(*first)
    verdict = "holds" if slack < 0.0 else "does not hold; it is sufficient only and asks for k3 < 1"
    found.append(
        Finding(where, "condition (10)", f"published stability condition {verdict}: {slack:+.2g}", None, slack, 0.0)
    )
    bias = leak_bias(*first)
    if bias > 0.0:
        found.append(Finding(where, "memory", f"k3 below 1 pulls estimates towards 0 by {bias:.2g}", None, bias))
    return found


__all__ = ["findings", "leak_bias", "learning_roots", "theorem_slack"]
