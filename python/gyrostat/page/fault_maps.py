# SPDX-License-Identifier: MIT
"""Failure rate of a campaign by what a fault did, how severely, and when it began: tables of the page of a campaign."""

from __future__ import annotations

from collections import Counter
from html import escape
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from gyrostat.campaign.rows import Columns, Rows
from gyrostat.campaign.sampled_faults import NONE
from gyrostat.page.campaign_blocks import note, percent

LEAST = 20
"""Flights of which a rate is shown."""
_most_maps = 40
_severities, _onsets = 5, 6


def fault_maps(rows: Rows) -> str:
    """Failure rate by what a fault did and when it began, a table a fault and cell."""
    faults = sorted({n.rpartition(".")[0] for n in rows.inputs() if n.startswith("fault.") and n.endswith(".0.kind")})
    if not faults:
        return ""
    if not rows.whole:
        return note("A rate needs the rows of flights that were no failures too; [keep] rows = 'all' keeps them.")
    maps = [
        f"<h3>{escape(fault.split('.')[1])}{escape(f', {label}' if label else '')}</h3>{_fault_map(columns, fault)}"
        for fault in faults
        for label, columns in rows.cells.items()
    ]
    left = f"{len(maps) - _most_maps} further tables are left out." if len(maps) > _most_maps else ""
    said = (
        f"Share of lost flights among those in which a fault happened; of fewer than {LEAST} flights "
        "their number in brackets. Of a fault that may happen several times: its first occurrence. "
    )
    return note(said + left) + "".join(maps[:_most_maps])


def _fault_map(columns: Columns, fault: str) -> str:
    onset = columns[f"{fault}.t_on"].astype(float)
    happened = columns[f"{fault}.kind"] != NONE
    if not happened.any():
        return note("Did not happen.")
    kinds = Counter(columns[f"{fault}.kind"][happened].tolist())
    edges = _edges(onset[happened], _parts(int(np.median(list(kinds.values()))), _onsets))
    head = "".join(f"<th>{a:.3g} to {b:.3g} s</th>" for a, b in pairwise(edges))
    begun = _bin(onset, edges)
    lines = []
    for name, mine in _severity_rows(columns, fault, len(edges) - 1):
        shares = (_map_cell(columns, mine & (begun == k)) for k in range(len(edges) - 1))
        lines.append(f"<tr><th>{escape(name)}</th>{''.join(shares)}</tr>")
    return f'<div class="wide"><table class="map"><tr><th></th>{head}</tr>{"".join(lines)}</table></div>'


def _severity_rows(columns: Columns, fault: str, onsets: int) -> list[tuple[str, NDArray[np.bool_]]]:
    """Kinds, in stretches of their first drawn parameter where they have one."""
    kinds = columns[f"{fault}.kind"]
    found: list[tuple[str, NDArray[np.bool_]]] = []
    for kind in sorted(set(kinds.tolist()) - {NONE}):
        mine = np.asarray(kinds == kind)
        drawn = [name for name in columns if name.startswith(f"{fault}.{kind}.")]
        if not drawn:
            found.append((kind.replace("_", " "), mine))
            continue
        x = columns[drawn[0]].astype(float)
        edges = _edges(x[mine], _parts(int(mine.sum()) // onsets, _severities))
        parameter = drawn[0].rpartition(".")[2]
        for k, (a, b) in enumerate(pairwise(edges)):
            name = f"{kind.replace('_', ' ')}, {parameter} {a:.3g} to {b:.3g}"
            found.append((name, np.asarray(mine & (_bin(x, edges) == k))))
    return found


def _parts(n: int, most: int) -> int:
    """Into how many parts n flights are divided so that most have a rate."""
    return min(max(2 * n // (3 * LEAST), 1), most)


def _edges(x: NDArray[np.float64], parts: int) -> NDArray[np.float64]:
    low, high = float(x.min()), float(x.max())
    return np.linspace(low, high, (parts if high > low else 1) + 1)


def _bin(x: NDArray[np.float64], edges: NDArray[np.float64]) -> NDArray[np.int64]:
    inside = np.searchsorted(edges[1:-1], np.nan_to_num(x, posinf=edges[-1]), side="right")
    return np.asarray(np.where(np.isfinite(x), inside, -1))


def _map_cell(columns: Columns, mine: NDArray[np.bool_]) -> str:
    n = int(mine.sum())
    if n < LEAST:
        return f'<td class="count">({n})</td>'
    lost = int(np.count_nonzero(mine & ~columns["success"].astype(bool)))
    return f'<td class="rate" style="--share:{100 * lost / n:.0f}%" title="{lost} of {n}">{percent(lost / n)}</td>'


__all__ = ["LEAST", "fault_maps"]
