# SPDX-License-Identifier: MIT
"""Many runs of one scenario with sampled changes, as part of a study.

A campaign is flown from a table of a ``claims.toml``::

    [campaigns.any_attitude]
    title = "..."
    like = "table1"                       # a case; `set` changes it
    set = { "controller.phi" = 0.01 }
    sampler = "attitude"                  # of SAMPLERS in signals.py: (rng, **arguments) -> changes of the scenario
    arguments = { norm = [0.0, 1.0] }
    runs = 150
    seed = 7                              # the same seed, sampler and arguments draw the same samples
    [campaigns.any_attitude.measures]     # one number a run, measured as claims measure
    settling = { metric = "settling_time", signal = "truth.mrp", band = 1e-3 }

Claims name it as their case, and a metric of `ENSEMBLE_METRICS` over its runs:
``measure = { metric = "share_below", signal = "settling", level = 20 }``.
"""

from __future__ import annotations

import csv
import io
import math
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Annotated, Any

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from gyrostat.errors import InputError, suggestion
from gyrostat.model import Model
from gyrostat.papers.measures import Measure, Metric
from gyrostat.results import Result
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
    measures: Mapping[str, Measure]
    watch: Callable[[float], None] | None = None
    """Called by every run now and then; what it raises ends the run."""

    def samples(self) -> list[Scenario]:
        """The scenarios to fly, all drawn from one generator, so that they do not depend on the order of flying."""
        rng = np.random.default_rng(self.seed)
        return [self.scenario.replace(**self.sampler(rng, **self.arguments)) for _ in range(self.runs)]

    def fly(self, sample: Scenario) -> dict[str, float]:
        """Fly one of them and measure it; NaN where a run could not be measured, e.g. because it never settled."""
        result = sample.run(progress=self.watch)
        return {name: _measured(measure, result) for name, measure in self.measures.items()}


@dataclass(frozen=True)
class Ensemble:
    """What a campaign measured: one column a measure, one row a run."""

    campaign: Campaign
    values: Mapping[str, Array]

    def __getitem__(self, name: str) -> Array:
        """A measure of every run."""
        if name not in self.values:
            raise KeyError(f"no measure '{name}'{suggestion(name, self.values)}")
        return self.values[name]

    def to_csv(self) -> str:
        """A line a run, with the sampled initial state."""
        text = io.StringIO()
        rows = csv.writer(text, lineterminator="\n")
        rows.writerow(
            ["campaign", "run", *(f"mrp_{i}" for i in range(3)), *(f"omega_{i}" for i in range(3)), *self.values]
        )
        for run, sample in enumerate(self.campaign.samples()):
            start = sample.resolve()["initial"]
            state = [*(start.get("mrp") or ["", "", ""]), *start.get("omega_BN_B", [0.0, 0.0, 0.0])]
            rows.writerow([self.campaign.id, run, *state, *(repr(float(v[run])) for v in self.values.values())])
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


def build(
    key: str,
    entry: CampaignEntry,
    base: Scenario,
    samplers: Mapping[str, Sampler],
    measure: Callable[[dict[str, Any]], Measure],
) -> Campaign:
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
    measure
        Reads a ``measure`` table.
    """
    if not re.fullmatch(r"[\w.@-]+", key):
        raise InputError("its name is that of a file: letters, digits, '_', '-', '.' and '@' belong there")
    if entry.sampler not in samplers:
        raise InputError(f"unknown sampler '{entry.sampler}'{suggestion(entry.sampler, samplers)}")
    measures = {name: measure(table) for name, table in entry.measures.items()}
    if any(m.others for m in measures.values()):
        raise InputError("a run of a campaign cannot be compared with a case")
    wanted = sorted({m.signal for m in measures.values() if m.signal is not None and m.signal not in m.signals})
    scenario = base.replace(**({"record": {"channels": wanted}} | entry.set))
    campaign = Campaign(
        key, entry.title, scenario, samplers[entry.sampler], entry.arguments, entry.runs, entry.seed, measures
    )
    try:
        scenario.replace(**campaign.sampler(np.random.default_rng(entry.seed), **entry.arguments))
    except TypeError as error:
        raise InputError(f"sampler '{entry.sampler}': {error}") from None
    return campaign


def _measured(measure: Measure, result: Result) -> float:
    try:
        return measure(result, {})
    except (ValueError, IndexError):
        return math.nan


__all__ = ["ENSEMBLE_METRICS", "Campaign", "CampaignEntry", "Ensemble", "build", "highest", "middle", "share_below"]
