# SPDX-License-Identifier: MIT
"""How a claim measures: a small table of metric functions, called with a result and the arguments of the claim.

Every metric takes the result and keyword arguments. One that asks for ``signal`` gets the named signal as an array, one
that asks for ``against`` the result of another case.
"""

from __future__ import annotations

import inspect
import math
from collections.abc import Callable, Container, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gyrostat import metrics
from gyrostat.errors import InputError, suggestion
from gyrostat.results import Result

Array = NDArray[np.float64]
Metric = Callable[..., float]
Window = tuple[float, float] | list[float]

_whole = (-math.inf, math.inf)
_common = {"metric", "signal", "column", "against"}


def settling_time(result: Result, *, signal: Array, band: float, after: float = 0.0) -> float:
    """Time from `after` until the signal stays below `band` to the end, s. Not measured when it never does."""
    _reaches(result, result.t[0], _planned_end(result))
    return metrics.settling_time(result.t, signal, band, after)


def _of_window(metric: Callable[..., float]) -> Metric:
    def measured(result: Result, *, signal: Array, window: Window = _whole) -> float:
        return metric(result.t, signal, *_reaches(result, *window))

    measured.__name__, measured.__doc__ = metric.__name__, metric.__doc__
    return measured


def final(result: Result, *, signal: Array) -> float:
    """Largest ``|signal|`` at the last instant."""
    _reaches(result, result.t[0], _planned_end(result))
    return metrics.final(result.t, signal)


def at(result: Result, *, signal: Array, time: float) -> float:
    """Value (signed) of a column at a sample, s."""
    _reaches(result, time, time)
    return float(signal[int(np.argmin(np.abs(result.t - time)))])


def fraction_at_least(result: Result, *, signal: Array, level: float, window: Window = _whole) -> float:
    """Fraction of the samples of a window in which ``|signal|`` reaches a level: time at a limit, breaches."""
    return metrics.fraction_at_least(result.t, signal, level, *_reaches(result, *window))


def energy(result: Result, *, signal: Array) -> float:
    """Integral of the squared signal."""
    return metrics.energy(result.t, signal)


def recovery(result: Result, *, signal: Array, band: float, after: float, until: float = math.inf) -> float:
    """Time from a fault until the signal stays below `band`, as far as `until`, s. Not measured when it never does.

    The sample at the fault is before it.
    """
    return metrics.recovery(result.t, signal, band, *_reaches(result, after, until))


def first_reach(result: Result, *, signal: Array, level: float, after: float = 0.0) -> float:
    """First instant, s, at which ``|signal|`` reaches a level. Not measured when it never does."""
    return metrics.first_reach(result.t, signal, level, after)


def ratio(result: Result, *, signal: Array, against: Result, other: Array, window: Window = _whole) -> float:
    """Largest ``|signal|`` in a window of time over that of another case."""
    of_other = metrics.window_max(against.t, other, *_reaches(against, *window))
    return metrics.window_max(result.t, signal, *_reaches(result, *window)) / of_other


def difference(result: Result, *, signal: Array, against: Result, other: Array, window: Window = _whole) -> float:
    """Largest ``|signal - signal of another case|`` in a window of time; both cases must share their instants."""
    if not np.array_equal(result.t, against.t):
        raise ValueError("the two cases have different instants")
    return metrics.window_max(result.t, signal - other, *_reaches(result, *window))


def completed(result: Result) -> float:
    """1 when the run reached its duration, else 0."""
    return float(result.completed)


def end_time(result: Result) -> float:
    """Last instant reached, s."""
    return result.end_time


def events(result: Result, *, name: str) -> float:
    """How often a counter moved."""
    return float(sum(event.name == name for event in result.events))


_of_windows = (
    metrics.window_max,
    metrics.window_norm,
    metrics.window_lowest,
    metrics.window_highest,
    metrics.window_rms,
    metrics.total_variation,
)
_of_runs = (settling_time, recovery, final, at, fraction_at_least, energy, first_reach, completed, end_time, events)
_all: tuple[Metric, ...] = (*map(_of_window, _of_windows), *_of_runs, ratio, difference)

METRICS: dict[str, Metric] = {metric.__name__: metric for metric in _all}


@dataclass(frozen=True)
class Measure:
    """A metric with its arguments, ready to be called with a result."""

    metric: Metric
    arguments: dict[str, Any]
    signals: Mapping[str, Callable[[Result], Array]]
    signal: str | None = None
    column: int | None = None
    others: tuple[str, ...] = field(default=())

    @classmethod
    def of(
        cls,
        table: Mapping[str, Any],
        known: Mapping[str, Metric],
        signals: Mapping[str, Callable[[Result], Array]],
        cases: Container[str],
    ) -> Measure:
        """From the ``measure`` table of a claim; names and arguments are checked now, not after an hour of running."""
        arguments = dict(table)
        name = str(arguments.pop("metric", ""))
        if name not in known:
            raise InputError(f"unknown metric '{name}'{suggestion(name, known)}")
        signal, column = arguments.pop("signal", None), arguments.pop("column", None)
        against = arguments.pop("against", None)
        if against is not None and against not in cases:
            raise InputError(f"no case '{against}' to compare with")
        takes = set(inspect.signature(known[name]).parameters) - {"result", "signal", "against", "other"}
        for key in set(arguments) - takes:
            raise InputError(f"metric '{name}' has no argument '{key}'{suggestion(key, takes | _common)}")
        given = dict(arguments)
        given |= {"signal": 0} if signal is not None else {}
        given |= {"against": 0, "other": 0} if against is not None else {}
        try:
            inspect.signature(known[name]).bind(None, **given)
        except TypeError as error:
            raise InputError(f"metric '{name}': {error}") from None
        others = () if against is None else (str(against),)
        return cls(known[name], arguments, signals, signal, column, others)

    def __call__(self, result: Any, results: Mapping[str, Result]) -> float:
        """The measured number of a result (or an ensemble); `results` holds the other cases that it compares with."""
        given: dict[str, Any] = dict(self.arguments)
        if self.signal is not None:
            given["signal"] = self._signal(result)
        for other in self.others:
            given |= {"against": results[other], "other": self._signal(results[other])}
        return float(self.metric(result, **given))

    def _signal(self, result: Any) -> Array:
        assert self.signal is not None
        x: Array = self.signals[self.signal](result) if self.signal in self.signals else result[self.signal]
        return x if self.column is None else x[:, self.column]


def _planned_end(result: Result) -> float:
    return float(result.description["duration"])


def _reaches(result: Result, t0: float, t1: float) -> tuple[float, float]:
    """The window, cut to the run; a run that ended before it is an error, not a small number."""
    start, end = max(t0, float(result.t[0])), min(t1, _planned_end(result))
    if result.end_time < end - 1e-9:
        raise ValueError(f"the run ended at {result.end_time:g} s: {result.cause or result.status}")
    return start, end
