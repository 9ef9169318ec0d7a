# SPDX-License-Identifier: MIT
"""What ``gyrostat campaign`` prints."""

from __future__ import annotations

import math
import shlex
import sys
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import typer

from gyrostat.campaign.results import CampaignResult
from gyrostat.campaign.running import State
from gyrostat.errors import InputError
from gyrostat.printing import columns


@contextmanager
def progress(patience: float = 1.0) -> Iterator[Callable[[State], None]]:
    """A line on stderr, if that is a terminal: how many, how fast, how long still, failures so far."""
    started = time.monotonic()
    wide = 0

    def tell(state: State) -> None:
        nonlocal wide
        if time.monotonic() - started < patience or not sys.stderr.isatty():
            return
        line = state_line(state)
        typer.echo("\r" + line.ljust(wide), nl=False, err=True)
        wide = len(line)

    try:
        yield tell
    finally:
        if wide:
            typer.echo("\r" + " " * wide + "\r", nl=False, err=True)


def state_line(state: State) -> str:
    """``1200 of 10000 runs, 480 a second, 18 s left, 31 failures``."""
    left = "" if state.remaining is None else f", {duration(state.remaining)} left"
    return f"{int(state.done)} of {state.runs} runs, {state.rate:.3g} a second{left}, {state.failures} failures"


def duration(seconds: float) -> str:
    """A time that people read."""
    for unit, size in (("days", 86400.0), ("h", 3600.0), ("min", 60.0)):
        if seconds >= 2.0 * size:
            return f"{seconds / size:.1f} {unit}"
    return f"{seconds:.0f} s"


def result(found: CampaignResult) -> None:
    """What a folder holds: a line a cell, then measures, then what it is."""
    wanted = int(found.manifest["runs"])
    gaps = ", ".join(f"{a} to {b - 1}" for a, b in found.missing[:4])
    typer.echo(f"{found.folder}: {found.runs} of {wanted} runs" + (f"; missing: {gaps}" if gaps else ""))
    for label, cell in found.counts.items():
        statuses = ", ".join(f"{n} {name}" for name, n in cell.status.items())
        rate = cell.failures / cell.runs if cell.runs else math.nan
        name = f"{label}: " if label else ""
        typer.echo(f"{name}{cell.failures} failures of {cell.runs} flights ({100 * rate:.3g} %); {statuses}")
        rows: list[tuple[str, ...]] = [("", "measure", "median", "95 %", "99 %", "nan")]
        for measure, sketch in cell.sketches.items():
            quantiles = [f"{sketch.quantile(level):.4g}" for level in (0.5, 0.95, 0.99)]
            rows.append(("", measure, *quantiles, str(sketch.bins.get("nan", 0))))
        columns(rows)


def hashes(found: CampaignResult) -> None:
    """What the folder is."""
    typer.echo(f"identity {found.identity}")
    typer.echo(f"table    {found.table_hash}")


_most_inputs = 12


def sensitivities(found: CampaignResult) -> None:
    """A line an input, those first that explain most: first-order indices in each cell."""
    from gyrostat.campaign.rows import Rows
    from gyrostat.campaign.sensitivities import sensitivities as indices_of

    told = indices_of(Rows.of(found))
    if told is None:
        raise InputError(f"{found.folder}: --inputs needs the rows of all runs, and independent ones, 64 at least")
    typer.echo(f"share of the variance of {told.of} that an input explains alone:")
    lines: list[tuple[str, ...]] = [("input", *(label or "all flights" for label in told.indices))]
    for i, name in enumerate(told.inputs[:_most_inputs]):
        lines.append((name, *(f"{100 * max(float(x[i]), 0.0):.3g} %" for x in told.indices.values())))
    columns(lines)


def comparison(found: CampaignResult, reference: str | None) -> None:
    """A line a cell: failures with an interval, and what it lost and saved of the reference's runs."""
    from gyrostat.campaign.comparing import compare

    rows = compare(found, reference)
    base = reference or rows[0].cell
    lines = [("cell", "failures", "rate, 95 %", f"lost, {base} not", f"saved, {base} not", "McNemar p")]
    for r in rows:
        rate = f"{100 * r.failures / r.runs:.3g} % ({100 * r.interval[0]:.3g} to {100 * r.interval[1]:.3g})"
        paired = ("-", "-", "-") if r.cell == base else (str(r.lost), str(r.saved), f"{r.p:.2g}")
        lines.append((r.cell, f"{r.failures} of {r.runs}", rate, *paired))
    columns(lines)


def rerun_command(folder: Path, run: int, cell: str = "") -> str:
    """The command that flies a run again, by itself."""
    chosen = f" --cell {shlex.quote(cell)}" if cell else ""
    return f"gyrostat campaign rerun {shlex.quote(str(folder))} {run}{chosen}"


def as_table(found: CampaignResult) -> dict[str, Any]:
    """As JSON."""
    return {
        "folder": str(found.folder),
        "identity": found.identity,
        "table": found.table_hash,
        "runs": found.runs,
        "wanted": int(found.manifest["runs"]),
        "missing": [list(gap) for gap in found.missing],
        "cells": {
            label: {
                "runs": c.runs,
                "failures": c.failures,
                "status": c.status,
                "measures": {
                    name: {f"{100 * q:g} %": s.quantile(q) for q in (0.05, 0.5, 0.95, 0.99)}
                    for name, s in c.sketches.items()
                },
            }
            for label, c in found.counts.items()
        },
    }


def rerun(row: Mapping[str, Any] | None, again: Mapping[str, Any], run: int) -> bool:
    """A run flown again, beside its row; whether they are equal to the bit."""
    lines = [("", "again", "row")]
    same = True
    for name, value in again.items():
        there = None if row is None else row[name]
        lines.append((name, _shown(value), "not kept" if row is None else _shown(there)))
        same = same and (row is None or _equal(value, there))
    columns(lines)
    verdict = "its row is not kept" if row is None else "equal to the bit" if same else "NOT EQUAL"
    typer.echo(f"run {run}: {verdict}")
    return same


def _equal(a: Any, b: Any) -> bool:
    return a == b or (isinstance(a, float) and isinstance(b, float) and math.isnan(a) and math.isnan(b))


def _shown(value: Any) -> str:
    return repr(value) if isinstance(value, float) else str(value)


__all__ = [
    "as_table",
    "comparison",
    "duration",
    "hashes",
    "progress",
    "rerun",
    "rerun_command",
    "result",
    "sensitivities",
    "state_line",
]
