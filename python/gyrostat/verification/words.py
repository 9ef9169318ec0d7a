# SPDX-License-Identifier: MIT
"""Random words by counter: Philox4x64-10 of many keys and counters at once (Salmon et al. 2011, SC'11).

A word is a function of its key and counter, so that nothing depends on the order in which chains are moved, on threads,
or on where a killed process began again. The last word of a counter is the domain, the others say whose word it is.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

Words = NDArray[np.uint64]

LARGEST_SEED = 2**64 - 1
"""Of the words that a key takes."""

CHAINS = 2
"""Domain of the Markov chains of `gyrostat.verification.rare`."""
OPTIMISERS = 3
"""Domain of `worst` and `tune`."""

_MULTIPLIERS = 0xD2E7470EE14C6C93, 0xCA5A826395121157
_KEY_STEPS = 0x9E3779B97F4A7C15, 0xBB67AE8584CAA73B
_LOW = np.uint64(0xFFFFFFFF)
_HALF = np.uint64(32)


def philox(key: tuple[ArrayLike, ArrayLike], counter: tuple[ArrayLike, ArrayLike, ArrayLike, ArrayLike]) -> Words:
    """Four words for each key and counter.

    Parameters
    ----------
    key, counter
        Two and four words, 0 to 2^64 - 1: whole numbers or arrays of uint64 that broadcast together.

    Returns
    -------
    ndarray
        Shape of the broadcast with a last axis of 4. What `numpy.random.Philox` gives for ``counter - 1``.
    """
    k0, k1, c0, c1, c2, c3 = np.broadcast_arrays(*(_word(w) for w in (*key, *counter)))
    with np.errstate(over="ignore"):
        for number in range(10):
            if number:
                k0, k1 = k0 + np.uint64(_KEY_STEPS[0]), k1 + np.uint64(_KEY_STEPS[1])
            high0, low0 = _product(_MULTIPLIERS[0], c0)
            high1, low1 = _product(_MULTIPLIERS[1], c2)
            c0, c1, c2, c3 = high1 ^ c1 ^ k0, low1, high0 ^ c3 ^ k1, low0
    return np.stack([c0, c1, c2, c3], axis=-1)


def stream(key: tuple[ArrayLike, ArrayLike], counter: tuple[ArrayLike, ArrayLike], domain: int, count: int) -> Words:
    """Words 0 to ``count - 1`` of streams: word j is ``philox(key, (j div 4, *counter, domain))[j mod 4]``.

    Returns
    -------
    ndarray
        Shape of the broadcast of key and counter, with a last axis of `count`.
    """
    key = (_word(key[0])[..., None], _word(key[1])[..., None])
    blocks = np.arange(-(-count // 4), dtype=np.uint64)
    words = philox(key, (blocks, _word(counter[0])[..., None], _word(counter[1])[..., None], domain))
    return words.reshape(*words.shape[:-2], 4 * blocks.size)[..., :count]


def uniforms(words: Words) -> NDArray[np.float64]:
    """Numbers strictly between 0 and 1: 52 bits and a half, so that the largest does not round to 1."""
    return ((words >> np.uint64(12)).astype(np.float64) + 0.5) * 2.0**-52


def _word(value: ArrayLike) -> Words:
    return np.asarray(value, np.uint64)


def _product(multiplier: int, x: Words) -> tuple[Words, Words]:
    """High and low word of a product, from 32-bit halves."""
    m_low, m_high = np.uint64(multiplier & 0xFFFFFFFF), np.uint64(multiplier >> 32)
    low, high = x & _LOW, x >> _HALF
    cross = m_high * low + ((m_low * low) >> _HALF)
    other = m_low * high + (cross & _LOW)
    return m_high * high + (cross >> _HALF) + (other >> _HALF), np.uint64(multiplier) * x


__all__ = ["CHAINS", "LARGEST_SEED", "OPTIMISERS", "philox", "stream", "uniforms"]
