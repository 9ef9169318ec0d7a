# SPDX-License-Identifier: MIT
"""The words and tables of a page: how the run went, its metrics, its events, its scenario."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from html import escape

from gyrostat import toml
from gyrostat.metrics import UNITS
from gyrostat.page import marks
from gyrostat.results import Result
from gyrostat.scenario import Scenario

_most_events = 250
"""Rows of the table of single events; the table of counts holds all."""
_most_text = 20_000
"""Characters of a scenario that are shown."""


def shown(value: float | None, unit: str) -> str:
    """A metric as people read it: angles in degrees; a dash where there is none."""
    if value is None:
        return "–"
    return f"{math.degrees(value):.4g} deg" if unit == "rad" else f"{value:.4g} {unit}".rstrip()


def chips(result: Result) -> str:
    """How the run went, in a few words."""
    values = result.metrics.to_dict()
    onset = " after the last fault" if result.metrics.last_fault > 0.0 else ""
    parts = [] if result.completed else [("bad", "ended early", result.cause or result.status)]
    if values["pointing_error"] is not None:
        settled = values["settling_time"]
        parts.append(
            ("bad", "does not settle", "to 0.1 deg")
            if settled is None
            else ("", "settled", f"to 0.1 deg {settled:.4g} s{onset}")
        )
        parts.append(("", "pointing error", f"{shown(values['pointing_error'], 'rad')} (rms, last tenth)"))
    if values["saturated_fraction"] is not None:
        parts.append(("", "at a limit", f"{100.0 * values['saturated_fraction']:.3g} % of the time"))
    samples = "sample" if len(result) == 1 else "samples"
    parts.append(("", f"{len(result):,}".replace(",", " "), f"{samples} to {result.end_time:g} s"))
    return "".join(f'<span class="chip {c}"><b>{escape(name)}</b> {escape(text)}</span>' for c, name, text in parts)


def of_run(result: Result) -> str:
    """Metrics, events and scenario of one run."""
    parts = [
        ("Metrics", _metrics(result), ""),
        ("Events", _events(result), ""),
        ("Scenario", f"<pre>{escape(_text(result))}</pre>", "whole"),
    ]
    return "".join(f'<div class="{width}"><h2>{title}</h2>{body}</div>' for title, body, width in parts)


def of_runs(results: Mapping[str, Result]) -> str:
    """Metrics of several runs beside each other, and the scenario of each."""
    head, *rows = metric_rows(results)
    scenarios = "".join(
        f"<details><summary>{escape(label)}</summary><pre>{escape(_text(r, len(results)))}</pre></details>"
        for label, r in results.items()
    )
    parts = [("Metrics", table(head, rows)), ("Scenarios", scenarios)]
    return "".join(f'<div class="whole"><h2>{heading}</h2>{body}</div>' for heading, body in parts)


def metric_rows(results: Mapping[str, Result]) -> list[list[str]]:
    """A table of metrics as text, a row a run; the first row names the columns."""
    names = list(UNITS)
    early = any(not r.completed for r in results.values())
    rows = [["run", *(name.replace("_", " ") for name in names), *(["ended"] if early else [])]]
    for label, result in results.items():
        values = result.metrics.to_dict()
        ended = "as planned" if result.completed else f"{result.cause or result.status} ({result.end_time:g} s)"
        rows.append([label, *(shown(values[name], UNITS[name]) for name in names), *([ended] if early else [])])
    return rows


def _metrics(result: Result) -> str:
    values = result.metrics.to_dict()
    rows = [[name.replace("_", " "), shown(values[name], UNITS[name])] for name in UNITS]
    rows += [[f"integrator: {key.replace('_', ' ')}", f"{value}"] for key, value in result.statistics.items()]
    return table(("metric", "value"), rows)


def _events(result: Result) -> str:
    counted = [
        [name, str(n), f"{first:.6g} s", f"{last:.6g} s"] for name, n, first, last in sorted(marks.counts(result))
    ]
    faults = [[m.text, f"{m.t:g} s", f"{m.end:g} s"] for m in marks.faults(result)]
    parts = [table(("fault", "from", "to"), faults[:_most_events])] if faults else []
    parts += [table(("event", "times", "first", "last"), counted)] if counted else []
    if counted:
        single = [[f"{e.t:.6g} s", e.name, str(e.count), e.what] for e in result.events[:_most_events]]
        rest = len(result.events) - len(single)
        more = f'<p class="dim">{rest} later ones are in the saved result.</p>' if rest else ""
        parts.append(
            f"<details><summary>one by one</summary>{table(('time', 'event', 'count', 'of'), single)}{more}</details>"
        )
    return "<p></p>".join(parts) or '<p class="dim">None.</p>'


def scenario_text(result: Result) -> str:
    """The scenario of a result as a TOML file says it."""
    if isinstance(result.scenario, Scenario) and not result.scenario.python_components():
        return result.scenario.to_toml()
    return toml.write(result.description)


def _text(result: Result, share: int = 1) -> str:
    text = scenario_text(result)
    most = _most_text // share
    return text if len(text) <= most else f"{text[:most]}\n# ... {len(text) - most} more characters"


def table(head: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """Cells of text; the first row names the columns."""
    return f'<div class="wide tall"><table>{"".join(_lines(head, rows))}</table></div>'


def _lines(head: Sequence[str], rows: Sequence[Sequence[str]]) -> Iterator[str]:
    yield "<tr>" + "".join(f"<th>{escape(cell)}</th>" for cell in head) + "</tr>"
    for row in rows:
        yield "<tr>" + "".join(f"<td>{escape(cell)}</td>" for cell in row) + "</tr>\n"
