# SPDX-License-Identifier: MIT
"""A static page for a reproduction: published against measured, with the figures. One file, no scripts, no network."""

from __future__ import annotations

import base64
import json
from collections.abc import Iterable, Sequence
from html import escape
from itertools import groupby
from pathlib import Path

from gyrostat._core import __version__
from gyrostat.files import writable_folder, write_text
from gyrostat.papers import EnsembleFigure, Evaluation, Paper, Reproduction

_style = """
:root { color-scheme: light; --line: #dfe3e8; --soft: #f6f8fa; --text: #1f2933; --dim: #5f6b7a }
* { box-sizing: border-box }
body { margin: 0 auto; max-width: 70rem; padding: 1.5rem 1rem 4rem; color: var(--text); background: #fff;
       font: 16px/1.55 system-ui, -apple-system, "Segoe UI", sans-serif }
h1 { font-size: 1.7rem; margin: 0 0 .3rem }
h2 { margin: 2.5rem 0 .3rem; font-size: 1.35rem } h3 { margin: 2rem 0 .6rem }
p { max-width: 46rem } .dim { color: var(--dim) } nav a { margin-right: 1rem }
.wide { overflow-x: auto; border: 1px solid var(--line); border-radius: 8px }
table { border-collapse: collapse; width: 100%; font-size: .87rem }
th, td { padding: .45rem .7rem; text-align: left; vertical-align: top; border-bottom: 1px solid var(--line) }
tr:last-child td { border-bottom: 0 }
th { background: var(--soft); white-space: nowrap } td.n { font-variant-numeric: tabular-nums; white-space: nowrap }
td.what { min-width: 14rem } td code { white-space: nowrap }
code { font: .85em ui-monospace, Menlo, Consolas, monospace }
.tag { display: inline-block; padding: .05rem .5rem; border-radius: 99px; font-size: .8rem; white-space: nowrap }
.good { background: #e3f4e6; color: #14632b } .bad { background: #fde5e5; color: #9b1c1c }
.warn { background: #fdf1d7; color: #7a4b00 } .none { background: #e9edf2; color: #3e4c59 }
figure { margin: 1.2rem 0 }
figure img { max-width: 100%; height: auto; border: 1px solid var(--line); border-radius: 8px }
figcaption { font-size: .9rem; color: var(--dim) }
"""

_verdict_colors = {"reproduces": "good", "does not reproduce": "warn", "not measured": "bad"}


def write_report(folder: Path, reproductions: Iterable[Reproduction]) -> Path:
    """Write ``index.html`` with everything in it, and beside it each study's claims, figures and their data.

    Parameters
    ----------
    folder
        Where to; made if it is not there.
    reproductions
        The studies, in the order of the page. Taken one by one: an iterator holds the results of one study at a time.

    Returns
    -------
    Path
        The page to open.
    """
    told, sections = [], []
    for reproduction in reproductions:
        sections.append(_section(writable_folder(folder / reproduction.paper.id), reproduction))
        told.append(reproduction.without_results())
        del reproduction  # before the next one flies
    page = folder / "index.html"
    write_text(page, _page(told, sections))
    return page


def _section(folder: Path, reproduction: Reproduction) -> str:
    paper = reproduction.paper
    write_text(folder / "claims.json", json.dumps(reproduction.to_dict(), indent=2) + "\n")
    for ensemble in reproduction.ensembles.values():
        write_text(folder / f"{ensemble.campaign.id}.csv", ensemble.to_csv())
    figures = []
    for figure in paper.figures:
        drawn = (
            figure.draw(reproduction.ensembles)
            if isinstance(figure, EnsembleFigure)
            else figure.draw(reproduction.results)
        )
        picture = drawn.save(folder / f"{figure.name}.png")
        data = base64.b64encode(picture.read_bytes()).decode()
        figures.append(
            f'<figure id="{escape(paper.id)}-{escape(figure.name)}"><img alt="{escape(figure.caption)}" '
            f'src="data:image/png;base64,{data}"><figcaption>{escape(figure.caption)} Data: '
            f"<code>{escape(paper.id)}/{escape(figure.name)}.npz</code></figcaption></figure>"
        )
    name = escape(paper.id)
    links = [("figures", "figures")] if figures else []
    links += [("claims", "published and measured"), ("cases", "cases")]
    return "\n".join(
        [
            f'<h2 id="{name}">{escape(paper.title)}</h2>',
            f'<p class="dim">{escape(paper.citation)}</p>',
            f"<p>{_summary(reproduction)}</p>",
            "<nav>" + " ".join(f'<a href="#{name}-{key}">{text}</a>' for key, text in links) + "</nav>",
            f'<h3 id="{name}-figures">Figures</h3>' if figures else "",
            *figures,
            f'<h3 id="{name}-claims">Published and measured</h3>',
            _claims(reproduction.evaluations),
            f'<h3 id="{name}-cases">Cases</h3>',
            _table(
                ("case", "what", "integrator", "period (s)", "duration (s)", "ended"), _case_rows(paper, reproduction)
            ),
        ]
    )


def _page(reproductions: Sequence[Reproduction], sections: Sequence[str]) -> str:
    links = " ".join(f'<a href="#{escape(r.paper.id)}">{escape(r.paper.id)}</a>' for r in reproductions)
    return f"""<!doctype html>
<html lang="en">
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<title>gyrostat: published and measured</title>
<style>{_style}</style>
<h1>Published and measured</h1>
<p class="dim">gyrostat {escape(__version__)}. A claim is accepted when the measured value lies in the stated range;
each paper's page says where its ranges come from. The published statement is judged apart from that, so an accepted
claim can show that a statement does not hold. Every number comes from the runs of this report.</p>
<nav>{links}</nav>
{"".join(sections)}
</html>
"""


def _summary(reproduction: Reproduction) -> str:
    claims = reproduction.evaluations
    stated = [e for e in claims if e.claim.reported is not None]
    held = sum(e.verdict == "reproduces" for e in stated)
    text = f"{len(claims) - reproduction.failed} of {len(claims)} claims accepted."
    if stated:
        text += f" What the publication states holds in {held} of {len(stated)} comparisons."
    return text


def _claims(evaluations: Sequence[Evaluation]) -> str:
    """One block a quantity, with a row for each case that it was measured on."""
    rows = []
    for name, group in groupby(evaluations, key=lambda e: e.claim.id.partition("@")[0]):
        members = list(group)
        claim = members[0].claim
        note = f'<br><span class="dim">{escape(claim.note)}</span>' if claim.note else ""
        quantity = f"{escape(claim.quantity)}{note}<br><code>{escape(name)}</code>"
        first = f'<td class="what" rowspan="{len(members)}">{quantity}</td>'
        for position, evaluation in enumerate(members):
            rows.append(f"<tr>{first if position == 0 else ''}{_claim_cells(evaluation)}</tr>")
    head = ("quantity", "case", "published", "measured", "accepted", "published statement", "")
    return _frame(head, rows)


def _claim_cells(evaluation: Evaluation) -> str:
    claim = evaluation.claim
    trouble = "" if evaluation.measured is not None else f"<br>{escape(evaluation.note)}"
    cells = [
        f"<code>{escape(claim.case)}</code>{trouble}",
        escape(number(claim.published)),
        escape(number(evaluation.measured)),
        escape(f"{number(claim.accept[0])} … {number(claim.accept[1])}"),
        _tag(evaluation.verdict, _verdict_colors.get(evaluation.verdict, "none")),
        _tag("accepted", "good") if evaluation.ok else _tag("not accepted", "bad"),
    ]
    return _cells(cells)


def _case_rows(paper: Paper, reproduction: Reproduction) -> list[list[str]]:
    return [
        [
            f"<code>{escape(case.id)}</code>",
            escape(case.title),
            escape(case.integrator),
            number(case.scenario.dt),
            number(case.scenario.duration),
            escape(reproduction.endings.get(case.id, "as planned")),
        ]
        for case in paper.cases.values()
    ] + [
        [
            f"<code>{escape(c.id)}</code>",
            f"{escape(c.title)} ({c.runs} runs, seed {c.seed}; each in <code>{escape(c.id)}.csv</code>)",
            escape(str(c.scenario.resolve()["integrator"]["type"])),
            number(c.scenario.dt),
            number(c.scenario.duration),
            "as planned",
        ]
        for c in paper.campaigns.values()
    ]


def _table(head: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    return _frame(head, [f"<tr>{_cells(row)}</tr>" for row in rows])


def _frame(head: Sequence[str], rows: Sequence[str]) -> str:
    header = "".join(f"<th>{h}</th>" for h in head)
    body = "\n".join(rows)
    return f'<div class="wide"><table><thead><tr>{header}</tr></thead><tbody>\n{body}\n</tbody></table></div>'


def _cells(cells: Sequence[str]) -> str:
    return "".join(f'<td class="n">{c}</td>' if _is_number(c) else f"<td>{c}</td>" for c in cells)


def number(value: float | str | None) -> str:
    """A number with three digits; a dash when there is none."""
    if value is None:
        return "–"
    return value if isinstance(value, str) else f"{value:.3g}"


def _tag(text: str, color: str) -> str:
    return f'<span class="tag {color}">{escape(text)}</span>'


def _is_number(text: str) -> bool:
    return bool(text) and (text[0].isdigit() or text[0] in "-–") and len(text) < 24
