# SPDX-License-Identifier: MIT
"""``gyrostat design mixed_learning`` and the findings of ``gyrostat check`` on mixed learning."""

from __future__ import annotations

import itertools
import math
from dataclasses import replace
from typing import Annotated, Any

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from gyrostat.design.feasibility import attainable_after_faults
from gyrostat.design.finding import Finding
from gyrostat.design.learning_loop import LearningLoop, settling
from gyrostat.design.mixed_learning import (
    LearningDesign,
    as_matrix,
    best_case,
    checked_inertia,
    conditions_hold,
    design_observer,
    design_sliding_mode,
    observer_margins,
    sliding_margins,
)
from gyrostat.design.registry import Design, DesignReport
from gyrostat.model import Model
from gyrostat.scenario import Scenario
from gyrostat.vehicle import all_actuators

Array = NDArray[np.float64]
Rows = list[list[float]]
Positive = Annotated[float, Field(gt=0.0)]

# rad. Measured with 400 random vehicles in the simulator: below, the settling times are those of the trial run to 12 %;
# above 0.6 the gyroscopic torques can delay it beyond what was asked.
_largest_turn = 0.25

_meaning = {
    "m11": "(11) K1 damps the error",
    "r12": "(12) K2 is P1 J^-1 / sigma2, relative",
    "m13": "(13) the learnt torque is forgotten",
    "m14": "(14) the share of the past error is small",
    "m15": "(15) the sign term exceeds the disturbance",
    "m33": "(33) the reaching gain damps s",
    "r34": "(34) K3 is P2 J^-1 / sigma4, relative",
    "m35": "(35) the learnt torque is forgotten",
    "m36": "(36) the share of the past s is small",
}


_Fault = Annotated[
    float | None,
    Field(
        gt=0.0,
        description="N m, torque fault on each axis that is tried; default a tenth of the torque that the scenario's "
        "vehicle has in every direction, without one of 0.04 rad/s^2",
    ),
]


class Wanted(Model):
    """Options of ``gyrostat design mixed_learning``."""

    J_B: Annotated[Rows | list[float], Field(description="kg m^2, nominal inertia")]
    dt: Annotated[float, Field(gt=0.0, description="s, period")]
    settling_time: Annotated[
        float | None, Field(gt=0.0, description="s, of the learnt torque to 2 %; default 300 periods")
    ] = None
    disturbance: Annotated[float, Field(ge=0.0, description="N m, bound of what is not to be learnt")] = 0.0
    fault: _Fault = None
    pointing_time: Annotated[
        float | None, Field(gt=0.0, description="s, of the attitude to 2 % on the surface; default 20 settling times")
    ] = None


class SixSteps(Model):
    """Options of ``gyrostat design mixed_learning_six_steps``: the published procedure; defaults of the publication."""

    J_B: Annotated[Rows | list[float], Field(description="kg m^2, nominal inertia")]
    dt: Annotated[float, Field(gt=0.0, description="s, period")] = 1e-3
    P1: Annotated[float, Field(gt=0.0, description="weight of the rate error")] = 81.0
    alpha0: Annotated[float, Field(ge=0.0, description="theorem constant")] = 0.0
    eta: Annotated[float, Field(ge=0.0, description="theorem constant")] = 0.05
    K1_slack: Annotated[float, Field(ge=0.0, description="N m s, added to K1")] = 0.1
    sigma1: Annotated[float | None, Field(description="kept and only checked; default from (14)")] = None
    sigma2: Annotated[float, Field(gt=0.0, le=1.0, description="share of the present error")] = 0.9
    theta1: Annotated[float | None, Field(ge=0.0, description="N m, kept and only checked")] = None
    theta2: Annotated[float | None, Field(gt=0.0, lt=1.0, description="kept and only checked")] = None
    sigma4: Annotated[float, Field(gt=0.0, le=1.0, description="share of the present s")] = 0.99
    k_lin: Annotated[float, Field(gt=0.0, description="N m s, reaching gain")] = 3.0
    k_sgn: Annotated[float, Field(ge=0.0, description="N m, switching gain")] = 0.01
    delta: Annotated[float, Field(gt=0.0, description="1/s, slope of the surface")] = 0.1
    disturbance: Annotated[float, Field(ge=0.0, description="N m, bound of what is not to be learnt")] = 2.4e-3
    fault: _Fault = None


def _conditions(where: str, margins: dict[str, float]) -> list[Finding]:
    holds = conditions_hold(margins)
    rows = []
    for name, value in margins.items():
        limit = 1e-3 if name.startswith("r") else 0.0
        relation = "<=" if name.startswith("r") else ">"
        text = f"{_meaning[name]}: {value:.3g}, must be {relation} {limit:g}"
        rows.append(Finding(where, name, text, holds[name], value, limit))
    return rows


def _stability(where: str, loop: LearningLoop) -> Finding:
    radius = loop.spectral_radius()
    text = f"spectral radius of the sampled loop {radius:.6f}, Schur margin {1.0 - radius:.3g}"
    return Finding(where, "schur", text, radius < 1.0, 1.0 - radius, 0.0)


def _steady(where: str, loop: LearningLoop, fault: float) -> Finding:
    error, learnt = loop.equilibrium(np.full(3, fault))
    left = float(np.abs(fault - learnt).max())
    rate = float(np.abs(error).max())
    text = f"steady state under {fault:g} N m on each axis: {left:.3g} N m not learnt, error {rate:.3g} rad/s"
    return Finding(where, "steady_state", text, None, left)


def _without_rounding(gain: Array) -> Rows:
    """Entries that only rounding has left become zero."""
    return np.where(np.abs(gain) < 1e-14 * np.abs(gain).max(), 0.0, gain).tolist()  # type: ignore[no-any-return]


def observer_table(loop: LearningLoop) -> dict[str, Any]:
    """Parameters of the observer, as a scenario writes them."""
    return {
        "type": "mixed_learning_disturbance",
        "K1": _without_rounding(loop.K_lin),
        "K2": _without_rounding(loop.K),
        "sigma1": loop.before,
        "sigma2": loop.now,
        "theta1": loop.sign_gain,
        "theta2": loop.keep,
        "width": loop.width,
        "delay": loop.delay,
    }


def controller_table(loop: LearningLoop, delta: float) -> dict[str, Any]:
    """Parameters of the controller, as a scenario writes them."""
    return {
        "type": "mixed_learning_sliding_mode",
        "delta": delta,
        "k_lin": float(loop.K_lin[0, 0]),
        "k_sgn": loop.sign_gain,
        "width": loop.width,
        "K3": _without_rounding(loop.K),
        "sigma3": loop.before,
        "sigma4": loop.now,
        "theta3": loop.keep,
        "delay": loop.delay,
    }


def flight_inertia(scenario: Scenario) -> Array:
    """Inertia that flight works with, kg m^2: with wheels, less their axial inertia along their axes."""
    vehicle = all_actuators(scenario.resolve())
    D_B = np.asarray(vehicle["D_B"], dtype=float)
    wheels = np.broadcast_to(np.asarray(vehicle.get("wheel_inertia") or 0.0, dtype=float), D_B.shape[1])
    return np.asarray(as_matrix(np.asarray(vehicle["J_B"])) - D_B * wheels @ D_B.T)


def usual_fault(J: Array, usable_torque: float | None = None) -> float:
    """A torque fault to try gains with, N m, in proportion to what the vehicle can do.

    Parameters
    ----------
    J
        kg m^2, inertia.
    usable_torque
        N m, in every direction. Where that says nothing it is taken as flight does: 0.04 rad/s^2 about the axis of
        largest inertia.
    """
    if usable_torque is None or not (math.isfinite(usable_torque) and usable_torque > 0.0):
        usable_torque = 0.04 * float(np.linalg.eigvalsh(J)[-1])
    return 0.1 * usable_torque


def _of_scenario(scenario: Scenario) -> dict[str, Any]:
    J = flight_inertia(scenario)
    sets = attainable_after_faults(scenario.replace(faults=[]))
    return {
        "J_B": J.tolist(),
        "dt": scenario.dt,
        "fault": usual_fault(J, None if sets is None else sets[0].in_every_direction),
    }


def six_steps(options: SixSteps) -> DesignReport:
    """The published procedure for observer and controller."""
    o = options
    observer = design_observer(
        as_matrix(np.asarray(o.J_B)), o.dt, P1=o.P1,
        alpha0=o.alpha0, eta=o.eta, K1_slack=o.K1_slack, sigma1=o.sigma1, sigma2=o.sigma2,
        theta1=o.theta1, theta2=o.theta2, disturbance=o.disturbance,
    )  # fmt: skip
    controller = design_sliding_mode(as_matrix(np.asarray(o.J_B)), o.dt, sigma4=o.sigma4, k_lin=o.k_lin, k_sgn=o.k_sgn)
    fault = usual_fault(observer.loop.J) if o.fault is None else o.fault
    return _report(observer, controller, o.delta, fault)


def _report(observer: LearningDesign, controller: LearningDesign, delta: float, fault: float) -> DesignReport:
    one, other = "observer mixed_learning_disturbance", "controller mixed_learning_sliding_mode"
    findings = [*_conditions(one, observer.margins), _stability(one, observer.loop)]
    findings += [_steady(one, observer.loop, fault)]
    findings += [*_conditions(other, controller.margins), _stability(other, controller.loop)]
    tables = {"observer": observer_table(observer.loop), "controller": controller_table(controller.loop, delta)}
    return DesignReport(tables, findings)


def _observer_for(J: Array, dt: float, b: float, disturbance: float) -> LearningDesign:
    """Six steps with P1 proportional to J J: a double pole at the bandwidth b on every axis.

    ``K1 = 2 b J``, ``K2 = b^2 dt J / sigma2``. theta2 leaves about half a per cent of a constant fault unlearnt. The
    rate unit of the conditions is what (11) then needs.
    """
    sigma2, eta, small = 0.9, 0.05, 0.0015 * b * dt
    eps, margin = (small, small, 1.0), min(3e-4, small)
    J_min = float(np.linalg.eigvalsh(J)[0])
    P1 = b * b * dt * J @ J
    unit = math.sqrt(0.5 * (1.0 + eta**2) / (b * b * dt * 2.0 * b)) / J_min
    sign = 1.05 * disturbance
    steps = design_observer(
        J, dt, P1=P1, sigma2=sigma2, eta=eta, K1_slack=0.0, eps=eps, margin=margin,
        disturbance=disturbance, theta1=sign, rate_unit=unit,
    ).loop  # fmt: skip
    loop = replace(
        steps, K_lin=2.0 * b * J * (1.0 + 3e-4), before=min(steps.before, 0.1), width=sign / (0.5 * b * J_min)
    )
    margins = observer_margins(loop, P1, eta=eta, eps=eps, disturbance=disturbance, rate_unit=unit)
    if disturbance == 0.0:
        margins.pop("m15")  # nothing to dominate, so no sign term
    return LearningDesign(loop, P1, margins)


def _controller_for(J: Array, dt: float, f: float, b: float) -> LearningDesign:
    """Six steps with P2 proportional to J J: reaching at 2 f, learning at f but no faster than the observer."""
    k_lin = float(np.linalg.eigvalsh(J)[-1]) * 2.0 * f
    p = min(f, b) ** 2 * dt
    unit = 1.01 / math.sqrt(2.0 * p * float(np.linalg.eigvalsh(J)[0]) * k_lin)
    return design_sliding_mode(
        J, dt, P2=p * J @ J, sigma4=0.99, k_lin=k_lin, k_sgn=0.0, eps=(1e-3, 1e-3, 1.0), rate_unit=unit
    )


def design_for(options: Wanted) -> DesignReport:
    """Gains that settle in the wanted time, by the six steps, or why there are none.

    The bandwidth is ``7 / settling_time``, or as much more as the trial run then asks for: with a sign term the end of
    the learning is slower. The trial run is the sampled loop itself, with the fault on every axis and the disturbance
    in every combination of signs; it has to settle in 95 % of the wanted time.
    """
    where = "observer mixed_learning_disturbance"
    J, dt = checked_inertia(np.asarray(options.J_B)), options.dt
    fault = usual_fault(J) if options.fault is None else options.fault
    wanted = 300.0 * dt if options.settling_time is None else options.settling_time
    fastest = 60.0 * dt
    if wanted < fastest * (1.0 - 1e-9):
        text = f"settling in {wanted:g} s needs 60 periods, {fastest:g} s: sample faster or allow more time"
        return DesignReport({}, [Finding(where, "period", text, False, wanted, fastest)])
    if options.disturbance >= 0.5 * fault:
        text = (
            f"a fault of {fault:g} N m cannot be told from {options.disturbance:g} N m of disturbance: "
            "theta1 must exceed the disturbance, and stays unlearnt"
        )
        return DesignReport({}, [Finding(where, "disturbance", text, False, options.disturbance, 0.5 * fault)])
    turn = 0.5 * (fault + options.disturbance) / float(np.linalg.eigvalsh(J)[0]) * (2.0 * wanted / 7.0) ** 2
    if turn > _largest_turn:
        text = (
            f"a fault of {fault:g} N m turns the body by {turn:.2g} rad before it is learnt, at most "
            f"{_largest_turn:g} rad: allow less time, or the fast turn itself has to be learnt"
        )
        return DesignReport({}, [Finding(where, "turn", text, False, turn, _largest_turn)])
    for haste in (1.0, 1.1, 1.2, 1.3, 1.45, 1.6):
        b = 7.0 * haste / wanted
        observer = _observer_for(J, dt, b, options.disturbance)
        trial = _trial(where, observer.loop, fault, options.disturbance, wanted)
        if trial.value is not None and trial.value <= 0.95 * wanted:
            break
    f = 4.0 / (20.0 * wanted if options.pointing_time is None else options.pointing_time)
    report = _report(observer, _controller_for(J, dt, f, b), 2.0 * f, fault)
    return DesignReport(report.components, [*report.findings, trial])


def _trial(where: str, loop: LearningLoop, fault: float, disturbance: float, wanted: float) -> Finding:
    """The slowest of the runs under the fault and the disturbance in every combination of signs."""
    signs = np.array(list(itertools.product((1.0, -1.0), repeat=3))) if disturbance > 0.0 else np.zeros((1, 3))
    pushes = fault + disturbance * signs
    runs = loop.response(pushes, math.ceil(2.0 * wanted / loop.dt))
    times = [settling(runs[:, i], loop.equilibrium(push)[1], 0.02 * fault, loop.dt) for i, push in enumerate(pushes)]
    found = float(np.max(times))  # nan when one does not settle
    settled = f"settled to 2 % in {found:.3g} s" if math.isfinite(found) else "not settled to 2 %"
    text = f"trial run under {fault:g} N m on each axis: {settled}, asked {wanted:g} s"
    return Finding(where, "settling", text, found <= wanted, found if math.isfinite(found) else None, wanted)


def findings(scenario: Scenario) -> list[Finding]:
    """Findings of ``gyrostat check``: the margins of every condition, for the constants that favour them most."""
    tables = scenario.resolve()
    J = flight_inertia(scenario)
    rows: list[Finding] = []
    observer, controller = tables.get("observer", {}), tables.get("controller", {})
    if observer.get("type") == "mixed_learning_disturbance":
        where = "observer mixed_learning_disturbance"
        loop = LearningLoop(
            J, scenario.dt, as_matrix(observer["K1"]), as_matrix(observer["K2"]), observer["sigma2"],
            observer["sigma1"], observer["theta2"], observer["delay"], observer["theta1"], observer["width"],
        )  # fmt: skip
        margins, unit = best_case(loop)
        sign = margins.pop("m15")
        rows += _conditions(where, margins)
        rows.append(
            Finding(where, "unit", f"unit of rate that favours (11) and (14) most: {unit:.3g} rad/s", None, unit)
        )
        rows.append(
            Finding(where, "m15", f"(15) theta1 = {sign:g} N m must exceed what is not to be learnt", None, sign)
        )
        rows.append(_stability(where, loop))
    if str(controller.get("type", "")).startswith("mixed_learning"):
        where = f"controller {controller['type']}"
        K3 = as_matrix(controller["K3"])
        loop = LearningLoop(
            J, scenario.dt, controller["k_lin"] * np.eye(3), K3, controller["sigma4"], controller["sigma3"],
            controller["theta3"], controller["delay"], controller["k_sgn"], controller["width"],
        )  # fmt: skip
        room = 1.0 / loop.keep**2 - 1.0 if loop.keep > 0.0 else 1e6
        symmetric = 0.5 * loop.now * (K3 + K3.T)
        needed = 2.0 * float(np.linalg.eigvalsh(symmetric)[0]) * controller["k_lin"]
        unit = max(1.01 / math.sqrt(needed), 1.0) if needed > 0.0 else 1.0
        eps = (max(0.999 * room, 1e-12), 0.0, 0.0)
        margins = sliding_margins(loop, loop.now * K3.T @ J, eps=eps, rate_unit=unit)
        rows += [*_conditions(where, margins), _stability(where, loop)]
    return rows


DESIGN = Design(
    "observer and controller that learn a torque fault in a wanted time, or why none exist",
    Wanted,
    design_for,
    _of_scenario,
)
SIX_STEPS = Design("the published six-step procedures for observer and sliding mode", SixSteps, six_steps, _of_scenario)
