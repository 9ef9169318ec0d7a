# SPDX-License-Identifier: MIT
"""What a saved result says beside its arrays, and what must fit before it is believed."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Annotated, Any

import numpy as np
from numpy.typing import NDArray
from pydantic import AfterValidator, Field

from gyrostat import _core
from gyrostat.errors import InputError, input_errors
from gyrostat.model import Model
from gyrostat.scenario import Scenario

if TYPE_CHECKING:
    from gyrostat.results import Result


def _ending(status: str) -> str:
    if status not in _core.endings():
        raise InputError(f"'{status}' is no ending of a run; there are: {', '.join(_core.endings())}")
    return status


_Time = Annotated[float, Field(ge=0.0, allow_inf_nan=False)]


class SavedEvent(Model):
    """A counter that moved."""

    t: _Time
    name: str
    count: int
    what: str = ""


class Facts(Model):
    """All that `Result.save` writes of a result but its arrays."""

    scenario: dict[str, Any]
    events: list[SavedEvent]
    status: Annotated[str, AfterValidator(_ending)]
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
            status=result.status,
            cause=result.cause,
            end_time=result.end_time,
            statistics=dict(result.statistics),
            meta={name: dict(meta) for name, meta in result.meta.items()},
        )

    def catalogued(self) -> Scenario:
        """The scenario, without the Python components that flew."""
        with input_errors("scenario"):
            return Scenario.from_dict(_catalogued(self.scenario))

    def flown(self) -> Scenario | dict[str, Any]:
        """The scenario; its tables as they are when a Python component flew."""
        return self.catalogued() if _catalogued(self.scenario) == self.scenario else self.scenario

    def hold_against(self, t: NDArray[np.float64], channels: Mapping[str, NDArray[np.float64]]) -> None:
        """Compare with the arrays.

        Raises
        ------
        InputError
            Something that no run leaves: lengths that differ, instants that do not increase, an end at another time.
        """
        if t.dtype != np.float64 or t.ndim != 1 or len(t) == 0 or not np.isfinite(t).all() or np.any(np.diff(t) <= 0.0):
            raise InputError("t does not increase from instant to instant")
        scenario = self.catalogued()
        sizes = {c["name"]: c["size"] for c in scenario.channel_names()}
        for name, x in channels.items():
            size = sizes.get(name, x.shape[1] if x.ndim > 1 else 1)
            shape = (len(t),) if size == 1 else (len(t), size)
            if x.dtype != np.float64 or x.shape != shape:
                raise InputError(f"{name} has shape {x.shape} of {x.dtype}; {shape} of float64 belongs there")
        completed = self.status == "completed"
        late = t[-1] - self.end_time  # the last sample of a run that ended early need not be among the recorded ones
        if t[0] < 0.0 or late > 0.5 * scenario.dt or (completed and late < -0.5 * scenario.dt):
            raise InputError(f"t goes from {t[0]:g} s to {t[-1]:g} s, and the run ended at {self.end_time:g} s")
        if completed and abs(self.end_time - scenario.duration) > 0.5 * scenario.dt:
            raise InputError(
                f"status is completed, and the run ended at {self.end_time:g} s of {scenario.duration:g} s"
            )


def _catalogued(tables: Mapping[str, Any]) -> dict[str, Any]:
    """Without what Python components were; those that are drives have a table of their own."""
    return {
        k: [entry for entry in v if not _is_python(entry)] if isinstance(v, list) else v
        for k, v in tables.items()
        if k != "drives" and not _is_python(v)
    }


def _is_python(value: Any) -> bool:
    return isinstance(value, dict) and value.get("type") == "python"


__all__ = ["Facts", "SavedEvent"]
