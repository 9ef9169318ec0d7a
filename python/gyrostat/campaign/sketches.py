# SPDX-License-Identifier: MIT
"""Counts of a measure in logarithmic bins: a distribution in constant memory whose merging is addition.

Bins have the ratio 1.01, so that a quantile is known to 0.5 %; zeros, infinite values and NaN have bins of their own.
Whole numbers are added: the result depends on no order.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field

import numpy as np

from gyrostat.campaign.streams import Array

RATIO = 1.01
_log = math.log(RATIO)


@dataclass
class Sketch:
    """Of the values of one measure."""

    bins: Counter[str] = field(default_factory=Counter)
    """By ``+k`` and ``-k`` for values of that sign in [1.01^k, 1.01^(k+1)), and ``0``, ``nan``, ``inf``, ``-inf``."""

    @classmethod
    def of(cls, values: Array) -> Sketch:
        """Of values, shape (n,)."""
        finite = values[np.isfinite(values) & (values != 0.0)]
        places = np.floor(np.log(np.abs(finite)) / _log).astype(int)
        signs = np.where(finite > 0.0, "+", "-")
        bins = Counter(f"{sign}{place}" for sign, place in zip(signs, places, strict=True))
        special = {
            "0": values == 0.0,
            "nan": np.isnan(values),
            "inf": values == math.inf,
            "-inf": values == -math.inf,
        }
        bins.update({name: int(np.count_nonzero(where)) for name, where in special.items() if np.any(where)})
        return cls(bins)

    @classmethod
    def merged(cls, sketches: Iterable[Sketch]) -> Sketch:
        """Of all of their values."""
        total: Counter[str] = Counter()
        for sketch in sketches:
            total.update(sketch.bins)
        return cls(total)

    @classmethod
    def from_dict(cls, bins: Mapping[str, int]) -> Sketch:
        """As written by `to_dict`."""
        return cls(Counter(dict(bins)))

    def to_dict(self) -> dict[str, int]:
        """Counts by bin, from the lowest value on."""
        return {name: self.bins[name] for name in sorted(self.bins, key=_order)}

    @property
    def count(self) -> int:
        """Values in all."""
        return sum(self.bins.values())

    def quantile(self, level: float) -> float:
        """The value below which a share `level` lies; NaN counts as larger than every number."""
        wanted, seen = level * self.count, 0
        for name in sorted(self.bins, key=_order):
            seen += self.bins[name]
            if seen >= wanted and seen > 0:
                return _value(name)
        return math.nan


def _order(name: str) -> tuple[int, int]:
    if name in ("-inf", "0", "inf", "nan"):
        return {"-inf": 0, "0": 2, "inf": 4, "nan": 5}[name], 0
    place = int(name[1:])
    return (1, -place) if name[0] == "-" else (3, place)


def _value(name: str) -> float:
    """The middle of a bin."""
    if name in ("-inf", "0", "inf", "nan"):
        return float(name)
    return math.copysign(math.exp((int(name[1:]) + 0.5) * _log), 1.0 if name[0] == "+" else -1.0)


__all__ = ["RATIO", "Sketch"]
