# SPDX-License-Identifier: MIT
"""Gains tuned on common flights: faster after a fault, at an effort that is held.

What is small is the mean of the worst tenth of the flights, at factors on the published values; energy and variation of
the command may grow by a limit, beyond which an e-fold costs `PENALTY` seconds. All factors fly the same flights, so
that their differences are those of the factors. Reported is what happens on flights that were not tuned on.
Page: docs/verification.md
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gyrostat.campaign.limits import whole
from gyrostat.errors import InputError
from gyrostat.verification.words import LARGEST_SEED
from gyrostat.verification.worst import evolution

Floats = NDArray[np.float64]

PENALTY = 100.0
"""Seconds an e-fold of effort beyond its limit."""
REFUSED = 1000.0
"""Seconds, plus the distance from the published values, of factors that no stack can fly."""
WORST_SHARE = 0.1
FACTOR = 10.0
"""Factors lie within 1/10 and 10."""
SIGMA = 0.4
SMALLEST_SIGMA = 0.05
PATIENCE = 10
OVERFIT = 1.25


@dataclass(frozen=True)
class FlownSet:
    """What became of the flights of one set of factors.

    Attributes
    ----------
    time
        Of each flight, s, shape (n,): until it settled after its last fault, and beyond its end where it did not; see
        `graded_time`.
    energy, variation
        Mean effort of a flight.
    """

    time: Floats
    energy: float
    variation: float


Fly = Callable[[Floats, str], FlownSet | None]
"""``fly(factors, split)``: flights of ``"train"`` or ``"held-out"`` with factors, shape (k,); None: refused."""


@dataclass(frozen=True)
class Trial:
    """One set of factors on the training flights: its worst tenth, and effort over that of the published values."""

    factors: Floats
    worst_tenth: float
    energy: float
    variation: float


@dataclass(frozen=True)
class Comparison:
    """Published and tuned factors on the same flights.

    Attributes
    ----------
    before, after
        Times of the flights, shape (n,).
    energy, variation
        Tuned over published.
    interval
        95 % interval of the change of the 95th percentile, s, by bootstrap of flights in pairs: below zero is faster.
    """

    before: Floats
    after: Floats
    energy: float
    variation: float
    interval: tuple[float, float]

    def percentile(self, level: float) -> tuple[float, float]:
        """Of the times, before and after."""
        return float(np.quantile(self.before, level)), float(np.quantile(self.after, level))


@dataclass(frozen=True)
class Tuned:
    """What tuning found.

    Attributes
    ----------
    factors
        On the published values, shape (k,): the mean of the last distribution, not the best that was seen; 1 where the
        flights that were tuned on do not fare better with it.
    train, held_out
        Before and after.
    trials
        All that was flown.
    evaluations
        How many sets of factors.
    overfit
        Whether held-out flights are slower than the tuned ones by a quarter.
    """

    factors: Floats
    train: Comparison
    held_out: Comparison
    trials: tuple[Trial, ...]
    evaluations: int
    overfit: bool

    def trade(self) -> list[Trial]:
        """Trials that no other beats in both energy and worst tenth, by energy."""
        front: list[Trial] = []
        for trial in sorted(self.trials, key=lambda t: (t.energy, t.worst_tenth)):
            if not front or trial.worst_tenth < front[-1].worst_tenth:
                front.append(trial)
        return front


@dataclass(frozen=True)
class Tuner:
    """How to tune.

    Attributes
    ----------
    parameters
        Factors, k.
    effort
        Largest energy and command variation over those of the published values; infinite: free.
    budget
        Sets of factors at most.
    seed
        Of the search and the bootstrap.
    """

    parameters: int
    effort: float = 1.4
    budget: int = 150
    seed: int = 0

    def __post_init__(self) -> None:
        whole("seed", self.seed, most=LARGEST_SEED)
        if self.parameters < 1:
            raise InputError("parameters: at least one belongs here")
        if not self.effort >= 1:
            raise InputError(f"effort = {self.effort:g}: at least 1, that of the published values, belongs here")
        if self.budget < 10:
            raise InputError(f"budget = {self.budget}: at least 10 sets of factors belong here")

    def run(self, fly: Fly) -> Tuned:
        """Tune.

        Raises
        ------
        InputError
            The published values cannot be flown.
        """
        one = np.ones(self.parameters)
        published = fly(one, "train")
        if published is None:
            raise InputError("tune: the published values are refused by the scenario")
        trials: list[Trial] = []

        def cost(log_factors: Floats) -> float:
            factors = np.exp(log_factors)
            flown = fly(factors, "train")
            if flown is None:
                return REFUSED + float(np.linalg.norm(log_factors))
            energy, variation = flown.energy / published.energy, flown.variation / published.variation
            trials.append(Trial(factors, worst_tenth(flown.time), energy, variation))
            over = [max(0.0, math.log(max(ratio, 1e-9)) - math.log(self.effort)) for ratio in (energy, variation)]
            return trials[-1].worst_tenth + PENALTY * sum(over)

        mean, evaluations = self._search(cost)
        better = cost(mean) < worst_tenth(published.time)
        factors = np.exp(mean) if better else one
        train = self._compare(fly, factors, "train", published)
        held_out = self._compare(fly, factors, "held-out", fly(one, "held-out"))
        overfit = worst_tenth(held_out.after) > OVERFIT * worst_tenth(train.after)
        return Tuned(factors, train, held_out, tuple(trials), evaluations, overfit)

    def _search(self, cost: Callable[[Floats], float]) -> tuple[Floats, int]:
        """Mean of the last distribution, in logarithms of factors, and how many sets were flown."""
        k, ends = self.parameters, math.log(FACTOR)
        dimension = max(k, 2)  # the library wants two
        bounds = {"bounds": [[-ends] * dimension, [ends] * dimension]}
        strategy = evolution(np.zeros(dimension), SIGMA, self.seed, 0, bounds)
        flown, best, stale = 0, math.inf, 0
        while strategy.sigma >= SMALLEST_SIGMA and stale < PATIENCE and flown + strategy.popsize <= self.budget:
            asked = strategy.ask()
            costs = [cost(np.asarray(x)[:k]) for x in asked]
            strategy.tell(asked, costs)
            flown += len(asked)
            stale = 0 if min(costs) < best - 0.01 * abs(best) or best == math.inf else stale + 1
            best = min(best, *costs)
        return np.asarray(strategy.result.xfavorite)[:k], flown

    def _compare(self, fly: Fly, factors: Floats, split: str, before: FlownSet | None) -> Comparison:
        after = fly(factors, split)
        if before is None or after is None:
            raise InputError(f"tune: the {split} flights are refused by the scenario")
        random = np.random.Generator(np.random.Philox(key=np.array([self.seed, 1], np.uint64)))
        rows = random.integers(0, before.time.size, (1000, before.time.size))
        change = np.quantile(after.time[rows], 0.95, axis=1) - np.quantile(before.time[rows], 0.95, axis=1)
        low, high = np.quantile(change, [0.025, 0.975])
        ratios = after.energy / before.energy, after.variation / before.variation
        return Comparison(before.time, after.time, *ratios, (float(low), float(high)))


def worst_tenth(time: Floats) -> float:
    """Mean of the slowest tenth of the flights, one at least."""
    count = max(1, round(WORST_SHARE * time.size))
    return float(np.sort(time)[-count:].mean())


def graded_time(settling: Floats, error: Floats, band: float, duration: float) -> Floats:
    """Settling times, and for flights that did not settle a time beyond the end that grows with their error.

    Parameters
    ----------
    settling
        After the last fault, s, shape (n,); nan where not settled.
    error
        At the end, rad, shape (n,).
    band
        That it has to stay within, rad.
    duration
        Of a flight, s: no settling time is longer.
    """
    with np.errstate(divide="ignore", invalid="ignore"):
        late = duration + 20 * (1 + np.maximum(np.log10(error / band), 0.0))
    late = np.where(np.isfinite(late), late, duration + 20 * 6)  # ended early, far from everywhere
    return np.asarray(np.where(np.isfinite(settling), settling, late))


__all__ = ["Comparison", "FlownSet", "Trial", "Tuned", "Tuner", "graded_time", "worst_tenth"]
