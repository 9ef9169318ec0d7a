# SPDX-License-Identifier: MIT
"""The report of studies: what was published, what is measured, and why.

Page: docs/pages.md
"""

from __future__ import annotations

import json
from collections.abc import Iterable
from html import escape
from pathlib import Path

from gyrostat._core import __version__
from gyrostat.files import writable_folder, write_text
from gyrostat.page import study
from gyrostat.page.picture import script
from gyrostat.page.writer import GENERATOR, asset, filled, page_path
from gyrostat.papers import EnsembleFigure, Reproduction


def write_report(folder: Path, reproductions: Iterable[Reproduction], *, with_data: bool = False) -> Path:
    """Write ``index.html``, and beside it each study's claims, its cases as TOML, and its figures.

    Parameters
    ----------
    folder
        Where to; made if it is not there.
    reproductions
        The studies, in the order of the page. Taken one by one: an iterator holds the results of one study at a time.
    with_data
        Write what the figures draw beside them, too, in full (``.npz``).

    Returns
    -------
    Path
        The page to open.

    Raises
    ------
    InputError
        Something else is there, or nothing can be written.
    """
    target = page_path(folder)
    told = []
    for reproduction in reproductions:
        panels = _write_files(writable_folder(folder / reproduction.paper.id), reproduction, with_data=with_data)
        told.append(study.Study.of(reproduction, panels, with_data=with_data))
        del reproduction  # before the next one flies
    write_text(target, _page(told))
    return target


def _write_files(folder: Path, found: Reproduction, *, with_data: bool) -> dict[str, int]:
    """What lies beside the page; the number of panels of each figure."""
    paper = found.paper
    write_text(folder / "claims.json", json.dumps(found.to_dict(), indent=2) + "\n")
    for case in paper.cases.values():
        case.scenario.to_toml(folder / f"{case.id}.toml")
    for many in paper.campaigns.values():
        many.campaign.to_toml(folder / f"{many.id}.toml")
    for ensemble in found.ensembles.values():
        write_text(folder / f"{ensemble.id}.csv", ensemble.to_csv())
    panels = {}
    for figure in paper.figures:
        drawn = figure.draw(found.ensembles) if isinstance(figure, EnsembleFigure) else figure.draw(found.results)
        if with_data:
            drawn.save_data(folder / f"{figure.name}.npz")
        write_text(folder / f"{figure.name}.js", script(f"{paper.id}/{figure.name}", drawn))
        panels[figure.name] = len(drawn.axes)
    return panels


def _page(studies: list[study.Study]) -> str:
    links = "".join(f'<a href="#{escape(s.paper.id)}">{escape(s.paper.id)}</a>' for s in studies)
    surprising = study.findings(studies)
    blocks = [
        '<nav id="tools"><a href="#top">overview</a>' + links + '<input id="search" type="search" '
        'placeholder="search claims" aria-label="Search claims"><select id="filter" aria-label="Show claims">'
        '<option value="">all claims</option><option value="fails">does not hold</option>'
        '<option value="holds">holds</option><option value="open">cannot be said</option>'
        '<option value="missed">not accepted</option></select><span id="found" class="dim"></span></nav>',
        study.overview(studies),
        f'<section id="surprises"><h2>Most surprising</h2>{surprising}</section>' if surprising else "",
        *(study.section(s) for s in studies),
    ]
    return filled(
        asset("plain.html"),
        {
            "generator": f"{GENERATOR} {__version__}",
            "version": escape(__version__),
            "title": "Published and measured",
            "description": "Published methods flown again. A claim is accepted when its number lies in the range that "
            "was set for it; what the publication states is judged apart, so an accepted claim can show that a "
            "statement does not hold. Every number comes from the runs of this report and opens how to repeat it.",
            "style": "".join(asset(f"{name}.css") for name in ("page", "plain", "figure", "report")),
            "chips": "",
            "blocks": "\n".join(blocks),
            "script": "".join(asset(f"{name}.js") for name in ("theme", "figure", "report", "plain")),
        },
    )


__all__ = ["write_report"]
