# SPDX-License-Identifier: MIT
"""The smallest fault or disturbance that loses a flight, and what of it is needed.

A search in the space of standard normal inputs for the lost flight of smallest size; with the squared norm as size that
is the likeliest one. A fifth of the flights is drawn at random; the best of them that lie apart are the starts of
evolution strategies with covariance adaptation (Hansen & Ostermeier 2001, Evol. Comput. 9), of which only ranks are
used, and the best of their ends that of another one. Then each input in turn is pulled to its nominal value as far as
the flight stays lost: what remains is the explanation. Page: docs/verification.md
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import special

from gyrostat.campaign.limits import whole
from gyrostat.errors import InputError
from gyrostat.verification.words import LARGEST_SEED, OPTIMISERS, stream, uniforms

Floats = NDArray[np.float64]
Batch = Callable[[Floats], Floats]

SIGMA = 0.5
"""Of a start."""
APART = 1.5
"""Starts lie so far from each other, and from where earlier ones ended."""
STARTS = 3
POLISH = 0.25, 0.2
"""Share of the budget, and sigma, of a last strategy from the best of the first three ends."""
PATIENCE = 15
"""Generations without a gain of 1 % that end a restart."""
NOT_LOST = 1e6


def squared_norm(z: Floats) -> Floats:
    """The default size: minus twice the log density of a flight, but for a constant."""
    return np.asarray((z * z).sum(axis=1))


@dataclass(frozen=True)
class Smallest:
    """The smallest lost flight that was found, or the flight that came nearest to it.

    Attributes
    ----------
    lost
        Whether any flight was.
    z
        Its inputs, shape (d,).
    size, margin
        Of it.
    number
        Of the flight among all flown, from 0.
    first_lost
        Number of the first lost flight; -1 without one.
    flights
        Flown in all.
    restarts
        Size where each start ended; infinite where nothing was lost.
    """

    lost: bool
    z: Floats
    size: float
    margin: float
    number: int
    first_lost: int
    flights: int
    restarts: tuple[float, ...]


def evolution(start: Floats, sigma: float, seed: int, number: int, options: dict[str, Any]) -> Any:
    """A strategy of the library ``cma`` whose random numbers are keyed by seed and number.

    Raises
    ------
    InputError
        The library is not installed.
    """
    try:
        import cma
    except ImportError:
        raise InputError("the optimiser needs the package 'cma': pip install 'gyrostat[tune]'") from None
    random = np.random.Generator(
        np.random.Philox(key=np.array([seed, number], np.uint64), counter=[0, 0, 0, OPTIMISERS])
    )
    quiet = {"verbose": -9, "seed": math.nan, "randn": lambda *shape: random.standard_normal(shape)}
    return cma.CMAEvolutionStrategy(list(start), sigma, quiet | options)


class _Search:
    """Objectives of flights, and the best of them."""

    def __init__(self, margin: Batch, size: Batch, inputs: int, budget: int) -> None:
        self.margin, self.size, self.inputs, self.budget = margin, size, inputs, budget
        self.flights, self.first_lost = 0, -1
        self.best: tuple[float, Floats, float, float, int] = (math.inf, np.zeros(inputs), math.inf, -math.inf, -1)

    def left(self) -> int:
        return self.budget - self.flights

    def fly(self, z: Floats) -> Floats:
        """Size where lost, else a large number that falls with the margin. Lower is better."""
        margins = np.asarray(self.margin(z.copy()), float)
        if margins.shape != (len(z),) or not np.isfinite(margins).all():
            raise InputError("margin: one finite number a flight belongs here")
        lost = margins > 0
        sizes = np.asarray(self.size(z.copy()), float)
        if sizes.shape != (len(z),) or not (np.abs(sizes[lost]) < NOT_LOST / 2).all():
            raise InputError(f"size: one number a flight belongs here, below {NOT_LOST / 2:g}")
        values = np.where(lost, sizes, NOT_LOST - 1e3 * margins)
        if lost.any() and self.first_lost < 0:
            self.first_lost = self.flights + int(np.argmax(lost))
        at = int(np.argmin(values))
        if values[at] < self.best[0]:
            found = float(sizes[at]) if lost[at] else math.inf
            self.best = (float(values[at]), z[at].copy(), found, float(margins[at]), self.flights + at)
        self.flights += len(z)
        return np.asarray(values)


@dataclass(frozen=True)
class WorstCase:
    """How to look for the smallest lost flight.

    Attributes
    ----------
    inputs
        Standard normal inputs, d.
    budget
        Flights at most.
    seed
        Of all words.
    batch
        Flights flown together: the population of a generation.
    """

    inputs: int
    budget: int = 2000
    seed: int = 0
    batch: int = 0

    def __post_init__(self) -> None:
        whole("seed", self.seed, most=LARGEST_SEED)
        if self.inputs < 1:
            raise InputError(f"inputs = {self.inputs}: at least one belongs here")
        if self.batch == 0:
            object.__setattr__(self, "batch", 4 + int(3 * math.log(max(self.inputs, 2))))
        if self.batch < 4 or self.budget < 10 * self.batch:
            raise InputError(
                f"budget = {self.budget}: ten batches at least belong here, of {self.batch} flights, and 4 a batch"
            )

    def run(self, margin: Batch, size: Batch = squared_norm) -> Smallest:
        """Search.

        Parameters
        ----------
        margin
            Of flights, (n, d) to (n,): positive where lost, finite.
        size
            Of flights, (n, d) to (n,): what is to be small.
        """
        search = _Search(margin, size, self.inputs, self.budget)
        points, values = self._random(search)
        order = np.argsort(values, kind="stable")
        taken: list[Floats] = []
        ends: list[float] = []
        without_gain = 0
        while search.left() >= self.batch and (len(ends) < STARTS or without_gain < STARTS):
            start = next((points[i] for i in order if all(np.linalg.norm(points[i] - t) > APART for t in taken)), None)
            if start is None:
                break
            before = search.best
            starts_left = STARTS - len(ends)
            kept = int(POLISH[0] * self.budget) if starts_left > 0 else 0
            end, found = self._climb(search, start, SIGMA, len(ends) + 1, (search.left() - kept) // max(starts_left, 1))
            taken += [start, end]
            ends.append(found)
            if starts_left == 1:
                self._climb(search, search.best[1], POLISH[1], 0, kept)
            without_gain = 0 if _gained(before, search.best) else without_gain + 1
        _, z, found, reached, number = search.best
        return Smallest(math.isfinite(found), z, found, reached, number, search.first_lost, search.flights, tuple(ends))

    def _random(self, search: _Search) -> tuple[Floats, Floats]:
        """A fifth of the budget, drawn from the distribution of the inputs."""
        count = max(self.budget // 5, self.batch)
        which = np.arange(count, dtype=np.uint64)
        points = special.ndtri(uniforms(stream((self.seed, 0), (which, 0), OPTIMISERS, self.inputs)))
        return points, search.fly(points)

    def _climb(self, search: _Search, start: Floats, sigma: float, number: int, budget: int) -> tuple[Floats, float]:
        """One strategy until it stagnates or has used its share. Returns where it ended, and the size there."""
        padded = np.append(start, np.zeros(max(2 - self.inputs, 0)))  # the library wants two dimensions
        strategy = evolution(padded, sigma, self.seed, number, {"popsize": self.batch})
        until = search.flights + min(budget, search.left())
        own = _Search(search.margin, search.size, self.inputs, 0)
        stale, mark = 0, own.best
        while not strategy.stop() and stale < PATIENCE and search.flights + self.batch <= until:
            asked = strategy.ask()
            z = np.array(asked)[:, : self.inputs]
            values = search.fly(z)
            strategy.tell(asked, values.tolist())
            at = int(np.argmin(values))
            if values[at] < own.best[0]:
                found = float(values[at]) if values[at] < NOT_LOST / 2 else math.inf
                own.best = (float(values[at]), z[at], found, (NOT_LOST - float(values[at])) / 1e3, 0)
            stale = 0 if _gained(mark, own.best) else stale + 1
            mark = mark if stale else own.best
        return own.best[1], own.best[2]


def _gained(before: tuple[float, Floats, float, float, int], after: tuple[float, Floats, float, float, int]) -> bool:
    """1 % in size, or, before anything is lost, in the distance of the margin from zero."""
    if math.isfinite(after[2]):
        return not math.isfinite(before[2]) or after[2] < before[2] - 0.01 * abs(before[2])
    return math.isfinite(after[3]) and (not math.isfinite(before[3]) or after[3] > before[3] + 0.01 * abs(before[3]))


def shrunk(margin: Batch, z: Floats, *, bisections: int = 10) -> tuple[Floats, int]:
    """Inputs of a lost flight pulled to their nominal value, zero, as far as it stays lost.

    One input after the other, the smallest first; each ends at zero, or where a thousandth of it less would save the
    flight.

    Parameters
    ----------
    margin
        Of flights, (n, d) to (n,), with the noise of the lost one.
    z
        Of a lost flight, shape (d,).
    bisections
        Of an input that cannot be dropped.

    Returns
    -------
    tuple of ndarray and int
        What is left of z, and the flights that it took.
    """
    left = z.copy()
    flights = 0

    def lost(at: int, value: float) -> bool:
        nonlocal flights
        flights += 1
        trial = left.copy()
        trial[at] = value
        return bool(margin(trial[None, :])[0] > 0)

    for at in np.argsort(np.abs(z), kind="stable").tolist():
        if left[at] == 0.0:
            continue
        if lost(at, 0.0):
            left[at] = 0.0
            continue
        saved, needed = 0.0, float(left[at])
        for _ in range(bisections):
            middle = 0.5 * (saved + needed)
            if lost(at, middle):
                needed = middle
            else:
                saved = middle
        left[at] = needed
    return left, flights


def explanation(names: Sequence[str], values: Sequence[float], nominal: Sequence[float]) -> list[str]:
    """What a shrunk flight needs, in words: ``truth.friction above 3.1e-05 (nominal 1e-05)``.

    Parameters
    ----------
    names, values, nominal
        Of the quantities of the flight: those at their nominal value, but for rounding, are not needed.
    """
    return [
        f"{name} {'above' if value > middle else 'below'} {value:.4g} (nominal {middle:.4g})"
        for name, value, middle in zip(names, values, nominal, strict=True)
        if not (math.isclose(value, middle, rel_tol=1e-9, abs_tol=1e-15) or (math.isnan(value) and math.isnan(middle)))
    ]


__all__ = ["Smallest", "WorstCase", "evolution", "explanation", "shrunk", "squared_norm"]
