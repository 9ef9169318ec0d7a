# SPDX-License-Identifier: MIT
"""The rows of a flown campaign by cell, and what its file says of them: what statistics of a folder are made from."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gyrostat.campaign.judging import TIMES
from gyrostat.campaign.results import CampaignResult
from gyrostat.experiment import usual_measures

Array = NDArray[np.float64]
Columns = dict[str, NDArray[Any]]


@dataclass(frozen=True)
class Rows:
    """Of a folder.

    Attributes
    ----------
    found
        The folder.
    cells
        Kept rows of each cell, in order of run, by column.
    """

    found: CampaignResult
    cells: Mapping[str, Columns]

    @classmethod
    def of(cls, found: CampaignResult) -> Rows:
        """All kept rows, in memory."""
        table = found.table()
        columns = {name: _numpy(table.column(name)) for name in table.column_names}
        split = {label: columns["cell"] == label for label in found.counts}
        return cls(found, {label: {n: x[mine] for n, x in columns.items()} for label, mine in split.items()})

    @property
    def spec(self) -> dict[str, Any]:
        """The campaign's file with its defaults, as plain tables."""
        return dict(self.found.manifest["resolved"]["campaign"])

    @property
    def independent(self) -> bool:
        """Whether runs are: of plain sampling."""
        return bool(self.spec["sampling"] == "plain")

    @cached_property
    def whole(self) -> bool:
        """Whether the row of every flight is kept."""
        return all(len(rows["run"]) == self.found.counts[label].runs for label, rows in self.cells.items())

    @cached_property
    def measures(self) -> dict[str, dict[str, Any]]:
        """What was measured."""
        cell = next(iter(self.found.manifest["resolved"]["cells"].values()))
        return dict(self.spec["measure"] or usual_measures(float(cell["duration"])))

    @property
    def times(self) -> list[str]:
        """Measures that are times at which something happened: settling and its like."""
        return [name for name, m in self.measures.items() if m["metric"] in TIMES]

    def limits(self, measure: str) -> list[float]:
        """Of ``[success]``."""
        criterion = self.spec["success"].get(measure) or {}
        return [float(x) for key in ("below", "above") if (x := criterion.get(key)) is not None]

    def values(self, cell: str, measure: str) -> Array:
        """Of a measure, shape (n,): infinite where it has no value and where the flight ended early."""
        rows = self.cells[cell]
        x = np.asarray(rows[measure], dtype=float)
        return np.where(np.isnan(x) | (rows["status"] != "completed"), np.inf, x)

    def points(self, run: NDArray[np.int64]) -> Array:
        """Uniform inputs of runs in their order, shape (n, dimension), drawn in stretches."""
        campaign = self.found.campaign
        if not len(run):
            return np.empty((0, campaign.dimension))
        parts = []
        for first in range(int(run[0]), int(run[-1]) + 1, 20_000):
            mine = run[(run >= first) & (run < first + 20_000)]
            if len(mine):
                parts.append(campaign.points(first, int(mine[-1]) + 1)[mine - first])
        return np.concatenate(parts)

    def inputs(self) -> list[str]:
        """Columns of what was drawn."""
        fixed = {"run", "cell", "success", "margin", "status", "cause", "t_end", *self.measures}
        return [name for name in next(iter(self.cells.values())) if name not in fixed]


def _numpy(column: Any) -> NDArray[Any]:
    if "string" in str(column.type):
        return np.asarray(column.to_pylist(), dtype=object)
    return np.asarray(column.to_numpy(zero_copy_only=False))


__all__ = ["Rows"]
