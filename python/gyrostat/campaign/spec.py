# SPDX-License-Identifier: MIT
"""How the file of a campaign reads. What its parts mean is said where they act.

TOML and Python say the same things: ``[vary]``, ``[[correlated]]``, ``[[fault]]``, ``[[grid]]``, ``[measure]``,
``[success]``, ``[margin]``, ``[keep]``. Page: docs/campaigns.md
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import Field, PlainSerializer, PlainValidator, model_validator

from gyrostat.campaign.distributions import Choice, Distribution, Poisson, Scalar, checked_weights, distribution, scalar
from gyrostat.errors import InputError, input_errors
from gyrostat.model import Model
from gyrostat.text import shown


def _number_or_drawn(value: Any) -> Any:
    return scalar(value) if isinstance(value, Scalar) or (isinstance(value, Mapping) and "dist" in value) else value


def _written(value: Any) -> Any:
    return value.table() if isinstance(value, Distribution) else value


Drawn = Annotated[Scalar, PlainValidator(scalar), PlainSerializer(_written)]
"""A distribution of one number."""
Leaf = Annotated[Any, PlainValidator(_number_or_drawn), PlainSerializer(_written)]
"""A distribution of one number, or what is the same in all runs."""


class _OneLine(Model):
    """Messages of a part name it."""

    def table(self) -> dict[str, Any]:
        """As it stands in a file: what was not written is left out."""
        return self.model_dump(exclude_none=True, exclude_defaults=True)


class Kind(_OneLine):
    """A kind of a fault: how likely, its type, and the parameters of that type, drawn or not."""

    weight: float
    type: str
    parameters: dict[str, Leaf]

    @classmethod
    def read(cls, table: Any) -> Kind:
        """Of ``{ weight = 0.6, type = "loss_of_effectiveness", remaining = { dist = ... } }``."""
        if isinstance(table, Kind):
            return table
        if not isinstance(table, Mapping) or not isinstance(table.get("type"), str):
            raise InputError(f"kind {shown(table)}: write {{ type = 'dead' }}, with the parameters of that fault")
        weight = table.get("weight", 1.0)
        if isinstance(weight, bool) or not isinstance(weight, int | float) or not 0.0 <= weight <= 1.0:
            raise InputError(f"kind '{table['type']}': weight = {shown(weight)} must be from 0 to 1")
        for key in ("actuator", "t_on"):
            if key in table:
                raise InputError(f"kind '{table['type']}': '{key}' belongs beside kind, not into it")
        rest = {key: value for key, value in table.items() if key not in ("weight", "type")}
        with input_errors(f"kind '{table['type']}'"):
            return cls(weight=float(weight), type=table["type"], parameters=rest)

    def written(self) -> dict[str, Any]:
        """As it stands in a file."""
        return {"weight": self.weight, "type": self.type} | {k: _written(v) for k, v in self.parameters.items()}


def _kinds(given: Any) -> list[Kind]:
    if not isinstance(given, list | tuple) or not given:
        raise InputError(f"{shown(given)} is no list of kinds: write [ {{ type = 'dead' }} ]")
    kinds = [Kind.read(kind) for kind in given]
    checked_weights([kind.weight for kind in kinds], len(kinds), "kind")
    names = [kind.type for kind in kinds]
    if len(set(names)) < len(names):
        raise InputError("a type stands twice; a mixture of its parameters says the same")
    return kinds


_Actuator = Annotated[int, Field(ge=0, le=15)]


class Fault(_OneLine):
    """A fault that may happen, once or several times, to one actuator or, as a common cause, to several at once."""

    name: Annotated[str, Field(min_length=1, pattern=r"^[A-Za-z0-9_-]+$")]
    probability: Annotated[float, Field(ge=0.0, le=1.0)] | None = None
    count: Annotated[Scalar, PlainValidator(scalar), PlainSerializer(_written)] | None = None
    actuator: Leaf = None
    actuators: Annotated[list[_Actuator], Field(min_length=1)] | None = None
    distinct: bool = False
    t_on: Leaf
    delay: Drawn | None = None
    kind: Annotated[
        list[Kind], PlainValidator(_kinds), PlainSerializer(lambda kinds: [kind.written() for kind in kinds])
    ]

    @model_validator(mode="after")
    def _fits(self) -> Fault:
        if self.probability is not None and self.count is not None:
            raise InputError("probability and count exclude each other")
        if (self.actuator is None) == (self.actuators is None):
            raise InputError("either actuator or actuators must be given")
        if self.delay is not None and self.actuators is None:
            raise InputError("delay belongs to a common cause: several actuators")
        if self.actuators is not None and len(set(self.actuators)) < len(self.actuators):
            raise InputError(f"actuators = {self.actuators}: one stands twice")
        if not isinstance(self.t_on, Scalar) and not _is_time(self.t_on):
            raise InputError(f"t_on = {shown(self.t_on)}: a time, s, or a distribution belongs here")
        self._counted()
        self._of_actuators()
        return self

    def _counted(self) -> None:
        if self.count is None:
            return
        wrong = InputError("count: a 'poisson' with `most`, or a 'choice' of whole numbers from 0 to 16 belongs here")
        if isinstance(self.count, Poisson):
            if self.count.most is None or self.count.most > 16:
                raise wrong
        elif not isinstance(self.count, Choice) or any(n != int(n) or not 0 <= n <= 16 for n in self.count.of):
            raise wrong

    def _of_actuators(self) -> None:
        who = self.actuator
        if isinstance(who, Scalar):
            if not isinstance(who, Choice) or any(n != int(n) or not 0 <= n <= 15 for n in who.of):
                raise InputError("actuator: a number, or a 'choice' of whole numbers from 0 to 15 belongs here")
        elif who is not None and (isinstance(who, bool) or not isinstance(who, int) or not 0 <= who <= 15):
            raise InputError(
                f"actuator = {shown(who)}: a whole number from 0 to 15, or a 'choice' of them belongs here"
            )
        if self.distinct and not (isinstance(who, Choice) and np.count_nonzero(who.shares) >= self.most):
            raise InputError(f"distinct: actuator must be a 'choice' of at least {self.most}")

    @property
    def most(self) -> int:
        """How often it can happen."""
        if isinstance(self.count, Poisson):
            return int(self.count.most or 0)
        return int(max(self.count.of)) if isinstance(self.count, Choice) else 1


def _is_time(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool) and 0.0 <= value < math.inf


class Correlated(_OneLine):
    """Scalar elements of ``[vary]`` with a Gaussian copula: `matrix` is the correlation of their normal scores."""

    keys: Annotated[list[str], Field(min_length=2)]
    matrix: list[list[float]]

    @model_validator(mode="after")
    def _definite(self) -> Correlated:
        n = len(self.keys)
        if len(set(self.keys)) < n:
            raise InputError("a key stands twice")
        if len(self.matrix) != n or any(len(row) != n for row in self.matrix):
            raise InputError(f"the matrix of {n} keys is {n} x {n}")
        R = np.array(self.matrix)
        if not np.all(np.isfinite(R)) or not np.array_equal(R, R.T) or not np.all(np.diag(R) == 1.0):
            raise InputError("the matrix must be symmetric, with ones on the diagonal")
        smallest = float(np.linalg.eigvalsh(R)[0])
        if smallest < 1e-12:
            raise InputError(f"the matrix is not positive definite: its smallest eigenvalue is {smallest:.3g}")
        return self


class Grid(_OneLine):
    """A factor: by level, what it sets in the scenario. Of a list: the values of the key `name`."""

    name: Annotated[str, Field(min_length=1)]
    of: dict[str, dict[str, Any]] | list[Any]

    @model_validator(mode="after")
    def _has_levels(self) -> Grid:
        if not self.of:
            raise InputError(f"grid '{self.name}': has no levels")
        if len(self.levels) < len(self.of):
            raise InputError(f"grid '{self.name}': two levels have one name")
        return self

    @property
    def levels(self) -> dict[str, dict[str, Any]]:
        """What each level sets."""
        if isinstance(self.of, dict):
            return self.of
        return {_level_name(value): {self.name: value} for value in self.of}


def _level_name(value: Any) -> str:
    if isinstance(value, Mapping):
        return str(value.get("type", value))
    return value if isinstance(value, str) else repr(value)


class Criterion(_OneLine):
    """What a measure must be for a success; of scale ``log`` distances from the limit are decades."""

    below: float | None = None
    above: float | None = None
    scale: Literal["linear", "log"] = "linear"

    @model_validator(mode="after")
    def _has_limit(self) -> Criterion:
        limits = [x for x in (self.below, self.above) if x is not None]
        if not limits or any(math.isnan(x) for x in limits):
            raise InputError("a limit is missing: below or above")
        if self.scale == "log" and any(x <= 0.0 for x in limits):
            raise InputError("scale = 'log' wants positive limits")
        if self.below is not None and self.above is not None and not self.above < self.below:
            raise InputError(f"nothing lies above {self.above:g} and below {self.below:g}")
        return self


class Margin(_OneLine):
    """The measure whose distance from its limit in ``[success]`` is the margin of a flight."""

    measure: str


class Worst(_OneLine):
    """How many of the flights with the largest values of a measure."""

    measure: str
    count: Annotated[int, Field(ge=1, le=10_000)] = 10


class Trajectories(_OneLine):
    """Whose trajectories are kept: the first failures, the worst, and each `every`-th run."""

    failures: Annotated[int, Field(ge=0, le=10_000)] = 0
    worst: Worst | None = None
    every: Annotated[int, Field(ge=1, lt=2**63)] | None = None


class Keep(_OneLine):
    """Which rows are kept: all, or failures and each `every`-th run. Counts and sketches are always of all."""

    rows: Literal["all", "failures"] = "all"
    every: Annotated[int, Field(ge=1, lt=2**63)] | None = None
    trajectories: Trajectories | None = None


def _vary(given: Any) -> dict[str, Distribution]:
    if not isinstance(given, Mapping):
        raise InputError(f"{shown(given)} is no table of distributions by key")
    read = {}
    for key, value in given.items():
        with input_errors(f"'{key}'"):
            read[str(key)] = distribution(value)
    return read


class Spec(_OneLine):
    """All of a campaign but its base, which is a scenario."""

    name: str = ""
    description: str = ""
    seed: Annotated[int, Field(ge=0, lt=2**63)] = 0
    sampling: Literal["plain", "lhs", "sobol"] = "plain"
    replicates: Annotated[int, Field(ge=1, le=100_000)] | None = None
    points: Annotated[int, Field(ge=1, le=2**26)] | None = None
    vary: Annotated[
        dict[str, Distribution],
        PlainValidator(_vary),
        PlainSerializer(lambda vary: {key: value.table() for key, value in vary.items()}),
    ] = Field(default_factory=dict)
    correlated: list[Correlated] = Field(default_factory=list)
    fault: list[Fault] = Field(default_factory=list)
    grid: list[Grid] = Field(default_factory=list)
    measure: dict[str, dict[str, Any]] = Field(default_factory=dict)
    success: dict[str, Criterion] = Field(default_factory=dict)
    margin: Margin | None = None
    keep: Keep = Field(default_factory=Keep)

    @model_validator(mode="after")
    def _fits(self) -> Spec:
        if self.sampling == "plain" and (self.replicates is not None or self.points is not None):
            raise InputError("replicates and points belong to sampling = 'lhs' or 'sobol'")
        for what, names in (("fault", [f.name for f in self.fault]), ("grid", [g.name for g in self.grid])):
            if len(set(names)) < len(names):
                raise InputError(f"{what}: a name stands twice; it names the random numbers")
        if self.sampling == "sobol" and self.points is not None and self.points & (self.points - 1):
            raise InputError(f"points = {self.points}: a net of Sobol has a power of two of them")
        return self


__all__ = ["Correlated", "Criterion", "Fault", "Grid", "Keep", "Kind", "Margin", "Spec", "Trajectories", "Worst"]
