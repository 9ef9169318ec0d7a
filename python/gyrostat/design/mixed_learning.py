# SPDX-License-Identifier: MIT
"""Gains of mixed learning: two six-step designs, their theorem conditions, and a design from what is wanted.

Conditions of Wang, Jia, Yu 2023, (11)-(15) for the observer and (33)-(36) for the sliding mode, with the signs and the
reaching gain that the text lost. A margin is positive where its condition holds. The conditions are sufficient for the
continuous loop; `LearningLoop.spectral_radius` is exact for the sampled one.

The conditions compare torques with a unit matrix, so they depend on the unit of rate: a functional that weighs
the past error by ``rate_unit^-2`` proves the same with ``rate_unit`` times the gains. 1 rad/s is the published case.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gyrostat.components import Matrix
from gyrostat.design.learning_loop import LearningLoop
from gyrostat.errors import InputError

Array = NDArray[np.float64]
Epsilons = tuple[float, float, float]

_published_eps: Epsilons = (0.01, 0.01, 1.0)


def as_matrix(value: float | Matrix) -> Array:
    """A scalar times the unit matrix, a diagonal, or the matrix itself, shape (3, 3)."""
    x = np.asarray(value, dtype=float)
    return x * np.eye(3) if x.ndim == 0 else np.diag(x) if x.ndim == 1 else x


def _largest(matrix: Array) -> float:
    return float(np.linalg.eigvalsh(0.5 * (matrix + matrix.T))[-1])


def checked_inertia(J: Matrix) -> Array:
    """The inertia as a matrix, kg m^2.

    Raises
    ------
    InputError
        It is not 3 x 3, symmetric and positive definite.
    """
    inertia = as_matrix(J)
    if inertia.shape != (3, 3):
        raise InputError(f"the inertia must be 3 moments or a 3 x 3 matrix, not {' x '.join(map(str, inertia.shape))}")
    if not np.allclose(inertia, inertia.T) or np.linalg.eigvalsh(inertia)[0] <= 0.0:
        raise InputError("the inertia must be symmetric and positive definite")
    return inertia


@dataclass(frozen=True)
class LearningDesign:
    """Gains of one learning loop with the margins of its conditions."""

    loop: LearningLoop
    P: Array
    """Weight of the error in the Lyapunov-Krasovskii functional."""
    margins: dict[str, float]
    """By condition, positive where it holds; `r12` and `r34` are residuals of an equality, Frobenius."""

    @property
    def holds(self) -> bool:
        """Whether every condition holds and the sampled loop is stable."""
        return all(conditions_hold(self.margins).values()) and self.loop.spectral_radius() < 1.0


def conditions_hold(margins: dict[str, float]) -> dict[str, bool]:
    """Which conditions hold; an equality holds to 1e-3."""
    return {name: value <= 1e-3 if name.startswith("r") else value > 0.0 for name, value in margins.items()}


def observer_margins(
    loop: LearningLoop,
    P1: float | Matrix,
    *,
    alpha0: float = 0.0,
    eta: float = 0.05,
    eps: Epsilons = _published_eps,
    disturbance: float = 0.0,
    rate_unit: float = 1.0,
) -> dict[str, float]:
    """Margins of (11)-(15) for given gains of the observer.

    Parameters
    ----------
    loop
        Its gains; `K_lin` is the K1 and `K` the K2 of the observer.
    P1
        Weight of the error, published unit.
    alpha0, eta, eps
        Free constants of the theorem.
    disturbance
        Bound of the torque that is not to be learnt, N m.
    rate_unit
        Unit of rate in which the conditions are taken, rad/s.
    """
    a1, (e1, e2, e3) = 1.0 + alpha0, eps
    K1, K2 = rate_unit * loop.K_lin, rate_unit * loop.K
    PJ = as_matrix(P1) @ np.linalg.inv(loop.J) * rate_unit
    return {
        "m11": -_largest(-2.0 * a1 * loop.now * K2.T @ K1 + (a1 * eta**2 + 1.0) * np.eye(3)),
        "r12": float(np.linalg.norm(PJ - a1 * loop.now * K2.T) / np.linalg.norm(PJ)),
        "m13": 1.0 - a1 * loop.keep**2 * (1.0 + e1 + e2),
        "m14": -_largest(a1 * loop.before**2 * (1.0 + 1.0 / e1 + e3) * K2.T @ K2 - np.eye(3)),
        "m15": loop.sign_gain - disturbance,
    }


def sliding_margins(
    loop: LearningLoop,
    P2: float | Matrix,
    *,
    alpha2: float = 0.0,
    eps: Epsilons = _published_eps,
    rate_unit: float = 1.0,
) -> dict[str, float]:
    """Margins of (33)-(36) for given gains of the sliding mode; the reaching gain is restored in (33)."""
    a3, (e4, e5, e6) = 1.0 + alpha2, eps
    PJ, K3 = rate_unit * as_matrix(P2) @ np.linalg.inv(loop.J), rate_unit * loop.K
    return {
        "m33": -_largest(-2.0 * rate_unit * PJ @ loop.K_lin + np.eye(3)),
        "r34": float(np.linalg.norm(PJ - a3 * loop.now * K3.T) / np.linalg.norm(PJ)),
        "m35": 1.0 - a3 * (1.0 + e4 + e5) * loop.keep**2,
        "m36": -_largest(a3 * loop.before**2 * (1.0 + 1.0 / e4 + e6) * K3.T @ K3 - np.eye(3)),
    }


def _kept(margin: float, alpha: float, eps: Epsilons) -> float:
    return math.sqrt((1.0 - margin) / (alpha * (1.0 + eps[0] + eps[1])))


def _past_share(margin: float, alpha: float, eps: Epsilons, K: Array) -> float:
    return math.sqrt((1.0 - margin) / (alpha * (1.0 + 1.0 / eps[0] + eps[2]) * _largest(K.T @ K)))


def design_observer(
    J: Matrix,
    dt: float,
    *,
    P1: float | Matrix = 81.0,
    alpha0: float = 0.0,
    sigma2: float = 0.9,
    eta: float = 0.05,
    K1_slack: float = 0.1,
    eps: Epsilons = _published_eps,
    margin: float = 3e-4,
    disturbance: float = 2.4e-3,
    sigma1: float | None = None,
    theta1: float | None = None,
    theta2: float | None = None,
    delay: int = 1,
    rate_unit: float = 1.0,
) -> LearningDesign:
    """The six steps of the observer. A value that is given is kept and only checked.

    Parameters
    ----------
    J, dt
        Nominal inertia (kg m^2) and period (s).
    P1
        Weight of the error; a scalar multiple of the unit matrix, or of J J (then every axis has the same bandwidth).
    alpha0, eta, eps, margin
        Free constants of the theorem, and what (13) and (14) keep in hand.
    sigma2
        Share of the present error.
    K1_slack
        Added to K1 beyond (11), N m s.
    disturbance
        Bound of the torque that is not to be learnt, N m; theta1 becomes twice as much.
    """
    inertia, a1, P = checked_inertia(J), 1.0 + alpha0, as_matrix(P1)
    PJ = P @ np.linalg.inv(inertia)
    K2 = PJ.T / (a1 * sigma2)
    K1 = 0.5 * (a1 * eta**2 + 1.0) * np.linalg.inv(PJ) / rate_unit**2 + K1_slack * np.eye(3)
    loop = LearningLoop(
        inertia,
        dt,
        K1,
        K2,
        sigma2,
        _past_share(margin, a1, eps, rate_unit * K2) if sigma1 is None else sigma1,
        _kept(margin, a1, eps) if theta2 is None else theta2,
        delay,
        2.0 * disturbance if theta1 is None else theta1,
    )
    margins = observer_margins(loop, P, alpha0=alpha0, eta=eta, eps=eps, disturbance=disturbance, rate_unit=rate_unit)
    return LearningDesign(loop, P, margins)


def design_sliding_mode(
    J: Matrix,
    dt: float,
    *,
    P2: float | Matrix | None = None,
    alpha2: float = 0.0,
    sigma4: float = 0.99,
    eps: Epsilons = _published_eps,
    k_lin: float = 3.0,
    k_sgn: float = 0.01,
    margin: float = 3e-4,
    sigma3: float | None = None,
    theta3: float | None = None,
    delay: int = 1,
    rate_unit: float = 1.0,
) -> LearningDesign:
    """The six steps of the sliding mode. P2 is the inertia unless given: K3 is then a multiple of the unit matrix."""
    inertia, a3 = checked_inertia(J), 1.0 + alpha2
    P = inertia if P2 is None else as_matrix(P2)
    K3 = (P @ np.linalg.inv(inertia)).T / (a3 * sigma4)
    before = min(1.0 - sigma4, _past_share(margin, a3, eps, rate_unit * K3)) if sigma3 is None else sigma3
    keep = _kept(margin, a3, eps) if theta3 is None else theta3
    loop = LearningLoop(inertia, dt, k_lin * np.eye(3), K3, sigma4, before, keep, delay, k_sgn)
    return LearningDesign(loop, P, sliding_margins(loop, P, alpha2=alpha2, eps=eps, rate_unit=rate_unit))


def best_case(loop: LearningLoop, disturbance: float = 0.0) -> tuple[dict[str, float], float]:
    """The observer's margins with the constants and the rate unit that favour them most, and that unit (rad/s).

    P1 is what (12) asks for, so `r12` is how far that is from symmetric; (11) is given half of what separates it
    from (14), on a logarithmic scale. A condition that fails here fails for every choice of the constants.
    """
    needed = -_largest(-2.0 * loop.now * loop.K.T @ loop.K_lin)
    room = 1.0 / loop.keep**2 - 1.0 if loop.keep > 0.0 else math.inf
    e1 = min(0.999 * room, 1e6)
    past = loop.before**2 * (1.0 + 1.0 / e1) * _largest(loop.K.T @ loop.K) if e1 > 0.0 else math.inf
    low = 1.0 / math.sqrt(needed) if needed > 0.0 else 1.0
    high = 1.0 / math.sqrt(past) if past > 0.0 else math.inf
    unit = (low * 2.0 if math.isinf(high) else math.sqrt(low * high)) if high > low else low * (1.0 + 1e-9)
    P1 = loop.now * loop.K.T @ loop.J
    symmetric = 0.5 * (P1 + P1.T)
    eps = (max(e1, 1e-12), 0.0, 0.0)
    return observer_margins(loop, symmetric, eta=0.0, eps=eps, disturbance=disturbance, rate_unit=unit), unit
