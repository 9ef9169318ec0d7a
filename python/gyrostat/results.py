# SPDX-License-Identifier: MIT
"""What a run leaves: channels by name, dated events, how it ended, and its metrics."""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import IO, TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from gyrostat.errors import InputError, suggestion
from gyrostat.files import file_errors, replacing
from gyrostat.metrics import Metrics

if TYPE_CHECKING:
    import pandas as pd
    import xarray

    from gyrostat.plots import Figure
    from gyrostat.scenario import Scenario

Array = NDArray[np.float64]

_groups = ("truth", "allocation", "estimate", "error", "detection", "reference", "demand", "measurement")
"""Where a short name is looked for, in this order; then in observer, controller, ..."""


@dataclass(frozen=True)
class Event:
    """A counter that moved: which, when, and its value from then on.

    Of what the guard did (``guard.rate``, ``guard.controller``, ...) there is one event: the first time, and at how
    many samples in all.
    """

    t: float
    name: str
    count: int
    what: str = ""
    """Of detection: the actuators and their classes of fault, "actuator 2 stuck"; of anything else nothing."""


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
    """``completed``, ``singular``, ``non_finite``, ``integration_failed``, or ``no_command``: the duration was reached,
    but the stack never issued a command of its own."""
    cause: str = ""
    """Why it is not ``completed``; "" when it is."""
    end_time: float = 0.0
    """Last instant reached, s."""
    statistics: Mapping[str, Any] = field(default_factory=dict)
    """Work of the integrator: steps, evaluations, restarts of CVODE, smooth pieces of time; samples flown, and those at
    which the guard held something."""
    meta: Mapping[str, Mapping[str, Any]] = field(default_factory=dict)
    """Unit, meaning and dimension of each channel."""
    components: Mapping[str, Any] = field(default_factory=dict)
    """The Python components that flew, by role, as the run left them: copies of the scenario's. Not saved."""

    @classmethod
    def from_core(cls, scenario: Scenario, raw: Mapping[str, Any], components: Mapping[str, Any]) -> Result:
        """From what the compiled loop returns, and the Python components that it flew."""
        meta = {c["name"]: c for c in raw["meta"]}
        events = tuple(Event(e["t"], e["name"], e["count"], e["what"]) for e in raw["events"])
        ending = {key: raw[key] for key in ("status", "cause", "end_time", "statistics")}
        return cls(scenario, raw["t"], raw["channels"], events, meta=meta, components=components, **ending)

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

    def _repr_html_(self) -> str:
        from gyrostat import notebook

        return notebook.result(self)

    def _ipython_key_completions_(self) -> list[str]:
        """Full names, and the short ones that are in use."""
        return [*self.channels, *sorted({full.partition(".")[2] for full in self.channels})]

    @property
    def completed(self) -> bool:
        """Whether the run reached its duration, and the stack flew."""
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
        return {k: _described(v) for k, v in tables.items()}

    @property
    def known_faults(self) -> list[dict[str, Any]]:
        """Tables of the faults that flew and are of the catalogue."""
        return [fault for fault in self.description.get("faults", []) if fault.get("type") != "python"]

    @cached_property
    def metrics(self) -> Metrics:
        """Settling time, pointing error, energy, ... of this run."""
        return Metrics(self)

    def to_xarray(self) -> xarray.Dataset:
        """A labelled data set, so that channels can be put together: units and meanings are attributes.

        Dimensions are ``time`` (s) and, shared by all channels, ``axis`` (x, y, z), ``quaternion`` (w, x, y, z) and
        ``actuator`` (counted from 0). Columns that are none of these have a dimension of their own, ``<channel>_i``.
        """
        import xarray

        from gyrostat.columns import labels

        coordinates: dict[str, Any] = {"time": ("time", self.t, {"unit": "s"})}
        variables = {}
        for name, x in self.channels.items():
            meta = self.meta.get(name, {})
            dimensions = ["time"]
            if x.ndim > 1:
                named = labels(str(meta.get("dimension", "")), x.shape[1])
                dimensions.append(str(meta["dimension"]) if named else f"{name}_i")
                if named:
                    coordinates[dimensions[-1]] = named
            variables[name] = (dimensions, x, {key: meta[key] for key in ("unit", "meaning") if meta.get(key)})
        attributes = {"status": self.status, "cause": self.cause, "scenario": json.dumps(self.description)}
        return xarray.Dataset(variables, coords=coordinates, attrs=attributes)

    def save(self, path: str | Path) -> Path:
        """Write everything to one ``.npz`` file, readable with plain numpy too.

        Returns
        -------
        Path
            The file; a name without ending gets ``.npz``.

        Raises
        ------
        InputError
            Another ending, or a file that cannot be written. What was there before is still there then.
        """
        from gyrostat.saved import Facts

        target = Path(path)
        if target.suffix not in ("", ".npz"):
            raise InputError(f"{path}: a result is saved as .npz; write that ending, or none")
        with file_errors(path, "cannot be written"):
            target = target.with_suffix(".npz")
        facts = np.array(json.dumps(Facts.of(self).model_dump()))
        with replacing(target) as temporary:
            np.savez_compressed(temporary, t=self.t, facts=facts, **self.channels)  # type: ignore[arg-type]
        return target

    @classmethod
    def load(cls, path: str | Path) -> Result:
        """Read what `save` wrote.

        Raises
        ------
        InputError
            The file is not there or is not a saved result.
        """
        with file_errors(path, "cannot be read"), Path(path).open("rb") as file:
            try:
                return cls._unpacked(file)
            except InputError as error:
                raise InputError(f"{path}: is not a saved result: {error}") from None
            except Exception:  # a damaged archive is told in a dozen ways
                raise InputError(f"{path}: is not a saved result") from None

    @classmethod
    def _unpacked(cls, file: IO[bytes]) -> Result:
        """Read and hold everything against what a run can leave."""
        from gyrostat.saved import Facts

        with np.load(file, allow_pickle=False) as data:
            arrays = {name: data[name] for name in data.files}
        facts, t = Facts(**json.loads(str(arrays.pop("facts")))), arrays.pop("t")
        scenario = facts.flown()
        facts.hold_against(t, arrays)
        for array in (t, *arrays.values()):
            array.flags.writeable = False
        events = tuple(Event(**vars(e)) for e in facts.events)
        meta = {name: dict(m) for name, m in facts.meta.items()}
        return cls(scenario, t, arrays, events, facts.status, facts.cause, facts.end_time, dict(facts.statistics), meta)

    def to_dataframe(self, channels: Iterable[str] | None = None) -> pd.DataFrame:
        """A pandas table, a row an instant, a column a number: ``truth.omega_BN_B.x``, ``allocation.u.0``.

        Parameters
        ----------
        channels
            Names of channels, short or full; all that were recorded when not given.
        """
        from gyrostat import columns

        return columns.data_frame(self, channels)

    def to_parquet(self, path: str | Path, channels: Iterable[str] | None = None) -> Path:
        """Write the table of `to_dataframe` as a Parquet file, with units, and the scenario in its metadata."""
        from gyrostat import columns

        return columns.write(self, path, ".parquet", channels)

    def to_csv(self, path: str | Path, channels: Iterable[str] | None = None) -> Path:
        """Write the table of `to_dataframe` as a CSV file; every number reads back exactly."""
        from gyrostat import columns

        return columns.write(self, path, ".csv", channels)

    def plot(self, *channels: str) -> Figure:
        """Draw channels by name, a panel each, with the faults marked.

        Parameters
        ----------
        *channels
            Names, short or full: ``result.plot("error.angle", "u")``. Without any an overview is drawn: pointing error,
            rate, commands and effectiveness.

        Raises
        ------
        KeyError
            Nothing of that name was recorded; the message lists near names.
        """
        from gyrostat import plots

        return plots.channels(self, channels) if channels else plots.overview(self)

    def to_html(self, path: str | Path, *, single_file: bool = False) -> Path:
        """Write a page that re-plays the run in a browser, from a file and without a network.

        Parameters
        ----------
        path
            A file that ends in ``.html``, or a folder for ``index.html``. The script of plotly is put beside it.
        single_file
            Put that script (5 MB) into the page.

        Returns
        -------
        Path
            The page.

        Raises
        ------
        InputError
            Nothing that a page shows was recorded (the message says what to record), or something else is there.
        """
        from gyrostat.page import write_page

        return write_page(path, self, single_file=single_file)

    def show(self) -> Path:
        """Open the page of the run in the browser; where there is none, print where it is."""
        from gyrostat.page import show

        return show(self)


def _rank(group: str) -> tuple[int, str]:
    return (_groups.index(group) if group in _groups else len(_groups), group)


def _described(value: Any) -> Any:
    """Plain: a Python component as its class."""
    if isinstance(value, dict):
        return {str(k): _described(v) for k, v in value.items()}
    if isinstance(value, list):
        return [_described(v) for v in value]
    plain = value is None or isinstance(value, bool | int | float | str)
    return value if plain else {"type": "python", "class": type(value).__name__}
