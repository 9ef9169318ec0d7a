# SPDX-License-Identifier: MIT
"""The commands ``gyrostat verify``, ``rare``, ``worst`` and ``tune``. Page: docs/verification.md."""

from __future__ import annotations

import math
import shlex
from collections.abc import Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from gyrostat import printing
from gyrostat.errors import InputError
from gyrostat.files import made_folder, write_text

if TYPE_CHECKING:
    from gyrostat.scenario import Scenario
    from gyrostat.verification.flown import Gain
    from gyrostat.verification.rare import Rare
    from gyrostat.verification.requirements import Judgement, Report
    from gyrostat.verification.tune import Tuned

CampaignName = Annotated[str, typer.Argument(metavar="CAMPAIGN", help="A TOML file, or a shipped campaign.")]
Cell = Annotated[str | None, typer.Option(help="Where there is a grid: which cell.")]
Jobs = Annotated[int | None, typer.Option(min=1, help="Threads; as many as there are cores if absent.")]
Json = Annotated[bool, typer.Option("--json", help="Print JSON.")]
Seed = Annotated[int, typer.Option(min=0, help="Of the search.")]


def register(app: typer.Typer) -> None:
    """Add the commands to the command line."""
    for command in (verify, rare, worst, tune):
        app.command()(command)


def verify(
    requirement: Annotated[
        str,
        typer.Argument(
            metavar="FILE", help="A TOML file that names a campaign and requirements on it, or a shipped one."
        ),
    ],
    out: Annotated[Path, typer.Option(metavar="DIR", help="Folder of the campaign: a new one, or one to go on with.")],
    *,
    runs: Annotated[int | None, typer.Option(min=1, help="At most, instead of the file's max_runs.")] = None,
    jobs: Jobs = None,
    as_json: Json = False,
) -> None:
    """Fly a campaign until its requirements PASS or FAIL, or its runs are used up.

    The verdict is that of looking after every run: it stays valid however often one looks, and the same command goes
    on. Exit status 0 PASS, 1 FAIL, 4 UNDECIDED.

    Examples: `gyrostat verify requirement.toml --out flown`, `gyrostat verify pointing_ftc --out ftc`
    """
    from gyrostat.campaign import printing as show
    from gyrostat.verification.requirements import verify as judge

    with show.progress() as progress:
        report = judge(requirement, out, runs=runs, jobs=jobs, progress=progress)
    if as_json:
        printing.as_json(_report(report))
    else:
        _print_report(report)
    raise typer.Exit(report.exit_status)


def rare(
    campaign: CampaignName,
    *,
    cell: Cell = None,
    population: Annotated[int, typer.Option(min=20, help="Flights of a replicate at a level; a multiple of 10.")] = 500,
    replicates: Annotated[int, typer.Option(min=2, help="Independent estimates at fixed levels.")] = 8,
    seed: Seed = 0,
    jobs: Jobs = None,
    out: Annotated[
        Path | None,
        typer.Option(
            metavar="DIR", help="Remembers what was flown, so that it can be taken up, and holds lost flights."
        ),
    ] = None,
    as_json: Json = False,
) -> None:
    """Estimate a probability of loss too small for plain flights, by subset simulation.

    Exit status 4 when it stalled or did not converge.

    Example: `gyrostat rare my_campaign.toml --out rare`
    """
    from gyrostat.campaign import Campaign
    from gyrostat.verification import flown
    from gyrostat.verification.searched import to_dict

    loaded = Campaign.load(campaign)
    search = partial(flown.rare, loaded, cell=cell, seed=seed, population=population, replicates=replicates, jobs=jobs)
    written: list[str] = []
    if out is None:
        found = search()
    else:
        with made_folder(out):
            found = search(out=out)
            written = _written(
                out,
                [
                    (f"lost{i}", flown.scenario(loaded, f.z, f.number, cell, f.versions))
                    for i, f in enumerate(found.lost)
                ],
            )
    if as_json:
        printing.as_json(to_dict(found) | {"again": written})
    else:
        _print_rare(found, written)
    if found.status != "converged":
        raise typer.Exit(4)


def worst(
    campaign: CampaignName,
    *,
    cell: Cell = None,
    size: Annotated[
        str | None, typer.Option(help="A sum of columns, like `a + b - c`; absent: how unlikely the flight is.")
    ] = None,
    budget: Annotated[int, typer.Option(min=50, help="Flights at most, before shrinking.")] = 2000,
    seed: Seed = 0,
    jobs: Jobs = None,
    out: Annotated[
        Path | None,
        typer.Option(
            metavar="DIR", help="Remembers what was flown, so that it can be taken up, and holds the flights."
        ),
    ] = None,
    as_json: Json = False,
) -> None:
    """Find the smallest fault or disturbance that loses a flight, and say what of it is needed.

    Exit status 4 when no flight was lost.

    Example: `gyrostat worst my_campaign.toml --budget 1000 --out worst`
    """
    from gyrostat.campaign import Campaign
    from gyrostat.verification import flown

    loaded = Campaign.load(campaign)
    search = partial(flown.worst, loaded, cell=cell, size=size, seed=seed, budget=budget, jobs=jobs)
    written: list[str] = []
    if out is None:
        got = search()
    else:
        with made_folder(out):
            got = search(out=out)
            z, number = got.found.z, got.found.number
            flights = [("found", z), ("shrunk", got.shrunk)] if got.found.lost else [("nearest", z)]
            written = _written(out, [(n, flown.scenario(loaded, z, number, cell)) for n, z in flights])
    found, left, words = got.found, got.shrunk, got.needs
    if as_json:
        told = {"lost": found.lost, "size": found.size, "margin": found.margin, "flights": found.flights}
        told |= {"first_lost": found.first_lost, "z": found.z.tolist(), "shrunk": left.tolist()}
        printing.as_json(told | {"needs": list(words), "again": written})
    elif found.lost:
        typer.echo(f"lost: size {found.size:.4g}, margin {found.margin:.3g}, after {found.flights} flights")
        typer.echo(
            f"first lost flight: number {found.first_lost}; ends: {', '.join(f'{s:.4g}' for s in found.restarts)}"
        )
        typer.echo("needs " + ("; ".join(words) if words else "nothing: the nominal flight is lost with this noise"))
    else:
        typer.echo(f"no flight of {found.flights} was lost; the nearest has margin {found.margin:.3g}")
    if not as_json:
        _lines(written)
    if not found.lost:
        raise typer.Exit(4)


def tune(
    campaign: CampaignName,
    *,
    parameters: Annotated[
        list[str] | None,
        typer.Option("--vary", metavar="KEY", help="A gain, like `controller.k1`; absent: all of them. Repeatable."),
    ] = None,
    effort: Annotated[
        float, typer.Option(help="Largest energy and command variation, over the published ones; `inf`: free.")
    ] = 1.4,
    train: Annotated[int, typer.Option(min=10, help="Flights to tune on.")] = 100,
    held_out: Annotated[int, typer.Option(min=10, help="Flights to report on.")] = 200,
    budget: Annotated[int, typer.Option(min=10, help="Sets of gains at most.")] = 150,
    seed: Seed = 0,
    jobs: Jobs = None,
    out: Annotated[
        Path | None, typer.Option(metavar="DIR", help="Gets gains.toml and trade.png, effort against settling.")
    ] = None,
    as_json: Json = False,
) -> None:
    """Tune gains on common flights: the slowest tenth settles faster, at an effort that is held.

    Example: `gyrostat tune my_campaign.toml --vary controller.k1 --vary controller.k2 --out tuned`
    """
    from gyrostat.campaign import Campaign
    from gyrostat.verification import flown

    loaded = Campaign.load(campaign)
    known = flown.parameters_of(loaded.base)
    chosen = parameters or list(known)
    if not chosen:
        raise InputError("tune: the scenario has no gain to tune")
    found = flown.tune(
        loaded, chosen, effort=effort, train=train, held_out=held_out, budget=budget, seed=seed, jobs=jobs
    )
    values = {key: flown.scaled(known[key], float(f)) for key, f in zip(chosen, found.factors, strict=True)}
    if out is not None:
        with made_folder(out):
            write_text(out / "gains.toml", _gains(values, loaded.base))
            flown.draw_trade(found, out / "trade.png")
    if as_json:
        printing.as_json(_tuned(found, values))
        return
    _print_tuned(found, known, values)
    typer.echo("\n" + _gains(values, loaded.base).rstrip())


def _gains(values: dict[str, Gain], scenario: Scenario) -> str:
    """Tables to paste: each component with its type, as it may stand nowhere in the scenario."""
    from gyrostat import toml

    resolved, tables = scenario.resolve(), dict[str, dict[str, Any]]()
    for key, value in values.items():
        role, _, name = key.partition(".")
        tables.setdefault(role, {"type": resolved[role]["type"]})[name] = value
    return toml.write(tables)


def _written(out: Path, scenarios: Sequence[tuple[str, Any]]) -> list[str]:
    """Scenario files, and the command that flies each."""
    commands = []
    for name, scenario in scenarios:
        scenario.to_toml(out / f"{name}.toml")
        commands.append(f"gyrostat run {shlex.quote(str(out / f'{name}.toml'))}")
    return commands


def _lines(commands: Sequence[str]) -> None:
    for command in commands:
        typer.echo(f"  {command}")


def _rerun(report: Report, judgement: Judgement, run: int) -> str:
    from gyrostat.campaign.printing import rerun_command

    return rerun_command(report.folder, run, judgement.cell)


def _print_report(report: Report) -> None:
    from gyrostat.verification.requirements import in_words

    for j in report.judgements:
        v, r = j.verdict, j.requirement
        failures = f"{v.failures} failure{'' if v.failures == 1 else 's'}"
        at = f"{v.outcome} at run {v.runs}" if v.outcome != "UNDECIDED" else f"UNDECIDED after {v.runs} runs"
        typer.echo(f"{j.name}: {at}, {failures}" + (f"; {r.text}" if r.text else ""))
        low, high = v.interval
        typer.echo(
            f"  failure probability {low:.3g} to {high:.3g}, limit {v.limit:.3g}; evidence for PASS"
            f" {_evidence(v.log_e_pass)}, for FAIL {_evidence(v.log_e_fail)}"
        )
        if r.percentile is not None and j.quantile is not None:
            p = r.percentile
            low, high = j.quantile
            typer.echo(f"  {100 * p.level:g} % of {p.of}: {low:.4g} to {high:.4g}, limit {p.at_most:.4g}")
        if j.needed is not None:
            typer.echo(
                f"  runs still needed: {in_words(j.needed.median)} (10 to 90 %: {in_words(j.needed.low)} to "
                f"{in_words(j.needed.high)}; {100 * j.needed.passing:.0f} % end in PASS)"
            )
        if j.dominant:
            typer.echo("  most of it from: " + ", ".join(f"{name} {100 * s:.0f} %" for name, s in j.dominant))
        _lines([_rerun(report, j, run) for run in j.failing])
        if (more := j.lost - len(j.failing)) > 0:
            typer.echo(f"  and {more} more failing flights among the {report.runs} flown")
    typer.echo(f"{report.outcome}: {report.runs} of at most {report.max_runs} runs in {report.folder}")


def _evidence(log: float) -> str:
    return "0" if log == -math.inf else f"{math.exp(log):.3g}" if log < 50 else f"e^{log:.0f}"


def _report(report: Report) -> dict[str, Any]:
    return {
        "outcome": report.outcome,
        "runs": report.runs,
        "max_runs": report.max_runs,
        "folder": str(report.folder),
        "requirements": [
            {"id": j.requirement.id, "cell": j.cell, "outcome": j.verdict.outcome, "runs": j.verdict.runs,
             "failures": j.verdict.failures, "limit": j.verdict.limit, "interval": list(j.verdict.interval),
             "log_e_pass": j.verdict.log_e_pass,
             "log_e_fail": None if j.verdict.log_e_fail == -math.inf else j.verdict.log_e_fail,
             "quantile": None if j.quantile is None else [x if math.isfinite(x) else None for x in j.quantile],
             "needed": None if j.needed is None else {
                 k: x if math.isfinite(x) else None
                 for k, x in (("low", j.needed.low), ("median", j.needed.median), ("high", j.needed.high))
             },
             "dominant": dict(j.dominant), "lost": j.lost, "failing": [_rerun(report, j, run) for run in j.failing]}
            for j in report.judgements
        ],
    }  # fmt: skip


def _print_rare(found: Rare, written: Sequence[str]) -> None:
    low, high = found.interval
    if found.status == "stalled":
        typer.echo(
            f"stalled after {found.flights} flights: the margin does not rise any more; none of {found.population} "
            f"independent flights was lost: at most {found.bound:.3g} (95 %)"
        )
    elif found.status == "converged":
        typer.echo(
            f"probability {found.probability:.3g}, 95 % interval {low:.3g} to {high:.3g}; {found.flights} flights"
        )
    else:
        typer.echo(
            f"not converged: mean {found.probability:.3g} of {found.replicates.size} replicates that differ too much; "
            f"try --population {2 * found.population}; {found.flights} flights; independent flights say at most "
            f"{found.bound:.3g} (95 %)"
        )
    if found.replicates.size:
        typer.echo("replicates: " + ", ".join(f"{p:.3g}" for p in found.replicates))
    rows: list[tuple[str, ...]] = [("level", "margin above", "kept", "step", "accepted")]
    rows += [
        (str(i), f"{x.margin:.4g}", f"{100 * x.share:.1f} %", f"{x.step:.3f}", f"{100 * x.acceptance:.0f} %")
        for i, x in enumerate(found.levels, 1)
    ]
    printing.columns(rows)
    if written:
        typer.echo("likeliest lost flights:")
        _lines(written)


def _print_tuned(found: Tuned, known: dict[str, Gain], values: dict[str, Gain]) -> None:
    printing.columns(
        [("gain", "published", "tuned", "factor")]
        + [
            (key, _number(known[key]), _number(value), f"{f:.2f}")
            for (key, value), f in zip(values.items(), found.factors.tolist(), strict=True)
        ]
    )
    for name, c in (("train", found.train), ("held out", found.held_out)):
        (p95, q95), (p50, q50) = c.percentile(0.95), c.percentile(0.5)
        typer.echo(
            f"{name}, {c.before.size} flights: 95 % settle in {p95:.1f} -> {q95:.1f} s (change {c.interval[0]:+.1f} to "
            f"{c.interval[1]:+.1f}), median {p50:.1f} -> {q50:.1f} s; "
            f"energy x{c.energy:.2f}, variation x{c.variation:.2f}"
        )
    if found.overfit:
        typer.echo("held-out flights are slower than the tuned ones by more than a quarter: take more --train flights")
    typer.echo("trade, energy against the slowest tenth: "
               + ", ".join(f"x{t.energy:.2f} {t.worst_tenth:.1f} s" for t in found.trade()))  # fmt: skip


def _number(gain: Gain) -> str:
    """A number; of a vector or matrix the largest."""
    return f"largest {_largest(gain):.4g}" if isinstance(gain, list) else f"{gain:.4g}"


def _largest(gain: Gain) -> float:
    return max(map(_largest, gain)) if isinstance(gain, list) else abs(gain)


def _tuned(found: Tuned, values: dict[str, Gain]) -> dict[str, Any]:
    def told(c: Any) -> dict[str, Any]:
        quantiles = {f"{100 * q:g} %": c.percentile(q) for q in (0.5, 0.95)}
        return {**quantiles, "interval": c.interval, "energy": c.energy, "variation": c.variation}

    return {
        "values": values,
        "factors": found.factors.tolist(),
        "train": told(found.train),
        "held_out": told(found.held_out),
        "overfit": found.overfit,
        "evaluations": found.evaluations,
        "trade": [{"energy": t.energy, "worst_tenth": t.worst_tenth} for t in found.trade()],
    }


__all__ = ["register"]
