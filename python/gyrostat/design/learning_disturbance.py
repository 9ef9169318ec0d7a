# SPDX-License-Identifier: MIT
"""Stability and accuracy of the learning disturbance observer, per axis.

With ``e`` the rate error and ``f`` the lumped acceleration the observer obeys

    e' = f - fhat - M e,    fhat(t) = k1 fhat(t - Tc) + k2 e(t) + k3 e(t - Tc)

and contains neither the known dynamics nor, with healthy actuators, the command. The continuous system is stable for
**every** delay if and only if ``|k1| < 1``, ``M + (k2 + k3) / (1 - k1) > 0`` and ``M + k2 > |k1 M - k3|`` (strictly
inside): ``fhat = (k2 + k3 q) / (1 - k1 q) e`` with ``|q| = 1`` must not meet ``-(M + j w)``. The theorem of Cao et al.
2023 asks for much more: its conditions need ``k3 < 1`` and ``k2 < sqrt(M - 1)``, which the gains of that publication
themselves do not satisfy.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from gyrostat.design.finding import Finding
from gyrostat.errors import InputError
from gyrostat.scenario import Scenario

Array = NDArray[np.float64]


@dataclass(frozen=True)
class LearningGains:
    """Gains of the learning law: `M`, `k2`, `k3` in 1/s, `k1` without unit, the interval `Tc` in s."""

    M: float
    k1: float
    k2: float
    k3: float
    Tc: float

    def __post_init__(self) -> None:
        if not (self.M > 0.0 and 0.0 <= self.k1 < 1.0 and self.Tc > 0.0):
            raise InputError(f"M = {self.M:g} and Tc = {self.Tc:g} must be positive, k1 = {self.k1:g} in [0, 1)")

    @property
    def delay_margin(self) -> float:
        """``M + k2 - |k1 M - k3|``, 1/s: positive when every delay is stable."""
        return self.M + self.k2 - abs(self.k1 * self.M - self.k3)

    @property
    def stable_for_every_delay(self) -> bool:
        """The exact condition on the continuous system."""
        return self.k1 < 1.0 and self.M + (self.k2 + self.k3) / (1.0 - self.k1) > 0.0 and self.delay_margin > 0.0

    @property
    def neutral_decay(self) -> float:
        """Decay rate, 1/s, of the fast modes that the memory itself has: ``-ln(k1) / Tc``."""
        return float(-np.log(self.k1) / self.Tc)

    @property
    def theorem_gamma1(self) -> float:
        """Largest value, over the free numbers of the theorem, of a bound on its ``gamma1``: ``M - 1 - k2^2``."""
        return self.M - 1.0 - self.k2**2

    @property
    def theorem_gamma3(self) -> float:
        """Largest value of a bound on its ``gamma3``: ``1 - k3^2``."""
        return 1.0 - self.k3**2

    def error_gain(self, omega: ArrayLike) -> Array:
        """``|f - fhat| / |f|`` for a sine of frequency `omega`, rad/s."""
        w = np.asarray(omega, dtype=float)
        q = np.exp(-1j * w * self.Tc)
        numerator = (self.M + 1j * w) * (1.0 - self.k1 * q)
        return np.asarray(np.abs(numerator / (numerator + self.k2 + self.k3 * q)))

    def largest_period(self) -> float:
        """Period, s, at which the rolling form loses its half-sample-rate mode; ``Tc`` is an even number of periods.

        ``tanh(M h / 2) / M = (1 - k1) / (k2 + k3)``; about ``2 (1 - k1) / (k2 + k3)``. Infinite when there is none.
        """
        if self.k2 + self.k3 <= 0.0:
            return float("inf")
        x = self.M * (1.0 - self.k1) / (self.k2 + self.k3)
        return float("inf") if x >= 1.0 else float(2.0 * np.arctanh(x) / self.M)

    def spectral_radius(self, dt: float, *, held: bool = False) -> float:
        """Largest modulus of the modes of the sampled observer, from the roots of its polynomial.

        Parameters
        ----------
        dt
            Sample period, s; `Tc` is a whole number of them.
        held
            The estimate is held over each interval.
        """
        N = round(self.Tc / dt)
        if N < 1 or abs(N * dt - self.Tc) > 1e-9 * self.Tc:
            raise InputError(f"Tc = {self.Tc:g} s is not a whole number of periods dt = {dt:g} s")
        step, delay = (self.Tc, 1) if held else (dt, N)
        a = np.exp(-self.M * step)
        b = (1.0 - a) / self.M
        p = np.zeros(delay + 2)
        p[0] = 1.0
        p[1] += b * self.k2 - a
        p[-2] -= self.k1
        p[-1] += a * self.k1 + b * self.k3
        return float(np.abs(np.roots(p)).max())


def gain_region(gains: LearningGains, dt: float, k2: ArrayLike, k3: ArrayLike) -> tuple[Array, Array, Array]:
    """Where in the plane of `k2`, `k3` the gains are stable for every delay, and also when sampled.

    Parameters
    ----------
    gains
        `M`, `k1` and `Tc` are taken from them.
    dt
        Sample period, s.
    k2, k3
        Learning gains, 1/s, the two axes of the plane.

    Returns
    -------
    tuple
        Delay margin, spectral radius of the rolling form, error gain at rest, each of shape (len(k3), len(k2)).
    """
    k2s, k3s = np.atleast_1d(np.asarray(k2, dtype=float)), np.atleast_1d(np.asarray(k3, dtype=float))
    margin, radius, rest = (np.empty((len(k3s), len(k2s))) for _ in range(3))
    for i, b in enumerate(k3s):
        for j, a in enumerate(k2s):
            here = replace(gains, k2=float(a), k3=float(b))
            margin[i, j], radius[i, j] = here.delay_margin, here.spectral_radius(dt)
            rest[i, j] = here.error_gain(0.0)
    return margin, radius, rest


def scenario_gains(scenario: Scenario) -> LearningGains | None:
    """Gains of a scenario's learning observer, or None when it flies another one."""
    observer = scenario.resolve().get("observer", {})
    if observer.get("type") != "learning_disturbance":
        return None
    return LearningGains(observer["M"], observer["k1"], observer["k2"], observer["k3"], observer["interval"])


def findings(scenario: Scenario) -> list[Finding]:
    """What ``gyrostat check`` says about a learning observer."""
    gains = scenario_gains(scenario)
    if gains is None:
        return []
    observer = scenario.resolve()["observer"]
    where = "observer learning_disturbance"
    held = observer["form"] == "held"
    radius = gains.spectral_radius(scenario.dt, held=held)
    limit = gains.largest_period()
    rest = float(gains.error_gain(0.0))
    proven = gains.theorem_gamma1 > 0.0 and gains.theorem_gamma3 > 0.0
    return [
        Finding(
            where,
            "every delay",
            f"M + k2 - |k1 M - k3| = {gains.delay_margin:.4g} 1/s, must be > 0: the continuous observer is "
            f"{'stable' if gains.stable_for_every_delay else 'unstable for some delay'}",
            gains.stable_for_every_delay,
            gains.delay_margin,
            0.0,
        ),
        Finding(
            where,
            "sampled",
            f"spectral radius {radius:.5f}, must be < 1 ({observer['form']}, interval {gains.Tc:g} s)"
            + ("" if held else f"; an even number of periods asks for dt < {1e3 * limit:.3g} ms"),
            radius < 1.0,
            radius,
            1.0,
        ),
        Finding(
            where,
            "error at rest",
            f"{100.0 * rest:.3g} % of a constant disturbance is not found: M (1 - k1) / (M (1 - k1) + k2 + k3)",
            None,
            rest,
        ),
        Finding(
            where,
            "published theorem",
            f"gamma1 <= M - 1 - k2^2 = {gains.theorem_gamma1:.4g}, gamma3 <= 1 - k3^2 = {gains.theorem_gamma3:.4g}, "
            f"both would have to be > 0: {'not excluded' if proven else 'the theorem says nothing of these gains'}",
            None,
            min(gains.theorem_gamma1, gains.theorem_gamma3),
            0.0,
        ),
    ]


__all__ = ["LearningGains", "findings", "gain_region", "scenario_gains"]
