# SPDX-License-Identifier: MIT
"""Many flights of one case with drawn numbers, as part of a study. Drawing and flying are `gyrostat.campaign`.

A table of a ``claims.toml`` is a campaign whose base is a case, or one that is like an earlier campaign, with more
changed, drawn and measured::

    [campaigns.any_attitude]
    title = "..."
    like = "table1"                       # a case or an earlier campaign; `set` changes it
    set = { "controller.phi" = 0.01 }
    runs = 150
    seed = 7                              # campaigns of one seed draw the same numbers under the same keys
    [campaigns.any_attitude.vary]         # as in the file of a campaign
    "initial.mrp" = { dist = "attitude" }
    [campaigns.any_attitude.measure]
    settling = { metric = "settling_time", signal = "truth.mrp", band = 1e-3 }

Claims name it as their case, and a metric of `ENSEMBLE_METRICS` over its runs:
``measure = { metric = "share_below", signal = "settling", level = 20 }``. A flight that ended early is not
measured, unless ``cut_short = true``.
"""

from __future__ import annotations

import io
import math
import re
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, Any

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from gyrostat.errors import InputError, suggestion
from gyrostat.model import Model
from gyrostat.papers.measures import Metric
from gyrostat.scenario import Scenario

if TYPE_CHECKING:
    from gyrostat.campaign import Campaign

Array = NDArray[np.float64]


class CampaignEntry(Model):
    """One ``[campaigns.<id>]`` table of a ``claims.toml``."""

    title: str
    like: str
    set: Annotated[dict[str, Any], Field(default_factory=dict)]
    runs: Annotated[int, Field(ge=1, le=1_000_000)] | None = None
    seed: int | None = None
    vary: Annotated[dict[str, Any], Field(default_factory=dict)]
    measure: Annotated[dict[str, dict[str, Any]], Field(default_factory=dict)]

    def after(self, earlier: CampaignEntry | None) -> CampaignEntry:
        """With what it takes over from the one that it is like."""
        if earlier is None:
            return self
        told = {name: getattr(self, name) for name in ("runs", "seed") if getattr(self, name) is not None}
        told |= {name: getattr(earlier, name) | getattr(self, name) for name in ("set", "vary", "measure")}
        return earlier.model_copy(update={"title": self.title, **told})


@dataclass(frozen=True)
class CampaignCase:
    """A campaign of a study, and how many of its runs are flown."""

    id: str
    title: str
    runs: int
    campaign: Campaign

    def fly(self, *, workers: int | None = None, progress: Callable[[float], None] | None = None) -> Ensemble:
        """Fly and measure all of them."""
        return Ensemble(self.id, self.campaign.fly(0, self.runs, jobs=workers, progress=progress).table)


@dataclass(frozen=True)
class Ensemble:
    """What a campaign drew and measured: the Arrow table of its runs."""

    id: str
    table: Any

    def __getitem__(self, name: str) -> Array:
        """A column of numbers, one a run: NaN where it never settled; of a flight that ended early, up to there."""
        if name not in self.table.column_names:
            raise KeyError(f"no measure '{name}'{suggestion(name, self.table.column_names)}")
        return np.asarray(self.table.column(name).to_numpy(), dtype=np.float64)

    def completed(self, signal: Array) -> Array:
        """The same, NaN where a flight ended early."""
        return np.where(np.array(self.table.column("status").to_pylist()) == "completed", signal, np.nan)

    def to_csv(self) -> str:
        """The table, a line a run."""
        import pyarrow.csv

        text = io.BytesIO()
        pyarrow.csv.write_csv(self.table, text)
        return text.getvalue().decode()


def share_below(ensemble: Ensemble, *, signal: Array, level: float) -> float:
    """Share of the runs whose number lies below a level; one that could not be measured does not."""
    return float(np.mean(np.nan_to_num(ensemble.completed(signal), nan=math.inf) < level))


def middle(ensemble: Ensemble, *, signal: Array) -> float:
    """Median over the runs; those that could not be measured count as infinite."""
    return float(np.median(np.nan_to_num(ensemble.completed(signal), nan=math.inf)))


def highest(ensemble: Ensemble, *, signal: Array, cut_short: bool = False) -> float:
    """Largest over the runs; not measured when one of them is not, unless what ended early counts up to there."""
    return float(np.max(signal if cut_short else ensemble.completed(signal)))


ENSEMBLE_METRICS: dict[str, Metric] = {f.__name__: f for f in (share_below, middle, highest)}


def build(key: str, entry: CampaignEntry, base: Scenario) -> CampaignCase:
    """A campaign from its table.

    Parameters
    ----------
    key
        Its identifier.
    entry
        The table, with all that it takes over.
    base
        Scenario of the case that it is like.
    """
    from gyrostat.campaign import Campaign

    if not re.fullmatch(r"[\w.@-]+", key):
        raise InputError("its name is that of a file: letters, digits, '_', '-', '.' and '@' belong there")
    if entry.runs is None:
        raise InputError("runs is missing: how many are flown")
    campaign = Campaign(
        base,
        set=entry.set,
        name=key,
        description=entry.title,
        seed=entry.seed or 0,
        vary=entry.vary,
        measure=entry.measure,
    )
    return CampaignCase(key, entry.title, entry.runs, campaign)


__all__ = [
    "ENSEMBLE_METRICS",
    "CampaignCase",
    "CampaignEntry",
    "Ensemble",
    "build",
    "highest",
    "middle",
    "share_below",
]
