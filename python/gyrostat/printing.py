# SPDX-License-Identifier: MIT
"""What the command ``gyrostat`` prints: lines, columns, JSON and a bar of progress."""

from __future__ import annotations

import json
import math
import sys
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any

import typer

from gyrostat.components import range_text
from gyrostat.text import number

if TYPE_CHECKING:
    from gyrostat.design import Design, DesignReport, Finding
    from gyrostat.design.linear_loop import Axis
    from gyrostat.model import Model
    from gyrostat.papers import Reproduction, Row
    from gyrostat.results import Result


def names(families: Mapping[str, Sequence[str]]) -> None:
    """A line a family."""
    for name, members in families.items():
        typer.echo(f"{name:12} {', '.join(members)}")


def component(info: Mapping[str, Any]) -> None:
    """A component with its parameters."""
    typer.echo(f"{info['family']} {info['name']}")
    rows = [
        (
            p["name"],
            "required" if p["required"] else "-" if p["default"] is None else _short(p["default"]),
            p["unit"],
            "|".join(p["options"]) or range_text(p),
            p["meaning"] + (" (default scales with the vehicle)" if p["scales"] else ""),
        )
        for p in info["params"]
    ]
    columns(rows or [("no parameters", "", "", "", "")])


def run(result: Result, remarks: Sequence[str]) -> None:
    """How a run went: a line, and another one when its integrator was a poor choice."""
    typer.echo("; ".join([_summary(result), *remarks]))
    if (note := _costly_integrator(result)) is not None:
        typer.echo(note)


def checks(rows: Sequence[Mapping[str, Any]], remarks: Sequence[str], findings: Sequence[Finding]) -> None:
    """What a check of a scenario found."""
    lines: list[tuple[str, ...]] = [
        (r["where"], r["name"], "ok" if r["ok"] else f"{r['code']}: {_relation(r)}") for r in rows
    ]
    lines += [("scenario", "remark", text) for text in remarks]
    columns([*lines, *_finding_lines(findings)])


def designs(known: Mapping[str, Design]) -> None:
    """Every design with its options; those that share them one after the other, with the options once."""
    shared: dict[type[Model], list[str]] = {}
    for key, one in known.items():
        shared.setdefault(one.options, []).append(key)
    for options, keys in shared.items():
        for key in keys:
            typer.echo(f"{key}: {known[key].summary}")
        columns([("", k, _described(f)) for k, f in options.model_fields.items()])


def design(report: DesignReport) -> None:
    """Conditions of a design, the margins about each axis, then its components as they stand in a scenario."""
    columns(_finding_lines(report.findings))
    if report.axes:
        typer.echo("")
        _axes(report.axes)
    for role, table in report.components.items():
        typer.echo(f"\n[{role}]")
        for key, value in table.items():
            typer.echo(f"{key} = {json.dumps(value)}")


def _axes(axes: Sequence[Axis]) -> None:
    """Margins about each principal axis."""
    rows = [("J, kg m^2", "rad/s", "damping", "crossover", "phase, deg", "gain up", "gain down", "delay, s", "samples")]
    for a in axes:
        numbers = (a.J, a.frequency, a.damping, a.crossover, math.degrees(a.phase_margin), a.gain_up, a.gain_down)
        rows.append(tuple(f"{x:.4g}" for x in (*numbers, a.delay_margin, a.delay_samples)))  # type: ignore[arg-type]
    columns(rows)


def reproductions(found: Sequence[Reproduction], page: Path | None, *, briefly: bool) -> None:
    """Every claim of some studies, or, when each has told its line, what was missed; and where the report is."""
    if briefly:
        missed(found)
    else:
        for one in found:
            reproduction(one)
    if page is not None:
        typer.echo(f"report: {page}")


def reproduction(found: Reproduction) -> None:
    """Every claim of a study, repeats over seeds in one line, and how many are accepted."""
    from gyrostat.papers import folded

    rows = [("claim", "published", "measured", "accepted", "", "published statement")]
    for experiment in folded(found):
        for row in experiment.rows:
            low, high = (number(end) for end in row.claim.accept)
            rows.append(
                (
                    row.claim.id,
                    number(row.claim.published),
                    _measured(row),
                    f"[{low}, {high}]",
                    "ok" if row.ok else "FAILED",
                    ": ".join([row.verdict, *_reasons(row)]),
                )
            )
    columns(rows)
    tally(found)


def _reasons(row: Row) -> list[str]:
    """Why something was not measured, where that is so."""
    told = "; ".join(text.removeprefix("not measured: ") for text in row.troubles)
    return [told] if told else []


def _measured(row: Row) -> str:
    """A number, and where it is that of several seeds their spread."""
    several = len(row.evaluations)
    if several == 1 or not row.measured:
        return number(row.first.measured)
    low, high = number(min(row.measured)), number(max(row.measured))
    return f"{number(row.first.measured)} ({len(row.measured)} seeds: {low if low == high else f'{low} ... {high}'})"


def tally(found: Reproduction) -> None:
    """A study in one line."""
    from gyrostat.papers import Tally, folded

    t = Tally.of(folded(found))
    text = f"{found.paper.id}: {t.accepted} of {t.claims} claims accepted"
    if t.holds or t.fails or t.open:
        undecided = f", {t.open} cannot be said" if t.open else ""
        text += f"; of its statements {t.holds} hold, {t.fails} do not{undecided}"
    typer.echo(text)


MOST_MISSED = 20
"""Claims that a short report of several studies names."""


def missed(found: Sequence[Reproduction]) -> None:
    """What is not accepted, and why, in a few lines."""
    from gyrostat.papers import folded

    rows = [(r.paper.id, row) for r in found for e in folded(r) for row in e.rows if not row.ok]
    for paper, row in rows[:MOST_MISSED]:
        low, high = (number(end) for end in row.claim.accept)
        why = "; ".join(row.troubles) or f"measured {_measured(row)}, accepted [{low}, {high}]"
        typer.echo(f"FAILED {paper} {row.claim.id}: {why}")
    if len(rows) > MOST_MISSED:
        typer.echo(f"FAILED {len(rows) - MOST_MISSED} more; --verbose prints all")


def columns(rows: Sequence[Sequence[str]]) -> None:
    """Cells under each other; the last of a row may be missing."""
    most = max(len(r) for r in rows)
    widths = [max((len(r[i]) for r in rows if i < len(r)), default=0) for i in range(most)]
    for row in rows:
        typer.echo("  ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=False)).rstrip())


def as_json(value: Any) -> None:
    """Indented JSON."""
    typer.echo(json.dumps(_finite(value), indent=2, allow_nan=False))


def complain(text: str, status: int) -> int:
    """One line on stderr; the status is handed on."""
    with suppress(OSError):  # nobody listens there either
        typer.echo(f"error: {text}", err=True)
    return status


def warning(message: Warning | str) -> None:
    """One line on stderr, without the line of code that the user has not written."""
    with suppress(OSError):
        typer.echo(f"warning: {message}", err=True)


@contextmanager
def progress(label: str, patience: float = 1.0) -> Iterator[Callable[[float], None]]:
    """A bar on stderr, if that is a terminal, that appears when the work takes longer than `patience` seconds."""
    started = time.monotonic()
    bar: Any = None
    task: Any = None

    def report(fraction: float) -> None:
        nonlocal bar, task, patience
        if bar is None:
            if time.monotonic() - started < patience or not sys.stderr.isatty():
                return
            from rich.console import Console
            from rich.progress import Progress

            console = Console(stderr=True)
            if not console.is_interactive:  # a terminal that cannot move its cursor: rich would print lines
                patience = math.inf
                return
            bar = Progress(console=console, transient=True)
            task = bar.add_task(label, total=1.0)
            bar.start()
        bar.update(task, completed=fraction)

    try:
        yield report
    finally:
        if bar is not None:
            bar.stop()


def _summary(result: Result) -> str:
    """How a run went, in one line."""
    values = result.metrics.to_dict()
    after = " after the last fault" if result.metrics.last_fault > 0.0 else ""
    parts = []
    if values["pointing_error"] is not None:
        settled = values["settling_time"]
        parts.append("does not settle to 0.1 deg" if settled is None else f"settled to 0.1 deg {settled:.1f} s{after}")
        parts.append(f"pointing error {math.degrees(values['pointing_error']):.3g} deg (rms, last tenth)")
    if values["saturated_fraction"] is not None:
        parts.append(f"at a limit {100 * values['saturated_fraction']:.3g} % of the time")
    parts += _guarded(result)
    if "estimate.effectiveness" in result.channels and "truth.effectiveness" in result.channels:
        estimated, true = result["estimate.effectiveness"][-1], result["truth.effectiveness"][-1]
        parts += [
            f"actuator {i} estimated at {e:.2f}, true {t:.2f}"
            for i, (e, t) in enumerate(zip(estimated, true, strict=True))
            if e != 1.0
        ]
    if "detector.declared" in result.channels:
        parts += _declared(result)
    return "; ".join(parts) or f"{len(result)} samples to {result.end_time:g} s"


def _guarded(result: Result) -> list[str]:
    """What the guard had to do, from when on, and how often."""
    done = [e for e in result.events if e.name.startswith("guard.")]
    samples = max(int(result.statistics.get("samples", len(result))), 1)
    return [
        f"{e.name.removeprefix('guard.')} {_guard_words[e.name]} at {100 * e.count / samples:.3g} % of the samples, "
        f"first at {e.t:g} s"
        for e in done
    ]


_guard_words = {f"guard.{name}": "not measured" for name in ("attitude", "rate", "momentum")}
_guard_words |= {
    f"guard.{name}": "started again" for name in ("navigator", "observer", "detector", "controller", "allocator")
}
_guard_words |= {"guard.reference": "held", "guard.command": "held"}


def _costly_integrator(result: Result) -> str | None:
    """A line when CVODE took more than four steps where `auto` takes about one: such a run takes ten times as long."""
    work = result.statistics
    pieces = max(1, work["pieces"])
    if work["restarts"] == 0 or work["steps"] <= 4 * pieces:
        return None
    return (
        f"cvode took {work['steps'] / pieces:.1f} steps where one would do: its history does not fit new commands; "
        'integrator = "auto" would have flown this in less than a tenth of the time'
    )


def _declared(result: Result) -> list[str]:
    """When the detector declared which actuators, and how long after a fault of theirs; a count when it was often."""
    from gyrostat.detection import declarations, true_changes

    found = declarations(result)
    if len(found) > 5:
        return [f"{len(found)} faults declared"]
    every_sample = len(result) > 1 and result.t[1] < 1.5 * float(result.description["dt"])
    faults = true_changes(result, 0.05) if every_sample and "truth.effectiveness" in result.channels else []
    parts = []
    for t, mask in found:
        named = [i for i in range(mask.bit_length()) if mask >> i & 1]
        earlier = [at for at, actuator, _ in faults if actuator in named and at <= t]
        after = f", {t - earlier[-1]:.2f} s after a fault of it" if earlier else ""
        parts.append(f"actuator {', '.join(map(str, named))} declared at {t:.2f} s{after}")
    return parts


def _finding_lines(findings: Sequence[Finding]) -> list[tuple[str, ...]]:
    verdicts = {True: "ok: ", False: "fails: ", None: ""}
    return [(f.where, f.name, verdicts[f.ok] + f.text) for f in findings]


def _described(option: Any) -> str:
    """Meaning of an option of a design, with its default."""
    if option.is_required():
        return f"{option.description} (must be given)"
    return str(option.description) + ("" if option.default is None else f" (default {option.default:g})")


def _relation(row: Mapping[str, Any]) -> str:
    return f"{row['quantity']} = {row['value']:g}, must be {row['relation']} {row['limit']:g}"


def _short(value: Any) -> str:
    if isinstance(value, list):
        return f"[{', '.join(_short(v) for v in value)}]"
    return f"{value:g}" if isinstance(value, float) else str(value)


def _finite(value: Any) -> Any:
    """JSON knows no infinity: an open end is null."""
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    if isinstance(value, Mapping):
        return {k: _finite(v) for k, v in value.items()}
    if isinstance(value, list | tuple):
        return [_finite(v) for v in value]
    return value


__all__ = [
    "as_json",
    "checks",
    "columns",
    "complain",
    "component",
    "design",
    "designs",
    "missed",
    "names",
    "progress",
    "reproduction",
    "reproductions",
    "run",
    "tally",
]
