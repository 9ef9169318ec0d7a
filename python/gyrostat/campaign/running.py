# SPDX-License-Identifier: MIT
"""Flying what a folder does not hold yet, chunk by chunk, here or on a cluster."""

from __future__ import annotations

import time
import warnings
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from gyrostat.campaign.chunks import Chunk
from gyrostat.campaign.identity import identity, resolved
from gyrostat.campaign.limits import whole
from gyrostat.campaign.results import CampaignResult
from gyrostat.campaign.store import FORMAT, Part, Store, first_difference
from gyrostat.errors import InputError
from gyrostat.files import made_folder
from gyrostat.text import shown

if TYPE_CHECKING:
    from gyrostat.campaign.campaign import Campaign

CHUNK = 500
"""Runs a part, where nobody says."""


@dataclass(frozen=True)
class State:
    """How far it is.

    Attributes
    ----------
    done, runs
        Runs that are there, and that are wanted.
    failures
        Failed flights in finished chunks.
    rate
        Runs a second since the start; 0 at first.
    """

    done: float
    runs: int
    failures: int
    rate: float

    @property
    def remaining(self) -> float | None:
        """Seconds, if that can be said."""
        return (self.runs - self.done) / self.rate if self.rate > 0.0 else None


class _Teller:
    """Makes a `State` of what has happened."""

    def __init__(self, tell: Callable[[State], None] | None, done: int, runs: int, failures: int) -> None:
        self._tell, self._done, self._runs, self._failures = tell, done, runs, failures
        self._before, self._started = done, time.monotonic()

    def within(self, count: int) -> Callable[[float], None]:
        """Of a chunk of so many runs."""
        return lambda fraction: self._say(self._done + fraction * count)

    def add(self, chunk: Chunk) -> None:
        """A chunk is written."""
        self._done += chunk.end - chunk.first
        self._failures += sum(c["failures"] for c in chunk.counts.values())
        self._say(self._done)

    def _say(self, done: float) -> None:
        if self._tell is not None:
            passed = time.monotonic() - self._started
            rate = (done - self._before) / passed if passed > 0.0 else 0.0
            self._tell(State(done, self._runs, self._failures, rate))


def run(
    campaign: Campaign,
    runs: int,
    *,
    out: Path,
    jobs: int | None = None,
    chunk: int | None = None,
    only: tuple[int, int] | None = None,
    scheduler: str | None = None,
    progress: Callable[[State], None] | None = None,
) -> CampaignResult:
    """See `Campaign.run`."""
    runs = whole("runs", runs, least=1)
    if jobs is not None:
        whole("jobs", jobs, least=1)
    campaign = campaign.with_points(runs)
    _within_design(campaign, runs)
    store = Store(out)
    known = store.manifest()
    manifest = _manifest(campaign, runs, chunk, known)
    if known is not None and known["identity"] != manifest["identity"]:
        raise InputError(f"{out}: holds another campaign; {first_difference(known['resolved'], manifest['resolved'])}")
    size = manifest["chunk"]
    first, end = 0, runs
    if only is not None:
        first, end = _only(only, size, runs)
    damaged = store.damaged(first, end)
    for part in damaged:
        warnings.warn(f"{part.path}: is not what was written, and is flown again", stacklevel=3)
    missing = store.missing(first, end, size, damaged)
    if missing:
        with made_folder(out):
            _fly(campaign, store, manifest, missing, _Started(first, end, jobs, scheduler, progress, damaged))
    result = CampaignResult(out)
    if only is None:
        result.keep_trajectories()
    return result


@dataclass(frozen=True)
class _Started:
    first: int
    end: int
    jobs: int | None
    scheduler: str | None
    progress: Callable[[State], None] | None
    damaged: list[Part]


def _fly(
    campaign: Campaign, store: Store, manifest: dict[str, Any], missing: list[tuple[int, int]], how: _Started
) -> None:
    there = how.end - how.first - sum(b - a for a, b in missing)
    failures = store.failures(how.first, how.end, how.damaged) if there else 0
    teller = _Teller(how.progress, there, how.end - how.first, failures)
    begun = False
    for chunk in _chunks(campaign, missing, how, teller):
        if chunk.first == 0:
            _refuse_a_mistake(chunk)
        if not begun:
            store.begin(manifest)
            store.log(event="started", runs=manifest["runs"], jobs=how.jobs, missing=len(missing))
            for part in how.damaged:
                store.remove(part)
                store.log(event="removed", part=part.path.name)
            begun = True
        store.write(chunk)
        teller.add(chunk)
    store.log(event="ended")


def _chunks(campaign: Campaign, missing: list[tuple[int, int]], how: _Started, teller: _Teller) -> Iterator[Chunk]:
    if how.scheduler is not None:
        from gyrostat.campaign.cluster import flown

        yield from flown(campaign, missing, how.scheduler)
        return
    for a, b in missing:
        yield campaign.fly(a, b, jobs=how.jobs, progress=teller.within(b - a))


def _manifest(campaign: Campaign, runs: int, chunk: int | None, known: dict[str, Any] | None) -> dict[str, Any]:
    if chunk is not None:
        chunk = whole("chunk", chunk, least=1)
    told = resolved(campaign)
    return {
        "format": FORMAT,
        "identity": identity(told),
        "runs": max(runs, 0 if known is None else int(known["runs"])),
        "chunk": (chunk or CHUNK) if known is None else known["chunk"],
        "campaign": _readable(campaign),
        "resolved": told,
    }


def _readable(campaign: Campaign) -> dict[str, Any] | None:
    """What the folder's campaign is made of again; Python components cannot be written down."""
    if campaign.base.python_components():
        return None
    return campaign.standalone()


def _refuse_a_mistake(chunk: Chunk) -> None:
    rows = sum(c["runs"] for c in chunk.counts.values())
    refused = sum(c["status"].get("refused", 0) for c in chunk.counts.values())
    if refused > 0.5 * rows:
        where = chunk.table.column("status").to_pylist().index("refused")
        cause = chunk.table.column("cause")[where].as_py()
        raise InputError(
            f"{refused} of the first {rows} flights are refused, run "
            f"{chunk.table.column('run')[where]} because: {cause}"
        )


def _within_design(campaign: Campaign, runs: int) -> None:
    spec = campaign.spec
    if spec.sampling != "plain" and spec.points is not None:
        most = spec.points * (spec.replicates or 1)
        if runs > most:
            raise InputError(f"runs = {runs}: {spec.replicates} replicates of {spec.points} points are {most}")


def _only(only: tuple[int, int], size: int, runs: int) -> tuple[int, int]:
    if len(list(only)) != 2:
        raise InputError(f"only = {shown(only)}: two numbers of chunks, (first, end), belong here")
    a, b = (whole("chunks", x) for x in only)
    count = -(-runs // size)
    if not 0 <= a < b or a >= count:
        raise InputError(f"chunks {a}:{b}: {runs} runs are chunks 0:{count} of {size}; a part of these belongs here")
    return a * size, min(b * size, runs)


__all__ = ["CHUNK", "State", "run"]
