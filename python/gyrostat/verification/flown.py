# SPDX-License-Identifier: MIT
"""Campaigns as the searches see them: a point of independent normal inputs becomes a flight, and its margin comes back.

`rare` moves through noise as through any other input: each second of a flight has noise of a version that its chain
holds. In the other searches a flight has the noise of its number among all that were flown. Either way a flight that
was found can be flown again by itself.
"""

from __future__ import annotations

import json
from collections.abc import Callable
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray
from scipy import special

from gyrostat.errors import InputError
from gyrostat.verification.journal import remembered
from gyrostat.verification.rare import Rare, SubsetSimulation
from gyrostat.verification.searched import Searched
from gyrostat.verification.tune import FlownSet, Tuned, Tuner, graded_time
from gyrostat.verification.words import Words
from gyrostat.verification.worst import Smallest, WorstCase, explanation, shrunk, squared_norm

if TYPE_CHECKING:
    from gyrostat.campaign import Campaign
    from gyrostat.scenario import Scenario

Floats = NDArray[np.float64]
Gain = float | list[Any]
"""A number, or a vector or matrix of numbers."""
_SMALLEST = 2.0**-53


def uniform(z: Floats) -> Floats:
    """Points of the open unit cube for normal inputs; beyond 8.2 they are taken as 8.2."""
    return np.asarray(np.clip(special.ndtr(z), _SMALLEST, 1 - _SMALLEST))


def noise_versions(words: Words) -> Floats:
    """Versions of noise of words, as a scenario holds them."""
    return np.asarray((words >> np.uint64(11)).astype(np.float64))


class FlownMargin:
    """Margins of flights, numbered in the order in which they are asked for."""

    def __init__(self, campaign: Campaign, cell: str | None, jobs: int | None) -> None:
        if not campaign.has_margin:
            raise InputError(
                "the campaign has no [margin]: name a measure that is finite for every flight and has a limit in "
                "[success]"
            )
        self.campaign, self.cell, self.jobs = campaign, cell, jobs
        self.asked = 0
        self.fly: Callable[..., Floats] = self._fly

    def __call__(self, z: Floats, *versions: Words) -> Floats:
        """Of a batch, shape (n, d) to (n,), with the noise of their numbers, or of versions, shape (n, blocks)."""
        first = self.asked
        self.asked += len(z)
        return self.fly(z, np.array([first]), *versions)

    def again(self, z: Floats, number: int) -> Floats:
        """Of one flight, shape (1, d), with the noise of a number."""
        return self._fly(z, np.array([number]))

    def _fly(self, z: Floats, first: NDArray[np.int64], words: Words | None = None) -> Floats:
        versions = None if words is None else noise_versions(words)
        outcome = self.campaign.evaluate(
            uniform(z), first=int(first[0]), cell=self.cell, versions=versions, jobs=self.jobs
        )
        assert outcome.margin is not None  # has_margin
        return outcome.margin


@dataclass(frozen=True)
class Explained:
    """The smallest lost flight of a campaign.

    Attributes
    ----------
    found
        It, or the nearest one.
    shrunk
        What of its inputs is left when each is pulled to its nominal value, shape (d,).
    needs
        That in words.
    """

    found: Smallest
    shrunk: Floats
    needs: tuple[str, ...]


def scenario(
    campaign: Campaign, z: Floats, number: int, cell: str | None = None, versions: Words | None = None
) -> Scenario:
    """The plain scenario of a flight that a search flew."""
    noise = None if versions is None or versions.size == 0 else noise_versions(versions)
    return campaign.scenario_at(uniform(z), number, cell, noise)


def rare(
    campaign: Campaign,
    *,
    cell: str | None = None,
    seed: int = 0,
    population: int = 500,
    replicates: int = 8,
    jobs: int | None = None,
    out: Path | None = None,
) -> Rare:
    """Probability that a flight of a campaign is lost, however small.

    Parameters
    ----------
    campaign
        With a margin.
    cell
        Where there is a grid: which.
    seed, population, replicates
        As of `SubsetSimulation`.
    jobs
        Threads; they change no bit.
    out
        A folder that is there: it remembers what was flown, a search that was killed goes on, and `gyrostat report`
        writes its page.
    """
    margin = FlownMargin(campaign, cell, jobs)
    blocks = campaign.noise_blocks(cell)
    plan = SubsetSimulation(campaign.dimension, blocks, seed, population, replicates=replicates)
    with ExitStack() as stack:
        if out is None:
            return plan.run(margin)
        identity = _identity(campaign)
        told = f"rare {plan} {cell} {identity}"
        margin.fly = stack.enter_context(remembered(margin.fly, out / "margins.bin", told))
        found = plan.run(margin)
    Searched(found, campaign.name, identity, cell, seed).write(out)
    return found


def worst(
    campaign: Campaign,
    *,
    cell: str | None = None,
    size: str | None = None,
    seed: int = 0,
    budget: int = 2000,
    jobs: int | None = None,
    out: Path | None = None,
) -> Explained:
    """The smallest lost flight of a campaign, and what of it is needed.

    Parameters
    ----------
    campaign, cell, jobs, out
        As of `rare`.
    size
        A sum of columns of the campaign's table, like ``"a + b - c"``; absent: the squared norm of the inputs.
    seed, budget
        As of `WorstCase`.
    """
    margin = FlownMargin(campaign, cell, jobs)
    measure = squared_norm if size is None else _size(campaign, size)
    with ExitStack() as stack:
        if out is not None:
            told = f"worst {seed} {budget} {size} {cell} {_identity(campaign)}"
            margin.fly = stack.enter_context(remembered(margin.fly, out / "margins.bin", told))
        found = WorstCase(campaign.dimension, budget, seed).run(margin, measure)
    if not found.lost:
        return Explained(found, found.z, ())
    left, _ = shrunk(lambda z: margin.again(z, found.number), found.z)
    needs, middle = (campaign.drawn(uniform(z[None, :])).columns for z in (left, np.zeros_like(left)))
    return Explained(found, left, tuple(_words(needs, middle)))


def tune(
    campaign: Campaign,
    parameters: list[str],
    *,
    effort: float = 1.4,
    train: int = 100,
    held_out: int = 200,
    budget: int = 150,
    seed: int = 0,
    jobs: int | None = None,
) -> Tuned:
    """Factors on parameters of a campaign's scenario that make its flights settle faster.

    Parameters
    ----------
    campaign
        Without a grid. Its measures are not used: settling, final error, energy and variation of the command are.
    parameters
        Dotted keys, as `parameters_of` lists them; a factor is on all of a vector or matrix.
    effort, budget, seed
        As of `Tuner`.
    train, held_out
        Flights: the runs from 0 on, and those after them.
    jobs
        Threads.
    """
    if len(campaign.cells) > 1:
        raise InputError("tune: a campaign without a grid belongs here")
    known = parameters_of(campaign.base)
    for key in parameters:
        if key not in known:
            raise InputError(f"tune: '{key}' is no gain of a component; there are: {', '.join(known)}")
        if parameters.count(key) > 1:
            raise InputError(f"tune: '{key}' stands twice")
    _changed(campaign, {key: known[key] for key in parameters})  # says why, if these cannot be flown
    splits = {"train": (0, train), "held-out": (train, train + held_out)}

    def fly(factors: Floats, split: str) -> FlownSet | None:
        changes = {key: scaled(known[key], float(f)) for key, f in zip(parameters, factors, strict=True)}
        try:
            changed = _changed(campaign, changes)
        except InputError:
            return None  # no stack can fly them
        first, end = splits[split]
        outcome = changed.evaluate(changed.points(first, end), first=first, jobs=jobs)
        m = outcome.measures
        settling = np.where(outcome.status == "completed", m["settling_time"], np.nan)
        error = np.where(outcome.status == "completed", m["final_error"], np.nan)
        time = graded_time(settling, error, _band(), changed.base.duration)
        return FlownSet(time, float(np.nanmean(m["energy"])), float(np.nanmean(m["command_variation"])))

    return Tuner(len(parameters), effort, budget, seed).run(fly)


def draw_trade(found: Tuned, path: Path) -> None:
    """Effort against settling of all that was flown, as a picture."""
    from matplotlib.figure import Figure

    from gyrostat.files import replacing

    figure = Figure(figsize=(6.4, 4.0), layout="constrained")
    axes = figure.subplots()
    front = found.trade()
    axes.plot([t.energy for t in found.trials], [t.worst_tenth for t in found.trials], ".", color="0.7", label="flown")
    axes.plot([t.energy for t in front], [t.worst_tenth for t in front], "o-", label="not beaten")
    axes.axvline(1.0, color="0.5", lw=0.8)
    axes.set(xlabel="energy over published", ylabel="settling, worst tenth (s)", xscale="log")
    axes.legend()
    with replacing(path) as temporary:
        figure.savefig(temporary, dpi=150)


def parameters_of(scenario: Scenario) -> dict[str, Gain]:
    """Gains of the observer, detector, controller and allocator, by dotted key.

    Positive numbers, and vectors and matrices that are not zero; what is infinite is switched off and no gain.
    """
    tables = scenario.resolve()
    return {
        f"{role}.{key}": value
        for role in ("observer", "detector", "controller", "allocator")
        for key, value in (tables.get(role) or {}).items()
        if _gain(value) and not _names_actuators(role, tables[role], key)
    }


def scaled(value: Gain, factor: float) -> Gain:
    """A gain times a factor."""
    return [scaled(x, factor) for x in value] if isinstance(value, list) else value * factor


def _gain(value: Any) -> bool:
    if isinstance(value, float):
        return 0 < value < 1e30
    if not isinstance(value, list) or not value:
        return False
    array = np.asarray(value)
    return array.dtype.kind in "if" and bool(np.isfinite(array).all() and array.any())


def _names_actuators(role: str, table: dict[str, Any], key: str) -> bool:
    from gyrostat import _core

    known = table["type"] in _core.catalogue()[role]
    return known and ("mask", key) in ((p["kind"], p["name"]) for p in _core.describe(role, table["type"])["params"])


def _changed(campaign: Campaign, changes: dict[str, Gain]) -> Campaign:
    from gyrostat.campaign import Campaign

    tables = campaign.spec.table()
    for key in ("measure", "success", "margin", "keep"):
        tables.pop(key, None)
    resolved = campaign.base.resolve()
    roles = {key.partition(".")[0] for key in changes}
    usual = {role: resolved[role]["type"] for role in sorted(roles) if getattr(campaign.base, role) is None}
    base = campaign.base.replace(**usual, **changes)
    for row in base.check():
        if not row["ok"]:
            raise InputError(f"{row['where']}: {row['quantity']} = {row['value']:g} is refused")
    return Campaign.from_dict({**tables, "base": base.to_dict()})


def _band() -> float:
    from gyrostat.metrics import DEFAULT_BAND

    return float(DEFAULT_BAND)


def _identity(campaign: Campaign) -> str:
    from gyrostat.campaign.identity import identity, resolved

    return identity(resolved(campaign))


def _words(needs: dict[str, NDArray[Any]], middle: dict[str, NDArray[Any]]) -> list[str]:
    """Quantities that differ from their nominal values; kinds and choices are named."""
    said = []
    for name, column in needs.items():
        value, nominal = column[0], middle[name][0]
        if isinstance(value, float | np.floating):
            said += explanation([name], [float(value)], [float(nominal)])
        elif value != nominal:
            said.append(f"{name} = {value} (nominal {nominal})")
    return said


def _size(campaign: Campaign, text: str) -> Callable[[Floats], Floats]:
    """A sum of columns with signs; what does not happen in a flight counts nothing."""
    terms: list[tuple[float, str]] = []
    for part in text.replace("-", "+-").split("+"):
        name = part.strip().removeprefix("-").strip()
        if name:
            terms.append((-1.0 if part.strip().startswith("-") else 1.0, name))
    known = campaign.draws(0, 1)
    for _, name in terms:
        if not _number(name) and name not in known:
            raise InputError(f"size: no column '{name}'; there are: {', '.join(known)}")
    if not terms:
        raise InputError(f"size = {json.dumps(text)}: a sum of columns belongs here")

    def size(z: Floats) -> Floats:
        columns = campaign.drawn(uniform(z)).columns
        total = np.zeros(len(z))
        for sign, name in terms:
            total += sign * (float(name) if _number(name) else np.nan_to_num(np.asarray(columns[name], float)))
        return total

    return size


def _number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True


__all__ = [
    "Explained",
    "FlownMargin",
    "Gain",
    "draw_trade",
    "noise_versions",
    "parameters_of",
    "rare",
    "scaled",
    "scenario",
    "tune",
    "uniform",
    "worst",
]
