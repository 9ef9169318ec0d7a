# SPDX-License-Identifier: MIT
"""Folders of one campaign that were flown apart, put together."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from gyrostat.campaign.results import CampaignResult
from gyrostat.campaign.store import Part, Store, first_difference
from gyrostat.errors import InputError
from gyrostat.files import made_folder


def join(folders: Sequence[str | Path], out: str | Path | None = None) -> CampaignResult | None:
    """Check that folders hold one campaign and cover its runs; put their parts into a new folder if one is given.

    Raises
    ------
    InputError
        Another identity, with the first key that differs, runs that are in none of them, or a damaged part.
    """
    if not folders:
        raise InputError("which folders?")
    results = [CampaignResult(folder) for folder in folders]
    first = results[0]
    for other in results[1:]:
        if other.identity != first.identity:
            why = first_difference(first.manifest["resolved"], other.manifest["resolved"])
            raise InputError(f"{other.folder}: holds another campaign than {first.folder}; {why}")
    runs = max(int(result.manifest["runs"]) for result in results)
    parts = _cover([part for result in results for part in result.parts()], runs)
    for part in parts:
        Store(part.path.parents[1]).data(part)
    if out is None:
        return None
    target = Store(Path(out))
    if target.manifest() is not None:
        raise InputError(f"{out}: holds a campaign already; a new folder belongs here")
    with made_folder(Path(out)):
        target.begin({**first.manifest, "runs": runs})
        for part in parts:
            target.copy_part(part)
    return CampaignResult(out)


def _cover(parts: Sequence[Part], runs: int) -> list[Part]:
    """Parts one after the other from run 0 to the last."""
    cover: list[Part] = []
    at = 0
    for part in sorted(parts, key=lambda p: (p.first, -p.end)):
        if part.first > at:
            raise InputError(f"runs {at} to {part.first - 1} are in none of the folders")
        if part.first < at < part.end:
            raise InputError(f"{part.path}: begins at run {part.first}, inside of another part; fly equal chunks")
        if part.end > at:
            cover.append(part)
            at = part.end
    if at < runs:
        raise InputError(f"runs {at} to {runs - 1} are in none of the folders")
    return cover


__all__ = ["join"]
