# SPDX-License-Identifier: MIT
"""Which inputs of a flown campaign matter, cell by cell, from the rows that are there. Page: docs/verification.md."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from gyrostat.campaign.rows import Rows
from gyrostat.campaign.streams import Array
from gyrostat.verification.sensitivity import first_order

MOST_RUNS = 100_000
"""Runs that are looked at."""


@dataclass(frozen=True)
class Sensitivities:
    """First-order indices.

    Attributes
    ----------
    of
        What of: the measure that success names first, in decades where its scale is ``log``.
    inputs
        Names, those that matter most first.
    indices
        By cell, shape (inputs,) each; nan where there are too few runs.
    """

    of: str
    inputs: tuple[str, ...]
    indices: dict[str, Array]


def sensitivities(rows: Rows) -> Sensitivities | None:
    """Of the rows of a campaign; None where they are not of all runs, not independent, or too few."""
    found = rows.found
    if found.manifest["campaign"] is None or not (rows.whole and rows.independent and found.campaign.dimension):
        return None
    campaign = found.campaign
    measure = next(iter(rows.spec["success"]), next(iter(rows.measures)))
    log = (rows.spec["success"].get(measure) or {}).get("scale") == "log"
    indices = {}
    for label, columns in rows.cells.items():
        run = columns["run"].astype(np.int64)[:MOST_RUNS]
        x = rows.values(label, measure)[:MOST_RUNS]
        indices[label] = first_order(rows.points(run), np.log(np.maximum(x, 1e-300)) if log else x)
    best = np.nan_to_num(np.array(list(indices.values())), nan=-1.0).max(axis=0)
    if best.max() < 0.0:
        return None
    order = np.argsort(-best, kind="stable")
    named = tuple(campaign.inputs[i] for i in order.tolist())
    return Sensitivities(f"log {measure}" if log else measure, named, {k: x[order] for k, x in indices.items()})


__all__ = ["MOST_RUNS", "Sensitivities", "sensitivities"]
