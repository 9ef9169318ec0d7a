# SPDX-License-Identifier: MIT
"""Rows of a campaign: each run is drawn, flown in every cell with the same draws and the same noise, and judged."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping
from copy import copy
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import product
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gyrostat.campaign.inputs import Draws, Inputs, never
from gyrostat.campaign.judging import Judge
from gyrostat.campaign.spec import Spec
from gyrostat.campaign.streams import Array
from gyrostat.errors import InputError, input_errors, suggestion
from gyrostat.experiment import Experiment, Flights, usual_measures
from gyrostat.scenario import Scenario, with_objects
from gyrostat.text import one_line

RAISED = "raised"
"""Status of a flight in which a Python component raised."""

Progress = Callable[[float], None]


@dataclass(frozen=True)
class Outcome:
    """What became of runs in one cell, shape (n,) each.

    Attributes
    ----------
    measures
        By name; of a flight that ended early, up to there.
    success
        Whether all of ``[success]`` holds.
    margin
        Positive where lost, finite everywhere; None where the campaign defines none.
    status, cause, t_end
        How each ended, why (None where completed), and when, s.
    """

    measures: dict[str, Array]
    success: NDArray[np.bool_]
    margin: Array | None
    status: NDArray[np.str_]
    cause: list[str | None]
    t_end: Array


class Cell:
    """One combination of the levels of the grid, ready to fly."""

    def __init__(self, label: str, scenario: Scenario, inputs: Inputs, spec: Spec) -> None:
        self.label = label
        self.plain = scenario
        self._inputs = inputs
        self._measures = measures = spec.measure or usual_measures(scenario.duration)
        with input_errors(f"cell '{label}'" if label else ""):
            for varied in inputs.varied:
                found = Experiment(inputs.scenario(scenario), vary=varied.paths, measure={}).columns
                if len(found) != len(varied.paths):
                    raise InputError(
                        f"vary '{varied.key}': holds {len(found)} numbers, and {len(varied.paths)} are drawn; "
                        f"write each = {len(found)}"
                    )
            self.experiment = Experiment(inputs.scenario(scenario), vary=inputs.paths, measure=measures)
            self.judge = Judge.of(spec, measures, scenario.duration)

    @property
    def noise_blocks(self) -> int:
        """Seconds whose noise has a version of its own; 0 without sensors."""
        return math.floor(self.plain.duration) + 1 if self.plain.sensors else 0

    @cached_property
    def versioned(self) -> Cell:
        """The same, with the versions of its blocks of noise as further values, after all others."""
        other = copy(self)
        scenario = self._inputs.scenario(self.plain).replace(noise_versions=[0.0] * self.noise_blocks)
        other.experiment = Experiment(scenario, vary=[*self._inputs.paths, "noise_versions"], measure=self._measures)
        return other

    def fly(self, values: Array, first: int, threads: int | None, progress: Progress | None = None) -> Outcome:
        """Runs first, first + 1, ..., one a row of values."""
        if len(values) == 0:
            return self._outcome(_none(self.experiment), first)
        if not self.plain.python_components():
            return self._outcome(self._flown(values, first, threads, progress), first)
        flown = []
        for i in range(len(values)):  # one alone: what a Python component raises is a row, and the others go on
            flown.append(self._careful(values[i : i + 1], first + i))
            if progress is not None:
                progress((i + 1) / len(values))
        return self._outcome(_joined(flown, first), first)

    def scenario(self, values: Array, run: int) -> Scenario:
        """The scenario of one run without what does not happen in it."""
        tables = with_objects(self.experiment.scenario(values, run).tables(), self.plain.python_components())
        faults = [fault for fault in tables.get("faults", []) if not never(fault)]
        return Scenario.from_dict({**tables, "faults": faults})

    def _flown(self, values: Array, first: int, threads: int | None, progress: Progress | None) -> Flights:
        if values.shape[1] == 0:
            return self.experiment.fly(runs=len(values), first=first, threads=threads, progress=progress)
        return self.experiment.fly(values, first=first, threads=threads, progress=progress)

    def _careful(self, values: Array, run: int) -> Flights:
        try:
            return self._flown(values, run, 1, None)
        except Exception as error:  # whatever a Python component raises
            empty = _none(self.experiment)
            return replace(
                empty,
                number=np.array([run]),
                values=values,
                status=np.array([RAISED]),
                end_time=np.zeros(1),
                held_fraction=np.zeros(1),
                metrics={name: np.full(1, np.nan) for name in self.experiment.metrics},
                causes={run: one_line(f"{type(error).__name__}: {error}")},
            )

    def _outcome(self, flights: Flights, first: int) -> Outcome:
        completed = flights.completed
        measures = {name: np.ascontiguousarray(x) for name, x in flights.metrics.items()}
        return Outcome(
            measures=measures,
            success=self.judge.successes(completed, measures),
            margin=self.judge.margins(completed, measures, flights.end_time, first),
            status=flights.status,
            cause=[flights.causes.get(int(number)) for number in flights.number],
            t_end=flights.end_time,
        )


def _none(experiment: Experiment) -> Flights:
    empty = np.empty(0)
    names, columns = experiment.metrics, experiment.columns
    return Flights(
        number=np.empty(0, dtype=np.int64),
        values=np.empty((0, len(columns))),
        status=np.empty(0, dtype=np.str_),
        end_time=empty,
        held_fraction=empty,
        metrics=dict.fromkeys(names, empty),
        causes={},
        columns=columns,
    )


def _joined(parts: list[Flights], first: int) -> Flights:
    return Flights(
        number=np.arange(first, first + len(parts)),
        values=np.concatenate([p.values for p in parts]),
        status=np.concatenate([p.status for p in parts]),
        end_time=np.concatenate([p.end_time for p in parts]),
        held_fraction=np.concatenate([p.held_fraction for p in parts]),
        metrics={name: np.concatenate([p.metrics[name] for p in parts]) for name in parts[0].metrics},
        causes={number: cause for p in parts for number, cause in p.causes.items()},
        columns=parts[0].columns,
    )


def unknown_cell(label: str, known: Iterable[str]) -> InputError:
    """The error for a cell that is not there."""
    labels = list(known)
    return InputError(f"no cell '{label}'" + ("; there is no grid" if labels == [""] else suggestion(label, labels)))


class Cells:
    """All cells of a campaign; the first level of every factor comes first."""

    def __init__(self, spec: Spec, base: Scenario, inputs: Inputs) -> None:
        self._spec, self._base, self._inputs = spec, base, inputs
        self.changes: dict[str, Mapping[str, Any]] = {}
        for levels in product(*[grid.levels.items() for grid in spec.grid]):
            changes = {key: value for _, level in levels for key, value in level.items()}
            self.changes["/".join(name for name, _ in levels)] = changes

    @property
    def labels(self) -> list[str]:
        """Levels joined by ``/``; one empty label where there is no grid."""
        return list(self.changes)

    @cached_property
    def all(self) -> dict[str, Cell]:
        """Ready to fly, by label; mistakes of the file show here."""
        made = {}
        for label, changes in self.changes.items():
            with input_errors(f"cell '{label}'" if label else ""):
                scenario = self._base.replace(**changes) if changes else self._base
            made[label] = Cell(label, scenario, self._inputs, self._spec)
        return made


__all__ = ["RAISED", "Cell", "Cells", "Draws", "Outcome", "unknown_cell"]
