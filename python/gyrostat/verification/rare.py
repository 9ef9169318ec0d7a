# SPDX-License-Identifier: MIT
"""Failures too rare for plain sampling: subset simulation with fixed levels, its interval from independent replicates.

A flight is a point z of independent standard normal inputs, and the versions of its blocks of noise; the margin says
how far it is from being lost, and is positive when it is. A pilot finds levels of the margin that each hold about a
tenth of the flights above the one before (Au & Beck 2001, Probab. Eng. Mech. 16). Replicates then fly with these levels
and steps held fixed: so they are independent and unbiased, which those with levels of their own are not.
Page: docs/verification.md
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Literal

import numpy as np
from numpy.typing import NDArray
from scipy import special

from gyrostat.campaign.limits import whole
from gyrostat.errors import InputError
from gyrostat.verification.words import CHAINS, LARGEST_SEED, Words, stream, uniforms

Floats = NDArray[np.float64]
Bools = NDArray[np.bool_]
Margin = Callable[..., Floats]
"""``margin(z)``, shape (n, d) to (n,); with blocks of noise ``margin(z, versions)``, of shape (n, blocks)."""
Status = Literal["converged", "not converged", "stalled"]

WANTED_ACCEPTANCE = 0.35
SMALLEST_STEP = 0.05
FIRST_STEP = 0.7
MOST_LEVELS = 60


@dataclass(frozen=True)
class Level:
    """What one level demands, and how far its chains move.

    Attributes
    ----------
    margin
        Flights of the next population lie above it.
    strict
        Or on it, if not strict.
    step
        Share of a chain's state that a move renews, in [0.05, 1].
    acceptance
        Share of moves accepted in the pilot.
    share
        Of the pilot's flights that were kept.
    """

    margin: float
    strict: bool
    step: float
    acceptance: float
    share: float

    def keeps(self, margins: Floats) -> Bools:
        """Which flights are above it."""
        return np.asarray(margins > self.margin if self.strict else margins >= self.margin)


@dataclass(frozen=True)
class LostFlight:
    """A lost flight that the chains came by.

    Attributes
    ----------
    z
        Its inputs, shape (d,).
    versions
        Of its blocks of noise, shape (blocks,).
    margin
        Positive.
    number
        Of the flight among all that the search flew, from 0.
    """

    z: Floats
    versions: Words
    margin: float
    number: int

    @property
    def distance(self) -> float:
        """Norm of z: the smaller, the likelier."""
        return float(np.linalg.norm(self.z))


@dataclass(frozen=True)
class Rare:
    """What subset simulation found.

    Attributes
    ----------
    status
        ``converged``; ``not converged``: a replicate found nothing or they differ by more than their mean, twice the
        `population` may do; ``stalled``: the pilot's margins ceased to rise, so there is nothing to climb.
    probability
        Mean of the replicates; nan when stalled.
    interval
        95 %, of Cox; when stalled from 0 to `bound`; (nan, nan) when a replicate found nothing.
    bound
        One-sided 95 % upper bound of Clopper and Pearson on independent flights alone, the first populations.
    replicates
        Estimate of each, shape (K,).
    levels
        Of the pilot, from the first to the last.
    population
        Flights of a replicate at a level, N.
    flights
        Flown in all, the pilot's among them.
    pilot
        The pilot's own estimate, which errs high and is used for nothing.
    lost
        The likeliest lost flights, by distance.
    """

    status: Status
    probability: float
    interval: tuple[float, float]
    bound: float
    replicates: Floats
    levels: tuple[Level, ...]
    population: int
    flights: int
    pilot: float
    lost: tuple[LostFlight, ...]

    @property
    def variation(self) -> float:
        """Standard deviation of one replicate over the mean."""
        return float(self.replicates.std(ddof=1) / self.replicates.mean()) if self.probability > 0 else math.nan


@dataclass(frozen=True)
class SubsetSimulation:
    """How to look for rare failures.

    Attributes
    ----------
    inputs
        Standard normal inputs, d.
    blocks
        Blocks of noise with versions of their own.
    seed
        Of all words.
    population
        Flights of a replicate at a level, N; N times `share` is a whole number.
    share
        Of a population that a level keeps, p0: one over a whole number.
    replicates
        K, at fixed levels.
    """

    inputs: int
    blocks: int = 0
    seed: int = 0
    population: int = 500
    share: float = 0.1
    replicates: int = 8
    keep_lost: int = field(default=10, kw_only=True)

    def __post_init__(self) -> None:
        whole("seed", self.seed, most=LARGEST_SEED)
        if self.inputs < 0 or self.blocks < 0 or self.inputs + self.blocks == 0:
            raise InputError("inputs, blocks: at least one input or block of noise belongs here")
        if not 0 < self.share <= 0.5 or not _whole(1 / self.share):
            raise InputError(f"share = {self.share:g}: one over a whole number, 2 or more, belongs here")
        if self.population < 2 or not _whole(self.population * self.share):
            raise InputError(f"population = {self.population}: a multiple of {self.moves} belongs here")
        if self.replicates < 2:
            raise InputError(f"replicates = {self.replicates}: without two of them there is no interval")

    @property
    def chains(self) -> int:
        """Of a replicate at a level, N p0."""
        return round(self.population * self.share)

    @property
    def moves(self) -> int:
        """Of each chain at a level, 1 / p0."""
        return round(1 / self.share)

    def run(self, margin: Margin) -> Rare:
        """Fly the pilot, then the replicates.

        Parameters
        ----------
        margin
            Of a batch of flights, finite: the same for the same point, whatever else is in the batch. One batch is a
            move of all chains.
        """
        pilot = _Populations(self, margin, np.zeros(1, np.uint64))
        levels, status = self._climb(pilot)
        estimate = float(pilot.estimates[0])
        first = self.population
        if status == "stalled":
            bound = _clopper_pearson(0, first)
            return Rare(
                "stalled", math.nan, (0.0, bound), bound, np.empty(0), levels, first, pilot.flights, math.nan, ()
            )
        replicates = _Populations(self, margin, np.arange(1, self.replicates + 1, dtype=np.uint64), pilot.flights)
        bound = _clopper_pearson(int((replicates.margins > 0).sum()), self.replicates * first)
        for number, level in enumerate(levels, 1):
            replicates.climb(number, level)
        replicates.end()
        p = replicates.estimates
        mean = float(p.mean())
        spread = float(p.std(ddof=1))
        good = bool((p > 0).all()) and spread <= mean
        interval = cox_interval(p) if (p > 0).all() else (math.nan, math.nan)
        return Rare(
            "converged" if good else "not converged",
            mean,
            interval,
            bound,
            p,
            levels,
            first,
            pilot.flights + replicates.flights,
            estimate,
            _likeliest((*pilot.lost, *replicates.lost), self.keep_lost),
        )

    def _climb(self, pilot: _Populations) -> tuple[tuple[Level, ...], Literal["climbed", "stalled"]]:
        """Levels, one a population, until a share p0 of it is lost."""
        levels: list[Level] = []
        last, step = -math.inf, FIRST_STEP
        while (pilot.margins[0] > 0).sum() < self.chains:
            G = pilot.margins[0]
            b = min(float(np.partition(G, -self.chains)[-self.chains]), 0.0)
            strict = bool(b == 0.0 or b <= last or b <= G.min())  # a plateau, or everybody is on it
            level = Level(b, strict, step, math.nan, math.nan)
            kept = level.keeps(G)
            if not kept.any() or len(levels) == MOST_LEVELS:
                return tuple(levels), "stalled"
            step, acceptance = pilot.climb(len(levels) + 1, level, adapt=True)
            levels.append(Level(b, strict, step, acceptance, float(kept.mean())))
            last = b
        pilot.end()
        return tuple(levels), "climbed"


class _Populations:
    """Populations of several replicates that climb the same levels in step, so that a batch has all their chains."""

    def __init__(self, plan: SubsetSimulation, margin: Margin, replicates: Words, before: int = 0) -> None:
        self.plan, self.margin, self.before = plan, margin, before
        self.replicates = replicates  # those that still have flights
        self.rows = np.arange(len(replicates))  # theirs in the estimates
        self.estimates = np.ones(len(replicates))
        self.flights = 0
        self.lost: list[LostFlight] = []
        normal, _, self.versions = self._draw(plan.population, 0, 0)
        self.z = normal
        self.margins, self.numbers = self._fly(self.z, self.versions)

    def climb(self, number: int, level: Level, *, adapt: bool = False) -> tuple[float, float]:
        """Keep what is above a level and move it: the next population. Returns the last step and the acceptance."""
        self._keep(number, level)
        step, accepted = level.step, []
        z, versions, margins, numbers = self.z, self.versions, self.margins, self.numbers
        population = []
        for t in range(1, self.plan.moves + 1):
            normal, chance, fresh = self._draw(self.plan.chains, number, t)
            new_z = math.sqrt(1 - step * step) * z + step * normal
            new_versions = np.where(chance < step, fresh, versions)
            new_margins, new_numbers = self._fly(new_z, new_versions)
            ok = level.keeps(new_margins)
            z, versions = np.where(ok[..., None], new_z, z), np.where(ok[..., None], new_versions, versions)
            margins, numbers = np.where(ok, new_margins, margins), np.where(ok, new_numbers, numbers)
            population.append((z, versions, margins, numbers))
            accepted.append(float(ok.mean()) if ok.size else math.nan)
            if adapt:
                step *= math.exp((accepted[-1] - WANTED_ACCEPTANCE) / math.sqrt(t))
                step = min(max(step, SMALLEST_STEP), 1.0)
        parts = (np.concatenate(part, axis=1) for part in zip(*population, strict=True))
        self.z, self.versions, self.margins, self.numbers = parts
        return step, sum(accepted) / len(accepted)

    def end(self) -> None:
        """Count what is lost."""
        lost = self.margins > 0
        self.estimates[self.rows] *= lost.sum(axis=1) / self.plan.population
        flights = zip(self.z[lost], self.versions[lost], self.margins[lost], self.numbers[lost], strict=True)
        self.lost = [LostFlight(z.copy(), v.copy(), float(g), int(i)) for z, v, g, i in flights]

    def _keep(self, number: int, level: Level) -> None:
        """Seeds of the next population, by systematic resampling of what a level keeps."""
        plan = self.plan
        kept = level.keeps(self.margins)
        self.estimates[self.rows] *= kept.sum(axis=1) / plan.population
        alive = kept.any(axis=1)
        self.rows, self.replicates, kept = self.rows[alive], self.replicates[alive], kept[alive]
        start = uniforms(stream((plan.seed, self.replicates), (0, number << 32), CHAINS, 1))[:, 0]
        seeds = np.zeros((len(kept), plan.chains), np.int64)
        for row, (mask, u) in enumerate(zip(kept, start, strict=True)):
            among = np.flatnonzero(mask)
            seeds[row] = among[((np.arange(plan.chains) + u) * (among.size / plan.chains)).astype(np.int64)]
        self.z = np.take_along_axis(self.z[alive], seeds[..., None], axis=1)
        self.versions = np.take_along_axis(self.versions[alive], seeds[..., None], axis=1)
        self.margins = np.take_along_axis(self.margins[alive], seeds, axis=1)
        self.numbers = np.take_along_axis(self.numbers[alive], seeds, axis=1)

    def _draw(self, chains: int, level: int, move: int) -> tuple[Floats, Floats, Words]:
        """Of each chain: d normal numbers, and of each block of noise a chance and a new version."""
        d, blocks = self.plan.inputs, self.plan.blocks
        which = np.arange(chains, dtype=np.uint64)
        key = self.plan.seed, self.replicates[:, None]
        words = stream(key, (which, (level << 32) + move), CHAINS, d + 2 * blocks)
        return special.ndtri(uniforms(words[..., :d])), uniforms(words[..., d : d + blocks]), words[..., d + blocks :]

    def _fly(self, z: Floats, versions: Words) -> tuple[Floats, NDArray[np.int64]]:
        """Margins and numbers of the flights of a batch, in its shape."""
        shape = z.shape[:2]
        number = shape[0] * shape[1]
        if number == 0:
            return np.zeros(shape), np.zeros(shape, np.int64)
        points = (z.reshape(number, -1).copy(), versions.reshape(number, -1).copy())  # theirs to change
        margins = np.asarray(self.margin(*points) if self.plan.blocks else self.margin(points[0]), float)
        if margins.shape != (number,):
            raise InputError(f"margin: {number} flights gave shape {margins.shape}; one number a flight belongs here")
        if not np.isfinite(margins).all():
            at = int(np.flatnonzero(~np.isfinite(margins))[0])
            raise InputError(f"margin: {margins[at]} of flight {at} of a batch; a finite number belongs here")
        numbers = self.before + self.flights + np.arange(number)
        self.flights += number
        return margins.reshape(shape), numbers.reshape(shape)


def cox_interval(p: Floats, confidence: float = 0.95) -> tuple[float, float]:
    """Interval of the mean of log-normal numbers, of Cox.

    Parameters
    ----------
    p
        Positive, independent, shape (K,).
    confidence
        Two-sided.
    """
    log = np.log(p)
    K, middle, v = len(p), float(log.mean()), float(log.var(ddof=1))
    half = float(special.stdtrit(K - 1, 0.5 + confidence / 2)) * math.sqrt(v / K + v * v / (2 * (K + 1)))
    return math.exp(middle + v / 2 - half), math.exp(middle + v / 2 + half)


def _clopper_pearson(failures: int, runs: int) -> float:
    """One-sided 95 % upper bound."""
    return 1.0 if failures >= runs else float(special.betaincinv(failures + 1, runs - failures, 0.95))


def _likeliest(lost: tuple[LostFlight, ...], count: int) -> tuple[LostFlight, ...]:
    """Lost flights by distance, each once: chains stand still where a move is refused."""
    different = {flight.number: flight for flight in lost}
    return tuple(sorted(different.values(), key=lambda flight: flight.distance)[:count])


def _whole(value: float) -> bool:
    return math.isclose(value, round(value), rel_tol=1e-9)


__all__ = ["Level", "LostFlight", "Rare", "SubsetSimulation", "cox_interval"]
