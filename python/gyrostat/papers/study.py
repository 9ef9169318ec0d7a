# SPDX-License-Identifier: MIT
"""Studies: cases, campaigns, claims and figures, read from a folder. `gyrostat.papers` says what one holds."""

from __future__ import annotations

import fnmatch
import importlib
import importlib.util
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from pydantic import Field

from gyrostat import toml
from gyrostat.errors import InputError, input_errors, suggestion
from gyrostat.model import Model
from gyrostat.papers.campaigns import CampaignCase, CampaignEntry, Ensemble, build
from gyrostat.papers.claims import Claim, MeasurementEntry, Subjects
from gyrostat.papers.story import Story, Surprise
from gyrostat.papers.story import check as check_story
from gyrostat.results import Result
from gyrostat.scenario import Scenario

if TYPE_CHECKING:
    from gyrostat.plots import Figure

_folder = Path(__file__).parent


class CaseEntry(Model):
    """One ``[cases.<id>]`` table of a ``claims.toml``."""

    title: str = ""
    scenario: str | None = None
    like: str | None = None
    set: Annotated[dict[str, Any], Field(default_factory=dict)]
    seeds: Annotated[list[int], Field(default_factory=list)]
    keep: list[str] | None = None

    def members(self, folder: Path, key: str, earlier: Mapping[str, Scenario]) -> Iterator[Case]:
        """The case, and the same with each of its seeds."""
        if self.like is None:
            base = Scenario.from_toml(folder / "scenarios" / f"{self.scenario or key}.toml")
        elif self.scenario is not None:
            raise InputError("give scenario or like, not both")
        elif self.like not in earlier:
            raise InputError(f"no case '{self.like}' before it{suggestion(self.like, earlier)}")
        else:
            base = earlier[self.like]
        scenario = base.replace(**self.set) if self.set else base
        title = self.title or scenario.description or key
        yield Case(key, title, scenario)
        for seed in self.seeds:
            yield Case(f"{key}_{seed}", f"{title}, seed {seed}", scenario.replace(seed=seed), key)


class ClaimsFile(Model):
    """A ``claims.toml``."""

    title: str
    citation: str
    record: list[str] | None = None
    cases: dict[str, CaseEntry]
    campaigns: Annotated[dict[str, CampaignEntry], Field(default_factory=dict)]
    claims: list[MeasurementEntry]
    story: Story | None = None
    findings: Annotated[list[Surprise], Field(default_factory=list)]


@dataclass(frozen=True)
class Case:
    """One experiment."""

    id: str
    title: str
    scenario: Scenario
    repeats: str = ""
    """The case that it is, with another seed."""

    @property
    def integrator(self) -> str:
        """Name of the integrator that flew it."""
        return str(self.scenario.resolve()["integrator"]["type"])


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
    campaigns: Mapping[str, CampaignCase] = field(default_factory=dict)
    story: Story | None = None
    findings: tuple[Surprise, ...] = ()

    def only(self, claims: Sequence[Claim]) -> Paper:
        """The study with some of its claims, what flies for them, and no figures."""
        needed = {c.case for c in claims} | {o for c in claims for o in c.measure.others}
        return replace(
            self,
            cases={key: case for key, case in self.cases.items() if key in needed},
            campaigns={key: campaign for key, campaign in self.campaigns.items() if key in needed},
            claims=tuple(claims),
            figures=(),
        )

    def needed_later(self) -> set[str]:
        """Cases whose results figures or claims about two cases ask for."""
        compared = [c for c in self.claims if c.measure.others]
        return {c for f in self.figures if isinstance(f, PaperFigure) for c in f.cases} | {
            o for c in compared for o in (c.case, *c.measure.others)
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
        record = _Record(entries.record)
        scenarios: dict[str, Scenario] = {}
        cases: dict[str, Case] = {}
        keeps: dict[str, list[str] | None] = {}
        for key, entry in entries.cases.items():
            with input_errors(f"case '{key}'"):
                keep = keeps.get(entry.like or "") if entry.keep is None else entry.keep
                for case in entry.members(folder, key, scenarios):
                    if case.id in cases:
                        raise InputError(f"there is a case '{case.id}' already")
                    scenarios[case.id] = case.scenario
                    keeps[case.id] = keep
                    cases[case.id] = replace(case, scenario=record.kept_by(case.scenario, keep))
        record.check()
        campaigns = _campaigns(entries.campaigns, scenarios)
        metrics, signals = (modules.attribute("signals", attribute, {}) for attribute in ("METRICS", "SIGNALS"))
        claims = Subjects(cases, campaigns, metrics, signals).claims(entries.claims)
        check_story(entries.story, entries.findings, [c.id for c in claims])
        figures = tuple(modules.attribute("figures", "FIGURES", []))
        for figure in figures:
            if isinstance(figure, EnsembleFigure):
                _known("campaign", figure.campaigns, campaigns)
            else:
                _known("case", figure.cases, cases)
    told = (entries.story, tuple(entries.findings))
    return Paper(folder.name, entries.title, entries.citation, cases, claims, figures, campaigns, *told)


def _is_study(folder: Path) -> bool:
    try:
        return (folder / "claims.toml").exists()
    except OSError:  # a name too long for a folder, say
        return False


def _known(what: str, needed: Iterable[str], known: Collection[str]) -> None:
    unknown = set(needed) - set(known)
    if unknown:
        raise InputError(f"a figure needs {what} '{min(unknown)}'{suggestion(min(unknown), known)}")


class _Record:
    """Channels that every case keeps as far as it offers them; none is for nothing."""

    def __init__(self, channels: Sequence[str] | None) -> None:
        self._channels = channels
        self._groups = {_group(name) for name in channels or ()}
        self._never = set(channels or ())
        self._offered: set[str] = set()

    def kept_by(self, scenario: Scenario, groups: Sequence[str] | None) -> Scenario:
        """The scenario with what it keeps, of these groups only; one that chooses its channels itself is as it was."""
        for unknown in set(groups or ()) - self._groups:
            raise InputError(f"keep: no channel of the record is of '{unknown}'{suggestion(unknown, self._groups)}")
        if self._channels is None or (scenario.record is not None and scenario.record.channels is not None):
            return scenario
        offered = [channel["name"] for channel in scenario.channel_names()]
        kept = [name for name in self._channels if fnmatch.filter(offered, name)]
        self._never -= set(kept)
        self._offered.update(offered)
        if groups is not None:
            kept = [name for name in kept if _group(name) in groups]
        return scenario.replace(**{"record.channels": kept})

    def check(self) -> None:
        """When all cases are known."""
        if self._never and self._offered:
            name = min(self._never)
            raise InputError(f"record: no case has a channel '{name}'{suggestion(name, self._offered)}")


def _group(channel: str) -> str:
    return channel.partition(".")[0]


def _campaigns(entries: Mapping[str, CampaignEntry], scenarios: Mapping[str, Scenario]) -> dict[str, CampaignCase]:
    """In their order; each may be like a case or like one before it."""
    whole: dict[str, tuple[CampaignEntry, Scenario]] = {}
    campaigns = {}
    for key, entry in entries.items():
        with input_errors(f"campaign '{key}'"):
            if key in scenarios:
                raise InputError("a case has that name already")
            if entry.like not in scenarios and entry.like not in whole:
                known = [*scenarios, *whole]
                raise InputError(f"no case or earlier campaign '{entry.like}'{suggestion(entry.like, known)}")
            earlier, base = whole.get(entry.like) or (None, scenarios[entry.like])
            whole[key] = entry.after(earlier), base
            campaigns[key] = build(key, *whole[key])
    return campaigns


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


__all__ = ["Case", "EnsembleFigure", "Paper", "PaperFigure", "available", "load"]
