# SPDX-License-Identifier: MIT
"""The figures of the page of a campaign: distributions, pointing over time, sensitivities, evidence."""

from __future__ import annotations

import math
from html import escape

import numpy as np
from numpy.typing import NDArray

from gyrostat.campaign.rows import Rows
from gyrostat.campaign.sensitivities import MOST_RUNS
from gyrostat.campaign.sensitivities import sensitivities as indices_of
from gyrostat.page.campaign_blocks import called, note, percent
from gyrostat.page.svg import Axis, Plot, keys
from gyrostat.page.tables import table
from gyrostat.results import Result
from gyrostat.verification.requirements import Report
from gyrostat.verification.sensitivity import failure_histogram
from gyrostat.verification.sequential import distribution_band

Array = NDArray[np.float64]

_most_kept = 200
_most_inputs = 8
_drawn_inputs = 3
_most_cells = 8
_bins = 16


def _figure(caption: str, plot: Plot) -> str:
    return f"<figure><figcaption>{escape(caption)}</figcaption>{plot.text()}</figure>"


def distributions(rows: Rows) -> str:
    """Distribution functions of what success depends on and of settling, with bands and limits."""
    names = list(dict.fromkeys([*rows.spec["success"], *rows.times])) or list(rows.measures)[:2]
    labels = list(rows.cells)[:_most_cells]
    drawn = [_distribution(rows, name, labels) for name in names if _finite(rows, name, labels).size]
    if not drawn:
        return note("No flight has a finite value.")
    if not rows.whole:
        return note("Distributions need the rows of all flights; [keep] rows = 'all' keeps them.")
    said = "Share of flights below a value"
    if rows.independent:
        said += (
            ", with the band that holds the whole true distribution at 95 % at all looks (after 64, 128, 256, ... runs)"
        )
    left = f"; the first {_most_cells} cells" if len(rows.cells) > _most_cells else ""
    legend = keys([called(label) for label in labels])
    return note(f"{said}{left}.") + legend + f'<div class="figures">{"".join(drawn)}</div>'


def _finite(rows: Rows, name: str, labels: list[str]) -> Array:
    x = np.concatenate([rows.values(label, name) for label in labels])
    return np.asarray(x[np.isfinite(x)])


def _distribution(rows: Rows, name: str, labels: list[str]) -> str:
    limits = rows.limits(name)
    plot = Plot(Axis.over([*_finite(rows, name, labels), *limits], name), Axis(0.0, 1.0, "share of flights"))
    for hue, label in enumerate(labels):
        x = rows.values(label, name)
        looked, half = distribution_band(len(x)) if rows.independent else (0, 1.0)
        if looked:
            seen = np.sort(x[:looked])
            share = np.arange(1, looked + 1) / looked
            plot.band(seen, np.maximum(share - half, 0.0), np.minimum(share + half, 1.0), hue)
        plot.line(np.sort(x), np.arange(1, len(x) + 1) / len(x), hue, step=True)
    for limit in limits:
        plot.level(x=limit, label=f"limit {limit:g}")
    return _figure(name, plot)


def envelope(rows: Rows) -> str:
    """Pointing over time of the flights whose trajectories are kept."""
    files = sorted((rows.found.folder / "trajectories").glob("*.npz"))[:_most_kept]
    if not files:
        return ""
    kept = [Result.load(path) for path in files]
    kept = [r for r in kept if "error.angle" in r and len(r) > 1]
    if not kept:
        return ""
    t = np.linspace(0.0, max(float(r.t[-1]) for r in kept), 240)
    angles = np.array([np.interp(t, r.t, r["error.angle"], right=np.nan) for r in kept])
    there = np.isfinite(angles).any(axis=0)
    levels = {q: np.nanquantile(angles[:, there], q, axis=0, method="higher") for q in (0.5, 0.95, 0.99)}
    values = np.concatenate(list(levels.values()))
    plot = Plot(Axis(0.0, float(t[-1]), "time, s"), Axis.over(values[values > 0.0], "pointing error, rad"), (960, 270))
    for hue, (_, x) in enumerate(levels.items()):
        plot.line(t[there], x, hue)
    said = (
        f"Of {len(kept)} flights that [keep] chose (failures, the worst, or each so-many-th): no sample of all flights."
    )
    return note(said) + keys([percent(q) for q in levels]) + plot.text()


def sensitivities(rows: Rows) -> str:
    """First-order indices of the margin, or of what success depends on, and the inputs of lost flights."""
    if rows.found.manifest["campaign"] is None:
        return ""
    campaign = rows.found.campaign
    if not campaign.dimension:
        return ""
    if not rows.independent:
        return note("Sensitivities are taken from independent runs: sampling = 'plain'.")
    names = np.array(campaign.inputs)
    parts = [_indices(rows), *(_inputs_of_lost(rows, label, names) for label in list(rows.cells)[:_most_cells])]
    return "".join(parts) or note("Too few runs for sensitivities, and none was lost.")


def _indices(rows: Rows) -> str:
    found = indices_of(rows)
    if found is None:
        return ""
    lines = [
        [name, *(_share(float(indices[i])) for indices in found.indices.values())]
        for i, name in enumerate(found.inputs[:_most_inputs])
    ]
    said = f"Share of the variance of {found.of} that an input explains alone (first-order index), of finite values."
    return note(said) + table(("input", *(called(label) for label in found.indices)), lines)


def _share(index: float) -> str:
    return "–" if math.isnan(index) else percent(max(index, 0.0))


def _inputs_of_lost(rows: Rows, label: str, names: NDArray[np.str_]) -> str:
    columns = rows.cells[label]
    lost = ~columns["success"].astype(bool)
    if int(lost.sum()) < 2:
        return ""
    run = columns["run"].astype(np.int64)[lost][:MOST_RUNS]
    found = failure_histogram(rows.points(run), np.ones(len(run), bool), bins=_bins)
    uneven = ((found.counts - len(run) / _bins) ** 2).sum(axis=1)
    edges = np.linspace(0.0, 1.0, _bins + 1)
    drawn = []
    for i in np.argsort(-uneven, kind="stable")[:_drawn_inputs]:
        plot = Plot(Axis(0.0, 1.0, "its quantile"), Axis(0.0, float(found.high[i].max()), "share"), (330, 180))
        plot.bars(edges, found.share[i], found.low[i], found.high[i], 0)
        plot.level(y=1.0 / _bins)
        drawn.append(_figure(str(names[i]), plot))
    head = f"Inputs of the {int(lost.sum())} lost flights{f', {label}' if label else ''}"
    said = "Dashed: an input that does not matter. Bars of one input with 95 % intervals of Clopper and Pearson."
    return f"<h3>{escape(head)}</h3>{note(said)}" + f'<div class="figures small">{"".join(drawn)}</div>'


def evidence(report: Report) -> str:
    """Evidence of every requirement against runs, and where a verdict falls: so that stopping can be judged."""
    drawn = []
    for j in report.judgements:
        at, for_pass, for_fail = j.evidence
        both = [x / math.log(10.0) for x in (for_pass, for_fail)]
        levels = {math.log10(x): name for name, x in zip("βα", reversed(j.wanted), strict=True)}  # one where they agree
        finite = np.concatenate([x[np.isfinite(x)] for x in both] + [list(levels)])
        y = Axis(max(float(finite.min()), -4.0), float(finite.max()) + 0.3, "evidence, decades")
        plot = Plot(Axis(1.0, max(float(at[-1]), 2.0), "runs", log=True), y)
        for hue, x in enumerate(both):
            plot.line(at, x, hue)
        for level, name in levels.items():
            plot.level(y=level, label=f"1/{name} = {10.0**level:.3g}")
        plot.level(x=float(j.verdict.runs), label=j.verdict.outcome)
        drawn.append(_figure(j.name, plot))
    return keys(["for PASS", "for FAIL"]) + f'<div class="figures">{"".join(drawn)}</div>'


__all__ = ["distributions", "envelope", "evidence", "sensitivities"]
