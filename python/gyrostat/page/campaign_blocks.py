# SPDX-License-Identifier: MIT
"""The words and tables of the page of a campaign."""

from __future__ import annotations

import math
import re
from collections import Counter
from html import escape
from typing import Any

import numpy as np
from scipy import stats

from gyrostat import toml
from gyrostat.campaign.comparing import compare
from gyrostat.campaign.flights import unknown_cell
from gyrostat.campaign.printing import rerun_command
from gyrostat.campaign.results import CampaignResult
from gyrostat.campaign.rows import Rows
from gyrostat.campaign.sampled_faults import NONE
from gyrostat.page.tables import table
from gyrostat.verification.requirements import Report, in_words
from gyrostat.verification.sequential import quantile_interval, rate_interval

LEVELS = (0.5, 0.95, 0.99)
_worst_flights = 10
_most_causes = 20
_numbers = re.compile(r"-?\d+(?:\.\d+)?(?:e[+-]?\d+)?")
"""By which the causes of flights differ; they are counted without."""
_most_text = 20_000


def note(text: str) -> str:
    """What a block says of itself."""
    return f'<p class="dim">{escape(text)}</p>'


def percent(rate: float) -> str:
    """Three digits."""
    return f"{100.0 * rate:.3g} %"


def called(cell: str) -> str:
    """A cell by its label."""
    return cell or "all flights"


def chips(rows: Rows, report: Report | None) -> str:
    """How it went, in a few words."""
    found = rows.found
    counts = found.counts.values()
    parts: list[tuple[str, str, str]] = []
    if report is not None:
        parts.append((_colour(report.outcome), report.outcome, f"after {report.runs} runs"))
    parts.append(("", f"{found.runs}", "runs" + (f" in {len(counts)} cells" if len(counts) > 1 else "")))
    parts.append(("", f"{sum(c.failures for c in counts)}", "failures"))
    if found.missing:
        parts.append(("bad", "unfinished", f"{int(found.manifest['runs'])} runs were wanted"))
    return "".join(f'<span class="chip {c}"><b>{escape(name)}</b> {escape(text)}</span>' for c, name, text in parts)


def _colour(outcome: str) -> str:
    return {"PASS": "good", "FAIL": "bad"}.get(outcome, "")


def verdict(report: Report) -> str:
    """Each requirement with its limit, interval, runs and evidence."""
    lines = []
    for j in report.judgements:
        v, r = j.verdict, j.requirement
        low, high = v.interval
        wanted = f"failures at most {v.limit:.3g}"
        if r.percentile is not None:
            wanted = f"{percent(r.percentile.level)} of {r.percentile.of} at most {r.percentile.at_most:.4g}"
        needed = "" if j.needed is None else in_words(j.needed.median)
        lines.append(
            [
                j.name,
                f"{v.outcome} at run {v.runs}",
                r.text,
                str(v.failures),
                f"{low:.3g} to {high:.3g}",
                f"{wanted}, confidence {r.confidence:g}",
                f"{_evidence(v.log_e_pass)} / {_evidence(v.log_e_fail)}",
                needed,
            ]
        )
    head = (
        "requirement",
        "verdict",
        "says",
        "failures",
        "probability",
        "wanted",
        "evidence PASS / FAIL",
        "runs needed",
    )
    said = f"{report.outcome}: {report.runs} of at most {report.max_runs} runs."
    return note(said) + table(head, lines)


def _evidence(log: float) -> str:
    return "0" if log == -math.inf else f"{math.exp(log):.3g}" if log < 50 else f"e^{log:.0f}"


def identity(rows: Rows) -> str:
    """What was flown and how it is flown again."""
    found = rows.found
    wanted = int(found.manifest["runs"])
    told = found.manifest["resolved"]
    lines = [
        ["identity", found.identity],
        ["rows", found.table_hash],
        ["gyrostat", f"{told['gyrostat']}, numpy {told['numpy']}, scipy {told['scipy']}"],
        ["seed, sampling", f"{rows.spec['seed']}, {rows.spec['sampling']}"],
        ["runs", f"{found.runs} of {wanted}"],
        ["command", f"gyrostat campaign campaign.toml --runs {wanted} --out {found.folder.name}"],
    ]
    text = _file(found)
    shown = text if len(text) <= _most_text else f"{text[:_most_text]}\n# ... {len(text) - _most_text} more characters"
    return (
        table(("what", "is"), lines) + f"<details><summary>campaign.toml</summary><pre>{escape(shown)}</pre></details>"
    )


def _file(found: CampaignResult) -> str:
    tables = found.manifest["campaign"]
    return "# flown with Python components, which no file can hold\n" if tables is None else toml.write(tables)


def rate(rows: Rows, cell: str) -> tuple[float, float]:
    """Interval of a failure rate, 95 %: valid at every run, or, for replicates of a net, Student's over them."""
    counts = rows.found.counts[cell]
    if rows.independent:
        return rate_interval(counts.runs, counts.failures)
    points = int(rows.spec["points"])
    if not rows.whole or counts.runs < 2 * points:
        return 0.0, 1.0
    replicates = counts.runs // points
    lost = ~rows.cells[cell]["success"].astype(bool)[: replicates * points]
    rates = lost.reshape(replicates, points).mean(axis=1)
    half = float(stats.t.ppf(0.975, replicates - 1) * rates.std(ddof=1) / math.sqrt(replicates))
    return max(float(rates.mean()) - half, 0.0), min(float(rates.mean()) + half, 1.0)


def cells(rows: Rows) -> str:
    """Failures of each cell with the interval of its rate."""
    lines = []
    for label, c in rows.found.counts.items():
        low, high = rate(rows, label)
        share = c.failures / c.runs if c.runs else math.nan
        lines.append(
            [called(label), str(c.runs), str(c.failures), percent(share), f"{percent(low)} to {percent(high)}"]
        )
    return table(("cell", "flights", "failures", "rate", "95 % interval"), lines)


def quantiles(rows: Rows) -> str:
    """Median, 95 % and 99 % of each measure: settling and its like first."""
    names = rows.times + [name for name in rows.measures if name not in rows.times]
    exact = rows.whole and rows.independent
    lines = [
        [name, called(label), *(_quantile(rows, label, name, level, exact=exact) for level in LEVELS)]
        for name in names
        for label in rows.found.counts
    ]
    why = (
        "With 95 % intervals from order statistics that are valid at every run; a flight without a value, or that "
        "ended early, counts as larger than every number."
        if exact
        else "To 0.5 %, of all flights, without intervals: these need independent runs and the rows of all of them."
    )
    return note(why) + table(("measure", "cell", *(percent(level) for level in LEVELS)), lines)


def _quantile(rows: Rows, cell: str, measure: str, level: float, *, exact: bool) -> str:
    if not exact:
        return _value(rows.found.counts[cell].sketches[measure].quantile(level))
    x = rows.values(cell, measure)
    low, high = quantile_interval(x, level)
    ordered = np.sort(x)
    middle = float(ordered[math.ceil(level * len(x)) - 1]) if len(x) else math.nan
    return f"{_value(middle)} ({_value(low)} to {_value(high)})"


def _value(x: float) -> str:
    return "none" if math.isinf(x) and x > 0 else "–" if not math.isfinite(x) else f"{x:.4g}"


def paired(rows: Rows, against: str | None) -> str:
    """Cells against one of them: the same draws, the same noise."""
    found = rows.found
    labels = list(found.counts)
    base = labels[0] if against is None else against
    if base not in labels:
        raise unknown_cell(base, labels)
    if len(labels) < 2:
        return ""
    if not (rows.whole and rows.independent):
        return note("Cells are compared run by run where runs are independent and all of their rows are kept.")
    lines = []
    for c in compare(found, base):
        if c.cell != base:
            difference = (c.lost - c.saved) / c.runs
            lines.append(
                [
                    c.cell,
                    f"{100 * difference:+.3g} %",
                    str(c.lost),
                    str(c.saved),
                    f"{c.p:.2g}",
                    *_later(rows, base, c.cell),
                ]
            )
    times = [f"median change of {name}" for name in rows.times]
    said = f"Each against {base}: every cell flew the same draws with the same noise."
    head = ("cell", "rate less that of the reference", "lost alone", "saved alone", "McNemar's exact p", *times)
    return note(said) + table(head, lines)


def _later(rows: Rows, base: str, cell: str) -> list[str]:
    """Median of the change of each time over runs in which both have one."""
    said = []
    for name in rows.times:
        a, b = rows.values(base, name), rows.values(cell, name)
        both = np.isfinite(a) & np.isfinite(b)
        said.append(f"{np.median(b[both] - a[both]):+.3g} ({int(both.sum())} runs)" if both.any() else "–")
    return said


def worst(rows: Rows) -> str:
    """The flights with the largest margins, or the first failures, with what was drawn and the command for each."""
    listed: list[tuple[float, int, str, int]] = []
    for label, columns in rows.cells.items():
        runs, lost = columns["run"].astype(int), ~columns["success"].astype(bool)
        margins = np.nan_to_num(columns["margin"].astype(float)) if "margin" in columns else np.zeros(len(runs))
        flew = np.flatnonzero((columns["status"] != "refused") & (lost | ("margin" in columns)))
        order = flew[np.lexsort((runs[flew], -margins[flew]))][:_worst_flights]
        listed += [(-float(margins[k]), int(runs[k]), label, int(k)) for k in order]
    if not listed:
        return note("No flight was lost.")
    lines = []
    for _, run, label, k in sorted(listed)[:_worst_flights]:
        row = {name: x[k] for name, x in rows.cells[label].items()}
        margin = row.get("margin", math.nan)
        lines.append(
            [
                str(run),
                called(label),
                "–" if math.isnan(margin) else f"{margin:.3g}",
                str(row["status"]),
                str(row["cause"] or ""),
                _drawn_faults(row),
                rerun_command(rows.found.folder, run, label),
                ", ".join(f"{name} = {_said(row[name])}" for name in rows.inputs() if not name.startswith("fault.")),
            ]
        )
    said = "Of flights that flew, by margin, or in order of run where there is none."
    head = ("run", "cell", "margin", "status", "cause", "faults", "again", "drawn")
    return note(said) + table(head, lines)


def _drawn_faults(row: dict[str, Any]) -> str:
    said = []
    for name, kind in row.items():
        if name.endswith(".kind") and name.startswith("fault.") and kind != NONE:
            prefix = name[: -len(".kind")]
            who = row.get(f"{prefix}.actuator")
            values = [f"{n.rpartition('.')[2]} {x:.3g}" for n, x in row.items() if n.startswith(f"{prefix}.{kind}.")]
            on = "" if who is None else f" on {int(who)}"
            of = prefix.split(".")[1]
            said.append(" ".join([f"{of}: {kind}{on} at {row[f'{prefix}.t_on']:.3g} s", *values]))
    return "; ".join(said)


def _said(value: Any) -> str:
    return value if isinstance(value, str) else f"{value:.4g}"


def statuses(rows: Rows) -> str:
    """How many flights ended how, and why."""
    names = sorted({s for c in rows.found.counts.values() for s in c.status})
    counts = [
        [called(label), *(str(c.status.get(name, 0)) for name in names)] for label, c in rows.found.counts.items()
    ]
    causes = Counter(
        (str(status), _numbers.sub("…", str(cause)))
        for columns in rows.cells.values()
        for status, cause in zip(columns["status"], columns["cause"], strict=True)
        if cause is not None
    )
    listed = [[str(n), status, cause] for (status, cause), n in causes.most_common(_most_causes)]
    return table(("cell", *names), counts) + (table(("flights", "status", "cause"), listed) if listed else "")


def assumptions(rows: Rows) -> str:
    """In words."""
    spec = rows.spec
    success = ", ".join(f"{name} {_bounds(c)}" for name, c in spec["success"].items()) or "that the flight completes"
    margin = (spec.get("margin") or {}).get("measure") or (
        next(iter(spec["success"])) if len(spec["success"]) == 1 else None
    )
    said = [
        _independence(rows),
        "The distributions of inputs and faults are those of the file, assumed and not measured.",
        "Vehicle, actuators, sensors and faults are those of the simulated truth; what it leaves out no flight shows.",
        f"A flight is a success by {success}; one that ended early, was refused or raised is none.",
    ]
    if margin and any("margin" in c for c in rows.cells.values()):
        said.append(
            f"The margin is the distance of '{margin}' from its limit, in decades where its scale is 'log', positive "
            "where lost; of a flight that ended early, 3 + (1 - end / duration)."
        )
    if rows.independent:
        said.append(
            "Intervals of rates and quantiles hold at 95 % each, however often one looks (Robbins' "
            "mixture). They are not corrected for the number of cells and measures shown."
        )
    return "<ul>" + "".join(f"<li>{escape(line)}</li>" for line in said) + "</ul>"


def _independence(rows: Rows) -> str:
    if rows.independent:
        return "Runs are independent of each other: each has its own random numbers."
    return (
        f"Runs are points of a net ({rows.spec['sampling']}) and depend on each other; only its replicates are "
        "independent: intervals are Student's over them, and hold for the runs that were chosen beforehand."
    )


def _bounds(criterion: dict[str, Any]) -> str:
    return " and ".join(f"{k} {criterion[k]:g}" for k in ("below", "above") if criterion.get(k) is not None)


__all__ = [
    "assumptions",
    "called",
    "cells",
    "chips",
    "identity",
    "note",
    "paired",
    "percent",
    "quantiles",
    "rate",
    "statuses",
    "verdict",
    "worst",
]
