# SPDX-License-Identifier: MIT
"""The command ``gyrostat dataset``: labelled flights for fault detection, and their score. Page: docs/campaigns.md."""

from __future__ import annotations

import csv
import math
from pathlib import Path
from typing import Annotated

import typer

from gyrostat import printing
from gyrostat.cli_campaign import FirstCommand
from gyrostat.errors import InputError
from gyrostat.files import file_errors


class _SourceFirst(FirstCommand):
    default = "make"


app = typer.Typer(
    cls=_SourceFirst,
    no_args_is_help=True,
    help="""Make a labelled data set for fault detection, and score detectors on it.

Start with `gyrostat dataset wheel_faults --runs 100 --out set`, then `gyrostat dataset score set`.""",
)


@app.command()
def make(
    source: Annotated[str, typer.Argument(help="A campaign or a scenario: a TOML file, or a shipped one.")],
    runs: Annotated[int, typer.Option(min=1, help="How many flights.")],
    out: Annotated[Path, typer.Option(metavar="DIR", help="A new or empty folder; it appears when it is complete.")],
    *,
    cell: Annotated[str | None, typer.Option(help="Where there is a grid: which cell.")] = None,
    every: Annotated[int, typer.Option(min=1, help="Write every so many samples.")] = 1,
) -> None:
    """Fly, and write what a detector may read (`samples.parquet`) and what happened (`labels.parquet`).

    Example: `gyrostat dataset wheel_faults --runs 100 --out set`
    """
    from gyrostat import dataset

    with printing.progress(f"flying {source}") as progress:
        dataset.make(dataset.source(source), runs, out, cell=cell, every=every, progress=progress)
    typer.echo(f"{out}: {runs} flights; samples.parquet, labels.parquet, flights.parquet, dataset.json")


@app.command()
def score(
    folder: Annotated[Path, typer.Argument(metavar="DIR", help="Of a data set.")],
    *,
    observers: Annotated[
        list[str] | None, typer.Option("--observer", help="By name; all if absent. Repeatable.")
    ] = None,
    detectors: Annotated[
        list[str] | None, typer.Option("--detector", help="By name; all if absent. Repeatable.")
    ] = None,
    declared: Annotated[
        Path | None, typer.Option(metavar="FILE.csv", help="Instead: declarations, columns run, t, mask (bits).")
    ] = None,
    horizon: Annotated[float, typer.Option(help="s after an onset in which a declaration belongs to it.")] = 4.0,
    as_json: Annotated[bool, typer.Option("--json", help="Print JSON.")] = False,
) -> None:
    """Score observers and detectors, or declarations of your own: delay, false alarms, isolation.

    It also says how many faults no detector could tell: the commands after them leave no trace, or that of another one.

    Examples: `gyrostat dataset score set --observer joint_kalman`, `gyrostat dataset score set --declared mine.csv`
    """
    from gyrostat import dataset
    from gyrostat.detection import ANSWERS

    given = None if declared is None else {declared.stem: _declarations(declared)}
    with printing.progress("scoring") as progress:
        found = dataset.score(
            folder, observers=observers, detectors=detectors, declared=given, horizon=horizon, progress=progress
        )
    if as_json:
        told = [
            {"name": s.name, "refused": s.refused, "delay": None if math.isnan(s.delay) else s.delay,
             "false_alarms_per_hour": s.false_alarms_per_hour, "isolation": s.isolation.tolist(),
             "answers": {a: s.count(a) for a in ANSWERS}}
            for s in found.scores
        ]  # fmt: skip
        printing.as_json({"scores": told, "faults": found.faults, "silent": found.silent, "confused": found.confused})
        return
    rows: list[tuple[str, ...]] = [("detector", *ANSWERS, "median delay, s", "false alarms an hour")]
    for s in found.scores:
        if s.refused is None:
            delay = "–" if math.isnan(s.delay) else f"{s.delay:.3g}"
            rows.append((s.name, *(str(s.count(a)) for a in ANSWERS), delay, f"{s.false_alarms_per_hour:.3g}"))
    printing.columns(rows)
    for s in found.scores:
        if s.refused is not None:
            typer.echo(f"{s.name}: did not run: {s.refused}")
        elif len(found.scores) == 1:
            n = len(s.isolation)
            head = ("failed", *(f"named {j}" for j in range(n)), "several", "missed")
            printing.columns([head, *((str(i), *map(str, row)) for i, row in enumerate(s.isolation.tolist()))])
    typer.echo(
        f"not identifiable within {horizon:g} s: of {found.faults} faults {found.silent} with an actuator that is "
        f"hardly commanded, {found.confused} with the trace of another one"
    )


def _declarations(path: Path) -> list[tuple[int, float, int]]:
    with file_errors(path, "cannot be read"), path.open(newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    try:
        return [(int(r["run"]), float(r["t"]), int(r["mask"])) for r in rows]
    except (KeyError, ValueError, TypeError):
        raise InputError(
            f"{path}: columns run, t (s) and mask (a whole number, a bit an actuator) belong here"
        ) from None


__all__ = ["app"]
