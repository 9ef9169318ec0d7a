# SPDX-License-Identifier: MIT
"""One scenario flown many times with other numbers in it: initial states, faults, the true vehicle, gains, seeds.

The scenario is read once; flights run in C++ on all cores, without Python's global lock, and keep metrics alone, so
that ten thousand flights take the memory of one. A flight is a function of the scenario, its number and its values:
flown in any order, on any thread or alone (`Experiment.scenario`), it gives the same bits. Page: docs/experiments.md
"""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from gyrostat import _core
from gyrostat.errors import InputError, input_errors
from gyrostat.metrics import DEFAULT_BAND
from gyrostat.scenario import Scenario, copies, with_objects
from gyrostat.text import shown

Measures = Mapping[str, Mapping[str, Any]]


def usual_measures(duration: float) -> dict[str, dict[str, Any]]:
    """The metrics of a result (`gyrostat.metrics.Metrics`), as an experiment measures them.

    Parameters
    ----------
    duration
        Of a flight, s.
    """
    error, command = {"signal": "error.angle"}, {"signal": "allocation.u"}
    return {
        "settling_time": {"metric": "settling_time", **error, "band": DEFAULT_BAND, "after": "last_fault"},
        "pointing_error": {"metric": "window_rms", **error, "t0": 0.9 * duration},
        "final_error": {"metric": "final", **error},
        "peak_error_after_fault": {"metric": "window_max", **error, "t0": "last_fault"},
        "energy": {"metric": "energy", **command},
        "command_variation": {"metric": "total_variation", **command},
        "saturated_fraction": {"metric": "fraction_at_least", "signal": "allocation.saturated", "level": 1.0},
    }


@dataclass(frozen=True)
class Flights:
    """What became of the flights of an experiment, one row a flight.

    Attributes
    ----------
    number
        Of each flight, shape (n,).
    values
        What each flew with, shape (n, columns).
    status
        How each ended, shape (n,): ``completed``, another ending of a `Result`, or ``refused`` for values that fit no
        vehicle, which did not fly.
    end_time
        Last instant that each reached, s, shape (n,).
    held_fraction
        Share of samples at which the guard replaced an input or a command, shape (n,).
    metrics
        By name, shape (n,) each; nan where there is no value. Of a flight that ended early: up to there.
    causes
        Why flights ended early, by their number.
    columns
        Names of the columns of `values`.
    """

    number: NDArray[np.int64]
    values: NDArray[np.float64]
    status: NDArray[np.str_]
    end_time: NDArray[np.float64]
    held_fraction: NDArray[np.float64]
    metrics: dict[str, NDArray[np.float64]]
    causes: dict[int, str]
    columns: tuple[str, ...]

    def __len__(self) -> int:
        return len(self.number)

    def __getitem__(self, metric: str) -> NDArray[np.float64]:
        """A metric by its name."""
        return self.metrics[metric]

    @property
    def completed(self) -> NDArray[np.bool_]:
        """Which flights reached their duration, shape (n,)."""
        return np.asarray(self.status == "completed")

    def to_dataframe(self) -> Any:
        """A pandas table, one row a flight: number, values, status, end time, metrics."""
        import pandas as pd

        table: dict[str, Any] = {"number": self.number}
        table |= {name: self.values[:, i] for i, name in enumerate(self.columns)}
        table |= {"status": self.status, "end_time": self.end_time, "held_fraction": self.held_fraction}
        return pd.DataFrame(table | self.metrics)

    def __repr__(self) -> str:
        good = int(self.completed.sum())
        return f"Flights({len(self)} flights, {good} completed, metrics: {', '.join(self.metrics)})"


class Experiment:
    """A scenario, the numbers in it that differ from flight to flight, and what is measured.

    Parameters
    ----------
    scenario
        What is flown.
    vary
        Dotted paths as in `Scenario.replace`: ``"initial.omega_BN_B.1"``, ``"faults.0.remaining"``,
        ``"truth.dJ_B.0.0"``, ``"observer.kappa"``, ``"seed"``. A path that names a vector or a matrix stands for all
        its elements; a value an actuator that is written as one number, or not at all, for one number. Types of
        components and the number of faults are the same in all flights; a fault that may or may not happen has an
        infinite onset where it does not.
    measure
        Metrics by name: ``{"settling": {"metric": "settling_time", "signal": "error.angle", "band": 1e-3}}``, with the
        arguments of `gyrostat.metrics`; ``column = 2`` takes a component of the signal, ``"last_fault"`` stands for the
        onset of the last fault, ``last = 5.0`` for a window of the last 5 s. The usual ones of a result if absent.

    Raises
    ------
    InputError
        One line: a path that is no number of the scenario (with the nearest name), an unknown metric, signal or
        argument, or a scenario that does not run.

    Examples
    --------
    >>> import gyrostat as gs
    >>> experiment = gs.Experiment(
    ...     gs.Scenario.load("wheel2_degraded").replace(duration=20.0),
    ...     vary=["faults.0.remaining", "initial.omega_BN_B"],
    ... )
    >>> experiment.columns
    ('faults.0.remaining', 'initial.omega_BN_B.0', 'initial.omega_BN_B.1', 'initial.omega_BN_B.2')
    >>> flights = experiment.fly([[0.4, 0.0, 0.0, 0.0], [0.1, 0.01, 0.0, 0.0]])
    >>> flights["final_error"].shape
    (2,)
    """

    def __init__(self, scenario: Scenario, *, vary: Sequence[str] = (), measure: Measures | None = None) -> None:
        base: Any = scenario
        paths: Any = vary
        if not isinstance(base, Scenario):
            raise InputError(f"{shown(base)} is a {type(base).__name__}; a Scenario belongs here")
        if isinstance(paths, str) or not all(isinstance(path, str) for path in paths):
            raise InputError(f"vary: {shown(paths)} is no list of paths; write ['initial.mrp']")
        components = scenario.python_components()
        measures: Any = usual_measures(scenario.duration) if measure is None else measure
        if not isinstance(measures, Mapping):
            raise InputError(f"measure: {shown(measures)} is no table of metrics by name")
        tables = {str(name): dict(m) if isinstance(m, Mapping) else m for name, m in measures.items()}
        self._fresh = (lambda: copies(components)) if components else None
        with input_errors():
            self._core = _core.Experiment(scenario.tables(), list(vary), tables, self._fresh)
        self._base = scenario

    @property
    def columns(self) -> tuple[str, ...]:
        """One name a number that differs."""
        return tuple(self._core.columns)

    @property
    def metrics(self) -> tuple[str, ...]:
        """Names of what is measured."""
        return tuple(self._core.metrics)

    def fly(
        self,
        values: ArrayLike | None = None,
        *,
        runs: int | None = None,
        first: int = 0,
        threads: int | None = None,
        progress: Callable[[float], None] | None = None,
    ) -> Flights:
        """Fly one flight a row of values. The results do not depend on the number of threads.

        Parameters
        ----------
        values
            Shape (n, columns), or (n,) where one number differs. Absent where none does: then `runs` flights differ in
            their noise alone.
        runs
            Number of flights, where there are no values.
        first
            Number of the first flight; it keys the noise.
        threads
            As many as there are cores if absent. Python components fly on one.
        progress
            Called now and then with the finished fraction, 0 to 1. What it raises ends the flights.

        Returns
        -------
        Flights

        Raises
        ------
        InputError
            Values of another shape.
        """
        rows = self._rows(values, runs)
        _whole("first", first, least=0)
        _whole("threads", 1 if threads is None else threads, least=1)
        if progress is not None and not callable(progress):
            raise InputError(f"progress: {shown(progress)} cannot be called")
        count = int(threads or os.cpu_count() or 1)
        flown = self._core.fly(int(first), rows, count, progress)
        return Flights(
            number=np.arange(first, first + len(rows)),
            values=rows,
            status=np.array(flown["status"], dtype=np.str_),
            end_time=flown["end_time"],
            held_fraction=flown["held_fraction"],
            metrics={name: flown["metrics"][:, i] for i, name in enumerate(self.metrics)},
            causes=dict(flown["causes"]),
            columns=self.columns,
        )

    def scenario(self, values: ArrayLike = (), number: int = 0) -> Scenario:
        """The scenario that one flight is: `Scenario.run` of it flies the same bits, with a record.

        Parameters
        ----------
        values
            What the flight flew with, shape (columns,).
        number
            Of the flight.

        Raises
        ------
        InputError
            Values that fit no vehicle.
        """
        with input_errors():
            tables = self._core.scenario(number, np.asarray(values, dtype=float))
        return Scenario.from_dict(with_objects(tables, self._base.python_components()))

    def _rows(self, values: ArrayLike | None, runs: int | None) -> NDArray[np.float64]:
        width = len(self.columns)
        if values is None:
            if width > 0:
                raise InputError(f"values are missing: {width} a flight ({', '.join(self.columns)})")
            if runs is None:
                raise InputError("runs is missing: how many flights?")
            _whole("runs", runs, least=1)
            return np.empty((runs, 0))
        try:
            rows = np.array(values, dtype=float)
        except (TypeError, ValueError):
            raise InputError(f"values: {shown(values)} are no rows of {width} numbers") from None
        if rows.ndim == 1 and width == 1:
            rows = rows[:, None]
        if rows.ndim != 2 or rows.shape[1] != width:
            raise InputError(
                f"values of shape {rows.shape}; (flights, {width}) belongs here: {', '.join(self.columns)}"
            )
        if runs is not None and runs != len(rows):
            raise InputError(f"runs = {shown(runs)}, and {len(rows)} rows of values")
        return rows


def _whole(name: str, number: Any, *, least: int) -> None:
    if isinstance(number, bool) or not isinstance(number, int | np.integer) or not least <= number < 2**31:
        raise InputError(f"{name} = {shown(number)}: a whole number from {least} on belongs here")


__all__ = ["Experiment", "Flights", "usual_measures"]
