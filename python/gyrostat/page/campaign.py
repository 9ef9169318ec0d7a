# SPDX-License-Identifier: MIT
"""The page of a campaign: what was flown, how often it was lost and with which certainty, when, why, and which flights.

One file below a megabyte that needs no network, light and dark. Page: docs/campaigns.md
"""

from __future__ import annotations

from html import escape
from pathlib import Path

from gyrostat._core import __version__
from gyrostat.campaign.results import CampaignResult
from gyrostat.campaign.rows import Rows
from gyrostat.files import writable_folder, write_text
from gyrostat.page import campaign_blocks as blocks
from gyrostat.page import campaign_figures as figures
from gyrostat.page.fault_maps import fault_maps
from gyrostat.page.rare import chip, rare, rare_identity
from gyrostat.page.writer import GENERATOR, asset, filled, page_path
from gyrostat.verification.requirements import Report, verified
from gyrostat.verification.searched import Searched


def write_campaign_page(path: str | Path, found: CampaignResult, against: str | None = None) -> Path:
    """Write the page of a flown campaign; that of a folder of ``gyrostat verify`` has its verdict on top.

    Parameters
    ----------
    path
        A file that ends in ``.html``, or a folder for ``index.html``.
    found
        The folder.
    against
        The cell with which the others are compared, run by run; the first one if absent.

    Returns
    -------
    Path
        The page.

    Raises
    ------
    InputError
        A folder without runs, no such cell, or a place where something else is or nothing can be written.
    """
    target = page_path(path)
    report, searched = verified(found), Searched.read(found.folder)
    if searched is not None and searched.identity != found.identity:
        searched = None
    text = _page(Rows.of(found), report, searched, against)
    writable_folder(target.parent)
    write_text(target, text)
    return target


def write_rare_page(path: str | Path, folder: Path, searched: Searched) -> Path:
    """Write the page of a search for rare failures, where no campaign is in its folder.

    Parameters
    ----------
    path
        A file that ends in ``.html``, or a folder for ``index.html``.
    folder
        Of ``gyrostat rare``.
    searched
        What it holds.

    Returns
    -------
    Path
        The page.
    """
    target = page_path(path)
    parts = [
        ("what", "What this is", rare_identity(searched)),
        ("rare", "Rare failures", rare(searched, folder)),
    ]
    text = _filled(searched.campaign or folder.resolve().name, "", chip(searched), parts)
    writable_folder(target.parent)
    write_text(target, text)
    return target


def _page(rows: Rows, report: Report | None, searched: Searched | None, against: str | None) -> str:
    found = rows.found
    parts = [
        ("verdict", "Verdict", "" if report is None else blocks.verdict(report)),
        ("what", "What this is", blocks.identity(rows)),
        ("cells", "Failures", blocks.cells(rows)),
        ("quantiles", "Measures", blocks.quantiles(rows)),
        ("paired", "Run by run", blocks.paired(rows, against)),
        ("faults", "Failure rate by severity and onset", fault_maps(rows)),
        ("distributions", "Distributions", figures.distributions(rows)),
        ("envelope", "Pointing of kept flights", figures.envelope(rows)),
        ("sensitivity", "What matters", figures.sensitivities(rows)),
        ("worst", "Worst ten", blocks.worst(rows)),
        ("statuses", "How flights ended", blocks.statuses(rows)),
        ("evidence", "Evidence against runs", "" if report is None else figures.evidence(report)),
        ("rare", "Rare failures", "" if searched is None else rare(searched, found.folder)),
        ("assumptions", "What this rests on", blocks.assumptions(rows)),
    ]
    name = str((found.manifest["campaign"] or {}).get("name") or found.folder.resolve().name)
    about = str((found.manifest["campaign"] or {}).get("description", ""))
    return _filled(name, about, blocks.chips(rows, report), parts)


def _filled(name: str, about: str, chips: str, parts: list[tuple[str, str, str]]) -> str:
    body = "\n".join(f'<section id="{id_}"><h2>{title}</h2>{text}</section>' for id_, title, text in parts if text)
    return filled(
        asset("plain.html"),
        {
            "generator": f"{GENERATOR} {__version__}",
            "version": escape(__version__),
            "title": escape(name),
            "description": escape(about),
            "style": asset("page.css") + asset("plain.css"),
            "chips": chips,
            "blocks": body,
            "script": asset("theme.js") + asset("plain.js"),
        },
    )


__all__ = ["write_campaign_page", "write_rare_page"]
