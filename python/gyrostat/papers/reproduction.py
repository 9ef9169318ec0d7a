# SPDX-License-Identifier: MIT
"""Reproducing a study: every case is flown, every claim is measured."""

from __future__ import annotations

import os
import threading
from collections.abc import Callable, Iterator, Mapping
from concurrent.futures import Executor, ThreadPoolExecutor, as_completed
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from typing import Any

from gyrostat.papers.campaigns import Ensemble
from gyrostat.papers.claims import Evaluation
from gyrostat.papers.study import Paper
from gyrostat.results import Result


@dataclass(frozen=True)
class Reproduction:
    """What `reproduce` found."""

    paper: Paper
    evaluations: tuple[Evaluation, ...]
    results: Mapping[str, Result]
    """Of the cases that figures need."""
    endings: Mapping[str, str]
    """Cause of each case that ended early."""
    ensembles: Mapping[str, Ensemble] = field(default_factory=dict)
    """What the campaigns measured."""

    @property
    def failed(self) -> int:
        """Number of claims outside their acceptance."""
        return sum(not e.ok for e in self.evaluations)

    def without_results(self) -> Reproduction:
        """What was measured, without the series that figures are drawn from."""
        return replace(self, results={}, ensembles={})

    def _repr_html_(self) -> str:
        from gyrostat import notebook

        return notebook.reproduction(self)

    def to_dict(self) -> dict[str, Any]:
        """As ``gyrostat reproduce --json`` prints it."""
        return {
            "paper": self.paper.id,
            "claims": [e.to_dict() for e in self.evaluations],
            "passed": len(self.evaluations) - self.failed,
            "failed": self.failed,
        }


def reproduce(
    paper: Paper, *, progress: Callable[[float], None] | None = None, workers: int | None = None
) -> Reproduction:
    """Fly every case of a study and evaluate every claim.

    Parameters
    ----------
    paper
        From `load`.
    progress
        Called with the finished fraction.
    workers
        Cases, and runs of a campaign, flown at once; one a core by default (the compiled loop runs without Python's
        global lock). The results do not depend on it.
    """
    keep = paper.needed_later()
    results: dict[str, Result] = {}
    found: dict[str, Evaluation] = {}
    endings: dict[str, str] = {}
    meter = _Meter(paper, progress)
    with _pool(workers, meter) as pool:
        longest_first = sorted(paper.cases.values(), key=lambda c: -c.scenario.duration / c.scenario.dt)
        runs = {pool.submit(c.scenario.run, progress=meter.of(c.id)): c.id for c in longest_first}
        for run in as_completed(runs):
            case = runs.pop(run)
            result = run.result()
            meter.advance(case, 1.0)
            if not result.completed:
                endings[case] = result.cause or result.status
            if case in keep:
                results[case] = result
            for claim in paper.claims:
                if claim.case == case and not claim.measure.others:
                    found[claim.id] = claim.evaluate(result, {})
    flown = {c.id: c.fly(workers=workers, progress=meter.of(c.id)) for c in paper.campaigns.values()}
    for claim in paper.claims:
        if claim.id not in found:
            about = flown[claim.case] if claim.case in flown else results[claim.case]
            found[claim.id] = claim.evaluate(about, results)
    return Reproduction(paper, tuple(found[c.id] for c in paper.claims), results, endings, flown)


@contextmanager
def _pool(workers: int | None, meter: _Meter) -> Iterator[Executor]:
    """Threads that fly. When the block fails or is interrupted, what waits is dropped and what flies ends at once."""
    pool = ThreadPoolExecutor(workers or os.cpu_count())
    try:
        yield pool
    except BaseException:
        meter.stop()
        pool.shutdown(cancel_futures=True)
        raise
    pool.shutdown()


class _StoppedError(Exception):
    """Ends a run that nobody waits for any more."""


class _Meter:
    """Adds up the progress of cases that run at once, weighted by their samples, and can stop them all."""

    def __init__(self, paper: Paper, report: Callable[[float], None] | None) -> None:
        self._weight = {key: c.scenario.duration / c.scenario.dt for key, c in paper.cases.items()}
        for key, many in paper.campaigns.items():
            self._weight[key] = many.runs * many.campaign.base.duration / many.campaign.base.dt
        self._done = dict.fromkeys(self._weight, 0.0)
        self._report = report
        self._lock = threading.Lock()
        self._stopped = False

    def stop(self) -> None:
        """Let every run end when it looks here the next time: after a fifth of a second, or the sample in hand."""
        self._stopped = True

    def look(self, _: float = 0.0) -> None:
        """What a run calls now and then."""
        if self._stopped:
            raise _StoppedError

    def of(self, case: str) -> Callable[[float], None]:
        """What the run of a case calls now and then, with the finished fraction."""

        def flown(fraction: float) -> None:
            self.look()
            self.advance(case, fraction)

        return flown

    def advance(self, case: str, fraction: float) -> None:
        """Report a finished fraction."""
        if self._report is None or self._stopped:
            return
        with self._lock:
            self._done[case] = fraction
            total = sum(self._weight.values())
            self._report(sum(self._done[c] * w for c, w in self._weight.items()) / total)


__all__ = ["Reproduction", "reproduce"]
