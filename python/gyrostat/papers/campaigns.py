# SPDX-License-Identifier: MIT
"""Many flights of one case with sampled numbers, as part of a study. The flying is `gyrostat.experiment`.

A campaign is flown from a table of a ``claims.toml``::

    [campaigns.any_attitude]
    title = "..."
    like = "table1"                       # a case; `set` changes it
    set = { "controller.phi" = 0.01 }
    sampler = "attitude"                  # of SAMPLERS in signals.py: (rng, **arguments) -> numbers by dotted path
    arguments = { norm = [0.0, 1.0] }
    runs = 150
    seed = 7                              # the same seed, sampler and arguments draw the same samples
    [campaigns.any_attitude.measures]     # one number a run: metric, signal and arguments, as an Experiment takes them
    settling = { metric = "settling_time", signal = "truth.mrp", band = 1e-3 }

Claims name it as their case, and a metric of `ENSEMBLE_METRICS` over its runs:
``measure = { metric = "share_below", signal = "settling", level = 20 }``. A flight that ended early is not measured.
"""

from __future__ import annotations

import csv
import io
import math
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Annotated, Any

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from gyrostat.errors import InputError, suggestion
from gyrostat.experiment import Experiment
from gyrostat.model import Model
from gyrostat.papers.measures import Metric
from gyrostat.scenario import Scenario

Array = NDArray[np.float64]
Sampler = Callable[..., dict[str, Any]]


class CampaignEntry(Model):
    """One ``[campaigns.<id>]`` table of a ``claims.toml``."""

    title: str
    like: str
    set: Annotated[dict[str, Any], Field(default_factory=dict)]
    sampler: str
    arguments: Annotated[dict[str, Any], Field(default_factory=dict)]
    runs: Annotated[int, Field(ge=1, le=1_000_000)]
    seed: Annotated[int, Field(ge=0)] = 0
    measures: Annotated[dict[str, dict[str, Any]], Field(min_length=1)]


@dataclass(frozen=True)
class Campaign:
    """A scenario, how it is varied, and what is measured of each run."""

    id: str
    title: str
    scenario: Scenario
    sampler: Sampler
    arguments: Mapping[str, Any]
    runs: int
    seed: int
    measures: Mapping[str, Mapping[str, Any]]

    @cached_property
    def experiment(self) -> Experiment:
        """What flies."""
        return Experiment(self.scenario, vary=list(self._draw(np.random.default_rng(self.seed))), measure=self.measures)

    def values(self) -> Array:
        """What the runs fly with, a row each; all drawn from one generator, whatever the order of flying."""
        rng = np.random.default_rng(self.seed)
        return np.array([np.concatenate([np.ravel(v) for v in self._draw(rng).values()]) for _ in range(self.runs)])

    def fly(self, *, workers: int | None = None, progress: Callable[[float], None] | None = None) -> Ensemble:
        """Fly and measure all of them; NaN where a run could not be measured, e.g. because it never settled."""
        flights = self.experiment.fly(self.values(), threads=workers, progress=progress)
        return Ensemble(self, {name: np.where(flights.completed, flights[name], np.nan) for name in self.measures})

    def _draw(self, rng: np.random.Generator) -> dict[str, Any]:
        return self.sampler(rng, **self.arguments)


@dataclass(frozen=True)
class Ensemble:
    """What a campaign measured: one column a measure, one row a run."""

    campaign: Campaign
    measured: Mapping[str, Array]

    def __getitem__(self, name: str) -> Array:
        """A measure of every run."""
        if name not in self.measured:
            raise KeyError(f"no measure '{name}'{suggestion(name, self.measured)}")
        return self.measured[name]

    def to_csv(self) -> str:
        """A line a run: the sampled numbers, then what was measured."""
        text = io.StringIO()
        rows = csv.writer(text, lineterminator="\n")
        rows.writerow(["campaign", "run", *self.campaign.experiment.columns, *self.measured])
        for run, values in enumerate(self.campaign.values()):
            numbers = [*values, *(column[run] for column in self.measured.values())]
            rows.writerow([self.campaign.id, run, *(repr(float(x)) for x in numbers)])
        return text.getvalue()


def share_below(ensemble: Ensemble, *, signal: Array, level: float) -> float:
    """Share of the runs whose number lies below a level; one that could not be measured does not."""
    del ensemble
    return float(np.mean(np.nan_to_num(signal, nan=math.inf) < level))


def middle(ensemble: Ensemble, *, signal: Array) -> float:
    """Median over the runs; those that could not be measured count as infinite."""
    del ensemble
    return float(np.median(np.nan_to_num(signal, nan=math.inf)))


def highest(ensemble: Ensemble, *, signal: Array) -> float:
    """Largest over the runs; not measured when one of them is not."""
    del ensemble
    return float(np.max(signal))


ENSEMBLE_METRICS: dict[str, Metric] = {f.__name__: f for f in (share_below, middle, highest)}


def build(key: str, entry: CampaignEntry, base: Scenario, samplers: Mapping[str, Sampler]) -> Campaign:
    """A campaign from its table; the first sample is drawn now, so that mistakes show before anything runs.

    Parameters
    ----------
    key
        Its identifier.
    entry
        The table.
    base
        Scenario of the case that it is like.
    samplers
        SAMPLERS of the study.
    """
    if not re.fullmatch(r"[\w.@-]+", key):
        raise InputError("its name is that of a file: letters, digits, '_', '-', '.' and '@' belong there")
    if entry.sampler not in samplers:
        raise InputError(f"unknown sampler '{entry.sampler}'{suggestion(entry.sampler, samplers)}")
    campaign = Campaign(
        key,
        entry.title,
        base.replace(**entry.set),
        samplers[entry.sampler],
        entry.arguments,
        entry.runs,
        entry.seed,
        entry.measures,
    )
    try:
        _ = campaign.experiment
    except TypeError as error:
        raise InputError(f"sampler '{entry.sampler}': {error}") from None
    return campaign


__all__ = ["ENSEMBLE_METRICS", "Campaign", "CampaignEntry", "Ensemble", "build", "highest", "middle", "share_below"]
