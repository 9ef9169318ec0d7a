# SPDX-License-Identifier: MIT
"""Few samples that draw the same picture: of each stretch the smallest and the largest, so that no peak is lost."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Indices = NDArray[np.int_]


def min_max(x: Array, stretch: int) -> Indices:
    """Samples to keep of a signal: of each stretch the smallest, the largest and the first that is not a number.

    Parameters
    ----------
    x
        Signal, shape (n,).
    stretch
        Samples that become two; 1 keeps all.

    Returns
    -------
    Indices
        In order, first and last sample always among them; the inside of a constant part is left out.
    """
    n = len(x)
    if stretch < 2 or n < 3:
        return _without_constant_parts(x, np.arange(n))
    rows = -(-n // stretch)
    padded = np.concatenate([x, np.full(rows * stretch - n, x[-1])]).reshape(rows, stretch)
    gap = np.isnan(padded)
    start = np.arange(rows) * stretch
    picked = [
        np.array([0, n - 1]),
        start + np.where(gap, np.inf, padded).argmin(1),
        start + np.where(gap, -np.inf, padded).argmax(1),
        (start + gap.argmax(1))[gap.any(1)],
    ]
    kept = np.unique(np.minimum(np.concatenate(picked), n - 1))
    return _without_constant_parts(x, kept)


def _without_constant_parts(x: Array, kept: Indices) -> Indices:
    """Of equal values in a row only the ends."""
    y = x[kept]
    same = (y[1:] == y[:-1]) | (np.isnan(y[1:]) & np.isnan(y[:-1]))
    inside = np.zeros(len(y), dtype=bool)
    inside[1:-1] = same[1:] & same[:-1]
    return kept[~inside]


@dataclass(frozen=True)
class Thinned:
    """Signals by name, each with the samples that are kept."""

    kept: Mapping[str, Indices]
    stretch: int
    """Samples that became two; 1: nothing was thinned."""


def within(signals: Mapping[str, Array], budget: int, cost: Callable[[Indices], int]) -> Thinned:
    """Keep as much of all signals together as a budget allows.

    All have the same stretch, within 5 % the shortest for which they fit. What is constant costs next to nothing, so
    few lively signals are kept in full.

    Parameters
    ----------
    signals
        By name, each of shape (n,).
    budget, cost
        What all may cost together, and what the kept samples of one cost.
    """

    def thinned(stretch: int) -> Thinned:
        return Thinned({name: min_max(x, stretch) for name, x in signals.items()}, stretch)

    def fits(found: Thinned) -> bool:
        return sum(map(cost, found.kept.values())) <= budget

    whole = thinned(1)
    if fits(whole):
        return whole
    low, high = 1, max(len(x) for x in signals.values())
    best = thinned(high)
    while high > max(1.05 * low, low + 1):
        middle = min(max(round((low * high) ** 0.5), low + 1), high - 1)
        tried = thinned(middle)
        if fits(tried):
            high, best = middle, tried
        else:
            low = middle
    return best
