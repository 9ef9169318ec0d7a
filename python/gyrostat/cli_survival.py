# SPDX-License-Identifier: MIT
"""The command ``gyrostat survive``. Page: docs/campaigns.md."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer

from gyrostat import comparison, printing
from gyrostat.errors import InputError
from gyrostat.files import made_folder
from gyrostat.scenario import Scenario


def register(app: typer.Typer) -> None:
    """Add the command to the command line."""
    app.command()(survive)


def survive(
    scenario: Annotated[str, typer.Argument(help="A TOML file, or a shipped scenario.")],
    out: Annotated[Path, typer.Option(metavar="DIR", help="Gets survival.csv, survival.parquet and survival.png.")],
    *,
    stacks: Annotated[
        str | None, typer.Option(metavar="CAMPAIGN", help="Fly the stacks that are levels of its grid `stack`.")
    ] = None,
    vary: Annotated[
        list[str] | None,
        typer.Option("--vary", metavar="KEY=A,B,...", help="Stacks that differ in a key, as `compare` takes it."),
    ] = None,
    kinds: Annotated[
        list[str] | None, typer.Option("--kind", metavar="KIND", help="A kind of fault; all if absent. Repeatable.")
    ] = None,
    severities: Annotated[
        str, typer.Option(metavar="A,B,...", help="Shares of the effectiveness lost, or of the actuator's limit.")
    ] = "0.2,0.4,0.6,0.8,1",
    second: Annotated[bool, typer.Option("--second", help="And every other actuator after it.")] = False,
    limit: Annotated[float, typer.Option(help="Pointing error over the last tenth that is saved, rad.")] = 8.7e-3,
    torque: Annotated[
        float | None, typer.Option(help="Needed in every direction, N m; absent: the largest that disturbs.")
    ] = None,
    jobs: Annotated[int | None, typer.Option(min=1, help="Threads; as many as there are cores if absent.")] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print JSON.")] = False,
) -> None:
    """Fly every actuator in every fault: what was saved, beside what the actuators that are left could have.

    `saved` and `lost though possible` are flights after which there is torque enough in every direction; `impossible`
    and `saved though impossible` those after which there is not (a wheel that sticks may do no harm for a while).

    Examples: `gyrostat survive wheel2_degraded --stacks five_stacks --out map`,
    `gyrostat survive my.toml --kind dead --kind lock --second --out pairs`
    """
    from gyrostat.survival import KINDS, NONE
    from gyrostat.survival import survive as fly

    base = Scenario.load(scenario)
    chosen = _stacks(base, stacks, vary)
    sizes = _numbers(severities)
    with made_folder(out):
        with printing.progress(f"flying {scenario}") as progress:
            found = fly(
                base, chosen, kinds=kinds or KINDS, severities=sizes, second=second, limit=limit, torque=torque,
                jobs=jobs, progress=progress,
            )  # fmt: skip
        paths = found.save(out)
    if as_json:
        told = {stack: found.counts(stack) for stack in found.stacks}
        printing.as_json({"needed": found.needed, "stacks": told, "out": [str(p) for p in paths]})
        return
    rows: list[tuple[str, ...]] = []
    for stack in found.stacks:
        counts = found.counts(stack)
        rows = rows or [("stack", *counts)]
        rows.append((stack or scenario, *(str(n) for n in counts.values())))
    printing.columns(rows)
    for case in found.cases:
        if case.first.kind == NONE and not case.verdict.startswith("saved"):
            whose = case.stack or scenario
            typer.echo(f"{whose}: is lost without a fault, too: {case.error:.3g} rad of --limit {limit:g}", err=True)
    typer.echo(f"needed in every direction: {found.needed:.3g} N m; {', '.join(str(p) for p in paths)}")


def _stacks(base: Scenario, campaign: str | None, vary: list[str] | None) -> dict[str, Any] | None:
    if campaign is not None and vary:
        raise InputError("--stacks and --vary exclude each other")
    if vary:
        return dict(comparison.variants(base, dict(comparison.read_variation(text) for text in vary)))
    if campaign is None:
        return None
    from gyrostat.campaign import Campaign

    grids = {grid.name: grid.levels for grid in Campaign.load(campaign).spec.grid}
    if "stack" not in grids:
        raise InputError(f"--stacks {campaign}: has no grid 'stack'")
    return dict(grids["stack"])


def _numbers(text: str) -> list[float]:
    try:
        return [float(part) for part in text.split(",")]
    except ValueError:
        raise InputError(f"--severities {text}: numbers from 0 to 1, with commas between them, belong here") from None


__all__ = ["register"]
