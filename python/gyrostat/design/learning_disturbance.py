# SPDX-License-Identifier: MIT
"""Stability and accuracy of the learning disturbance observer, per axis.

With ``e`` the rate error and ``f`` the lumped acceleration the observer obeys

    e' = f - fhat - M e,    fhat(t) = k1 fhat(t - Tc) + k2 e(t) + k3 e(t - Tc)

and contains neither the known dynamics nor, with healthy actuators, the command. The continuous system is stable for
**every** delay if and only if ``|k1| < 1``, ``M + (k2 + k3) / (1 - k1) > 0`` and ``M + k2 > |k1 M - k3|`` (strictly
inside): ``fhat = (k2 + k3 q) / (1 - k1 q) e`` with ``|q| = 1`` must not meet ``-(M + j w)``. The theorem of Cao et al.
2023 asks for much more: its conditions need ``k3 < 1`` and ``k2 < sqrt(M - 1)``, which the gains of that publication
themselves do not satisfy. With the free numbers ``r_i``, ``psi`` of its proof and ``A = 1 + psi + 1 / (2 r7)`` they are

    gamma1 = M - 1 - r7 / 2 - A (1 + 1/r1 + r4 + r5) k2^2 > 0
    gamma2 = 1 - A (1 + r1 + r2 + r3) k1^2 >= 0
    gamma3 = 1 - A (1 + 1/r2 + 1/r4 + r6) k3^2 >= 0
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from gyrostat.design.finding import Finding
from gyrostat.errors import InputError
from gyrostat.plots import Figure
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
    def theorem_gamma1(self) -> float:
        """Largest value, over the free numbers of the theorem, of a bound on its ``gamma1``: ``M - 1 - k2^2``."""
        return self.M - 1.0 - self.k2**2

    @property
    def theorem_gamma3(self) -> float:
        """Largest value of a bound on its ``gamma3``: ``1 - k3^2``."""
        return 1.0 - self.k3**2

    def theorem_largest_k2(self) -> float:
        """Largest `k2`, 1/s, that the theorem admits with this `M`, `k1`, `k3`; nan when it admits none.

        Only ``r1, r2, r4, r7`` cost anything, the others tend to zero; ``gamma2 = gamma3 = 0`` leaves two to search.
        """
        room = 1.0 / max(self.k1, 1e-6) ** 2 - 1.0
        least, most = 0.5 / room, 2.0 * (self.M - 1.0)
        if not least < most:
            return float("nan")
        r7 = np.linspace(least, most, 402)[1:-1, None]
        A = 1.0 + 0.5 / r7
        budget = 1.0 / (A * max(self.k1, 1e-6) ** 2) - 1.0  # r1 + r2
        r2 = budget * np.concatenate([np.geomspace(1e-9, 1e-2, 80), np.linspace(0.01, 1.0, 200)[1:-1]])
        with np.errstate(divide="ignore"):
            over_r4 = np.divide(1.0, A * self.k3**2) - 1.0 - 1.0 / r2
        r4 = np.divide(1.0, over_r4, out=np.full_like(over_r4, np.nan), where=over_r4 > 0.0)
        squared = (self.M - 1.0 - 0.5 * r7) / (A * (1.0 + 1.0 / (budget - r2) + r4))
        return float(np.sqrt(np.nanmax(squared))) if np.isfinite(squared).any() else float("nan")

    def growth(self, dt: float, *, held: bool = False) -> float:
        """By how much `k2` and `k3` may grow before an unstable sampled observer, or delay; infinite beyond 1e6."""

        def stable(factor: float) -> bool:
            more = replace(self, k2=factor * self.k2, k3=factor * self.k3)
            return more.stable_for_every_delay and more.spectral_radius(dt, held=held) < 1.0

        low = 0.0
        for high in np.geomspace(1e-3, 1e6, 181):
            if not stable(high):
                break
            low = float(high)
        else:
            return float("inf")
        while high > (1.0 + 1e-4) * low and high > 1e-3:
            middle = 0.5 * (low + high)
            low, high = (middle, high) if stable(middle) else (low, middle)
        return low

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


def largest_stable_k3(gains: LearningGains, dt: float, k2: ArrayLike, *, held: bool = False) -> Array:
    """Largest `k3`, 1/s, up to which every smaller one is stable when sampled, for each `k2`; nan when none is.

    `M`, `k1` and `Tc` are those of `gains`. For every delay it is ``(1 + k1) M + k2``.
    """
    tried = np.concatenate([[0.0], np.geomspace(1e-3, 1e4, 141)])

    def stable(a: float, b: float) -> bool:
        return replace(gains, k2=a, k3=b).spectral_radius(dt, held=held) < 1.0

    found = np.full(np.size(k2), np.nan)
    for i, a in enumerate(np.atleast_1d(np.asarray(k2, dtype=float))):
        first = next((j for j, b in enumerate(tried) if not stable(a, b)), None)
        if first == 0:
            continue
        low, high = (tried[-1], tried[-1]) if first is None else (tried[first - 1], tried[first])
        while high - low > 1e-3 * high:
            middle = 0.5 * (low + high)
            low, high = (middle, high) if stable(a, middle) else (low, middle)
        found[i] = low
    return found


def response_figure(named: Mapping[str, LearningGains]) -> Figure:
    """Share of a sine that the estimate misses, against its frequency, for some gains by name."""
    title = "Share of the lumped acceleration that the estimate misses"
    figure = Figure(title, size=(8.0, 4.2), along="frequency", unit="rad/s")
    omega = np.geomspace(0.01, 2000.0, 6000)
    figure.axes[0].set_ylabel("|f - fhat| / |f|", fontsize=9)
    for name, gains in named.items():
        figure.line(0, omega, gains.error_gain(omega), name, labels=[name])
    rest = float(next(iter(named.values())).error_gain(0.0))
    figure.level(0, rest, f"{100.0 * rest:.3g} % at rest")
    figure.axes[0].set_xscale("log")
    figure.axes[0].set_yscale("log")
    figure.axes[0].legend(loc="upper left", fontsize=8, frameon=False)
    return figure


def region_figure(gains: LearningGains, dt: float) -> Figure:
    """Largest `k3` against `k2`: stable for every delay, sampled in either form, and admitted by the theorem."""
    title = f"Learning gains for M = {gains.M:g} /s, k1 = {gains.k1:g}, Tc = {1e3 * gains.Tc:g} ms: largest k3"
    figure = Figure(title, size=(8.0, 4.6), along="k2", unit="1/s")
    k2 = np.geomspace(0.05, 300.0, 60)
    figure.axes[0].set_ylabel("k3 (1/s)", fontsize=9)
    curves = {
        "stable for every delay": (1.0 + gains.k1) * gains.M + k2,
        f"sampled at {1e3 * dt:g} ms, rolling": largest_stable_k3(gains, dt, k2),
        "sampled, held": largest_stable_k3(gains, dt, k2, held=True),
    }
    for name, k3 in curves.items():
        figure.line(0, k2, k3, name, labels=[name])
    admitted = np.geomspace(1e-3, 1.0, 60)
    least = np.array([replace(gains, k3=float(b)).theorem_largest_k2() for b in admitted])
    if np.isfinite(least).any():
        kept = np.isfinite(least)
        figure.line(0, least[kept], admitted[kept], "published theorem", labels=["published theorem"])
    figure.axes[0].plot([gains.k2], [gains.k3], "k*", markersize=10, label="as flown")
    figure.axes[0].set_xscale("log")
    figure.axes[0].set_yscale("log")
    figure.axes[0].legend(loc="lower right", fontsize=8, frameon=False)
    return figure


def scenario_gains(scenario: Scenario) -> LearningGains | None:
    """Gains of a scenario's learning observer, or None when it flies another one."""
    observer = scenario.resolve().get("observer", {})
    if observer.get("type") != "learning_disturbance":
        return None
    return LearningGains(observer["M"], observer["k1"], observer["k2"], observer["k3"], observer["interval"])


def figures(scenario: Scenario) -> dict[str, Figure]:
    """What ``gyrostat check --out`` draws of a learning observer: its frequency response and the gain region."""
    gains = scenario_gains(scenario)
    if gains is None:
        return {}
    traditional = replace(gains, k2=gains.k2 + gains.k3, k3=0.0)
    response = {"as flown": gains, "traditional, same k2 + k3": traditional, "traditional": replace(gains, k3=0.0)}
    return {"response": response_figure(response), "gain_region": region_figure(gains, scenario.dt)}


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
    growth = gains.growth(scenario.dt, held=held)
    admitted = replace(gains, k3=0.0).theorem_largest_k2()
    left = float(replace(gains, k2=admitted, k3=0.0).error_gain(0.0))
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
            "gain region",
            f"k2 and k3 together may grow {growth:.3g} times before either condition fails; "
            f"every delay asks for k3 < (1 + k1) M + k2 = {(1.0 + gains.k1) * gains.M + gains.k2:.4g} 1/s",
            None,
            growth,
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
            f"both would have to be > 0: {'not excluded' if proven else 'the theorem says nothing of these gains'}; "
            f"it admits k2 up to {admitted:.3g} 1/s at k3 = 0, where {100.0 * left:.3g} % is not found",
            None,
            min(gains.theorem_gamma1, gains.theorem_gamma3),
            0.0,
        ),
    ]


__all__ = [
    "LearningGains",
    "figures",
    "findings",
    "largest_stable_k3",
    "region_figure",
    "response_figure",
    "scenario_gains",
]
