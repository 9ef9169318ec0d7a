# SPDX-License-Identifier: MIT
"""Published studies as data: scenarios, claims and figures; `reproduce` flies the cases and evaluates the claims.

How to add a study
------------------
A study is a folder ``papers/<id>/`` (with an empty ``__init__.py``) that holds

``scenarios/<name>.toml``
    Its experiments. Parameters of the publication belong here, never into a component's defaults.
``claims.toml``
    What it claims and what we accept::

        title = "..."
        citation = "..., journal, year, doi"
        record = ["truth.mrp", "allocation.u", "observer.z1"]   # what every case keeps, if its scenario does not say

        [cases.table1]                       # scenarios/table1.toml
        [cases.table1_10ms]
        title = "Table 1 at 10 ms"
        scenario = "table1"                  # another case of the same scenario, with values changed
        set = { dt = 0.01, "controller.k1" = 4.9 }
        [cases.table1_10ms_cvode]
        like = "table1_10ms"                 # an earlier case with its changes, and more of them
        set = { integrator = "cvode" }

        [[claims]]
        id = "t1.settling_1e-3"
        case = "table1"                      # or a list: the claim is then evaluated for each, as <id>@<case>
        quantity = "settling time of the MRP to 1e-3, s"
        published = 50                       # number or text of the publication; absent: it gives none
        reported = ["-inf", 50]              # the measured values for which the publication's statement holds
        accept = [42, 46]                    # what this library must measure; "-inf" and "inf" are open ends
        measure = { metric = "settling_time", signal = "truth.mrp", band = 1e-3 }
        note = "..."                         # what a reader should know; may be absent

    ``ok`` says whether the measured value lies in ``accept``, the verdict whether it lies in ``reported``: a claim can
    be ok and still show that a publication's statement does not hold. `metric` names an entry of `METRICS` (or of the
    study's own), the other keys of ``measure`` are its arguments. `signal` is a channel or one of the study's signals;
    ``column = 2`` picks a component. The size of a signal is its largest component, unless the metric says otherwise.
    ``[campaigns.<id>]`` tables fly one case many times with sampled changes: `gyrostat.papers.campaigns`.
``signals.py`` (may be absent)
    ``SIGNALS: dict[str, Callable[[Result], ndarray]]``, quantities computed from channels, one row a sample; and
    ``METRICS: dict[str, Callable[..., float]]``, called with the result and the keyword arguments of ``measure``;
    ``SAMPLERS: dict[str, Callable[..., dict]]`` of its campaigns.
``figures.py`` (may be absent)
    ``FIGURES: list[PaperFigure]``: name, caption, the cases it needs, and a function of the results (by case) that
    draws a `gyrostat.plots.Figure`. Its data are saved beside the picture. An `EnsembleFigure` draws campaigns.
"""

from __future__ import annotations

import importlib
import importlib.util
import math
import os
import threading
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import Executor, ThreadPoolExecutor, as_completed
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from pydantic import Field

from gyrostat import toml
from gyrostat.errors import InputError, input_errors, suggestion
from gyrostat.model import Model
from gyrostat.papers.campaigns import ENSEMBLE_METRICS, Campaign, CampaignEntry, Ensemble, build
from gyrostat.papers.measures import METRICS, Measure
from gyrostat.results import Result
from gyrostat.scenario import Scenario

if TYPE_CHECKING:
    from gyrostat.plots import Figure

_folder = Path(__file__).parent


class ClaimEntry(Model):
    """One ``[[claims]]`` table of a ``claims.toml``."""

    id: str
    case: str | list[str]
    quantity: str
    published: float | str | None = None
    reported: list[float | str] | None = None
    accept: Annotated[list[float | str], Field(min_length=2, max_length=2)]
    measure: dict[str, Any]
    note: str = ""


class CaseEntry(Model):
    """One ``[cases.<id>]`` table of a ``claims.toml``."""

    title: str = ""
    scenario: str | None = None
    like: str | None = None
    set: Annotated[dict[str, Any], Field(default_factory=dict)]


class ClaimsFile(Model):
    """A ``claims.toml``."""

    title: str
    citation: str
    record: list[str] | None = None
    cases: dict[str, CaseEntry]
    campaigns: Annotated[dict[str, CampaignEntry], Field(default_factory=dict)]
    claims: list[ClaimEntry]


@dataclass(frozen=True)
class Case:
    """One experiment."""

    id: str
    title: str
    scenario: Scenario

    @property
    def integrator(self) -> str:
        """Name of the integrator that flew it."""
        return str(self.scenario.resolve()["integrator"]["type"])


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
        return Evaluation(self, measured, "; ".join(part for part in (trouble, self.note) if part))


@dataclass(frozen=True)
class Evaluation:
    """A claim and what was measured."""

    claim: Claim
    measured: float | None
    note: str

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
class PaperFigure:
    """A figure of a study: `draw` gets the results by case."""

    name: str
    caption: str
    cases: Sequence[str]
    draw: Callable[[Mapping[str, Result]], Figure]


@dataclass(frozen=True)
class EnsembleFigure:
    """A figure of a study about its campaigns: `draw` gets what they measured, by campaign."""

    name: str
    caption: str
    campaigns: Sequence[str]
    draw: Callable[[Mapping[str, Ensemble]], Figure]


@dataclass(frozen=True)
class Paper:
    """A study: cases, campaigns, claims, figures."""

    id: str
    title: str
    citation: str
    cases: Mapping[str, Case]
    claims: tuple[Claim, ...]
    figures: tuple[PaperFigure | EnsembleFigure, ...]
    campaigns: Mapping[str, Campaign] = field(default_factory=dict)

    def needed_later(self) -> set[str]:
        """Cases whose results figures or claims about two cases ask for."""
        compared = [c for c in self.claims if c.measure.others]
        return {c for f in self.figures if isinstance(f, PaperFigure) for c in f.cases} | {
            o for c in compared for o in (c.case, *c.measure.others)
        }


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

    def to_dict(self) -> dict[str, Any]:
        """As ``gyrostat reproduce --json`` prints it."""
        return {
            "paper": self.paper.id,
            "claims": [e.to_dict() for e in self.evaluations],
            "passed": len(self.evaluations) - self.failed,
            "failed": self.failed,
        }


def available() -> list[str]:
    """Identifiers of the studies that come with the package."""
    return sorted(p.parent.name for p in _folder.glob("*/claims.toml"))


def load(name: str) -> Paper:
    """A study by its identifier, or by the path of its folder.

    Raises
    ------
    InputError
        No such study, or something in its claims cannot be understood: file, claim and key are named.
    """
    folder = next((f for f in (Path(name), _folder / name) if _is_study(f)), None)
    if folder is None:
        raise InputError(f"no paper '{name}'{suggestion(name, [*available(), 'all'])}")
    source = folder / "claims.toml"
    tables = toml.read(source)
    with input_errors(str(source)):
        entries = ClaimsFile(**tables)
        modules = _Extensions(folder)
        cases: dict[str, Case] = {}
        for key, entry in entries.cases.items():
            cases[key] = _case(folder, key, entry, entries.record, cases)
        campaigns = {key: _campaign(key, campaign, cases, modules) for key, campaign in entries.campaigns.items()}
        claims = tuple(c for claim in entries.claims for c in _claims(claim, cases, campaigns, modules))
        repeated = {c.id for c in claims if sum(c.id == other.id for other in claims) > 1}
        if repeated:
            raise InputError(f"claim '{min(repeated)}' stands twice")
        figures = tuple(modules.attribute("figures", "FIGURES", []))
        for figure in figures:
            of_runs = isinstance(figure, EnsembleFigure)
            what, needed, known = (
                ("campaign", figure.campaigns, campaigns) if of_runs else ("case", figure.cases, cases)
            )
            unknown = set(needed) - set(known)
            if unknown:
                raise InputError(f"a figure needs {what} '{min(unknown)}'{suggestion(min(unknown), known)}")
    return Paper(folder.name, entries.title, entries.citation, cases, claims, figures, campaigns)


def _is_study(folder: Path) -> bool:
    try:
        return (folder / "claims.toml").exists()
    except OSError:  # a name too long for a folder, say
        return False


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
        for key, campaign in paper.campaigns.items():
            self._weight[key] = campaign.runs * campaign.scenario.duration / campaign.scenario.dt
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


class _Extensions:
    """The Python part of a study, if it has one."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder

    def attribute(self, module: str, name: str, default: Any) -> Any:
        path = self._folder / f"{module}.py"
        if not path.exists():
            return default
        if self._folder.parent == _folder:
            loaded = importlib.import_module(f"gyrostat.papers.{self._folder.name}.{module}")
        else:
            spec = importlib.util.spec_from_file_location(f"{self._folder.name}_{module}", path)
            assert spec is not None
            assert spec.loader is not None
            loaded = importlib.util.module_from_spec(spec)
            spec.loader.exec_module(loaded)
        return getattr(loaded, name, default)


def _case(folder: Path, key: str, entry: CaseEntry, record: Sequence[str] | None, earlier: Mapping[str, Case]) -> Case:
    with input_errors(f"case '{key}'"):
        if entry.like is None:
            scenario = Scenario.from_toml(folder / "scenarios" / f"{entry.scenario or key}.toml")
        elif entry.scenario is not None:
            raise InputError("give scenario or like, not both")
        elif entry.like not in earlier:
            raise InputError(f"no case '{entry.like}' before it{suggestion(entry.like, earlier)}")
        else:
            scenario = earlier[entry.like].scenario
        usual = {} if record is None or scenario.record is not None else {"record": {"channels": list(record)}}
        scenario = scenario.replace(**(usual | entry.set))
    return Case(key, entry.title or scenario.description or key, scenario)


def _campaign(key: str, entry: CampaignEntry, cases: Mapping[str, Case], modules: _Extensions) -> Campaign:
    with input_errors(f"campaign '{key}'"):
        if key in cases:
            raise InputError("a case has that name already")
        if entry.like not in cases:
            raise InputError(f"no case '{entry.like}'{suggestion(entry.like, cases)}")
        samplers = modules.attribute("signals", "SAMPLERS", {})
        return build(key, entry, cases[entry.like].scenario, samplers)


def _measure(table: Mapping[str, Any], cases: Mapping[str, Case], modules: _Extensions) -> Measure:
    own_metrics, signals = (modules.attribute("signals", name, {}) for name in ("METRICS", "SIGNALS"))
    return Measure.of(table, METRICS | own_metrics, signals, cases)


def _claims(
    entry: ClaimEntry, cases: Mapping[str, Case], campaigns: Mapping[str, Campaign], modules: _Extensions
) -> list[Claim]:
    with input_errors(f"claim '{entry.id}'"):
        names = [entry.case] if isinstance(entry.case, str) else entry.case
        for name in names:
            if name not in cases and name not in campaigns:
                raise InputError(f"no case '{name}'{suggestion(name, [*cases, *campaigns])}")
        of_runs = [name in campaigns for name in names]
        if any(of_runs) != all(of_runs):
            raise InputError("cases and campaigns are measured by different claims")
        if any(of_runs):
            measure = Measure.of(entry.measure, ENSEMBLE_METRICS, {}, ())
            for name in names:
                if measure.signal not in campaigns[name].measures:
                    raise InputError(f"campaign '{name}' does not measure '{measure.signal}'")
        else:
            measure = _measure(entry.measure, cases, modules)
        reported = None if entry.reported is None else _interval(entry.reported)
        accept = _interval(entry.accept)
    several = not isinstance(entry.case, str)
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


__all__ = [
    "Campaign",
    "Case",
    "Claim",
    "Ensemble",
    "EnsembleFigure",
    "Evaluation",
    "Paper",
    "PaperFigure",
    "Reproduction",
    "available",
    "load",
    "reproduce",
]
