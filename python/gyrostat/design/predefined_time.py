# SPDX-License-Identifier: MIT
"""Predefined-time control: what the lemma promises, and the smallest promise that the torque can keep.

``V' = -exp(V^h) V^(1-h) / (h T)`` ends at ``T (1 - exp(-V0^h)) < T``. The law of Cao, Gong, Han 2022 follows it twice,
to the surface within T2 and along it within T1, with whatever torque that takes; a limited vehicle keeps the promise
only when T1 + T2 is long enough. How long is found on the simulated manoeuvre.
"""

from __future__ import annotations

import math

import numpy as np

from gyrostat.design import feasible_time
from gyrostat.design.feasible_time import FeasibleTime
from gyrostat.design.finding import Finding
from gyrostat.errors import InputError
from gyrostat.scenario import Scenario


def settling_time(V0: float, h: float, T: float) -> float:
    """Time, s, at which the equality of the lemma reaches zero: ``T (1 - exp(-V0^h))``.

    Parameters
    ----------
    V0
        Initial value, not negative.
    h
        Power, inside (0, 1).
    T
        Predefined time, s.
    """
    if not (V0 >= 0.0 and 0.0 < h < 1.0 and T > 0.0):
        raise InputError(f"V0 = {V0:g} must not be negative, h = {h:g} in (0, 1), T = {T:g} s positive")
    return -T * math.expm1(-(V0**h))


def promised_time(scenario: Scenario) -> tuple[float, float]:
    """Bound of the lemma for a scenario's initial state, s: to the surface, then along it.

    The attitude is taken from the initial state, as if it had not moved while the surface was reached.
    """
    law = _law(scenario)
    start = scenario.replace(duration=scenario.dt, shadows=[], record=None)
    first = start.run(channels=["error.mrp", "controller.s"])
    V1, V2 = (0.5 * float(np.sum(first[name][0] ** 2)) for name in ("error.mrp", "controller.s"))
    return settling_time(V2, law["h2"], law["T2"]), settling_time(V1, law["h1"], law["T1"])


def torque_use(scenario: Scenario, factor: float = 1.0) -> float:
    """Largest command of the healthy manoeuvre without limits, over the limits; T1 and T2 are multiplied by a factor.

    Parameters
    ----------
    scenario
        Flies a predefined-time law on a vehicle with limits. Faults and sensors are left out, the observer too.
    factor
        Of T1 and T2.
    """
    law = _law(scenario)
    limits = np.broadcast_to(np.asarray(_limit(scenario), dtype=float), np.shape(scenario.axes_B)[1:])
    horizon = min(scenario.duration, factor * (law["T1"] + law["T2"]))
    samples = max(1, round(horizon / scenario.dt))
    flown = scenario.replace(
        **{
            "vehicle.u_max": math.inf,
            "truth": {},
            "controller.T1": factor * law["T1"],
            "controller.T2": factor * law["T2"],
            "duration": samples * scenario.dt,
            "allow_unstable": True,
            "observer": "passthrough",
            "integrator": "rk4",
            "faults": [],
            "sensors": [],
            "shadows": [],
            "record": None,
        }
    ).run(channels=["allocation.u"])
    return float(np.max(np.abs(flown["allocation.u"]) / limits))


def smallest_feasible_time(scenario: Scenario, tolerance: float = 1e-3) -> FeasibleTime:
    """The smallest T1 + T2 that the torque limits allow from a scenario's initial state, T1 / T2 kept.

    Parameters
    ----------
    scenario
        As for `torque_use`.
    tolerance
        Relative width at which to stop.

    Raises
    ------
    InputError
        No law or limit to look at, or no factor from 1/64 to 64 brackets the limit (k_s alone may exceed it).
    """
    law = _law(scenario)
    total = law["T1"] + law["T2"]
    return feasible_time.smallest_feasible_time(
        lambda time: torque_use(scenario, time / total) > 1.0, total, tolerance=tolerance
    )


def findings(scenario: Scenario) -> list[Finding]:
    """What ``gyrostat check`` says about a predefined-time law; nothing for another one.

    The smallest feasible time flies some twenty healthy manoeuvres of at most T1 + T2: tenths of a second.
    """
    law = scenario.resolve()["controller"]
    if law.get("type") != "predefined_time":
        return []
    where = "controller predefined_time"
    reach, slide = promised_time(scenario)
    T = law["T1"] + law["T2"]
    found = [
        Finding(
            where,
            "settling",
            f"unlimited torque: at most {reach:.3g} s to the surface and {slide:.3g} s along it, promised {T:.3g} s",
            None,
            reach + slide,
            T,
        )
    ]
    inside = 0.5 * 0.05**2 * 1e-3
    found.append(
        Finding(
            where,
            "singularity",
            f"h1 = {law['h1']:.3g}: beyond 0.25 the torque has no bound at the target without a floor; "
            f"floor1 = {law['floor1']:.3g}",
            bool(law["h1"] <= 0.25 or law["floor1"] > inside),
            law["h1"],
            0.25,
        )
    )
    limit = _limit(scenario)
    if limit is None or not np.all(np.isfinite(np.asarray(limit, dtype=float))):
        return found
    weakest = float(np.min(np.asarray(limit, dtype=float)))
    found.append(
        Finding(
            where,
            "theorem2",
            f"the proof asks for k_s > u_max + d_max, to outweigh a wrong estimate: k_s = {law['k_s']:.3g} N m, "
            f"u_max = {weakest:.3g} N m",
            bool(law["k_s"] > weakest),
            law["k_s"],
            weakest,
        )
    )
    found.append(
        feasible_time.feasible_time_finding(where, "T1 + T2 (healthy)", T, lambda: smallest_feasible_time(scenario))
    )
    return found


def _law(scenario: Scenario) -> dict[str, float]:
    law = scenario.resolve()["controller"]
    if law.get("type") != "predefined_time":
        raise InputError("the scenario does not fly controller 'predefined_time'")
    return {k: float(law[k]) for k in ("h1", "T1", "h2", "T2")}


def _limit(scenario: Scenario) -> object:
    return None if scenario.thrusters is not None else scenario.resolve()["vehicle"].get("u_max")


__all__ = [
    "findings",
    "promised_time",
    "settling_time",
    "smallest_feasible_time",
    "torque_use",
]
