# SPDX-License-Identifier: MIT
"""The parts of the report of studies: the table over all of them, the findings, and the section of each."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from html import escape

from gyrostat.page.picture import height
from gyrostat.papers import ExperimentRows, Paper, Reproduction, Row, Tally, folded
from gyrostat.papers.story import Surprise, parts
from gyrostat.text import number

MOST_FINDINGS = 5
"""On the top of a report."""

_words = {"holds": "holds", "fails": "does not hold", "open": "cannot be said"}
_colors = {"holds": "good", "fails": "warn", "open": "none"}


@dataclass(frozen=True)
class Study:
    """A reproduced study as the page tells it."""

    found: Reproduction
    experiments: Sequence[ExperimentRows]
    tally: Tally
    panels: Mapping[str, int]
    """Of each figure."""
    with_data: bool
    """Whether the data behind its figures lie beside the page."""

    @classmethod
    def of(cls, found: Reproduction, panels: Mapping[str, int], *, with_data: bool) -> Study:
        """Without the series that figures are drawn from."""
        experiments = folded(found)
        return cls(found.without_results(), experiments, Tally.of(experiments), panels, with_data)

    @property
    def paper(self) -> Paper:
        """What was reproduced."""
        return self.found.paper

    def anchors(self) -> dict[str, tuple[str, str]]:
        """Place on the page, and measured number, of every claim."""
        return {
            e.claim.id: (_anchor(self.paper, row), figure(e.measured))
            for experiment in self.experiments
            for row in experiment.rows
            for e in row.evaluations
        }


def figure(value: float | str | None) -> str:
    """A number as HTML: three digits, powers of ten written out."""
    if isinstance(value, str):
        return escape(value)
    text = number(value).replace("inf", "∞")
    found = re.fullmatch(r"(-?[\d.]+)e([+-]\d+)", text)
    if found is None:
        return text.replace("-", "−")
    digits, power = found[1].replace("-", "−"), str(int(found[2])).replace("-", "−")
    return f"10<sup>{power}</sup>" if digits == "1" else f"{digits}·10<sup>{power}</sup>"


def overview(studies: Sequence[Study]) -> str:
    """One table over all studies."""
    rows = [
        f'<tr><td><a class="name" href="#{_id(s.paper)}">{escape(s.paper.id)}</a></td>'
        f'<td class="title">{escape(s.paper.title)}</td>{_tally_cells(s.tally)}</tr>'
        for s in studies
    ]
    if len(studies) > 1:
        total = Tally(*(sum(x) for x in zip(*(vars(s.tally).values() for s in studies), strict=True)))
        rows.append(f'<tr class="total"><td>all</td><td></td>{_tally_cells(total)}</tr>')
    head = ("study", "about", "claims accepted", "what the publication states", *_words.values())
    return (
        f'<div class="wide"><table id="overview"><thead><tr>{"".join(f"<th>{h}</th>" for h in head)}</tr></thead>'
        f"<tbody>{''.join(rows)}</tbody></table></div>"
    )


def _tally_cells(tally: Tally) -> str:
    share = 100.0 * tally.accepted / max(tally.claims, 1)
    missed = "" if tally.accepted == tally.claims else " missed"
    counts = {"holds": tally.holds, "fails": tally.fails, "open": tally.open}
    pieces = "".join(
        f'<i class="{_colors[k]}" style="flex:{n}" title="{n} {_words[k]}"></i>' for k, n in counts.items() if n
    )
    numbers = "".join(f'<td class="n {_colors[k]}">{n}</td>' for k, n in counts.items())
    return (
        f'<td class="n accepted{missed}"><b>{tally.accepted}</b> of {tally.claims}'
        f'<span class="share"><i style="width:{share:.4g}%"></i></span></td>'
        f'<td class="bars"><span class="stack">{pieces}</span></td>{numbers}'
    )


def findings(studies: Sequence[Study]) -> str:
    """The most surprising findings: the first of each study, then the second ones, until there are enough."""
    listed = [[(s, one) for one in s.paper.findings] for s in studies]
    ranked = [found for k in range(max(map(len, listed), default=0)) for found in (x[k] for x in listed if len(x) > k)]
    cards = [_finding(study, one) for study, one in ranked[:MOST_FINDINGS]]
    return f'<div id="findings">{"".join(cards)}</div>' if cards else ""


def _finding(study: Study, one: Surprise) -> str:
    anchors = study.anchors()
    return (
        f'<article><p class="dim"><a href="#{_id(study.paper)}">{escape(study.paper.id)}</a></p>'
        f"<h3>{escape(one.title)}</h3><p>{_told(one.text, anchors)}</p>"
        f'<a class="more" href="#{anchors[one.claim][0]}">the numbers →</a></article>'
    )


def _told(text: str, anchors: Mapping[str, tuple[str, str]]) -> str:
    """A text with its numbers, each a link to its claim."""
    pieces = []
    for said, claim in parts(text):
        pieces.append(escape(said))
        if claim:
            place, value = anchors[claim]
            pieces.append(f'<a class="told" href="#{place}">{value}</a>')
    return "".join(pieces)


def section(study: Study) -> str:
    """Story, figures and claims of one study."""
    paper, tally = study.paper, study.tally
    story = ""
    if paper.story is not None:
        anchors = study.anchors()
        told = {"Promised": paper.story.promised, "What we see": paper.story.seen, "Why": paper.story.why}
        story = "".join(f"<div><h3>{k}</h3><p>{_told(text, anchors)}</p></div>" for k, text in told.items())
        story = f'<div class="story">{story}</div>'
    drawn = "".join(_figure(study, one.name, one.caption) for one in paper.figures)
    claims = "".join(_experiment(study, experiment) for experiment in study.experiments)
    accepted = "good" if tally.accepted == tally.claims else "bad"
    chips = [(accepted, f"{tally.accepted} of {tally.claims}", "claims accepted")]
    chips += [(_colors[k], str(getattr(tally, k)), f"statements: {_words[k]}") for k in _words if getattr(tally, k)]
    return (
        f'<section class="study" id="{_id(paper)}"><h2>{escape(paper.title)}</h2>'
        f'<p class="dim">{escape(paper.id)}: {escape(paper.citation)}</p>'
        f'<div class="chips">{"".join(f"""<span class="chip {c}"><b>{n}</b> {w}</span>""" for c, n, w in chips)}</div>'
        f"{story}"
        + (f'<div class="drawings"><h3>Figures</h3><div class="figures">{drawn}</div></div>' if drawn else "")
        + '<div class="claims"><h3>Claims, by experiment <button class="all" type="button">open all</button></h3>'
        + f"{claims}</div></section>"
    )


def _figure(study: Study, name: str, caption: str) -> str:
    paper = study.paper
    place = escape(f"{paper.id}/{name}")
    data = f' <a href="{place}.npz" download>data</a>' if study.with_data else ""
    return (
        f'<figure id="{_id(paper)}-{escape(name)}" data-name="{place}" data-src="{place}.js">'
        f'<figcaption>{escape(caption)}{data} <span class="at dim"></span></figcaption>'
        f'<div class="drawing" style="min-height:{height(study.panels[name])}px"></div></figure>'
    )


def _experiment(study: Study, experiment: ExperimentRows) -> str:
    paper = study.paper
    said = [row.statement for row in experiment.rows]
    dots = "".join(f'<i class="{_colors[s]}"></i>' for s in said if s is not None)
    failed = not all(row.ok for row in experiment.rows)
    rows = "".join(_row(paper, row) for row in experiment.rows)
    number_of = len(experiment.rows)
    return (
        f'<details class="experiment"{" open" if failed else ""} data-paper="{escape(paper.id)}" '
        f'data-case="{escape(experiment.id)}"><summary><b>{escape(_title(paper, experiment.id))}</b> '
        f'<span class="dim">{number_of} claim{"s" * (number_of > 1)}</span><span class="dots">{dots}</span></summary>'
        f'<p class="dim">{"; ".join(_flown(study, experiment))}</p>'
        '<div class="wide"><table><thead><tr><th>quantity</th><th>published</th><th>measured</th>'
        f"<th>accepted range</th><th>statement</th><th></th></tr></thead><tbody>{rows}</tbody></table></div></details>"
    )


def _title(paper: Paper, case: str) -> str:
    return paper.cases[case].title if case in paper.cases else paper.campaigns[case].title


def _flown(study: Study, experiment: ExperimentRows) -> Iterator[str]:
    """How an experiment was flown, and where to fly it again."""
    paper, case = study.paper, experiment.id
    files = ", ".join(f'<a href="{_toml(paper, c)}">{escape(c)}.toml</a>' for c in experiment.cases)
    yield f"<code>{escape(case)}</code>: {files}"
    if case in paper.cases:
        one = paper.cases[case]
        yield f"{escape(one.integrator)}, period {one.scenario.dt:g} s, {one.scenario.duration:g} s"
        yield f"<code>gyrostat run {escape(_toml(paper, case))} --out flight</code>"
        ended = {study.found.endings[c]: None for c in experiment.cases if c in study.found.endings}
        yield from (f"<b>ended early: {escape(cause)}</b>" for cause in ended)
    else:
        many = paper.campaigns[case]
        every = f'<a href="{escape(paper.id)}/{escape(case)}.csv">each run</a>'
        base = many.campaign.base
        yield f"{many.runs} runs, seed {base.seed}, period {base.dt:g} s, {base.duration:g} s"
        yield every
        file = escape(_toml(paper, case))
        yield f"<code>gyrostat campaign {file} --runs {many.runs} --out flown</code>"


def _row(paper: Paper, row: Row) -> str:
    claim = row.claim
    note = f'<span class="dim">{escape(claim.note)}</span>' if claim.note else ""
    trouble = "".join(f'<span class="trouble">{escape(text)}</span>' for text in row.troubles)
    pattern = claim.id if len(row.evaluations) == 1 else row.name
    command = f"gyrostat reproduce {paper.id} --claim {pattern}"
    value = f'<a href="{_toml(paper, claim.case)}" title="{escape(command)}">{figure(row.first.measured)}</a>'
    low, high = (figure(end) for end in claim.accept)
    stated = "–" if row.statement is None else _tag(_words[row.statement], _colors[row.statement])
    several = "" if len(row.evaluations) == 1 else f" {row.accepted}/{len(row.evaluations)}"
    accepted = _tag("accepted", "good") if row.ok else _tag(f"not accepted{several}", "bad")
    return (
        f'<tr id="{_anchor(paper, row)}" class="{row.statement or "none"} {"ok" if row.ok else "missed"}">'
        f'<td class="what">{escape(claim.quantity)}{note}{trouble}<code>{escape(row.name)}</code></td>'
        f'<td class="n">{figure(claim.published)}</td><td class="n measured">{value}{_spread(row)}</td>'
        f'<td class="n">{low} … {high}</td><td>{stated}</td><td>{accepted}</td></tr>'
    )


def _spread(row: Row) -> str:
    """Over the repeats of a row."""
    if len(row.evaluations) == 1:
        return ""
    if not row.measured:
        return f"<small>none of {len(row.evaluations)} seeds</small>"
    low, high = figure(min(row.measured)), figure(max(row.measured))
    span = low if low == high else f"{low} … {high}"
    return f"<small>{len(row.measured)} seeds: {span}</small>"


def _toml(paper: Paper, case: str) -> str:
    return f"{paper.id}/{case}.toml"


def _id(paper: Paper) -> str:
    return escape(paper.id)


def _anchor(paper: Paper, row: Row) -> str:
    return escape(f"{paper.id}:{row.claim.id}")


def _tag(text: str, color: str) -> str:
    return f'<span class="tag {color}">{escape(text)}</span>'


__all__ = ["MOST_FINDINGS", "Study", "figure", "findings", "overview", "section"]
