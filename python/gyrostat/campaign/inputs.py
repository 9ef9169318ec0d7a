# SPDX-License-Identifier: MIT
"""From a point of the unit cube to the numbers of a flight: dispersions, correlations and faults of one campaign."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import special

from gyrostat import attitude
from gyrostat.campaign.distributions import Attitude, Distribution, Inertia, Scalar
from gyrostat.campaign.sampled_faults import SampledFault
from gyrostat.campaign.spec import Correlated, Spec
from gyrostat.campaign.streams import SMALLEST, Array, Stream, Streams
from gyrostat.errors import InputError, suggestion
from gyrostat.scenario import Scenario, with_objects

_attitudes = {"q_NB": 4, "mrp": 3, "euler": 3}
_of_quaternion = {"mrp": attitude.mrp_from_quat, "euler": attitude.euler_from_quat}


@dataclass(frozen=True)
class Varied:
    """A key of ``[vary]``: its distribution, and the numbers of the scenario that it fills."""

    key: str
    distribution: Distribution
    paths: tuple[str, ...]

    @classmethod
    def of(cls, key: str, distribution: Distribution) -> Varied:
        """The elements that a distribution fills under a key."""
        if isinstance(distribution, Attitude):
            last = key.rpartition(".")[2]
            if last not in _attitudes:
                raise InputError(f"vary '{key}': an 'attitude' fits q_NB, mrp and euler")
            return cls(key, distribution, tuple(f"{key}.{i}" for i in range(_attitudes[last])))
        if isinstance(distribution, Inertia):
            if key not in ("truth.dJ_B", "vehicle.J_B"):
                raise InputError(f"vary '{key}': an 'inertia' fits truth.dJ_B and vehicle.J_B")
            return cls(key, distribution, tuple(f"{key}.{i}.{j}" for i in range(3) for j in range(3)))
        each = distribution.each if isinstance(distribution, Scalar) else None
        return cls(key, distribution, (key,) if each is None else tuple(f"{key}.{i}" for i in range(each)))

    @property
    def words(self) -> int:
        """Uniform numbers that it takes."""
        drawn = self.distribution
        return drawn.words * (len(self.paths) if isinstance(drawn, Scalar) else 1)

    def draw(self, u: Array, nominal: Mapping[str, Array]) -> Array:
        """Its numbers, shape (n, paths), of uniform numbers, shape (n, words)."""
        drawn = self.distribution
        if isinstance(drawn, Scalar):
            w = drawn.words
            parts = [np.ascontiguousarray(u[:, i * w : (i + 1) * w]) for i in range(len(self.paths))]
            return np.column_stack([drawn.draw(part)[:, 0] for part in parts])
        if isinstance(drawn, Attitude):
            q, last = drawn.draw(u), self.key.rpartition(".")[2]
            if last == "q_NB":
                return q
            if drawn.angle is None:  # q and -q are one attitude: of its two MRP the short one
                q = np.where(q[:, :1] < 0.0, -q, q)
            return np.asarray(_of_quaternion[last](q))
        if isinstance(drawn, Inertia):
            offset = nominal["vehicle.J_B"] if self.key == "truth.dJ_B" else 0.0
            return np.asarray(drawn.draw_about(u, nominal[self.key]) - offset).reshape(len(u), 9)
        raise TypeError(drawn.dist)


@dataclass(frozen=True)
class Draws:
    """What runs are flown with.

    Attributes
    ----------
    columns
        By name, as in the tables of a campaign: drawn values, kinds and actuators of faults, shape (n,) each.
    values
        For an `Experiment` of `Inputs.paths`, shape (n, paths).
    """

    columns: dict[str, NDArray[Any]]
    values: Array


class Inputs:
    """The random inputs of a campaign over one base scenario.

    Parameters
    ----------
    spec
        The file.
    base
        What is varied.
    """

    def __init__(self, spec: Spec, base: Scenario) -> None:
        self.varied = tuple(Varied.of(key, drawn) for key, drawn in spec.vary.items())
        self.faults = tuple(SampledFault(entry) for entry in spec.fault)
        for fault in self.faults:
            fault.check(base.actuators)
        self.correlated = tuple(spec.correlated)
        streams = [Stream(v.key, v.words) for v in self.varied]
        streams += [stream for fault in self.faults for stream in fault.streams()]
        streams += [Stream(f"corr.{i}", len(c.keys)) for i, c in enumerate(self.correlated)]
        self.streams = Streams(tuple(streams))
        self._elements = self._checked_elements()
        self._places = self.streams.places
        self._nominal = _nominal_inertias(base)
        self._before = len(base.tables().get("faults", ()))
        self.paths = tuple(p for v in self.varied for p in v.paths) + tuple(
            f"faults.{self._before + i}.{name}" for i, slot in enumerate(self._slots) for name in slot.drawn
        )

    @property
    def _slots(self) -> list[Any]:
        return [slot for fault in self.faults for slot in fault.slots]

    def scenario(self, cell: Scenario) -> Scenario:
        """The scenario of a cell with all that may happen in it, as faults that never begin."""
        tables = with_objects(cell.tables(), cell.python_components())
        initial = dict(tables.get("initial", {}))
        drawn = {v.key.partition(".")[2] for v in self.varied if v.key.startswith("initial.")}
        for name in _attitudes:
            if drawn & set(_attitudes) and name not in drawn:
                initial.pop(name, None)  # what is drawn stands instead
        if initial:
            tables["initial"] = initial
        else:
            tables.pop("initial", None)
        faults = [*tables.get("faults", []), *(slot.table for slot in self._slots)]
        return Scenario.from_dict(tables | {"faults": faults})

    def draw(self, u: Array) -> Draws:
        """Of points of the unit cube, shape (n, dimension). What overflows is refused as a flight."""
        with np.errstate(over="ignore", invalid="ignore"):
            return self._draw(u)

    def _draw(self, u: Array) -> Draws:
        points = {name: np.ascontiguousarray(u[:, place]) for name, place in self._places.items()}
        for i, table in enumerate(self.correlated):
            self._correlate(points, table, points[f"corr.{i}"])
        columns: dict[str, NDArray[Any]] = {}
        values: list[Array] = []
        for v in self.varied:
            drawn = v.draw(points[v.key], self._nominal)
            columns |= {path: np.ascontiguousarray(drawn[:, i]) for i, path in enumerate(v.paths)}
            values += list(drawn.T)
        for fault in self.faults:
            more, numbers = fault.draw(points, len(u))
            columns |= more
            values += numbers
        return Draws(columns, np.column_stack(values) if values else np.empty((len(u), 0)))

    def _correlate(self, points: dict[str, Array], table: Correlated, u: Array) -> None:
        """Put a point of a Gaussian copula where the elements' own uniform numbers stand."""
        L = np.linalg.cholesky(np.array(table.matrix))
        z = special.ndtri(u)
        for i, key in enumerate(table.keys):
            varied, element = self._elements[key]
            mixed = sum((L[i, j] * z[:, j] for j in range(1, i + 1)), L[i, 0] * z[:, 0])
            points[varied.key] = points[varied.key].copy()
            points[varied.key][:, element] = np.clip(special.ndtr(mixed), SMALLEST, 1.0 - SMALLEST)

    def _checked_elements(self) -> dict[str, tuple[Varied, int]]:
        """Elements that can be correlated, by path, with the place of their uniform number."""
        known = {
            path: (v, i)
            for v in self.varied
            if isinstance(v.distribution, Scalar) and v.distribution.words == 1
            for i, path in enumerate(v.paths)
        }
        seen: set[str] = set()
        for i, table in enumerate(self.correlated):
            for key in table.keys:
                if key not in known:
                    raise InputError(
                        f"correlated[{i}]: '{key}' is no element of [vary] with a distribution of one number"
                        f"{suggestion(key, known)}"
                    )
                if key in seen:
                    raise InputError(f"correlated[{i}]: '{key}' is correlated already")
                seen.add(key)
        return known


def _nominal_inertias(base: Scenario) -> dict[str, Array]:
    tables = base.resolve()
    J = _matrix(tables["vehicle"]["J_B"])
    return {"vehicle.J_B": J, "truth.dJ_B": J + _matrix((tables.get("truth") or {}).get("dJ_B") or [0.0] * 3)}


def _matrix(value: Any) -> Array:
    array = np.array(value, dtype=float)
    return np.diag(array) if array.ndim == 1 else array


def never(table: object) -> bool:
    """Whether a fault of a scenario never begins; of a Python object nobody knows."""
    return isinstance(table, Mapping) and bool(table.get("t_on", 0.0) == math.inf)


__all__ = ["Draws", "Inputs", "Varied", "never"]
