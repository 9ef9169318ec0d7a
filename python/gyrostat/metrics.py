# SPDX-License-Identifier: MIT
"""Metrics of a run. They live in C++, once, and serve single runs, claims and experiments alike.

Instants and windows are absolute, in seconds; a settling time is counted from the instant ``after``, which is the last
fault in `Metrics` and zero in the function unless given. A signal has shape (n,) or (n, k), and its size at an instant
is the largest ``|x_i|``. Claims (`gyrostat.papers`) measure with the same functions under the same names.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from gyrostat._core import (
    energy,
    final,
    first_reach,
    fraction_at_least,
    recovery,
    settling_time,
    total_variation,
    window_highest,
    window_lowest,
    window_max,
    window_norm,
    window_rms,
)

if TYPE_CHECKING:
    from gyrostat.results import Result

DEFAULT_BAND = math.radians(0.1)
"""Pointing error that counts as settled unless said otherwise: 0.1 deg."""


class Metrics:
    """Numbers that sum up one run; each is computed when it is asked for.

    A metric whose channels were not recorded raises `KeyError` naming the channel.
    """

    def __init__(self, result: Result) -> None:
        self._result = result

    @property
    def last_fault(self) -> float:
        """Onset of the last fault that the run saw, s; 0 without faults."""
        onsets = [float(fault.get("t_on", 0.0)) for fault in self._result.known_faults]
        return max((t_on for t_on in onsets if t_on < self._result.end_time), default=0.0)

    @property
    def settling_time(self) -> float:
        """Time from the last fault until the pointing error stays below 0.1 deg, s; nan if it does not."""
        return self.settling()

    def settling(self, band: float = DEFAULT_BAND, signal: str = "error.angle") -> float:
        """Time from the last fault until a signal stays inside a band to the end, s; nan if it does not."""
        return settling_time(self._result.t, self._result[signal], band, self.last_fault)

    @property
    def pointing_error(self) -> float:
        """Root mean square of the pointing error over the last tenth of the run, rad."""
        t = self._result.t
        return window_rms(t, self._result["error.angle"], t[0] + 0.9 * (t[-1] - t[0]), t[-1])

    @property
    def final_error(self) -> float:
        """Pointing error at the end, rad."""
        return float(self._result["error.angle"][-1])

    @property
    def peak_error_after_fault(self) -> float:
        """Largest pointing error from the last fault on, rad."""
        t = self._result.t
        return window_max(t, self._result["error.angle"], min(self.last_fault, t[-1]), t[-1])

    @property
    def energy(self) -> float:
        """Integral of ``u'u``, N^2 m^2 s."""
        return energy(self._result.t, self._result["allocation.u"])

    @property
    def command_variation(self) -> float:
        """Mean total variation of the commands, N m/s: what a chattering law shows in."""
        t = self._result.t
        return total_variation(t, self._result["allocation.u"], t[0], t[-1])

    @property
    def saturated_fraction(self) -> float:
        """Fraction of samples at which ``allocation.saturated`` names an actuator: at a limit, and not at rest."""
        t = self._result.t
        return fraction_at_least(t, self._result["allocation.saturated"], 1.0, t[0], t[-1])

    @property
    def held_fraction(self) -> float:
        """Fraction of samples at which the guard replaced an input or issued the previous command again."""
        statistics = self._result.statistics
        return float(statistics["held_samples"]) / float(statistics["samples"])

    def to_dict(self) -> dict[str, float | None]:
        """All of them by name; None where a channel was not recorded or the value is not finite."""
        return {name: self._value(name) for name in UNITS}

    def _repr_html_(self) -> str:
        from gyrostat import notebook

        return notebook.metrics(self)

    def __repr__(self) -> str:
        return "\n".join(f"{name:24} {value}" for name, value in self.to_dict().items())

    def _value(self, name: str) -> float | None:
        try:
            value = float(getattr(self, name))
        except KeyError:
            return None
        return value if math.isfinite(value) else None


UNITS = {
    "settling_time": "s",
    "pointing_error": "rad",
    "final_error": "rad",
    "peak_error_after_fault": "rad",
    "energy": "N^2 m^2 s",
    "command_variation": "N m/s",
    "saturated_fraction": "",
    "held_fraction": "",
}
"""Unit of each metric that needs no arguments."""

__all__ = [
    "UNITS",
    "Metrics",
    "energy",
    "final",
    "first_reach",
    "fraction_at_least",
    "recovery",
    "settling_time",
    "total_variation",
    "window_highest",
    "window_lowest",
    "window_max",
    "window_norm",
    "window_rms",
]
