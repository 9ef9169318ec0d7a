# SPDX-License-Identifier: MIT
"""Random numbers by name: a word is a function of seed, run, the name of its stream, and its place in it.

Nothing is drawn in order, so that run i can be drawn alone, and an input that is added changes no other. A stream is
named in words (``initial.omega_BN_B``, ``fault.wheel.0.t_on``); its words are those of Philox4x64-10 [1]_.

References
----------
.. [1] J. Salmon, M. Moraes, R. Dror, D. Shaw, "Parallel random numbers: as easy as 1, 2, 3", SC11 (2011)
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from hashlib import blake2b
from itertools import accumulate

import numpy as np
from numpy.typing import NDArray

from gyrostat import _core
from gyrostat.errors import InputError

Array = NDArray[np.float64]

DRAWS, CHAINS, OPTIMISERS, NETS = 1, 2, 3, 4
"""Domains of words: last word of the counter. Domain 0 is sensor noise."""

SMALLEST = 2.0**-53
"""Nearest that a uniform number comes to 0, and to 1."""


@dataclass(frozen=True)
class Stream:
    """A named stream and how many of its words a run takes."""

    name: str
    words: int


def name_hash(name: str) -> int:
    """The first 8 bytes, little endian, of BLAKE2b of the name with a digest of 8 bytes."""
    return int.from_bytes(blake2b(name.encode(), digest_size=8).digest(), "little")


def uniform(words: NDArray[np.uint64]) -> Array:
    """Numbers in (0, 1), of the same shape: 52 bits of a word, half a step away from both ends."""
    return np.asarray(((words >> np.uint64(12)).astype(np.float64) + 0.5) * 2.0**-52)


@dataclass(frozen=True)
class Streams:
    """The random inputs of a campaign: a run is a point of the open unit cube, one dimension a word."""

    streams: tuple[Stream, ...]

    def __post_init__(self) -> None:
        seen: dict[int, str] = {}
        for stream in self.streams:
            other = seen.setdefault(name_hash(stream.name), stream.name)
            if other == stream.name and sum(s.name == other for s in self.streams) > 1:
                raise InputError(f"two inputs are called '{other}'")
            if other != stream.name:
                raise InputError(f"'{other}' and '{stream.name}' have the same hash; call one of them otherwise")

    @property
    def dimension(self) -> int:
        """Words a run."""
        return sum(s.words for s in self.streams)

    @property
    def places(self) -> dict[str, slice]:
        """Where each stream stands in a point."""
        ends = accumulate(s.words for s in self.streams)
        return {s.name: slice(end - s.words, end) for s, end in zip(self.streams, ends, strict=True)}

    def uniforms(self, seed: int, first: int, last: int) -> Array:
        """The points of runs first to last - 1, shape (last - first, dimension)."""
        return uniform(words(seed, first, last, self.streams))


def words(
    seed: int, first: int, last: int, streams: Sequence[Stream], *, domain: int = DRAWS, part: int = 0
) -> NDArray[np.uint64]:
    """Words of runs first to last - 1, shape (last - first, words of all streams).

    Parameters
    ----------
    seed, first, last
        Of the campaign, and of the runs.
    streams
        What is wanted, in this order.
    domain, part
        Last and last but one word of the counter.
    """
    names = [name_hash(s.name) for s in streams]
    return _core.words(seed, first, last, names, [s.words for s in streams], domain, part)


__all__ = [
    "CHAINS",
    "DRAWS",
    "NETS",
    "OPTIMISERS",
    "SMALLEST",
    "Array",
    "Stream",
    "Streams",
    "name_hash",
    "uniform",
    "words",
]
