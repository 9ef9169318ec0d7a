# SPDX-License-Identifier: MIT
"""Cells of a grid beside each other. They flew the same draws with the same noise, so that differences are paired.

Reference: Q. McNemar, Psychometrika 12 (1947).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import stats

from gyrostat.campaign.flights import unknown_cell
from gyrostat.campaign.results import CampaignResult
from gyrostat.errors import InputError
from gyrostat.verification.sequential import rate_interval


@dataclass(frozen=True)
class Comparison:
    """A cell beside the reference.

    Attributes
    ----------
    cell
        Its label.
    runs, failures
        Of all of its flights.
    interval
        Of the failure rate, 95 %, by `gyrostat.verification.sequential.rate_interval`.
    lost, saved
        Runs that it lost and the reference did not, and the reverse.
    p
        McNemar's exact p that it loses as often as the reference; 1 for the reference itself.
    """

    cell: str
    runs: int
    failures: int
    interval: tuple[float, float]
    lost: int
    saved: int
    p: float


def compare(found: CampaignResult, reference: str | None = None) -> list[Comparison]:
    """Every cell against a reference, the first one if absent. All rows must be kept.

    Raises
    ------
    InputError
        No such cell, or a campaign that keeps failures alone.
    """
    cells = list(found.counts)
    base = cells[0] if reference is None else reference
    if base not in cells:
        raise unknown_cell(base, cells)
    success = np.concatenate([np.asarray(t.column("success"), dtype=bool) for t in found.tables(["success"])])
    if len(success) != len(cells) * found.runs:
        raise InputError(f"{found.folder}: keeps failures alone; cells are compared run by run")
    by_cell = dict(zip(cells, success.reshape(-1, len(cells)).T, strict=True))
    return [_compared(label, ok, by_cell[base]) for label, ok in by_cell.items()]


def _compared(label: str, ok: NDArray[np.bool_], base: NDArray[np.bool_]) -> Comparison:
    lost, saved = int(np.count_nonzero(~ok & base)), int(np.count_nonzero(ok & ~base))
    failures = int(np.count_nonzero(~ok))
    return Comparison(label, len(ok), failures, rate_interval(len(ok), failures), lost, saved, mcnemar(lost, saved))


def mcnemar(lost: int, saved: int) -> float:
    """Exact p, two-sided, that runs which one of two lost alone are as often lost as saved."""
    return 1.0 if lost + saved == 0 else float(stats.binomtest(lost, lost + saved).pvalue)


__all__ = ["Comparison", "compare", "mcnemar"]
