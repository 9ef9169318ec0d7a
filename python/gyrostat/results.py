# SPDX-License-Identifier: MIT
"""What a run leaves: channels by name, dated events, how it ended, and its metrics."""

from __future__ import annotations

import json
import zipfile
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from gyrostat.errors import InputError, suggestion
from gyrostat.files import replacing
from gyrostat.metrics import Metrics

if TYPE_CHECKING:
    import xarray

    from gyrostat.plots import Figure
    from gyrostat.scenario import Scenario

Array = NDArray[np.float64]

_groups = ("truth", "allocation", "estimate", "error", "detection", "reference", "demand", "measurement")
"""Where a short name is looked for, in this order; then in observer, controller, ..."""


@dataclass(frozen=True)
class Event:
    """A counter that moved: which, when, and its value from then on."""

    t: float
    name: str
    count: int


@dataclass(frozen=True, eq=False)
class Result:
    """A finished run. ``result["omega_BN_B"]`` is a read-only array, time first; ``result.t`` its instants.

    A short name finds the truth first, then allocation, estimate, error and the other groups; a full name
    (``estimate.omega_BN_B``) is never ambiguous.
    """

    scenario: Scenario | dict[str, Any]
    """What was flown (a dictionary when a loaded run held a Python component)."""
    t: Array
    """Instants, s, shape (n,)."""
    channels: Mapping[str, Array]
    """Every recorded channel by its full name."""
    events: tuple[Event, ...] = ()
    """Arms, breaches, switches, ... with their times."""
    status: str = "completed"
    """``completed``, ``singular``, ``non_finite`` or ``integration_failed``."""
    cause: str = ""
    """Why it ended early, with the time; "" when it did not."""
    end_time: float = 0.0
    """Last instant reached, s."""
    statistics: Mapping[str, Any] = field(default_factory=dict)
    """Work of the integrator: steps, evaluations, restarts of CVODE, and smooth pieces of time."""
    meta: Mapping[str, Mapping[str, Any]] = field(default_factory=dict)
    """Unit and meaning of each channel."""

    @classmethod
    def from_core(cls, scenario: Scenario, raw: Mapping[str, Any]) -> Result:
        """From what the compiled loop returns."""
        recorded = raw["channels"]
        meta = {c["name"]: c for c in scenario.channel_names() if c["name"] in recorded}
        events = tuple(Event(e["t"], e["name"], e["count"]) for e in raw["events"])
        ending = {key: raw[key] for key in ("status", "cause", "end_time", "statistics")}
        return cls(scenario, raw["t"], recorded, events, meta=meta, **ending)

    def __getitem__(self, name: str) -> Array:
        return self.channels[self.full_name(name)]

    def __contains__(self, name: object) -> bool:
        try:
            self.full_name(str(name))
        except KeyError:
            return False
        return True

    def __iter__(self) -> Iterator[str]:
        return iter(self.channels)

    def __len__(self) -> int:
        return len(self.t)

    def __repr__(self) -> str:
        ended = "" if self.completed else f", {self.cause or self.status}"
        return f"<Result: {len(self)} samples to {self.end_time:g} s, {len(self.channels)} channels{ended}>"

    @property
    def completed(self) -> bool:
        """Whether the run reached its duration."""
        return self.status == "completed"

    def full_name(self, name: str) -> str:
        """The channel that a short name means.

        Raises
        ------
        KeyError
            Nothing of that name was recorded; the message lists near names.
        """
        if name in self.channels:
            return name
        found = [full for full in self.channels if full.partition(".")[2] == name]
        if not found:
            short = {full.partition(".")[2] for full in self.channels}
            raise KeyError(f"no channel '{name}' was recorded{suggestion(name, short | set(self.channels))}")
        return min(found, key=lambda full: _rank(full.partition(".")[0]))

    def unit(self, name: str) -> str:
        """Unit of a channel, "" when it has none."""
        return str(self.meta.get(self.full_name(name), {}).get("unit", ""))

    @cached_property
    def description(self) -> dict[str, Any]:
        """The scenario as plain tables."""
        tables = self.scenario if isinstance(self.scenario, dict) else self.scenario.to_dict()
        return {k: v if _is_plain(v) else {"type": "python", "class": type(v).__name__} for k, v in tables.items()}

    @cached_property
    def metrics(self) -> Metrics:
        """Settling time, pointing error, energy, ... of this run."""
        return Metrics(self)

    def to_xarray(self) -> xarray.Dataset:
        """A labelled data set: dimension ``t`` and one a channel with several columns; units as attributes."""
        import xarray

        variables = {
            name: (("t",) if x.ndim == 1 else ("t", f"{name}_i"), x, dict(_labels(self.meta.get(name, {}))))
            for name, x in self.channels.items()
        }
        attributes = {"status": self.status, "cause": self.cause, "scenario": json.dumps(self.description)}
        return xarray.Dataset(variables, coords={"t": ("t", self.t, {"unit": "s"})}, attrs=attributes)

    def save(self, path: str | Path) -> Path:
        """Write everything to one ``.npz`` file, readable with plain numpy too.

        Returns
        -------
        Path
            The file, with the ending ``.npz``.
        """
        target = Path(path).with_suffix(".npz")
        facts = {
            "scenario": self.description,
            "events": [vars(e) for e in self.events],
            "status": self.status,
            "cause": self.cause,
            "end_time": self.end_time,
            "statistics": dict(self.statistics),
            "meta": {k: dict(v) for k, v in self.meta.items()},
        }
        with replacing(target) as temporary:
            np.savez_compressed(temporary, t=self.t, facts=np.array(json.dumps(facts)), **self.channels)  # type: ignore[arg-type]
        return target

    @classmethod
    def load(cls, path: str | Path) -> Result:
        """Read what `save` wrote.

        Raises
        ------
        InputError
            The file is not there or is not a saved result.
        """
        from gyrostat.scenario import Scenario

        try:
            with np.load(path, allow_pickle=False) as data:
                arrays = {name: data[name] for name in data.files}
            facts = json.loads(str(arrays.pop("facts")))
            t = arrays.pop("t")
        except OSError as error:
            raise InputError(f"{path}: cannot be read: {(error.strerror or str(error)).lower()}") from None
        except (KeyError, ValueError, zipfile.BadZipFile):
            raise InputError(f"{path}: is not a saved result") from None
        for array in arrays.values():
            array.flags.writeable = False
        events = tuple(Event(**e) for e in facts.pop("events"))
        tables = facts.pop("scenario")
        flew_python = any(isinstance(v, dict) and v.get("type") == "python" for v in tables.values())
        scenario: Scenario | dict[str, Any] = tables if flew_python else Scenario.from_dict(tables)
        return cls(scenario, t, arrays, events, **facts)

    def plot(self) -> Figure:
        """An overview: pointing error, rate, commands and effectiveness, with the faults marked."""
        from gyrostat import plots

        return plots.overview(self)


def _rank(group: str) -> tuple[int, str]:
    return (_groups.index(group) if group in _groups else len(_groups), group)


def _is_plain(value: Any) -> bool:
    return isinstance(value, bool | int | float | str | list | dict)


def _labels(meta: Mapping[str, Any]) -> Iterator[tuple[str, str]]:
    for key in ("unit", "meaning"):
        if meta.get(key):
            yield key, str(meta[key])
