# SPDX-License-Identifier: MIT
"""Requirements on a campaign, and the verdict on them: ``gyrostat verify requirement.toml``.

A requirement says how probable a failure may be, or below which value a percentile of a measure lies; the second is the
first about flights beyond that value. The campaign is flown until every verdict is there or the runs are used up.
Page: docs/verification.md
"""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import numpy as np
from numpy.typing import NDArray
from pydantic import Field, model_validator

from gyrostat import toml
from gyrostat.campaign.flights import unknown_cell
from gyrostat.campaign.limits import MOST_RUNS
from gyrostat.errors import InputError, input_errors, suggestion
from gyrostat.files import file_errors, write_text
from gyrostat.model import Model
from gyrostat.verification.sensitivity import first_order
from gyrostat.verification.sequential import (
    Needed,
    Outcome,
    SequentialTest,
    Verdict,
    levels,
    quantile_interval,
    together,
)

if TYPE_CHECKING:
    from gyrostat.campaign import Campaign, CampaignResult, State

Counts = NDArray[np.int64]
Confidence = Annotated[float, Field(ge=0.5, lt=1.0)]

LISTED = 5
"""Failing flights that are named."""
GROWTH = 0.1
"""Share of the flown runs that is flown before the next look."""
SENSITIVITY_RUNS = 100_000
VERIFIED = "requirements.json"
"""In a folder: what was verified."""


def shipped() -> dict[str, Path]:
    """Files of requirements that come with the package, by name."""
    return {p.stem: p for p in sorted((Path(__file__).parent.parent / "requirements").glob("*.toml"))}


class Bounds(Model):
    """Values of a measure that are failures; so is a missing value."""

    above: float | None = None
    below: float | None = None

    @model_validator(mode="after")
    def _fits(self) -> Bounds:
        given = [x for x in (self.above, self.below) if x is not None]
        if not given or not all(math.isfinite(x) for x in given):
            raise InputError("a finite 'above' or 'below' belongs here")
        return self

    def failed(self, x: NDArray[np.float64]) -> NDArray[np.bool_]:
        """Which values are failures."""
        good = np.ones(x.shape, bool)
        if self.above is not None:
            good &= x <= self.above
        if self.below is not None:
            good &= x >= self.below
        return np.asarray(~good)


class Probability(Model):
    """How probable a failure may be."""

    at_most: Annotated[float, Field(gt=0.0, lt=1.0)]
    confidence: Confidence = 0.95


class Percentile(Model):
    """Below which value a percentile of a measure lies."""

    of: str
    level: Annotated[float, Field(gt=0.0, lt=1.0)]
    at_most: Annotated[float, Field(allow_inf_nan=False)]
    confidence: Confidence = 0.95


class Requirement(Model):
    """One requirement; see the module."""

    id: str
    text: str = ""
    fails: Annotated[dict[str, Bounds], Field(min_length=1)] | None = None
    probability: Probability | None = None
    percentile: Percentile | None = None
    cell: str | None = None

    @model_validator(mode="after")
    def _fits(self) -> Requirement:
        if (self.probability is None) == (self.percentile is None):
            raise InputError(f"{self.id}: one of 'probability' and 'percentile' belongs here")
        if self.percentile is not None and self.fails is not None:
            raise InputError(f"{self.id}: 'fails' belongs to 'probability'; a percentile says itself what fails")
        return self

    @property
    def limit(self) -> float:
        """Failure probability that is tested."""
        if self.probability is not None:
            return self.probability.at_most
        assert self.percentile is not None
        return 1.0 - self.percentile.level

    @property
    def confidence(self) -> float:
        """In the verdict."""
        chosen = self.probability or self.percentile
        assert chosen is not None
        return chosen.confidence

    @property
    def measures(self) -> tuple[str, ...]:
        """That decide about failure; none: the campaign's ``[success]``."""
        if self.percentile is not None:
            return (self.percentile.of,)
        return tuple(self.fails or ())

    def failed(self, rows: Mapping[str, NDArray[Any]]) -> NDArray[np.bool_]:
        """Which rows of a campaign are failures; a flight that ended early always is."""
        lost = np.asarray(rows["status"] != "completed")
        if self.percentile is not None:
            bounds = Bounds(above=self.percentile.at_most)
            return np.asarray(lost | bounds.failed(rows[self.percentile.of]))
        if self.fails is None:
            return np.asarray(lost | ~rows["success"].astype(bool))
        for name, bounds in self.fails.items():
            lost = lost | bounds.failed(rows[name])
        return np.asarray(lost)


class RequirementFile(Model):
    """``requirement.toml``: a campaign, how many runs at most, and requirements."""

    campaign: str
    max_runs: Annotated[int, Field(ge=1, le=MOST_RUNS)]
    familywise: bool = False
    requirement: Annotated[list[Requirement], Field(min_length=1)]

    @model_validator(mode="after")
    def _fits(self) -> RequirementFile:
        ids = [r.id for r in self.requirement]
        if len(set(ids)) < len(ids):
            raise InputError("requirement: an id stands twice")
        return self

    @classmethod
    def load(cls, name: str | Path) -> RequirementFile:
        """Of a file, or shipped, by name. A campaign that is a file is looked for beside it. Messages name the file."""
        path, known = Path(name), shipped()
        if path.suffix != ".toml" and str(name) in known:
            path = known[str(name)]
        elif path.suffix != ".toml" and not path.exists():
            raise InputError(f"no requirements '{name}'{suggestion(str(name), known)}")
        tables = toml.read(Path(path))
        with input_errors(str(path)):
            read = cls(**tables)
        if read.campaign.endswith(".toml"):
            return read.model_copy(update={"campaign": str(Path(path).parent / read.campaign)})
        return read


@dataclass(frozen=True)
class Judgement:
    """The verdict on one requirement in one cell.

    Attributes
    ----------
    requirement, cell
        Which.
    verdict
        Latched at its first crossing.
    needed
        Runs still needed; None when decided.
    quantile
        Of a percentile requirement: interval of that percentile over all flown runs.
    lost
        Failing runs among all flown ones.
    failing
        Numbers of the first of them.
    dominant
        Inputs with the largest first-order indices of the measure, with the index.
    evidence
        As of `SequentialTest.evidence`.
    wanted
        Evidence at which PASS and FAIL are given.
    """

    requirement: Requirement
    cell: str
    verdict: Verdict
    needed: Needed | None
    quantile: tuple[float, float] | None
    lost: int
    failing: tuple[int, ...]
    dominant: tuple[tuple[str, float], ...]
    evidence: tuple[Counts, NDArray[np.float64], NDArray[np.float64]]
    wanted: tuple[float, float]

    @property
    def name(self) -> str:
        """Of the requirement, and the cell where there is a grid."""
        return f"{self.requirement.id} [{self.cell}]" if self.cell else self.requirement.id


@dataclass(frozen=True)
class Report:
    """The verdict on a file of requirements.

    Attributes
    ----------
    outcome
        FAIL if any requirement fails, PASS if all pass.
    judgements
        One a requirement and cell.
    runs
        Flown.
    max_runs
        That may be flown.
    folder
        That holds them.
    """

    outcome: Outcome
    judgements: tuple[Judgement, ...]
    runs: int
    max_runs: int
    folder: Path

    @property
    def exit_status(self) -> int:
        """0 PASS, 1 FAIL, 4 UNDECIDED."""
        return {"PASS": 0, "FAIL": 1, "UNDECIDED": 4}[self.outcome]


def verify(
    file: RequirementFile | str | Path,
    out: str | Path,
    *,
    runs: int | None = None,
    jobs: int | None = None,
    progress: Callable[[State], None] | None = None,
) -> Report:
    """Fly the campaign until the verdict is there.

    Looking often costs nothing: the verdict is that of looking after every run. A further call goes on with the folder.

    Parameters
    ----------
    file
        Requirements, or their file.
    out
        Folder of the campaign, new or to go on with.
    runs
        At most, instead of ``max_runs``.
    jobs
        Threads.
    progress
        As of `Campaign.run`.

    Raises
    ------
    InputError
        A file, campaign or folder that does not fit; a campaign whose runs are not independent.
    """
    from gyrostat.campaign import Campaign, CampaignResult

    wanted = file if isinstance(file, RequirementFile) else RequirementFile.load(file)
    campaign = Campaign.load(wanted.campaign)
    pairs = _pairs(wanted, campaign)
    most = wanted.max_runs if runs is None else runs
    folder = Path(out)
    flown = CampaignResult(folder).runs if (folder / "manifest.json").exists() else 0
    goal = min(most, max(flown, 500))
    while True:
        result = campaign.run(max(goal, 1), out=folder, jobs=jobs, progress=progress)
        found = _Failures.of(result, pairs, goal)
        outcomes = [found.test(i).crossing(found.failures[i], goal)[0] for i in range(len(pairs))]
        if goal >= most or together(outcomes) != "UNDECIDED":
            break
        goal = min(most, goal + max(500, int(GROWTH * goal) // 500 * 500))
    report = _reported(found, campaign, result, most, wanted.max_runs)
    draw_evidence(report, folder / "evidence.png")
    told = {"file": wanted.model_dump(mode="json", exclude_none=True), "runs": goal, "max_runs": most}
    write_text(folder / VERIFIED, json.dumps(told, indent=1) + "\n")
    return report


def verified(result: CampaignResult) -> Report | None:
    """The verdict that `verify` gave on a folder, from its rows again; None where it gave none.

    Raises
    ------
    InputError
        What `verify` left there is not what it wrote.
    """
    path = result.folder / VERIFIED
    if not path.exists():
        return None
    with file_errors(path, "cannot be read"):
        text = path.read_text(encoding="utf-8")
    with input_errors(str(path)):
        try:
            told = json.loads(text)
            file, runs, most = RequirementFile(**told["file"]), int(told["runs"]), int(told["max_runs"])
        except (ValueError, TypeError, KeyError, OverflowError):
            runs, most = 0, 0
        if not 1 <= runs <= min(result.runs, most):
            raise InputError("is not what gyrostat verify wrote; call it again")
        pairs = _pairs(file, result.campaign)
    return _reported(_Failures.of(result, pairs, runs), result.campaign, result, most, file.max_runs)


def _reported(found: _Failures, campaign: Campaign, result: CampaignResult, most: int, affordable: int) -> Report:
    ahead = max(most, affordable)
    judgements = tuple(_judged(found, i, campaign, result, ahead) for i in range(len(found.pairs)))
    outcome = together([j.verdict.outcome for j in judgements])
    return Report(outcome, judgements, found.runs, most, result.folder)


def _pairs(file: RequirementFile, campaign: Campaign) -> list[tuple[Requirement, str, SequentialTest]]:
    """Requirements by cell, with their tests; what does not fit is refused before anything flies."""
    if campaign.spec.sampling != "plain":
        raise InputError(
            f"verify: sampling = '{campaign.spec.sampling}': its runs depend on each other, and the test counts on "
            "independent ones; write sampling = 'plain'"
        )
    pairs = []
    for requirement in file.requirement:
        with input_errors(f"requirement '{requirement.id}'"):
            for name in requirement.measures:
                if name not in campaign.measures:
                    raise InputError(f"no measure '{name}'{suggestion(name, campaign.measures)}")
            if requirement.measures and campaign.spec.keep.rows != "all":
                raise InputError("the campaign keeps rows of its own failures alone; write [keep] rows = 'all'")
            if not requirement.measures and not campaign.spec.success:
                raise InputError("neither 'fails' nor the campaign's [success] says what a failure is")
            if requirement.cell is not None and requirement.cell not in campaign.cells:
                raise unknown_cell(requirement.cell, campaign.cells)
        cells = campaign.cells if requirement.cell is None else (requirement.cell,)
        pairs += [(requirement, cell) for cell in cells]
    tests = []
    for requirement, cell in pairs:
        alpha, beta = levels(requirement.confidence, len(pairs), familywise=file.familywise)
        tests.append((requirement, cell, SequentialTest(requirement.limit, alpha, beta)))
    return tests


@dataclass(frozen=True)
class _Failures:
    """Numbers of the failing runs of each requirement and cell."""

    pairs: list[tuple[Requirement, str, SequentialTest]]
    failures: list[Counts]
    runs: int

    @classmethod
    def of(cls, result: CampaignResult, pairs: list[tuple[Requirement, str, SequentialTest]], runs: int) -> _Failures:
        names = ["run", "cell", "success", "status", *{n for r, _, _ in pairs for n in r.measures}]
        found: list[list[Counts]] = [[] for _ in pairs]
        for rows in _rows(result, names):
            for i, (requirement, cell, _) in enumerate(pairs):
                mine = (rows["cell"] == cell) & requirement.failed(rows) & (rows["run"] < runs)
                found[i].append(rows["run"][mine])
        empty = np.empty(0, np.int64)
        return cls(pairs, [np.sort(np.concatenate([empty, *parts])) for parts in found], runs)

    def test(self, i: int) -> SequentialTest:
        return self.pairs[i][2]


def _rows(result: CampaignResult, names: list[str]) -> Any:
    """Kept rows as numpy columns, part by part."""
    for table in result.tables(names):
        yield {name: _column(table.column(name)) for name in names}


def _column(column: Any) -> NDArray[Any]:
    values = column.to_pylist() if "string" in str(column.type) else column.to_numpy(zero_copy_only=False)
    return np.asarray(values)


def _judged(found: _Failures, i: int, campaign: Campaign, result: CampaignResult, ahead: int) -> Judgement:
    requirement, cell, test = found.pairs[i]
    failures = found.failures[i]
    verdict = test.decide(failures, found.runs)
    needed = None
    if verdict.outcome == "UNDECIDED":
        needed = test.still_needed(verdict.runs, verdict.failures, most=ahead)
    measure = requirement.measures[0] if requirement.measures else next(iter(campaign.spec.success), None)
    quantile: tuple[float, float] | None = None
    dominant: tuple[tuple[str, float], ...] = ()
    if measure is not None and campaign.spec.keep.rows == "all":
        y = np.full(found.runs, np.nan)
        ended = np.zeros(found.runs, bool)
        for rows in _rows(result, ["run", "cell", "status", measure]):
            mine = (rows["cell"] == cell) & (rows["run"] < found.runs)
            y[rows["run"][mine]] = rows[measure][mine]
            ended[rows["run"][mine]] = rows["status"][mine] != "completed"
        if requirement.percentile is not None:
            values = np.where(ended, np.inf, y)
            quantile = quantile_interval(values, requirement.percentile.level, 1 - requirement.confidence)
        dominant = _dominant(campaign, np.where(ended, np.nan, y))
    evidence = test.evidence(failures, found.runs)
    named = tuple(failures[:LISTED].tolist())
    wanted = 1 / test.alpha, 1 / test.beta
    return Judgement(requirement, cell, verdict, needed, quantile, failures.size, named, dominant, evidence, wanted)


def in_words(needed: float) -> str:
    """Runs that are still needed, to three digits."""
    return f"{float(f'{needed:.3g}'):.0f}" if math.isfinite(needed) else "more than max_runs"


def draw_evidence(report: Report, path: Path) -> None:
    """Evidence against runs of every requirement, as a picture: so that stopping can be judged."""
    from matplotlib.figure import Figure

    from gyrostat.files import replacing

    count = len(report.judgements)
    figure = Figure(figsize=(6.4, 2.4 * count), layout="constrained")
    for axes, judgement in zip(figure.subplots(count, squeeze=False)[:, 0], report.judgements, strict=True):
        at, for_pass, for_fail = judgement.evidence
        axes.plot(at, for_pass / math.log(10), label="for PASS")
        axes.plot(at, np.where(np.isfinite(for_fail), for_fail, np.nan) / math.log(10), label="for FAIL")
        for wanted in set(judgement.wanted):
            axes.axhline(math.log10(wanted), color="0.5", lw=0.8)
        axes.set(title=f"{judgement.name}: {judgement.verdict.outcome}", xscale="log", ylabel="log10 evidence")
        axes.set_ylim(bottom=-3)
        axes.legend()
    axes.set_xlabel("runs")
    with replacing(path) as temporary:
        figure.savefig(temporary, dpi=150)


def _dominant(campaign: Campaign, y: NDArray[np.float64], count: int = 3) -> tuple[tuple[str, float], ...]:
    """Inputs by first-order index, those above the scatter of so many runs."""
    n = min(y.size, SENSITIVITY_RUNS)
    indices = first_order(campaign.points(0, n), y[:n])
    order = np.argsort(-np.nan_to_num(indices))[:count]
    floor = max(0.02, 4 * math.sqrt(2 * 31) / n)
    return tuple((campaign.inputs[i], float(indices[i])) for i in order.tolist() if indices[i] > floor)


__all__ = [
    "Bounds",
    "Judgement",
    "Percentile",
    "Probability",
    "Report",
    "Requirement",
    "RequirementFile",
    "draw_evidence",
    "in_words",
    "shipped",
    "verified",
    "verify",
]
