# SPDX-License-Identifier: MIT
"""Sampled faults: what may happen stands in the scenario as faults that never begin, and a draw gives some an onset.

So all flights of a cell have the same types in them and fly as one experiment. A fault of infinite onset changes
nothing: the flight is, bit for bit, the one of the scenario without it.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gyrostat.campaign.distributions import Choice, Scalar, chosen
from gyrostat.campaign.spec import Fault, Kind
from gyrostat.campaign.streams import Array, Stream
from gyrostat.errors import InputError

NONE = "none"
"""Kind of a fault that does not happen."""

Columns = dict[str, NDArray[Any]]
Points = Mapping[str, Array]
"""The uniform numbers of each stream, shape (n, words)."""


@dataclass(frozen=True)
class Slot:
    """A fault of the scenario that may begin: an occurrence, its kind, and which actuator of a common cause."""

    occurrence: int
    kind: Kind
    member: int
    table: dict[str, Any]
    """As it stands in the scenario: never."""
    drawn: tuple[str, ...]
    """Its parameters that are numbers of a run."""


class SampledFault:
    """A ``[[fault]]`` table: its streams, its slots, and what a run makes of them."""

    def __init__(self, entry: Fault) -> None:
        self.entry = entry
        self.slots = tuple(
            self._slot(k, kind, member)
            for k in range(entry.most)
            for kind in entry.kind
            for member in range(len(entry.actuators or [0]))
        )

    def check(self, actuators: int) -> None:
        """Refuse an actuator that a vehicle of so many does not have."""
        who = self.entry.actuator
        named = who.of if isinstance(who, Choice) else self.entry.actuators or [who]
        for actuator in named:
            if actuator >= actuators:
                raise InputError(
                    f"fault '{self.entry.name}': actuator {actuator:g} is not there; the vehicle has {actuators} "
                    f"(0 to {actuators - 1})"
                )

    def streams(self) -> list[Stream]:
        """``fault.<name>.<k>.<field>``, and ``fault.<name>.<k>.<type>.<field>`` of the parameters of a kind."""
        f, out = self.entry, []
        for k in range(f.most):
            if f.probability is not None:
                out.append(self._stream(k, "probability", 1))
            if f.count is not None and k == 0:
                out.append(self._stream(k, "count", f.count.words))
            for field in ("actuator", "t_on"):
                value = getattr(f, field)
                if isinstance(value, Scalar):
                    out.append(self._stream(k, field, value.words))
            if len(f.kind) > 1:
                out.append(self._stream(k, "kind", 1))
            if f.delay is not None:
                out.append(self._stream(k, "delay", f.delay.words * len(f.actuators or ())))
            for kind in f.kind:
                drawn = {name: value for name, value in kind.parameters.items() if isinstance(value, Scalar)}
                out += [self._stream(k, f"{kind.type}.{name}", value.words) for name, value in drawn.items()]
        return out

    def draw(self, u: Points, n: int) -> tuple[Columns, list[Array]]:
        """What happens in n runs: columns to read, and one of numbers for each drawn parameter of each slot."""
        f = self.entry
        columns: Columns = {}
        parts: dict[tuple[int, str, int], dict[str, Array]] = {}
        taken = np.zeros((n, 16), dtype=bool)
        for k in range(f.most):
            happens = self._happens(u, k, n)
            which = np.zeros(n, dtype=np.int64)
            if len(f.kind) > 1:
                which = chosen(np.array([kind.weight for kind in f.kind]), u[self._name(k, "kind")][:, 0])
            names = np.array([kind.type for kind in f.kind] + [NONE])
            prefix = f"fault.{f.name}.{k}"
            columns[f"{prefix}.kind"] = names[np.where(happens, which, len(f.kind))]
            onset = self._onset(u, k, n)
            columns[f"{prefix}.t_on"] = np.where(happens, onset, math.inf)
            who = self._who(u, k, n, taken)
            if f.actuators is None:
                columns[f"{prefix}.actuator"] = np.where(happens, who, -1)
            delays = self._delays(u, k, n)
            if f.delay is not None:
                for member in range(delays.shape[1]):
                    columns[f"{prefix}.delay.{member}"] = np.where(happens, delays[:, member], np.nan)
            for i, kind in enumerate(f.kind):
                active = happens & (which == i)
                drawn = self._parameters(u, k, kind, active)
                columns |= {f"{prefix}.{kind.type}.{name}": np.where(active, x, np.nan) for name, x in drawn.items()}
                for member in range(len(f.actuators or [0])):
                    begins = np.where(active, onset + delays[:, member], math.inf)
                    parts[k, kind.type, member] = {"t_on": begins, "actuator": who.astype(float), **drawn}
        values = [parts[s.occurrence, s.kind.type, s.member][name] for s in self.slots for name in s.drawn]
        return columns, values

    def _slot(self, k: int, kind: Kind, member: int) -> Slot:
        f = self.entry
        who = f.actuator if f.actuators is None else f.actuators[member]
        drawn = ["t_on"]
        if isinstance(who, Choice):
            drawn.append("actuator")
            who = int(who.of[int(np.argmax(who.shares))])
        table: dict[str, Any] = {"type": kind.type, "actuator": who, "t_on": math.inf}
        for name, value in kind.parameters.items():
            if isinstance(value, Scalar):
                drawn.append(name)
            table[name] = value.median if isinstance(value, Scalar) else value
        return Slot(k, kind, member, table, tuple(drawn))

    def _happens(self, u: Points, k: int, n: int) -> NDArray[np.bool_]:
        f = self.entry
        if f.probability is not None:
            return np.asarray(u[self._name(k, "probability")][:, 0] < f.probability)
        if f.count is not None:
            return np.asarray(f.count.draw(u[self._name(0, "count")])[:, 0] > k)
        return np.ones(n, dtype=bool)

    def _onset(self, u: Points, k: int, n: int) -> Array:
        t_on = self.entry.t_on
        return t_on.draw(u[self._name(k, "t_on")])[:, 0] if isinstance(t_on, Scalar) else np.full(n, float(t_on))

    def _who(self, u: Points, k: int, n: int, taken: NDArray[np.bool_]) -> NDArray[np.int64]:
        """The actuator of an occurrence; of distinct ones, among those that are left, by their weights."""
        who = self.entry.actuator
        if not isinstance(who, Choice):
            return np.full(n, -1 if who is None else who, dtype=np.int64)
        points = u[self._name(k, "actuator")]
        if not self.entry.distinct:
            return who.draw(points)[:, 0].astype(np.int64)
        of = np.array(who.of, dtype=np.int64)
        left = np.where(taken[:, : len(of)], 0.0, who.shares)
        sums = np.cumsum(left, axis=1)
        place = np.argmax(sums > points[:, :1] * sums[:, -1:], axis=1)
        taken[np.arange(n), place] = True
        return np.asarray(of[place])

    def _delays(self, u: Points, k: int, n: int) -> Array:
        f = self.entry
        members = len(f.actuators or [0])
        if f.delay is None:
            return np.zeros((n, members))
        points = u[self._name(k, "delay")].reshape(n, members, f.delay.words)
        return np.column_stack([f.delay.draw(np.ascontiguousarray(points[:, i]))[:, 0] for i in range(members)])

    def _parameters(self, u: Points, k: int, kind: Kind, active: NDArray[np.bool_]) -> dict[str, Array]:
        """Drawn ones of a kind; where it does not happen, the median, which must not be refused in its stead."""
        return {
            name: np.where(active, value.draw(u[self._name(k, f"{kind.type}.{name}")])[:, 0], value.median)
            for name, value in kind.parameters.items()
            if isinstance(value, Scalar)
        }

    def _name(self, k: int, field: str) -> str:
        return f"fault.{self.entry.name}.{k}.{field}"

    def _stream(self, k: int, field: str, words: int) -> Stream:
        return Stream(self._name(k, field), words)


__all__ = ["NONE", "SampledFault", "Slot"]
