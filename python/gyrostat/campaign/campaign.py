# SPDX-License-Identifier: MIT
"""A campaign: one scenario, what differs from run to run, what is measured, and what counts as a success.

A run is a function of the campaign and its number: its random inputs are a point of the open unit cube that a
counter-based generator gives it, flown in every cell of the grid with the same noise. So a run can be drawn, flown and
explained alone, and thousands of them on any number of threads or machines, stopped and taken up again: the same bits.
Page: docs/campaigns.md
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from gyrostat import toml
from gyrostat.campaign import chunks
from gyrostat.campaign.catalogue import shipped
from gyrostat.campaign.chunks import Chunk
from gyrostat.campaign.distributions import Distribution
from gyrostat.campaign.flights import Cell, Cells, Outcome, unknown_cell
from gyrostat.campaign.inputs import Draws, Inputs
from gyrostat.campaign.limits import whole
from gyrostat.campaign.sampling import REPLICATES, LatinHypercube, Plain, Sampling, Sobol
from gyrostat.campaign.spec import Fault, Grid, Spec
from gyrostat.campaign.streams import Array
from gyrostat.components import Component
from gyrostat.errors import InputError, input_errors, suggestion
from gyrostat.experiment import Measures
from gyrostat.model import Model
from gyrostat.scenario import Scenario, find
from gyrostat.text import shown

if TYPE_CHECKING:
    from gyrostat.campaign.results import CampaignResult
    from gyrostat.campaign.running import State


class Campaign:
    """Many flights of one scenario with drawn inputs.

    Parameters
    ----------
    base
        A scenario, the name of a shipped one, a file, or its tables.
    set
        Values of the base that are changed first, by dotted key, as `Scenario.replace` takes them.
    name, description
        For people.
    seed
        Of all draws and all noise.
    sampling, replicates, points
        ``plain``: independent runs. ``lhs``, ``sobol``: so many replicates of so many points.
    vary
        Distributions by dotted key: ``{"initial.omega_BN_B": dist.normal(0.0, 0.01, each=3)}``.
    correlated
        Tables with ``keys`` and ``matrix``.
    faults
        Tables of sampled faults.
    grids
        Factors: tables with ``name`` and ``of``.
    measure, success, margin, keep
        What is measured of a flight (as an `Experiment` takes it), when it is a success, by how much, what is kept.

    Raises
    ------
    InputError
        One line: what cannot be, where, and what is allowed.

    Examples
    --------
    >>> import gyrostat as gs
    >>> from gyrostat.campaign import dist
    >>> campaign = gs.Campaign(
    ...     base="wheel2_degraded",
    ...     set={"duration": 20.0, "integrator": "rk4", "faults": []},
    ...     vary={"initial.omega_BN_B": dist.normal(0.0, 0.01, each=3)},
    ... )
    >>> campaign.inputs
    ('initial.omega_BN_B[0]', 'initial.omega_BN_B[1]', 'initial.omega_BN_B[2]')
    >>> campaign.draws(0, 2)["initial.omega_BN_B.0"].shape
    (2,)
    """

    def __init__(
        self,
        base: str | Path | Scenario | Mapping[str, Any],
        *,
        set: Mapping[str, Any] | None = None,  # noqa: A002
        name: str = "",
        description: str = "",
        seed: int = 0,
        sampling: str = "plain",
        replicates: int | None = None,
        points: int | None = None,
        vary: Mapping[str, Distribution | Mapping[str, Any]] | None = None,
        correlated: Sequence[Mapping[str, Any]] = (),
        faults: Sequence[Mapping[str, Any] | Fault] = (),
        grids: Sequence[Mapping[str, Any] | Grid] = (),
        measure: Measures | None = None,
        success: Mapping[str, Mapping[str, Any]] | None = None,
        margin: Mapping[str, Any] | None = None,
        keep: Mapping[str, Any] | None = None,
    ) -> None:
        given: dict[str, Any] = {
            "name": name,
            "description": description,
            "seed": seed,
            "sampling": sampling,
            "replicates": replicates,
            "points": points,
            "vary": vary,
            "correlated": _table(correlated),
            "fault": _table(faults),
            "grid": _table(grids),
            "measure": _table(measure),
            "success": _table(success),
            "margin": _table(margin),
            "keep": _table(keep),
        }
        if set is not None and not isinstance(set, Mapping):
            raise InputError(f"set = {shown(set)}: a table belongs here")
        self._given = base, dict(set or {})
        self.spec = Spec(**{key: value for key, value in given.items() if value is not None})
        self.base = _scenario(base, dict(set or {})).replace(seed=self.spec.seed)
        self._inputs = Inputs(self.spec, self.base)
        self._cells = Cells(self.spec, self.base, self._inputs)
        self._check_names()

    @classmethod
    def load(cls, name: str | Path) -> Campaign:
        """A campaign of a file, or a shipped one by name."""
        path = Path(name)
        known = shipped()
        if path.suffix != ".toml" and str(name) in known:
            path = known[str(name)]
        elif path.suffix != ".toml" and not path.exists():
            raise InputError(f"no campaign '{name}'{suggestion(str(name), known)}")
        return cls.from_toml(path)

    @classmethod
    def from_toml(cls, path: str | Path) -> Campaign:
        """Read a TOML file; messages name it. A base that is a file is looked for beside it."""
        tables = toml.read(Path(path))
        base = tables.get("base")
        if isinstance(base, str) and base.endswith(".toml"):
            tables = {**tables, "base": str(Path(path).parent / base)}
        with input_errors(str(path)):
            return cls.from_dict(tables)

    @classmethod
    def from_dict(cls, tables: Mapping[str, Any]) -> Campaign:
        """From the tables of a TOML file, or of `to_dict`."""
        keys = {"base", "set", *Spec.model_fields}
        if "base" not in tables and "vehicle" in tables:
            raise InputError('this is a scenario; a campaign names one: base = "..."')
        for key in tables:
            if key not in keys:
                raise InputError(f"unknown key '{key}'{suggestion(str(key), keys)}")
        if "base" not in tables:
            raise InputError("base is missing: the name, the file or the tables of a scenario")
        for key in ("set", "vary", "measure", "success", "margin", "keep"):
            if key in tables and not isinstance(tables[key], Mapping):
                raise InputError(f"{key} = {shown(tables[key])}: a table belongs here")
        for key in ("correlated", "fault", "grid"):
            if not isinstance(tables.get(key, []), list) or not all(
                isinstance(t, Mapping) for t in tables.get(key, [])
            ):
                raise InputError(f"{key}: a list of tables belongs here; write [[{key}]]")
        renamed = {"fault": "faults", "grid": "grids"}
        return cls(**{renamed.get(key, key): value for key, value in tables.items()})

    def to_dict(self) -> dict[str, Any]:
        """Plain tables. A base that was given as a file or a `Scenario` stands with all of its tables."""
        base, changes = self._given
        if not isinstance(base, str) or base not in _shipped_scenarios():
            base, changes = self.base.to_dict(), {}
        tables = self.spec.table()
        head = {key: tables.pop(key) for key in ("name", "description") if key in tables}
        return head | {"base": base} | ({"set": _plain(changes)} if changes else {}) | tables

    def standalone(self) -> dict[str, Any]:
        """As `to_dict`, with all tables of the base in it: what another machine, or a later version, can read alone."""
        tables = {**self.to_dict(), "base": self.base.to_dict()}
        tables.pop("set", None)
        return tables

    def to_toml(self, path: str | Path | None = None) -> str:
        """The text of a TOML file, also written to `path` if given."""
        for role in self.base.python_components():
            raise InputError(f"{role} is a Python object; a TOML file can only hold components of the catalogue")
        tables = self.to_dict()
        if (absent := _absent(tables)) is not None:
            raise InputError(f"{absent} is None, which TOML cannot say; name a component that does nothing")
        text = toml.write(tables)
        if path is not None:
            from gyrostat.files import write_text

            write_text(Path(path), text)
        return text

    @property
    def name(self) -> str:
        """For people."""
        return self.spec.name

    @property
    def inputs(self) -> tuple[str, ...]:
        """One name a dimension of a point: that of its stream, and which word of it."""
        return tuple(
            s.name if s.words == 1 else f"{s.name}[{i}]" for s in self._inputs.streams.streams for i in range(s.words)
        )

    @property
    def dimension(self) -> int:
        """Uniform numbers a run."""
        return self._inputs.streams.dimension

    @property
    def cells(self) -> dict[str, Cell]:
        """Cells of the grid by label, ready to fly; one with an empty label where there is no grid.

        Raises
        ------
        InputError
            A key, a measure or a component that does not fit the scenario.
        """
        return self._cells.all

    @property
    def measures(self) -> tuple[str, ...]:
        """Names of what is measured."""
        return next(iter(self.cells.values())).experiment.metrics

    @property
    def has_margin(self) -> bool:
        """Whether flights have a margin: ``[margin]``, or a single criterion whose measure is always a number."""
        return next(iter(self.cells.values())).judge.margin is not None

    def points(self, first: int, last: int) -> Array:
        """The points of runs first to last - 1 in the open unit cube, shape (last - first, dimension)."""
        whole("first", first)
        whole("last", last)
        if last < first:
            raise InputError(f"last = {last} lies before first = {first}")
        return self._sampling.points(first, last)

    def draws(self, first: int, last: int) -> dict[str, NDArray[Any]]:
        """What runs first to last - 1 fly with: by column of the table, shape (last - first,) each."""
        return self.drawn(self.points(first, last)).columns

    def drawn(self, u: ArrayLike) -> Draws:
        """What points of the open unit cube, shape (n, dimension), stand for."""
        return self._inputs.draw(self._checked(u))

    def evaluate(
        self,
        u: ArrayLike,
        *,
        first: int = 0,
        cell: str | None = None,
        versions: ArrayLike | None = None,
        jobs: int | None = None,
        progress: Callable[[float], None] | None = None,
    ) -> Outcome:
        """Fly points of the open unit cube, whatever chose them.

        Parameters
        ----------
        u
            Shape (n, dimension).
        first
            Number of the first; first, first + 1, ... key the noise.
        cell
            Where there is a grid: which.
        versions
            Of the noise of each second, shape (n, `noise_blocks`), whole numbers from 1 to 2^53: instead of that of
            the runs. What has the same version has the same noise, in whichever run.
        jobs
            Threads; as many as there are cores if absent.
        progress
            Called now and then with the finished fraction.

        Returns
        -------
        Outcome
            Measures, success, margin, status, cause, end time: a row a point.
        """
        whole("first", first)
        flying, values = self._versioned(cell, self.drawn(u).values, versions)
        return flying.fly(values, first, jobs, progress)

    def scenario(self, run: int, cell: str | None = None) -> Scenario:
        """The plain scenario that a run is: flown by itself, it gives the same row to the bit."""
        return self.scenario_at(self.points(run, run + 1)[0], run, cell)

    def scenario_at(
        self, u: ArrayLike, run: int = 0, cell: str | None = None, versions: ArrayLike | None = None
    ) -> Scenario:
        """The plain scenario of a point, shape (dimension,), flown with the noise of a run, or of these versions."""
        point = np.asarray(u, dtype=float)
        more = None if versions is None else np.asarray(versions)[None, :]
        flying, values = self._versioned(cell, self.drawn(point[None, :]).values, more)
        return flying.scenario(values[0], run)

    def noise_blocks(self, cell: str | None = None) -> int:
        """Seconds whose noise may have a version of its own; 0 where there are no sensors."""
        return self._cell(cell).noise_blocks

    def fly(
        self, first: int, end: int, *, jobs: int | None = None, progress: Callable[[float], None] | None = None
    ) -> Chunk:
        """Runs [first, end) in every cell, in memory: their rows and their counts."""
        draws = self.drawn(self.points(first, end))
        outcomes: dict[str, Outcome] = {}
        for i, (label, cell) in enumerate(self.cells.items()):
            tell = None if progress is None else _part_of(progress, i, len(self.cells))
            outcomes[label] = cell.fly(draws.values, first, jobs, tell)
        return chunks.made(self.spec, draws, outcomes, first)

    def run(
        self,
        runs: int,
        *,
        out: str | Path,
        jobs: int | None = None,
        chunk: int | None = None,
        only: tuple[int, int] | None = None,
        scheduler: str | None = None,
        progress: Callable[[State], None] | None = None,
    ) -> CampaignResult:
        """Fly runs 0 to runs - 1, or those of them that the folder does not hold yet.

        Parts that are there are read; one that is not what was written is named by a warning and flown again.

        Parameters
        ----------
        runs
            How many the folder is to hold.
        out
            The folder; one of another campaign is refused.
        jobs
            Threads; as many as there are cores if absent.
        chunk
            Runs a part. That of the folder if there is one; results do not depend on it.
        only
            Chunks [a, b) alone, for job arrays.
        scheduler
            Address of a Dask scheduler whose workers fly the chunks.
        progress
            Called several times a second. What it raises ends the flights; the folder can be taken up again.

        Raises
        ------
        InputError
            A folder of another campaign, with the first key that differs; no flights that can be flown.
        """
        from gyrostat.campaign.running import run

        return run(self, runs, out=Path(out), jobs=jobs, chunk=chunk, only=only, scheduler=scheduler, progress=progress)

    def with_points(self, runs: int) -> Campaign:
        """The campaign with as many points a replicate as `runs` makes; itself where runs are independent."""
        if self.spec.sampling == "plain" or self.spec.points is not None:
            return self
        replicates = self.spec.replicates or REPLICATES
        if runs % replicates:
            raise InputError(f"runs = {runs}: must be a multiple of replicates = {replicates}")
        other = object.__new__(Campaign)
        other.__dict__.update({key: value for key, value in self.__dict__.items() if key != "_sampling"})
        other.spec = Spec(**{**dict(self.spec), "replicates": replicates, "points": runs // replicates})
        return other

    @cached_property
    def _sampling(self) -> Sampling:
        streams, seed, n = self._inputs.streams, self.spec.seed, self.spec.points
        if self.spec.sampling == "plain":
            return Plain(streams, seed)
        if n is None:
            raise InputError(f"points is missing: how many a replicate of '{self.spec.sampling}' has")
        return (LatinHypercube if self.spec.sampling == "lhs" else Sobol)(streams, seed, n)

    def _versioned(self, label: str | None, values: Array, versions: ArrayLike | None) -> tuple[Cell, Array]:
        cell = self._cell(label)
        if versions is None:
            return cell, values
        more = np.asarray(versions, dtype=float)
        if cell.noise_blocks == 0 or more.shape != (len(values), cell.noise_blocks):
            raise InputError(f"versions of shape {more.shape}; ({len(values)}, {cell.noise_blocks}) belongs here")
        return cell.versioned, np.hstack([values, more])

    def _cell(self, label: str | None) -> Cell:
        if label is None:
            if len(self.cells) > 1:
                raise InputError(f"which cell? there are: {', '.join(self.cells)}")
            return next(iter(self.cells.values()))
        if label not in self.cells:
            raise unknown_cell(label, self.cells)
        return self.cells[label]

    def _checked(self, u: ArrayLike) -> Array:
        try:
            points = np.asarray(u, dtype=float)
        except (TypeError, ValueError):
            raise InputError(f"u: {shown(u)} are no points of {self.dimension} numbers") from None
        if points.ndim != 2 or points.shape[1] != self.dimension:
            raise InputError(f"u of shape {points.shape}; (points, {self.dimension}) belongs here")
        if not np.all((points > 0.0) & (points < 1.0)):
            raise InputError("u: numbers between 0 and 1, both excluded, belong here")
        return points

    def _check_names(self) -> None:
        """Columns of the table, each once; the inputs' names are known without flying."""
        one = np.full((1, self.dimension), 0.5)
        names = chunks.columns_of(list(self._inputs.draw(one).columns), self.measures)
        twice = sorted({n for n in names if names.count(n) > 1})
        if twice or "margin" in self.measures:
            raise InputError(
                f"'{(twice or ['margin'])[0]}' would be two columns of the table; call the measure otherwise"
            )
        keep = self.spec.keep.trajectories
        if keep is not None and keep.worst is not None and keep.worst.measure not in self.measures:
            raise InputError(f"keep: no measure '{keep.worst.measure}'{suggestion(keep.worst.measure, self.measures)}")

    def __repr__(self) -> str:
        cells = f", {len(self.cells)} cells" if len(self.cells) > 1 else ""
        return (
            f"Campaign({self.name or 'unnamed'}: {self.dimension} inputs{cells}, measures: {', '.join(self.measures)})"
        )


def _shipped_scenarios() -> Mapping[str, Path]:
    from gyrostat.scenario import shipped as scenarios

    return scenarios()


def _scenario(base: Any, changes: Mapping[str, Any]) -> Scenario:
    with input_errors("base"):
        if isinstance(base, Scenario):
            scenario = base
        elif isinstance(base, Mapping):
            scenario = Scenario.from_dict(base)
        else:
            scenario = Scenario.from_toml(find(base))
    with input_errors("set"):
        return scenario.replace(**changes) if changes else scenario


def _table(value: Any) -> Any:
    """What a model reads: of models in it, their tables."""
    if isinstance(value, Model):
        return value.model_dump(exclude_none=True)
    if isinstance(value, Mapping):
        return {key: _table(v) for key, v in value.items()}
    return [_table(v) for v in value] if isinstance(value, list | tuple) else value


def _plain(value: Any) -> Any:
    """Components in what was set, as tables."""
    if isinstance(value, Component):
        return value.to_dict()
    if isinstance(value, Mapping):
        return {key: _plain(v) for key, v in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(v) for v in value]
    return value.tolist() if isinstance(value, np.ndarray | np.generic) else value


def _absent(value: Any, path: str = "") -> str | None:
    """The first key under which there is nothing."""
    if isinstance(value, Mapping):
        items: Any = value.items()
    elif isinstance(value, list | tuple):
        items = enumerate(value)
    else:
        return path if value is None else None
    found = (_absent(v, f"{path}.{key}" if path else str(key)) for key, v in items)
    return next((path for path in found if path is not None), None)


def _part_of(progress: Callable[[float], None], i: int, n: int) -> Callable[[float], None]:
    return lambda fraction: progress((i + fraction) / n)


__all__ = ["Campaign"]
