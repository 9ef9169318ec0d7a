# SPDX-License-Identifier: MIT
"""Few samples that draw the same picture: of each stretch the smallest and the largest, so that no peak is lost."""

from __future__ import annotations

import base64
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

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
        [0, n - 1],
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


def within(signals: Mapping[str, Array], budget: int) -> Thinned:
    """Keep as much of all signals together as a number of characters of base64 holds.

    All signals have the same stretch, the shortest for which they fit. What is constant costs next to nothing, so a
    page of few lively signals shows them in full.
    """
    low, high = 1, max((len(x) for x in signals.values()), default=1)
    best = {name: min_max(x, 1) for name, x in signals.items()}
    if _size(best, signals) <= budget:
        return Thinned(best, 1)
    while low + 1 < high:
        middle = (low * high) ** 0.5 if low * 2 < high else (low + high) / 2  # first the magnitude, then the number
        stretch = min(max(round(middle), low + 1), high - 1)
        tried = {name: min_max(x, stretch) for name, x in signals.items()}
        low, high, best = (low, stretch, tried) if _size(tried, signals) <= budget else (stretch, high, best)
        if high < 1.05 * low:
            break
    return Thinned({name: min_max(x, high) for name, x in signals.items()}, high)


def _size(kept: Mapping[str, Indices], signals: Mapping[str, Array]) -> int:
    return sum(len(k) * (4 + _index_type(len(signals[name])).itemsize) * 4 // 3 + 90 for name, k in kept.items())


def _index_type(samples: int) -> np.dtype[Any]:
    return np.dtype("<u2" if samples <= 1 << 16 else "<u4")


def pack_indices(kept: Indices, samples: int) -> str:
    """Indices of a run of so many samples: two bytes each if that is enough, else four."""
    return _packed(kept.astype(_index_type(samples)))


def pack(x: NDArray[Any]) -> str:
    """Values in single precision, seven digits; an infinity is not drawn and stands as not a number."""
    with np.errstate(over="ignore"):
        single = np.asarray(x, dtype="<f4")
    return _packed(np.where(np.isfinite(single), single, np.float32(np.nan)).astype("<f4"))


def pack_times(t: Array) -> str:
    """Instants in double precision."""
    return _packed(np.asarray(t, dtype="<f8"))


def _packed(x: NDArray[Any]) -> str:
    return base64.b64encode(np.ascontiguousarray(x).tobytes()).decode()


def clock(t: Array) -> dict[str, Any]:
    """How the page counts time: start, step, number and end when the samples are evenly spaced, else all instants.

    A recording keeps the last sample always, so the last step may be shorter.
    """
    n = len(t)
    step = float(t[1] - t[0]) if n > 1 else 0.0
    regular = float(t[0]) + step * np.arange(n)
    if np.allclose(regular[:-1], t[:-1], rtol=1e-9, atol=1e-6 * step):
        return {"start": float(t[0]), "step": step, "count": n, "end": float(t[-1])}
    return {"count": n, "times": pack_times(t)}
