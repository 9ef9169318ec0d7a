# SPDX-License-Identifier: MIT
"""The command ``gyrostat campaign``: a file is flown into a folder; folders are shown, joined, and flown again."""

from __future__ import annotations

import errno
from difflib import get_close_matches
from pathlib import Path
from typing import Annotated, Any

import typer
from typer.core import TyperGroup

from gyrostat import printing
from gyrostat.errors import FileError, InputError


class FirstCommand(TyperGroup):
    """``gyrostat campaign FILE`` is short for ``gyrostat campaign fly FILE``."""

    default = "fly"

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        """As they were meant: what is hardly another than a command, and flies no runs, is one mistyped."""
        if args and not args[0].startswith("-") and args[0] not in self.commands:
            mistyped = get_close_matches(args[0], self.commands, cutoff=0.7) and "--runs" not in args
            args = args if mistyped else [self.default, *args]
        return super().parse_args(ctx, args)


app = typer.Typer(
    cls=FirstCommand,
    no_args_is_help=True,
    help="""Fly a campaign: many flights with drawn inputs and sampled faults, resumable, the same bits anywhere.

Start with `gyrostat campaign FILE.toml --runs 1000 --out DIR`; the same command takes it up again.""",
)

FULL_DISK = 5
"""Exit status when the disk is full: what was written stays, and the same command goes on from there."""
_full = (errno.ENOSPC, errno.EDQUOT)

Folder = Annotated[Path, typer.Argument(metavar="DIR", help="Of a campaign.")]
Json = Annotated[bool, typer.Option("--json", help="Print JSON.")]


@app.command()
def fly(
    file: Annotated[str, typer.Argument(help="A TOML file, or a shipped campaign.")],
    runs: Annotated[int, typer.Option(help="How many runs the folder is to hold.")],
    out: Annotated[Path, typer.Option(metavar="DIR", help="A new folder, or one to go on with.")],
    *,
    jobs: Annotated[int | None, typer.Option(help="Threads; as many as there are cores if absent.")] = None,
    chunk: Annotated[int | None, typer.Option(help="Runs a part of a new folder (500).")] = None,
    chunks: Annotated[
        str | None, typer.Option(metavar="A:B", help="Chunks A to B - 1 alone: one task of a job array.")
    ] = None,
    scheduler: Annotated[str | None, typer.Option(metavar="ADDRESS", help="Of a Dask cluster that flies it.")] = None,
    as_json: Json = False,
) -> None:
    """Fly a campaign, or what a folder does not hold of it yet.

    Exit status 5 if the disk is full; what is there stays, and the same command goes on.

    Examples: `gyrostat campaign wheel_faults --runs 1000 --out flown`,
    `gyrostat campaign my.toml --runs 100000 --chunks 0:20 --out flown`
    """
    from gyrostat.campaign import Campaign
    from gyrostat.campaign import printing as show

    campaign = Campaign.load(file)
    only = None if chunks is None else _chunks(chunks)
    try:
        with show.progress() as progress:
            found = campaign.run(
                runs, out=out, jobs=jobs, chunk=chunk, only=only, scheduler=scheduler, progress=progress
            )
    except FileError as error:
        if error.errno not in _full:
            raise
        raise typer.Exit(printing.complain(f"{error}; free some and call it again", FULL_DISK)) from None
    if as_json:
        printing.as_json(show.as_table(found))
    else:
        show.result(found)


@app.command()
def show(
    folder: Folder,
    against: Annotated[
        str | None, typer.Option(metavar="CELL", help="Compare the cells with this one, run by run.")
    ] = None,
    inputs: Annotated[bool, typer.Option("--inputs", help="Say which inputs matter.")] = False,
    as_json: Json = False,
) -> None:
    """Say what a folder holds: failures, statuses, quantiles, and the hashes of campaign and table.

    Examples: `gyrostat campaign show flown`, `gyrostat campaign show five --against recommended`,
    `gyrostat campaign show flown --inputs`
    """
    from gyrostat.campaign import CampaignResult
    from gyrostat.campaign import printing as show_

    found = CampaignResult(folder)
    if as_json:
        printing.as_json(show_.as_table(found))
        return
    show_.result(found)
    if against is not None:
        show_.comparison(found, against)
    if inputs:
        show_.sensitivities(found)
    show_.hashes(found)


@app.command()
def rerun(
    folder: Folder,
    run: Annotated[int, typer.Argument(min=0, help="Its number.")],
    cell: Annotated[str | None, typer.Option(help="Where there is a grid: which cell.")] = None,
    *,
    out: Annotated[
        Path | None, typer.Option(metavar="FILE.toml", help="Write the plain scenario that the run is.")
    ] = None,
) -> None:
    """Fly one run again, by itself, and hold it against its row; exit status 1 if they differ.

    Example: `gyrostat campaign rerun flown 1234 --out run1234.toml && gyrostat run run1234.toml --out page`
    """
    from gyrostat.campaign import CampaignResult
    from gyrostat.campaign import printing as show
    from gyrostat.experiment import Experiment

    found = CampaignResult(folder)
    campaign = found.campaign
    if not any(part.first <= run < part.end for part in found.parts()):
        raise InputError(f"{folder}: run {run} was not flown here; {found.runs} were")
    scenario = campaign.scenario(run, cell)
    if out is not None:
        scenario.to_toml(out)
    label = next(iter(campaign.cells)) if cell is None else cell
    measures = campaign.spec.measure or None
    flown = Experiment(scenario, measure=measures).fly(runs=1, first=run)
    again: dict[str, Any] = {name: float(x[0]) for name, x in flown.metrics.items()}
    again |= {"status": str(flown.status[0]), "t_end": float(flown.end_time[0])}
    if not show.rerun(found.row(run, label), again, run):
        raise typer.Exit(1)


@app.command()
def join(
    folders: Annotated[list[Path], typer.Argument(metavar="DIR...", help="Of one campaign.")],
    out: Annotated[Path | None, typer.Option(metavar="NEW", help="A new folder for all of their parts.")] = None,
) -> None:
    """Check that folders hold one campaign without gaps, and put them together.

    Example: `gyrostat campaign join node1 node2 --out all`
    """
    from gyrostat.campaign import join as join_
    from gyrostat.campaign import printing as show

    joined = join_(folders, out)
    if joined is None:
        typer.echo(f"{len(folders)} folders hold one campaign, without gaps")
    else:
        show.result(joined)


def report(
    folder: Folder,
    against: Annotated[
        str | None, typer.Option(metavar="CELL", help="Compare the cells with this one; the first if absent.")
    ] = None,
    out: Annotated[
        Path | None, typer.Option(metavar="PAGE.html", help="Instead of `report.html` in the folder.")
    ] = None,
) -> None:
    """Write the page of a flown campaign: one HTML file below 1 MB that needs no network, light and dark.

    It has failures with intervals, quantiles, cells run by run, failure rates by severity and onset, distributions,
    what matters, the worst ten with the command that flies each again, how flights ended, and what all of it rests on.
    The page of a folder of `gyrostat verify` has the verdict on top, and its evidence against runs; that of a folder of
    `gyrostat rare` its levels and replicates.

    Examples: `gyrostat report flown`, `gyrostat report five --against recommended --out five.html`
    """
    from gyrostat.campaign import CampaignResult
    from gyrostat.page.campaign import write_rare_page
    from gyrostat.verification.searched import Searched

    path = folder / "report.html" if out is None else out
    searched = Searched.read(folder)
    if searched is not None and not (folder / "manifest.json").exists():
        page = write_rare_page(path, folder, searched)
    else:
        page = CampaignResult(folder).to_html(path, against)
    typer.echo(f"page: {page}")


def _chunks(text: str) -> tuple[int, int]:
    a, colon, b = text.partition(":")
    if not colon or not all(part.isascii() and part.isdecimal() and len(part) < 13 for part in (a, b)):
        raise InputError(f"--chunks {text}: write A:B, for example --chunks 0:20")
    return int(a), int(b)


__all__ = ["FULL_DISK", "FirstCommand", "app", "report"]
