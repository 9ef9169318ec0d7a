# SPDX-License-Identifier: MIT
"""Where the points of the runs lie: independent, on Latin hypercubes, or on scrambled nets of Sobol.

``lhs`` and ``sobol`` take R independent replicates of n points: run i is point ``i mod n`` of replicate ``i div n``.
Their runs are not independent of each other; means over the replicates are.

References
----------
.. [1] M. McKay, R. Beckman, W. Conover, Technometrics 21 (1979): Latin hypercubes
.. [2] A. Owen, J. Complexity 14 (1998): scrambled nets
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from functools import lru_cache
from typing import Protocol

import numpy as np
from numpy.typing import NDArray
from scipy.stats import qmc

from gyrostat.campaign.streams import NETS, SMALLEST, Array, Stream, Streams, words

REPLICATES = 16
"""Where the file does not say."""


class Sampling(Protocol):
    """A choice of points."""

    def points(self, first: int, last: int) -> Array:
        """The points of runs first to last - 1, shape (last - first, dimension), all inside the open unit cube."""
        ...


class Plain:
    """Independent points."""

    def __init__(self, streams: Streams, seed: int) -> None:
        self._streams, self._seed = streams, seed

    def points(self, first: int, last: int) -> Array:
        """By their words."""
        return self._streams.uniforms(self._seed, first, last)


class _Replicated(ABC):
    def __init__(self, streams: Streams, seed: int, points: int) -> None:
        self._streams, self._seed, self._n = streams, seed, points
        self._replicate = lru_cache(maxsize=2)(self._made)

    def points(self, first: int, last: int) -> Array:
        """Those of the replicates that these runs belong to."""
        parts = []
        while first < last:
            replicate, at = divmod(first, self._n)
            count = min(last - first, self._n - at)
            parts.append(self._of(replicate, at, count))
            first += count
        return np.concatenate(parts) if parts else np.empty((0, self._streams.dimension))

    @abstractmethod
    def _of(self, replicate: int, at: int, count: int) -> Array:
        """Points from `at` on of a replicate, shape (count, dimension)."""

    @abstractmethod
    def _made(self, replicate: int) -> NDArray[np.float64]:
        """What all points of a replicate are made from."""


class LatinHypercube(_Replicated):
    """Each of n equal parts of every input once a replicate; where within its part, says the plain point."""

    def _of(self, replicate: int, at: int, count: int) -> Array:
        first = replicate * self._n + at
        within = self._streams.uniforms(self._seed, first, first + count)
        return np.minimum((self._replicate(replicate)[at : at + count] + within) / self._n, 1.0 - SMALLEST)

    def _made(self, replicate: int) -> NDArray[np.float64]:
        """Permutations, one a dimension: the order of words."""
        columns = []
        for stream in self._streams.streams:
            named = [Stream(stream.name, self._n)]
            for word in range(stream.words):
                order = words(self._seed, replicate, replicate + 1, named, domain=NETS, part=word)[0]
                columns.append(np.argsort(order, kind="stable").astype(np.float64))
        return np.column_stack(columns) if columns else np.empty((self._n, 0))


class Sobol(_Replicated):
    """A net of Sobol a replicate, scrambled by a word of its own."""

    def _of(self, replicate: int, at: int, count: int) -> Array:
        return self._replicate(replicate)[at : at + count]

    def _made(self, replicate: int) -> NDArray[np.float64]:
        d = self._streams.dimension
        if d == 0:
            return np.empty((self._n, 0))
        word = words(self._seed, replicate, replicate + 1, [Stream("sobol", 1)], domain=NETS)[0, 0]
        net = qmc.Sobol(d, scramble=True, bits=52, rng=np.random.Generator(np.random.PCG64(int(word))))
        return np.asarray(np.clip(net.random(self._n) + SMALLEST, SMALLEST, 1.0 - SMALLEST))


__all__ = ["REPLICATES", "LatinHypercube", "Plain", "Sampling", "Sobol"]
