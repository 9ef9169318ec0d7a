# SPDX-License-Identifier: MIT
"""The page of a search for rare failures, and its part of the page of a campaign. Page: docs/verification.md."""

from __future__ import annotations

from pathlib import Path

from gyrostat.page.campaign_blocks import note
from gyrostat.page.tables import table
from gyrostat.verification.searched import Searched


def chip(searched: Searched) -> str:
    """How it went, in a few words."""
    found = searched.found
    if found.status == "converged":
        return f'<span class="chip"><b>{found.probability:.3g}</b> probability of loss</span>'
    return f'<span class="chip bad"><b>{found.status}</b> search for rare failures</span>'


def rare(searched: Searched, folder: Path) -> str:
    """Estimate and interval, levels, replicates, and the likeliest lost flights."""
    found = searched.found
    levels = [
        [f"{i}", f"{x.margin:.4g}", f"{100 * x.share:.3g} %", f"{x.step:.3f}", f"{100 * x.acceptance:.0f} %"]
        for i, x in enumerate(found.levels, 1)
    ]
    replicates = [[f"{i}", f"{p:.3g}"] for i, p in enumerate(found.replicates, 1)]
    lost = [[f"{f.distance:.3g}", f"{f.margin:.3g}", _again(folder, i)] for i, f in enumerate(found.lost)]
    parts = [
        note(_said(searched)),
        note(
            "Levels are those of a pilot: margins above which about a tenth of the flights lies that were above the "
            "one before. Replicates fly with these levels and steps held fixed, independently of each other; their "
            "mean is the estimate, and their scatter gives the interval (Cox, of 95 %). Nobody may pass a requirement "
            "on it: it advises."
        ),
        table(("level", "margin above", "kept of the pilot", "step", "moves accepted"), levels) if levels else "",
        table(("replicate", "estimate"), replicates) if replicates else "",
        note("Lost flights, the likeliest first: the smaller the distance, the likelier.") if lost else "",
        table(("distance of the inputs", "margin", "again"), lost) if lost else "",
    ]
    return "".join(parts)


def rare_identity(searched: Searched) -> str:
    """What was searched."""
    cell = [] if searched.cell is None else [["cell", searched.cell]]
    lines = [["identity of the campaign", searched.identity], *cell, ["seed", f"{searched.seed}"]]
    lines += [["flights of a replicate at a level", f"{searched.found.population}"]]
    return table(("what", "is"), lines)


def _said(searched: Searched) -> str:
    found = searched.found
    low, high = found.interval
    bound = f"independent flights alone say at most {found.bound:.3g} (95 %)"
    if found.status == "stalled":
        return f"Stalled after {found.flights} flights: the margin does not rise any more; {bound}."
    if found.status == "not converged":
        return (
            f"Not converged: mean {found.probability:.3g} of {found.replicates.size} replicates that differ too much; "
            f"twice the population may do. {found.flights} flights; {bound}."
        )
    return (
        f"Probability of loss {found.probability:.3g}, {low:.3g} to {high:.3g} (95 %), of {found.flights} flights; one "
        f"replicate scatters by {100 * found.variation:.0f} %; {bound}."
    )


def _again(folder: Path, i: int) -> str:
    path = folder / f"lost{i}.toml"
    return f"gyrostat run {path}" if path.exists() else "–"


__all__ = ["chip", "rare", "rare_identity"]
