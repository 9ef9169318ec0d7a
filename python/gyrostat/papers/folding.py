# SPDX-License-Identifier: MIT
"""The claims of a study as a table reads them: by experiment, the repeats over seeds in one row."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from gyrostat.papers.claims import Claim, Evaluation, Statement
from gyrostat.papers.reproduction import Reproduction


@dataclass(frozen=True)
class Row:
    """A claim on an experiment, with the same claim on its repeats with other seeds."""

    evaluations: tuple[Evaluation, ...]
    """The experiment as it stands first, if the claim is about it."""

    @property
    def first(self) -> Evaluation:
        """What stands for all in a table."""
        return self.evaluations[0]

    @property
    def claim(self) -> Claim:
        """The claim of the first."""
        return self.first.claim

    @property
    def name(self) -> str:
        """Of the claim, without the case."""
        return self.claim.id.partition("@")[0]

    @property
    def measured(self) -> tuple[float, ...]:
        """What was measured, one a repeat."""
        return tuple(e.measured for e in self.evaluations if e.measured is not None)

    @property
    def accepted(self) -> int:
        """How many are accepted."""
        return sum(e.ok for e in self.evaluations)

    @property
    def ok(self) -> bool:
        """Whether all are accepted."""
        return self.accepted == len(self.evaluations)

    @property
    def statement(self) -> Statement | None:
        """What became of the publication's statement; open where repeats differ."""
        found = {e.statement for e in self.evaluations}
        return found.pop() if len(found) == 1 else "open"

    @property
    def verdict(self) -> str:
        """In words; that of repeats which differ says so."""
        found = {e.verdict for e in self.evaluations}
        return found.pop() if len(found) == 1 else "differs between seeds"

    @property
    def troubles(self) -> tuple[str, ...]:
        """Why something was not measured, each reason once."""
        return tuple(dict.fromkeys(e.trouble for e in self.evaluations if e.trouble))


@dataclass(frozen=True)
class ExperimentRows:
    """A case or campaign, its repeats with other seeds, and its claims."""

    id: str
    cases: tuple[str, ...]
    """The case and its repeats."""
    rows: tuple[Row, ...]


def folded(found: Reproduction) -> list[ExperimentRows]:
    """Every claim, by experiment, in the order of the cases; one without claims is left out."""
    base = {key: case.repeats or key for key, case in found.paper.cases.items()} | {k: k for k in found.paper.campaigns}
    repeats: dict[str, list[str]] = {}
    for case, experiment in base.items():
        repeats.setdefault(experiment, []).append(case)
    rows: dict[str, dict[str, list[Evaluation]]] = {}
    for e in found.evaluations:
        of_case = rows.setdefault(base[e.claim.case], {})
        of_case.setdefault(e.claim.id.partition("@")[0], []).append(e)
    return [
        ExperimentRows(key, tuple(cases), tuple(Row(tuple(same)) for same in rows[key].values()))
        for key, cases in repeats.items()
        if key in rows
    ]


@dataclass(frozen=True)
class Tally:
    """A study in numbers."""

    claims: int
    accepted: int
    holds: int
    """Statements of the publication, repeats over seeds counted once."""
    fails: int
    open: int

    @classmethod
    def of(cls, experiments: Sequence[ExperimentRows]) -> Tally:
        """Counted over all experiments."""
        rows = [row for e in experiments for row in e.rows]
        said = [row.statement for row in rows]
        return cls(
            sum(len(row.evaluations) for row in rows),
            sum(row.accepted for row in rows),
            said.count("holds"),
            said.count("fails"),
            said.count("open"),
        )


__all__ = ["ExperimentRows", "Row", "Tally", "folded"]
