# SPDX-License-Identifier: MIT
"""Which inputs matter, from the rows of a campaign that was flown for something else.

First-order index of an input: the share of a measure's variance that lies between bins of that input
(Pearson's correlation ratio; Saltelli et al. 2008, Global Sensitivity Analysis). Failures: where the inputs of the lost
flights lie. Runs have to be independent: plain sampling. Page: docs/verification.md
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy import special

from gyrostat.errors import InputError

Floats = NDArray[np.float64]

BINS = 32


@dataclass(frozen=True)
class FailureHistogram:
    """Where the inputs of lost flights lie.

    Attributes
    ----------
    counts
        Lost flights by input and bin, shape (d, bins).
    share
        Of the lost flights; 1 / bins everywhere when the input does not matter.
    low, high
        Interval of Clopper and Pearson of each share, 95 %.
    """

    counts: NDArray[np.int64]
    share: Floats
    low: Floats
    high: Floats


def first_order(u: ArrayLike, y: ArrayLike, bins: int = BINS) -> Floats:
    """First-order index of each input.

    Parameters
    ----------
    u
        Uniform inputs of the runs, shape (n, d), in (0, 1).
    y
        A measure of each, shape (n,); runs without a finite value are left out.
    bins
        Equal parts of (0, 1).

    Returns
    -------
    ndarray
        Shape (d,), the bias of so many bins removed: about zero, and sometimes below, for an input that does not
        matter. nan where the measure does not vary or the runs are fewer than two a bin.
    """
    u, y = _rows(u, y)
    good = np.isfinite(y)
    u, y = u[good], y[good]
    n = y.size
    if n < 2 * bins or np.ptp(y) == 0:
        return np.full(u.shape[1], np.nan)
    deviation = y - y.mean()
    total = float(deviation @ deviation)
    indices = np.empty(u.shape[1])
    for i, where in enumerate(_bins(u, bins).T):
        counts = np.bincount(where, minlength=bins)
        sums = np.bincount(where, weights=deviation, minlength=bins)
        filled = counts > 0
        between = float((sums[filled] ** 2 / counts[filled]).sum()) / total
        indices[i] = between - (1 - between) * (filled.sum() - 1) / (n - filled.sum())
    return indices


def failure_histogram(u: ArrayLike, failed: ArrayLike, bins: int = BINS) -> FailureHistogram:
    """Histogram of each input given failure.

    Parameters
    ----------
    u
        Uniform inputs of the runs, shape (n, d); those of lost runs suffice.
    failed
        Which runs are lost, shape (n,).
    bins
        Equal parts of (0, 1).
    """
    u, lost = _rows(u, failed)
    where = _bins(u[lost.astype(bool)], bins)
    counts = np.stack([np.bincount(column, minlength=bins) for column in where.T])
    total = len(where)
    if total == 0:
        nothing = np.full(counts.shape, np.nan)
        return FailureHistogram(counts, nothing, np.zeros(counts.shape), np.ones(counts.shape))
    k = counts.astype(float)
    low = np.where(k > 0, special.betaincinv(np.maximum(k, 1), total - k + 1, 0.025), 0.0)
    high = np.where(k < total, special.betaincinv(k + 1, np.maximum(total - k, 1), 0.975), 1.0)
    return FailureHistogram(counts, k / total, low, high)


def _rows(u: ArrayLike, y: ArrayLike) -> tuple[Floats, Floats]:
    u, y = np.asarray(u, float), np.asarray(y, float)
    if u.ndim != 2 or y.shape != (len(u),):
        raise InputError(f"inputs of shape {u.shape} and a measure of shape {y.shape} do not fit: (n, d) and (n,)")
    return u, y


def _bins(u: Floats, bins: int) -> NDArray[np.int64]:
    return np.minimum((u * bins).astype(np.int64), bins - 1)


__all__ = ["BINS", "FailureHistogram", "failure_histogram", "first_order"]
