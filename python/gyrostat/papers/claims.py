# SPDX-License-Identifier: MIT
"""Claims: how the rows of a ``claims.toml`` read, and what holding one against a result gives."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass
from fnmatch import fnmatchcase
from typing import Annotated, Any, Literal

from pydantic import ConfigDict, Field

from gyrostat.errors import InputError, input_errors, suggestion
from gyrostat.model import Model
from gyrostat.papers.campaigns import ENSEMBLE_METRICS, CampaignCase, Ensemble
from gyrostat.papers.measures import METRICS, Array, Measure, Metric
from gyrostat.results import Result

Statement = Literal["holds", "fails", "open"]
"""What became of a statement of a publication; open: what was measured does not decide it."""

_statements: dict[str, Statement] = {"reproduces": "holds", "does not reproduce": "fails"}


class ClaimEntry(Model):
    """A row of a ``[[claims]]`` table, with what it shares with the others."""

    id: str
    case: str | list[str]
    quantity: str
    published: float | str | None = None
    reported: list[float | str] | None = None
    accept: Annotated[list[float | str], Field(min_length=2, max_length=2)]
    measure: dict[str, Any]
    note: str = ""


class MeasurementEntry(Model):
    """One ``[[claims]]`` table: a measurement, what its rows share, and the rows. Without rows it is the one row."""

    model_config = ConfigDict(extra="allow")

    measure: dict[str, Any]
    rows: Annotated[list[dict[str, Any]], Field(default_factory=lambda: [{}], min_length=1)]

    def entries(self) -> Iterator[ClaimEntry]:
        """Its claims. What is no key of a claim in a row is an argument of the measure."""
        of_claim = ClaimEntry.model_fields.keys() - {"measure"}
        for row in self.rows:
            told = {**(self.model_extra or {}), **{key: value for key, value in row.items() if key in of_claim}}
            arguments = {key: value for key, value in row.items() if key not in of_claim}
            with input_errors(f"claim '{told.get('id', '')}'"):
                yield ClaimEntry(**told, measure=self.measure | arguments)


@dataclass(frozen=True)
class Claim:
    """One statement about one case."""

    id: str
    case: str
    quantity: str
    published: float | str | None
    reported: tuple[float, float] | None
    accept: tuple[float, float]
    measure: Measure
    note: str

    def fits(self, pattern: str) -> bool:
        """Whether a pattern names it, with or without its case: ``t1.*``."""
        return any(fnmatchcase(name, pattern) for name in (self.id, self.id.partition("@")[0]))

    def evaluate(self, result: Result | Ensemble, results: Mapping[str, Result]) -> Evaluation:
        """Measure it on the result of its case."""
        measured, trouble = None, ""
        try:
            value = self.measure(result, results)
            measured = value if math.isfinite(value) else None
            if measured is None:
                trouble = f"measured {value}"
        except (KeyError, ValueError, IndexError) as error:
            trouble = f"not measured: {error.args[0] if error.args else error}"
        return Evaluation(self, measured, trouble)


@dataclass(frozen=True)
class Evaluation:
    """A claim and what was measured."""

    claim: Claim
    measured: float | None
    trouble: str = ""
    """Why nothing was measured."""

    @property
    def note(self) -> str:
        """Why nothing was measured, and what a reader should know."""
        return "; ".join(part for part in (self.trouble, self.claim.note) if part)

    @property
    def ok(self) -> bool:
        """Whether the measured value is accepted; a value that could not be measured is not."""
        return _inside(self.measured, self.claim.accept)

    @property
    def verdict(self) -> str:
        """Whether the publication's statement holds for what was measured."""
        if self.measured is None:
            return "not measured"
        if self.claim.reported is None:
            return "measured only"
        return "reproduces" if _inside(self.measured, self.claim.reported) else "does not reproduce"

    @property
    def statement(self) -> Statement | None:
        """The same for a table: None where the publication states nothing."""
        if self.claim.reported is None and self.claim.published is None:
            return None
        return _statements.get(self.verdict, "open")

    def to_dict(self) -> dict[str, Any]:
        """As ``gyrostat reproduce --json`` prints it; null is an open end."""
        claim = self.claim
        return {
            "id": claim.id,
            "case": claim.case,
            "quantity": claim.quantity,
            "published": claim.published,
            "measured": self.measured,
            "accept": [end if math.isfinite(end) else None for end in claim.accept],
            "ok": self.ok,
            "verdict": self.verdict,
            "note": self.note,
        }


@dataclass(frozen=True)
class Subjects:
    """What claims can be about, and what they can be measured with."""

    cases: Collection[str]
    campaigns: Mapping[str, CampaignCase]
    metrics: Mapping[str, Metric]
    """Of the study, beside `METRICS`."""
    signals: Mapping[str, Callable[[Result], Array]]

    def claims(self, tables: Sequence[MeasurementEntry]) -> tuple[Claim, ...]:
        """Of the tables of a study, in their order; mistakes show now, not after an hour of running."""
        entries = [entry for table in tables for entry in table.entries()]
        claims = tuple(claim for entry in entries for claim in self._claims(entry))
        seen: set[str] = set()
        for claim in claims:
            if claim.id in seen:
                raise InputError(f"claim '{claim.id}' stands twice")
            seen.add(claim.id)
        return claims

    def _claims(self, entry: ClaimEntry) -> list[Claim]:
        """One a case."""
        several = not isinstance(entry.case, str)
        names = [entry.case] if isinstance(entry.case, str) else entry.case
        with input_errors(f"claim '{entry.id}'"):
            measure = self._measure(entry.measure, names)
            reported = None if entry.reported is None else _interval(entry.reported)
            accept = _interval(entry.accept)
        return [
            Claim(
                f"{entry.id}@{name}" if several else entry.id,
                name,
                entry.quantity,
                entry.published,
                reported,
                accept,
                measure,
                entry.note,
            )
            for name in names
        ]

    def _measure(self, table: Mapping[str, Any], names: Sequence[str]) -> Measure:
        """What measures all these cases, or all these campaigns."""
        for name in names:
            if name not in self.cases and name not in self.campaigns:
                raise InputError(f"no case '{name}'{suggestion(name, [*self.cases, *self.campaigns])}")
        of_runs = [name in self.campaigns for name in names]
        if not any(of_runs):
            return Measure.of(table, {**METRICS, **self.metrics}, self.signals, self.cases)
        if not all(of_runs):
            raise InputError("cases and campaigns are measured by different claims")
        measure = Measure.of(table, ENSEMBLE_METRICS, {}, ())
        for name in names:
            if measure.signal not in self.campaigns[name].campaign.measures:
                raise InputError(f"campaign '{name}' does not measure '{measure.signal}'")
        return measure


def _interval(ends: Sequence[float | str]) -> tuple[float, float]:
    try:
        lo, hi = (float(end) for end in ends)
    except ValueError:
        raise InputError(f"{list(ends)} must be two numbers, '-inf' or 'inf'") from None
    if not lo <= hi:
        raise InputError(f"{list(ends)} is empty: the first end lies above the second")
    return lo, hi


def _inside(value: float | None, ends: tuple[float, float]) -> bool:
    return value is not None and ends[0] <= value <= ends[1]


__all__ = ["Claim", "ClaimEntry", "Evaluation", "MeasurementEntry", "Statement", "Subjects"]
