# SPDX-License-Identifier: MIT
"""Quantities of the yang2023 claims that are computed from channels."""

from __future__ import annotations

from collections.abc import Callable
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from gyrostat import allocation, metrics
from gyrostat.detection import detection_report, true_changes
from gyrostat.results import Result

Array = NDArray[np.float64]
Method = Literal["pseudo_inverse", "bound", "exact", "paper_constant"]

BENCH_START = 5.0
"""s; the paper's RMSE windows are not printed, the transient of the start is left out."""
AFTER_JUMP = 5.0
"""s after a fault that do not count as quiet."""


def axes(result: Result) -> Array:
    """Nominal actuator axes."""
    return np.array(result.description["vehicle"]["D_B"], dtype=float)


def held(result: Result) -> Array:
    """Command over the interval that ended at each sample; zero at the first."""
    u = result["allocation.u"]
    return np.vstack([np.zeros(u.shape[1]), u[:-1]])


def index(result: Result) -> Array:
    """Health index of the paper, ``[J w' + w x J w]_i / u_i`` of the first three actuators, mean over the interval."""
    u = held(result)
    torque = result["truth.lumped_mean_B"] + u @ axes(result).T
    return np.divide(torque, u[:, :3], out=np.ones_like(torque), where=np.abs(u[:, :3]) > 0.0)


def _index_error(role: str) -> Callable[[Result], Array]:
    return lambda result: result[f"{role}estimate.effectiveness"][:, :3] - index(result)


def health_error(result: Result) -> Array:
    """Estimate less true effectiveness; carries the 8 % of the inertia error."""
    return np.asarray(result["estimate.effectiveness"] - result["truth.effectiveness"])[:, :3]


def relative_gap(result: Result) -> Array:
    """Certified distance to the optimum over the objective; zero where the objective is below rounding of a demand."""
    primal, gap = result["allocator.primal"], result["allocation.gap"]
    return np.asarray(np.divide(gap, primal, out=np.zeros_like(gap), where=primal > 1e-12))


def norm_error(result: Result) -> Array:
    """``| |q| - 1 |``."""
    return np.asarray(np.abs(np.linalg.norm(result["truth.q_NB"], axis=1) - 1.0))


def net_probe(result: Result) -> Array:
    """Net torque of the preferred command, N m; in closed loop nothing but the probe prefers anything."""
    return np.asarray(result["demand.u_pref"] @ axes(result).T)


def early_spare(result: Result) -> Array:
    """Command of the spare actuator until the first declaration, N m; zero after it."""
    return np.asarray(np.where(result["detection.event"] == 0.0, result["allocation.u"][:, 3], 0.0))


def event_time(result: Result, *, name: str, count: int = 1, after: float = 0.0) -> float:
    """When a counter reached `count`, s after `after`."""
    return _first([e.t for e in result.events if e.name == name and e.count >= count], name) - after


def first_event_after(result: Result, *, name: str, after: float) -> float:
    """How long after `after` a counter moved, s."""
    return _first([e.t for e in result.events if e.name == name and e.t >= after], name) - after


def _first(times: list[float], name: str) -> float:
    if not times:
        raise ValueError(f"'{name}' did not count so far")
    return times[0]


def slew_settling(result: Result, *, signal: Array, band: float, window: tuple[float, float]) -> float:
    """Time from the start of a window until the signal stays below `band` to its end, s."""
    part = (result.t >= window[0] - 1e-9) & (result.t < window[1] - 1e-9)
    return metrics.settling_time(result.t[part], signal[part], band, window[0])


def _quiet(result: Result) -> NDArray[np.bool_]:
    keep = np.asarray(result.t > BENCH_START)
    for t, _, _ in true_changes(result, 0.05):
        keep &= ~((result.t > t) & (result.t <= t + AFTER_JUMP))
    return keep


def quiet_rms(result: Result, *, signal: Array) -> float:
    """Root mean square away from faults."""
    return float(np.sqrt(np.mean(signal[_quiet(result)] ** 2)))


def time_to_band(result: Result, *, signal: Array, band: float, worst: bool = False) -> float:
    """Time from a fault until the error of its actuator is below `band`, s; mean over the faults, or the longest."""
    times = []
    for t, actuator, _ in true_changes(result, 0.05):
        rows = np.nonzero((result.t > t + 1e-9) & (np.abs(signal[:, actuator]) < band))[0]
        times.append(result.t[rows[0]] - t)
    return float(max(times) if worst else np.mean(times))


def detection(
    result: Result, *, quantity: Literal["missed", "false", "isolated", "delay", "error"], role: str = ""
) -> float:
    """One number of the report: misses, false alarms, share isolated, longest delay s, or largest RMS error.

    A change counts from 0.25 on: the threshold is 0.2, and the index shows 92 % of a change.
    """
    report = detection_report(result, role, least=0.25)
    match quantity:
        case "missed":
            return float(report.missed)
        case "false":
            return float(len(report.false_alarms))
        case "isolated":
            return float(np.mean([c.answer == "isolated" for c in report.changes]))
        case "delay":
            return float(report.delays.max())
        case "error":
            return float(report.error.max())


def recorded_problems(result: Result) -> tuple[Array, Array, Array]:
    """Every 20th demand with the effectiveness and the limits it was allocated with: (k, 3), (k, 4), (k, 4)."""
    rows = slice(0, None, 20)
    enabled = result["detection.enabled"][rows].astype(int)
    usable = np.array([[bool(mask >> j & 1) for j in range(4)] for mask in enabled])
    limit = np.where(usable, float(result.description["vehicle"]["u_max"]), 0.0)
    return result["demand.tau_B"][rows], np.minimum(result["estimate.effectiveness"][rows], 1.0), limit


def allocated(result: Result, method: Method, h: float, bound: float) -> tuple[Array, Array]:
    """Commands of one method on the recorded demands (k, 4), and the certified relative gaps (k)."""
    demand, e, limit = recorded_problems(result)
    D = axes(result)
    if method == "pseudo_inverse":
        B = D * np.where(limit > 0.0, e, 0.0)[:, None, :]
        u = np.einsum("kij,kj->ki", np.linalg.pinv(B), demand)
        return np.clip(u, -limit, limit), np.zeros(len(u))
    found = allocation.solve(
        D,
        demand,
        limit,
        effectiveness=e,
        bound=0.0 if method == "paper_constant" else bound,
        mode="robust_socp",
        worst_case=method,
        residual_weight=h,
        margin=bound if method == "paper_constant" else 0.0,
    )
    return found.command, found.gap / np.maximum(found.primal, 1e-12)


def recorded_allocation(
    result: Result,
    *,
    method: Method,
    quantity: Literal["energy", "residual", "worst", "gap"],
    h: float = 1e3,
    bound: float = 0.1,
) -> float:
    """One method on the recorded demands: effort (N m)^2 s, rms (worst) residual N m, or largest relative gap.

    The worst residual is over relative errors of +-0.1 of each effectiveness, all 16 corners: no allocator computes it.
    """
    u, gap = allocated(result, method, h, bound)
    demand, e, _ = recorded_problems(result)
    D = axes(result)
    if quantity == "energy":
        return float(np.sum(u**2) * 20.0 * float(result.description["dt"]))
    if quantity == "gap":
        return float(gap.max())
    corners = np.array(np.meshgrid(*[[-0.1, 0.1]] * 4)).reshape(4, -1).T if quantity == "worst" else np.zeros((1, 4))
    residuals = [np.linalg.norm((u * e * (1.0 + c)) @ D.T - demand, axis=1) for c in corners]
    return float(np.sqrt(np.mean(np.max(residuals, axis=0) ** 2)))


def recorded_excess(result: Result, *, method: Method, h: float) -> float:
    """Rms worst residual of one method on the recorded demands less that of the pseudo-inverse, N m."""
    worst = recorded_allocation(result, method=method, quantity="worst", h=h)
    return worst - recorded_allocation(result, method="pseudo_inverse", quantity="worst")


def energy_ratio(result: Result, *, signal: Array, against: Result, other: Array) -> float:
    """Energy over that of another case."""
    return metrics.energy(result.t, signal) / metrics.energy(against.t, other)


def gain_law(
    result: Result,
    *,
    k1: tuple[float, float, float],
    k2: tuple[float, float, float],
    k4: tuple[float, float, float],
    deadzone: float,
    leak: float,
    chi: float,
    gamma: float,
) -> float:
    """Largest relative difference of the gains from (5) on the recorded rate errors; each: first, largest, rate."""
    dt = float(result.description["dt"])
    expected = np.array([k1[0], k2[0], k4[0]])
    worst = 0.0
    for m, found in zip(
        np.linalg.norm(result["observer.error"], axis=1)[1:], result["observer.gains"][1:], strict=True
    ):
        for i, (first, largest, rate) in ((0, k1), (2, k4)):
            grown = expected[i] + dt * (rate * m if m > deadzone else -leak * (expected[i] - first))
            expected[i] = min(grown, largest)
        moved = k2[2] * m * np.sign(m - chi) if expected[1] > k2[0] else gamma
        expected[1] = min(max(expected[1] + dt * moved, 0.0), k2[1])
        worst = max(worst, float(np.max(np.abs(found / expected - 1.0))))
    return worst


def surface_law(result: Result, *, b1: float, b2: float, r: float, eps_core: float, z_max: float) -> float:
    """Largest difference of s from ``w_e + b1 eps + b2 sig^r(eps)`` at recorded z and rates; reference at rest."""
    z = result["controller.z"]
    inside = np.clip(z, -z_max, z_max)
    eps = np.log((1.0 + inside) / (1.0 - inside)) + 2.0 / (1.0 - z_max**2) * (z - inside)
    size = np.abs(eps)
    core = ((2.0 - r) * eps_core ** (r - 1.0) + (r - 1.0) * eps_core ** (r - 2.0) * size) * eps
    power = np.where(size < eps_core, core, np.sign(eps) * size**r)
    s = result["estimate.omega_BN_B"] + b1 * eps + b2 * power
    return float(np.max(np.abs(s - result["controller.s"])))


def shortest_gap(result: Result) -> float:
    """Between two declarations of one actuator, s."""
    rows = 1 + np.nonzero(np.diff(result["detection.event"]))[0]
    members = result["detector.declared"][rows].astype(int)
    gaps = [np.diff(result.t[rows[(members >> i & 1) == 1]]) for i in range(axes(result).shape[1])]
    return float(np.concatenate(gaps).min())


SIGNALS = {
    "index": index,
    "index_error": _index_error(""),
    "index_error_0": _index_error("shadow0."),
    "index_error_1": _index_error("shadow1."),
    "health_error": health_error,
    "relative_gap": relative_gap,
    "norm_error": norm_error,
    "net_probe": net_probe,
    "early_spare": early_spare,
}
METRICS = {
    f.__name__: f
    for f in (
        event_time,
        first_event_after,
        slew_settling,
        quiet_rms,
        time_to_band,
        detection,
        recorded_allocation,
        recorded_excess,
        energy_ratio,
        gain_law,
        surface_law,
        shortest_gap,
    )
}
