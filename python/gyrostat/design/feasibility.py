# SPDX-License-Identifier: MIT
"""Whether the actuators can give what is asked of them, healthy and after a scenario's faults."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from gyrostat.allocation import DEFAULT_RANK_TOLERANCE, AttainableSet, attainable_set
from gyrostat.design.finding import Finding
from gyrostat.design.idle import faults_alone
from gyrostat.scenario import Scenario
from gyrostat.vehicle import all_actuators

Floats = NDArray[np.float64]


def attainable_after_faults(scenario: Scenario) -> tuple[AttainableSet, AttainableSet] | None:
    """What a scenario's vehicle can do while healthy, and when its faults leave it least.

    Limits are the truth's. Spare actuators count when the scenario has a detector that could enable them; what a faulty
    actuator delivers by itself (bias, stuck output) moves the set. An axis that the scenario's allocator drops as too
    weak (its `rank_tolerance`), the effectiveness known, has no torque.

    Returns
    -------
    tuple or None
        The healthy set, and of all that the faults leave over time the one with least torque in every direction;
        None where a limit is infinite.
    """
    D, lo, up = _actuators(scenario)
    if not (np.all(np.isfinite(lo)) and np.all(np.isfinite(up))):
        return None
    n, tolerance = D.shape[1], _rank_tolerance(scenario)
    healthy = attainable_set(D, up, lo, rank_tolerance=tolerance)
    passed = faults_alone(scenario, ["truth.effectiveness", "truth.bias"])
    states = np.unique(np.hstack([passed["truth.effectiveness"], passed["truth.bias"]]), axis=0)
    least = _least(healthy.normals, D, up, lo, states)
    least[_weakest_axis(D, states[:, :n]) <= tolerance] = 0.0
    weakest = states[np.argsort(least, kind="stable")[:100]]
    sets = [attainable_set(D, up, lo, row[:n], rank_tolerance=tolerance).moved(D @ row[n:]) for row in weakest]
    return healthy, min(sets, key=lambda s: s.in_every_direction)


def _least(normals: Floats, D: Floats, up: Floats, lo: Floats, states: Floats) -> Floats:
    """Torque in every direction, N m, of each state (effectiveness, bias), (k, 2n).

    Weaker actuators turn no face, so the healthy normals serve all states; exact unless an actuator is dead.
    """
    n = D.shape[1]
    across = normals @ D
    least = np.empty(len(states))
    for at in range(0, len(states), 4096):
        effectiveness, bias = states[at : at + 4096, :n], states[at : at + 4096, n:]
        reach = effectiveness @ (np.abs(across) * ((up - lo) / 2)).T
        centre = effectiveness @ (across * ((up + lo) / 2)).T + bias @ across.T
        least[at : at + 4096] = (reach + centre).min(axis=1)
    return least


def _weakest_axis(D: Floats, effectiveness: Floats) -> Floats:
    """Smallest singular value of ``D diag(effectiveness)`` relative to the largest, for each row (k, n)."""
    values = np.linalg.svd(D * effectiveness[:, None, :], compute_uv=False)
    least = values[:, 2] if D.shape[1] >= 3 else np.zeros(len(values))
    return np.asarray(np.divide(least, values[:, 0], out=np.zeros(len(values)), where=values[:, 0] > 0))


def _rank_tolerance(scenario: Scenario) -> float:
    return float(scenario.resolve()["allocator"].get("rank_tolerance", DEFAULT_RANK_TOLERANCE))


def _actuators(scenario: Scenario) -> tuple[Floats, Floats, Floats]:
    """Axes (3, n) and limits (n,) that really fly; magnetorquers and spares that nobody enables have none."""
    plain = scenario.resolve()
    truth, vehicle = plain.get("truth", {}), all_actuators(plain)
    D = np.asarray(vehicle["D_B"], float)
    if truth.get("dD_B") is not None:
        D = D + np.asarray(truth["dD_B"], float)

    own = D.shape[1] - len((plain.get("thrusters") or {}).get("positions", ()))

    def limit(name: str, default: Floats) -> Floats:
        value = vehicle.get(name)
        out = default if value is None else np.broadcast_to(np.asarray(value, float), D.shape[1]).copy()
        if truth.get(name) is not None:  # of all but the thrusters
            out[:own] = truth[name]
        return out

    up = limit("u_max", np.full(D.shape[1], np.inf))
    lo = limit("u_min", -up)
    if truth.get("u_max") is not None and truth.get("u_min") is None and plain["vehicle"].get("u_min") is None:
        lo[:own] = -up[:own]
    off = list(plain["vehicle"].get("magnetorquers") or [])
    if plain["detector"]["type"] == "none":
        off += list(plain["vehicle"].get("spare") or [])
    up[off] = lo[off] = 0.0
    return D, lo, up


def torque_findings(
    scenario: Scenario,
    torque_B: Sequence[float] | None = None,
    *,
    fly: bool = False,
) -> list[Finding]:
    """Hold torques against what the actuators can give, healthy and when the faults leave them least.

    Parameters
    ----------
    scenario
        Vehicle, limits and faults. It needs some torque in every direction to be feasible.
    torque_B
        (3,) N m, a demand; it must be within reach after the faults.
    fly
        Fly the scenario too, and hold the torque that its controller asks for against what the faults have left at
        that sample.

    Returns
    -------
    list of Finding
        Of a vehicle with an infinite limit only when the signs of its actuators leave out some direction.
    """
    if scenario.actuators == len(scenario.vehicle.magnetorquers or ()):
        return [Finding("torque", "every direction", "of magnetorquers alone: none along the magnetic field")]
    sets = attainable_after_faults(scenario)
    if sets is None:
        D, lo, up = _actuators(scenario)
        bounded = attainable_set(D, np.clip(up, 0, 1), np.clip(lo, -1, 0), rank_tolerance=_rank_tolerance(scenario))
        if bounded.in_every_direction > 1e-12:
            return []
        text = f"no torque in some direction, whatever the limits: {_why(scenario, bounded)}"
        return [Finding("torque", "every direction", text, False, 0.0, 0.0)]
    healthy, left = sets
    least, once = left.in_every_direction, healthy.in_every_direction
    nothing = 1e-12 * once  # what rounding leaves of a flat set
    now = (
        f"{least:.3g} N m in every direction"
        if least > nothing
        else f"no torque in some direction ({_why(scenario, left)})"
        if least >= -nothing
        else f"some direction falls short of zero by {-least:.3g} N m"
    )
    text = f"after the faults {now}, healthy {once:.3g} N m"
    found = [Finding("torque", "every direction", text, least > nothing, least, 0.0)]
    if torque_B is not None:
        found.append(_demand(healthy, left, np.asarray(torque_B, float)))
    if fly:
        found.append(_flown(scenario))
    return found


def _why(scenario: Scenario, left: AttainableSet) -> str:
    """Why a set has no torque in some direction."""
    values = np.linalg.svd(left.generators, compute_uv=False)
    if len(values) == 3 and values[2] > 1e-9 * values[0]:
        return "no positive commands of all actuators add up to zero"
    tolerance = _rank_tolerance(scenario)
    return f"an axis is lost, or below rank_tolerance = {tolerance:g} of the strongest and not served"


def _demand(healthy: AttainableSet, left: AttainableSet, torque_B: Floats) -> Finding:
    size = float(np.linalg.norm(torque_B))
    reach, once = (float(np.nan_to_num(s.radius(torque_B))) for s in (left, healthy))
    text = f"{size:.3g} N m along ({', '.join(f'{x:g}' for x in torque_B)}): after the faults {reach:.3g} N m"
    return Finding("torque", "demand", f"{text}, healthy {once:.3g} N m", bool(left.contains(torque_B)), size, reach)


def _flown(scenario: Scenario) -> Finding:
    """The largest shortfall of the demand against the set of its own sample, and how often there is one."""
    D, lo, up = _actuators(scenario)
    n, tolerance = D.shape[1], _rank_tolerance(scenario)
    names = ["demand.tau_B", "truth.effectiveness", "truth.bias"]
    flown = scenario.run(channels=names)
    state = np.hstack([flown["truth.effectiveness"], flown["truth.bias"]])
    rows, which = np.unique(state, axis=0, return_inverse=True)
    short = np.zeros(len(flown))
    if len(rows) > 2000:  # effectiveness that varies without end: to 1e-3 it does not
        rows, which = np.unique(np.round(state, 3), axis=0, return_inverse=True)
    for k, row in enumerate(rows):
        left = attainable_set(D, up, lo, row[:n], rank_tolerance=tolerance).moved(D @ row[n:])
        at = which.ravel() == k
        beyond = (flown["demand.tau_B"][at] - left.centre) @ left.normals.T - left.heights
        short[at] = np.maximum(beyond.max(axis=1), 0.0)
    worst = int(np.argmax(short))
    share = float(np.mean(short > 1e-9))
    text = (
        f"flown: the demand is out of reach in {100 * share:.3g} % of the samples, "
        f"by {short[worst]:.3g} N m at most (t = {flown.t[worst]:.4g} s)"
        if share > 0.0
        else "flown: the demand is within reach in every sample"
    )
    return Finding("torque", "flight", text, None, share)
