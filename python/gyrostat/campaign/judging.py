# SPDX-License-Identifier: MIT
"""What counts as a success, and by how much a flight is lost or saved.

A flight that ended early is never a success. Its margin is ``3 + (1 - t_end / duration)``, the earlier the worse, so
that a margin is finite for every flight and what looks for failures has a direction everywhere.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gyrostat.campaign.spec import Criterion, Spec
from gyrostat.campaign.streams import Array
from gyrostat.errors import InputError, suggestion

LOST = 3.0
"""Margin of a flight that ended at its very end; one that ended at once has one more."""

TIMES = ("settling_time", "recovery", "first_reach")
"""Metrics without a value where what they wait for does not happen."""
_smallest = sys.float_info.min


@dataclass(frozen=True)
class Judge:
    """Of flights by their measures."""

    success: Mapping[str, Criterion]
    margin: str | None
    """The measure of the margin, if there is one."""
    duration: float

    @classmethod
    def of(cls, spec: Spec, measures: Mapping[str, Mapping[str, object]], duration: float) -> Judge:
        """Of a campaign whose flights are measured so.

        Raises
        ------
        InputError
            A measure that there is none of, or a margin that some flights would not have.
        """
        for name in spec.success:
            if name not in measures:
                raise InputError(f"success: no measure '{name}'{suggestion(name, measures)}")
        margin = None
        if spec.margin is not None:
            margin = spec.margin.measure
            if margin not in measures:
                raise InputError(f"margin: no measure '{margin}'{suggestion(margin, measures)}")
            if margin not in spec.success:
                raise InputError(f"margin: '{margin}' has no limit in [success]")
            if (metric := str(measures[margin].get("metric"))) in TIMES:
                raise InputError(
                    f"margin: '{margin}' is not finite for every flight: {metric} is nan where it does not happen; "
                    "take the size itself, e.g. window_max"
                )
        elif len(spec.success) == 1:
            (only,) = spec.success
            margin = None if measures[only].get("metric") in TIMES else only
        return cls(spec.success, margin, duration)

    def successes(self, completed: NDArray[np.bool_], measures: Mapping[str, Array]) -> NDArray[np.bool_]:
        """Which flights succeeded, shape (n,): completed, and every criterion holds; NaN does not."""
        good = np.array(completed)
        for name, criterion in self.success.items():
            x = measures[name]
            if criterion.below is not None:
                good &= x < criterion.below
            if criterion.above is not None:
                good &= x > criterion.above
        return good

    def margins(
        self, completed: NDArray[np.bool_], measures: Mapping[str, Array], t_end: Array, first: int
    ) -> Array | None:
        """Signed distances from the limit, shape (n,), positive where lost; None where no margin is defined.

        Raises
        ------
        InputError
            A completed flight whose measure is not finite.
        """
        if self.margin is None:
            return None
        x, criterion = measures[self.margin], self.success[self.margin]
        parts = []
        if criterion.below is not None:
            parts.append(_distance(x, criterion.below, criterion.scale))
        if criterion.above is not None:
            parts.append(-_distance(x, criterion.above, criterion.scale))
        margin = parts[0] if len(parts) == 1 else np.maximum(*parts)
        flown = t_end / self.duration if self.duration > 0.0 else np.ones_like(t_end)
        out = np.where(completed, margin, LOST + (1.0 - flown))
        if not np.all(np.isfinite(out)):
            at = int(np.flatnonzero(~np.isfinite(out))[0])
            raise InputError(
                f"margin: '{self.margin}' of run {first + at} is {x[at]:g}, and the flight completed; "
                "a margin is finite for every flight"
            )
        return out


def _distance(x: Array, limit: float, scale: str) -> Array:
    """Above the limit; NaN stays."""
    if scale == "linear":
        return x - limit
    return np.log10(np.maximum(x, _smallest)) - math.log10(limit)


__all__ = ["LOST", "TIMES", "Judge"]
