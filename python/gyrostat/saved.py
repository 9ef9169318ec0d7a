# SPDX-License-Identifier: MIT
"""What a saved result says beside its arrays, and what must fit before it is believed."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Annotated, Any, Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from gyrostat.errors import InputError, input_errors
from gyrostat.model import Model
from gyrostat.scenario import Scenario

if TYPE_CHECKING:
    from gyrostat.results import Result

_Time = Annotated[float, Field(ge=0.0, allow_inf_nan=False)]


class SavedEvent(Model):
    """A counter that moved."""

    t: _Time
    name: str
    count: int


class Facts(Model):
    """All that `Result.save` writes of a result but its arrays."""

    scenario: dict[str, Any]
    events: list[SavedEvent]
    status: Literal["completed", "singular", "non_finite", "integration_failed"]
    cause: str
    end_time: _Time
    statistics: dict[str, int | float]
    meta: dict[str, dict[str, str | int]]

    @classmethod
    def of(cls, result: Result) -> Facts:
        """Of a result that is to be saved."""
        return cls(
            scenario=result.description,
            events=[SavedEvent(**vars(e)) for e in result.events],
            status=result.status,  # type: ignore[arg-type]
            cause=result.cause,
            end_time=result.end_time,
            statistics=dict(result.statistics),
            meta={name: dict(meta) for name, meta in result.meta.items()},
        )

    def flown(self) -> Scenario | dict[str, Any]:
        """The scenario; its tables as they are when a Python component flew."""
        with input_errors("scenario"):
            catalogued = {k: v for k, v in self.scenario.items() if not _is_python(v)}
            scenario = Scenario.from_dict(catalogued)
        return scenario if len(catalogued) == len(self.scenario) else self.scenario

    def hold_against(self, t: NDArray[np.float64], channels: Mapping[str, NDArray[np.float64]]) -> None:
        """Compare with the arrays.

        Raises
        ------
        InputError
            Something that no run leaves: lengths that differ, instants that do not increase, an end at another time.
        """
        if t.dtype != np.float64 or t.ndim != 1 or len(t) == 0 or not np.isfinite(t).all() or np.any(np.diff(t) <= 0.0):
            raise InputError("t does not increase from instant to instant")
        for name, x in channels.items():
            if x.dtype != np.float64 or x.ndim not in (1, 2) or len(x) != len(t):
                raise InputError(f"{name} has shape {x.shape} of {x.dtype}; {len(t)} rows of float64 belong there")
        duration, dt = self._number("duration"), self._number("dt")
        completed = self.status == "completed"
        after = t[-1] - self.end_time  # the last sample of a run that ended early need not be among the recorded ones
        if t[0] < 0.0 or after > 0.5 * dt or (completed and after < -0.5 * dt):
            raise InputError(f"t goes from {t[0]:g} s to {t[-1]:g} s, and the run ended at {self.end_time:g} s")
        if completed and abs(self.end_time - duration) > 0.5 * dt:
            raise InputError(f"status is completed, and the run ended at {self.end_time:g} s of {duration:g} s")
        for name, meta in self.meta.items():
            if name in channels and meta.get("size", 1) != channels[name][0].size:
                raise InputError(f"{name} has {channels[name][0].size} columns instead of {meta.get('size', 1)}")

    def _number(self, key: str) -> float:
        value = self.scenario.get(key)
        if isinstance(value, bool) or not isinstance(value, int | float):
            raise InputError(f"scenario: {key} is missing")
        return float(value)


def _is_python(value: Any) -> bool:
    return isinstance(value, dict) and value.get("type") == "python"


__all__ = ["Facts", "SavedEvent"]
