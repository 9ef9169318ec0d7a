# SPDX-License-Identifier: MIT
"""A folder of flown runs, to be read: rows, counts, hashes, and each run again."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pyarrow as pa

from gyrostat.campaign.flights import unknown_cell
from gyrostat.campaign.sketches import Sketch
from gyrostat.campaign.store import Part, Store
from gyrostat.errors import InputError, input_errors

if TYPE_CHECKING:
    from gyrostat.campaign.campaign import Campaign


@dataclass(frozen=True)
class CellCounts:
    """Of all flights of a cell, whether or not their rows are kept.

    Attributes
    ----------
    runs, failures
        Flights, and those that are no success.
    status
        How many ended how.
    sums
        Of the finite values of each measure.
    sketches
        Of each measure.
    """

    runs: int
    failures: int
    status: dict[str, int]
    sums: dict[str, float]
    sketches: dict[str, Sketch]


class CampaignResult:
    """What a folder holds; nothing of it is changed here, but for trajectories that the campaign keeps.

    Parameters
    ----------
    folder
        Of `Campaign.run`.

    Raises
    ------
    InputError
        It holds no campaign.
    """

    def __init__(self, folder: str | Path) -> None:
        self._store = Store.existing(folder)
        self.folder = Path(folder)

    @cached_property
    def manifest(self) -> dict[str, Any]:
        """As written: ``identity``, ``runs``, ``chunk``, ``campaign``, ``resolved``."""
        return dict(self._store.manifest() or {})

    @property
    def identity(self) -> str:
        """Of the campaign: equal for folders that may be joined."""
        return str(self.manifest["identity"])

    @cached_property
    def campaign(self) -> Campaign:
        """The campaign again."""
        from gyrostat.campaign.campaign import Campaign

        if self.manifest["campaign"] is None:
            raise InputError(f"{self.folder}: was flown with Python components, which no file can hold")
        with input_errors(f"{self.folder / 'manifest.json'}"):
            return Campaign.from_dict(self.manifest["campaign"])

    @cached_property
    def counts(self) -> dict[str, CellCounts]:
        """By cell."""
        return {
            label: CellCounts(
                runs=c["runs"],
                failures=c["failures"],
                status=c["status"],
                sums={name: m["sum"] for name, m in c["measures"].items()},
                sketches={name: Sketch.from_dict(m["bins"]) for name, m in c["measures"].items()},
            )
            for label, c in self._store.counts()[1].items()
        }

    @property
    def runs(self) -> int:
        """How many are there."""
        return sum(part.end - part.first for part in self._store.parts())

    def parts(self) -> list[Part]:
        """Its parts, in order of run, none twice."""
        return self._store.parts()

    @property
    def missing(self) -> list[tuple[int, int]]:
        """Runs [first, end) below the wanted number that are not there."""
        wanted = int(self.manifest["runs"])
        return self._store.missing(0, wanted, wanted)

    @property
    def complete(self) -> bool:
        """Whether all wanted runs are there."""
        return not self.missing

    @property
    def table_hash(self) -> str:
        """SHA-256 of the kept rows in order of run; all of them are read."""
        return self._store.table_hash()

    def tables(self, columns: Sequence[str] | None = None) -> Iterator[Any]:
        """The kept rows as Arrow tables, part by part, in order of run: for more rows than fit into memory."""
        return self._store.tables(columns)

    def table(self, columns: Sequence[str] | None = None, cell: str | None = None) -> Any:
        """The kept rows as one Arrow table, in order of run and cell."""
        import pyarrow.compute as pc

        wanted = None if columns is None else list(dict.fromkeys([*columns, "cell"] if cell is not None else columns))
        parts = list(self.tables(wanted))
        if not parts:
            raise InputError(f"{self.folder}: holds no runs")
        table = pa.concat_tables(parts).unify_dictionaries()
        if cell is not None:
            if cell not in self.counts:
                raise unknown_cell(cell, self.counts)
            table = table.filter(pc.equal(table.column("cell").cast(pa.string()), cell))
        return table if columns is None else table.select(list(columns))

    def to_dataframe(self) -> Any:
        """The kept rows as a pandas table."""
        return self.table().to_pandas()

    def row(self, run: int, cell: str | None = None) -> dict[str, Any] | None:
        """A kept row; None where it is not kept."""
        for part in self._store.parts():
            if part.first <= run < part.end:
                table = self._store.read(part)
                label = next(iter(self.counts)) if cell is None else cell
                for row in table.filter(pa.array(table.column("run").to_numpy() == run)).to_pylist():
                    if row["cell"] == label:
                        return dict(row)
        return None

    def to_html(self, path: str | Path, against: str | None = None) -> Path:
        """Write the page of the campaign, one file that needs no network; see `gyrostat.page.campaign`.

        Parameters
        ----------
        path
            A file that ends in ``.html``, or a folder for ``index.html``.
        against
            The cell with which the others are compared, run by run; the first one if absent.
        """
        from gyrostat.page.campaign import write_campaign_page

        return write_campaign_page(path, self, against)

    def keep_trajectories(self) -> list[Path]:
        """Fly the runs once more whose trajectories are to be kept, as far as their files are not there."""
        keep = None if self.manifest["campaign"] is None else self.campaign.spec.keep.trajectories
        written: list[Path] = []
        if keep is None or not self.complete:
            return written
        for run, cell in self._chosen():
            name = f"{run}.npz" if not cell else f"{run}-{cell.replace('/', '-')}.npz"
            path = self.folder / "trajectories" / name
            if not path.exists():
                from gyrostat.files import writable_folder

                writable_folder(path.parent)
                self.campaign.scenario(run, cell).run().save(path)
                written.append(path)
        return written

    def _chosen(self) -> list[tuple[int, str]]:
        """Runs and cells whose trajectories are kept: a function of the rows alone."""
        keep = self.campaign.spec.keep.trajectories
        assert keep is not None  # asked by whom calls
        failures: dict[str, list[int]] = {label: [] for label in self.counts}
        worst: dict[str, list[tuple[float, int]]] = {label: [] for label in self.counts}
        chosen: set[tuple[int, str]] = set()
        names = ["run", "cell", "success", "status"] + ([keep.worst.measure] if keep.worst is not None else [])
        for table in self.tables(names):
            for row in table.to_pylist():
                run, cell = row["run"], row["cell"]
                if row["status"] == "refused" or row["status"] == "raised":
                    continue  # nothing flew
                if not row["success"] and len(failures[cell]) < keep.failures:
                    failures[cell].append(run)
                if keep.worst is not None:
                    x = row[keep.worst.measure]
                    worst[cell] = sorted([*worst[cell], (-np.inf if np.isnan(x) else -x, run)])[: keep.worst.count]
                if keep.every is not None and run % keep.every == 0:
                    chosen.add((run, cell))
        chosen |= {(run, cell) for cell, runs in failures.items() for run in runs}
        chosen |= {(run, cell) for cell, runs in worst.items() for _, run in runs}
        return sorted(chosen)

    def __repr__(self) -> str:
        failed = sum(c.failures for c in self.counts.values())
        return f"CampaignResult({self.folder}: {self.runs} runs, {failed} failures)"


__all__ = ["CampaignResult", "CellCounts"]
