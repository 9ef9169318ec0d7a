# SPDX-License-Identifier: MIT
"""Distributions by short names, for campaigns that are written in Python: ``dist.normal(0.0, 0.01, each=3)``."""

from __future__ import annotations

from collections.abc import Sequence

from gyrostat.campaign.distributions import (
    Attitude,
    Beta,
    Choice,
    Exponential,
    Inertia,
    Inverse,
    LogNormal,
    LogUniform,
    Mixture,
    Normal,
    Poisson,
    Quantiles,
    Scalar,
    Share,
    Triangular,
    TruncNormal,
    Uniform,
)


def normal(mean: float, std: float, *, each: int | None = None) -> Normal:
    """Normal, of mean and standard deviation."""
    return Normal(mean=mean, std=std, each=each)


def truncnormal(mean: float, std: float, low: float, high: float, *, each: int | None = None) -> TruncNormal:
    """Normal of `mean` and `std` before it is cut off at both ends."""
    return TruncNormal(mean=mean, std=std, low=low, high=high, each=each)


def lognormal(mu: float, sigma: float, *, each: int | None = None) -> LogNormal:
    """The exponential of a normal number of mean `mu` and standard deviation `sigma`."""
    return LogNormal(mu=mu, sigma=sigma, each=each)


def uniform(low: float, high: float, *, each: int | None = None) -> Uniform:
    """Uniform between two ends."""
    return Uniform(low=low, high=high, each=each)


def loguniform(low: float, high: float, *, each: int | None = None) -> LogUniform:
    """The logarithm is uniform between those of two positive ends."""
    return LogUniform(low=low, high=high, each=each)


def exponential(mean: float, *, each: int | None = None) -> Exponential:
    """Exponential, of a mean."""
    return Exponential(mean=mean, each=each)


def beta(a: float, b: float, *, low: float = 0.0, high: float = 1.0, each: int | None = None) -> Beta:
    """Beta of shapes `a` and `b`."""
    return Beta(a=a, b=b, low=low, high=high, each=each)


def triangular(low: float, mode: float, high: float, *, each: int | None = None) -> Triangular:
    """Triangular with its top at `mode`."""
    return Triangular(low=low, mode=mode, high=high, each=each)


def choice(of: Sequence[float], weights: Sequence[float] | None = None, *, each: int | None = None) -> Choice:
    """One of several numbers."""
    return Choice(of=list(of), weights=None if weights is None else list(weights), each=each)


def poisson(mean: float, *, most: int | None = None, each: int | None = None) -> Poisson:
    """A count of a mean; what lies above `most` is `most`."""
    return Poisson(mean=mean, most=most, each=each)


def table(
    values: Sequence[float], probabilities: Sequence[float] | None = None, *, each: int | None = None
) -> Quantiles:
    """Quantiles: `values` at `probabilities` from 0 to 1, evenly spaced if absent."""
    given = None if probabilities is None else list(probabilities)
    return Quantiles(values=list(values), probabilities=given, each=each)


def mixture(parts: Sequence[tuple[float, float | Inverse]], *, each: int | None = None) -> Mixture:
    """One of several numbers or distributions, each with its weight before it."""
    return Mixture(of=[Share(weight=weight, of=of) for weight, of in parts], each=each)


def attitude(angle: Scalar | None = None) -> Attitude:
    """A rotation: uniform over all of them, or about a random axis by an angle (rad) of a distribution."""
    return Attitude(angle=angle)


def inertia(spread: float) -> Inertia:
    """An inertia near the nominal one that always belongs to a body."""
    return Inertia(spread=spread)


__all__ = [
    "attitude",
    "beta",
    "choice",
    "exponential",
    "inertia",
    "lognormal",
    "loguniform",
    "mixture",
    "normal",
    "poisson",
    "table",
    "triangular",
    "truncnormal",
    "uniform",
]
