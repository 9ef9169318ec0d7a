# SPDX-License-Identifier: MIT
"""``gyrostat design CONTROLLER``: gains for a bandwidth and a damping, with the margins of the loop that they make.

The bandwidth is the natural frequency of the closed loop about the axis of largest inertia, rad/s; about the others a
law with one gain for all is faster and better damped. What a vehicle adds is in the loop: hold of the command, delay of
sensors, viscous friction of wheels, appendages that bend. What its actuators can give is held against a step.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from typing import Annotated, Any

import numpy as np
from numpy.typing import NDArray
from pydantic import Field
from scipy.optimize import nnls

from gyrostat.components import Component, controller
from gyrostat.design.bandwidth_rules import RULES, Asked, Rule
from gyrostat.design.feasibility import attainable_after_faults
from gyrostat.design.finding import Finding
from gyrostat.design.linear_loop import Body, Loop
from gyrostat.design.mixed_learning import checked_inertia
from gyrostat.design.mixed_learning_tool import flight_inertia
from gyrostat.design.momentum import capacity
from gyrostat.design.registry import Design, DesignReport
from gyrostat.errors import InputError
from gyrostat.model import Model
from gyrostat.plots import Figure
from gyrostat.scenario import Scenario
from gyrostat.vehicle import Vehicle, all_actuators

Array = NDArray[np.float64]
Rows = list[list[float]]

FASTEST = 0.5
"""rad in a period, beyond which no bandwidth is accepted: a sixth of half the sample rate."""

PHASE, GAIN = math.radians(30.0), 2.0
"""Margins below which a design fails."""

APART = 3.0
"""As in `gyrostat.design.flexible`."""

WHEELS = 0.1
"""Of the largest moment: wheels, whose axial inertia flight leaves out, may break the triangle inequality by that."""

_samples = 20_000  # of a step, at most


class Wanted(Model):
    """Options of the designs by bandwidth."""

    J_B: Annotated[Rows | list[float], Field(description="kg m^2, nominal inertia")]
    dt: Annotated[float, Field(gt=0.0, description="s, period")]
    bandwidth: Annotated[
        float | None,
        Field(
            gt=0.0,
            description="rad/s, natural frequency about the axis of largest inertia; default that of default gains",
        ),
    ] = None
    damping: Annotated[
        float | None, Field(gt=0.0, le=100.0, description="damping ratio about it; default 0.8, of sliding modes 1.1")
    ] = None
    amplitude: Annotated[
        float, Field(gt=0.0, le=2.0, description="rad, of an error at which powers have these slopes")
    ] = 0.1
    step: Annotated[
        float | None,
        Field(gt=0.0, le=math.pi, description="rad, an error to answer within the torque; default: only say which is"),
    ] = None
    torque: Annotated[
        float | None,
        Field(gt=0.0, description="N m, in every direction; default of an acceleration of 0.04 rad/s^2"),
    ] = None
    momentum: Annotated[float | None, Field(gt=0.0, description="N m s, that wheels hold in every direction")] = None
    delay: Annotated[int, Field(ge=0, le=50, description="samples, from measuring to the command")] = 0
    attitude_delay: Annotated[int, Field(ge=0, le=50, description="samples, of the attitude")] = 0
    rate_delay: Annotated[int, Field(ge=0, le=50, description="samples, of the rate")] = 0
    friction: Annotated[float, Field(ge=0.0, description="1/s, viscous friction of wheels over their inertia")] = 0.0
    delta: Annotated[Rows | None, Field(description="kg^(1/2) m, coupling of the appendages, a row a mode")] = None
    omega: Annotated[list[float] | None, Field(description="rad/s, their frequencies with the body held")] = None
    xi: Annotated[list[float] | None, Field(description="their damping ratios; default 0.005")] = None
    pulse: Annotated[
        list[float] | None,
        Field(description="N m, smallest torque about each axis that opens a valve, mean of a period"),
    ] = None
    impulse: Annotated[list[float] | None, Field(description="N m s, of the smallest pulse about each axis")] = None


def _of_scenario(scenario: Scenario) -> dict[str, Any]:
    """Options that a scenario decides: what flies, without its faults and its stack."""
    standing = scenario.standing()
    if scenario.vehicle.coordinates not in (None, "body"):
        raise InputError("vehicle: in Euler angles; a design by bandwidth is for a body")
    if np.linalg.matrix_rank(np.asarray(all_actuators(standing.to_dict())["D_B"], dtype=float)) < 3:
        raise InputError("vehicle: its actuators have no torque about every axis; a loop needs that")
    out: dict[str, Any] = {"J_B": flight_inertia(standing).tolist(), "dt": standing.dt}
    sets = attainable_after_faults(standing.replace(faults=[]))
    if sets is not None and sets[0].in_every_direction > 0.0:
        out["torque"] = sets[0].in_every_direction
    if math.isfinite(room := capacity(standing)):
        out["momentum"] = room
    return out | _late(scenario) | _friction(standing) | _bends(standing) | _valves(standing)


def _late(scenario: Scenario) -> dict[str, Any]:
    """A navigator carries the attitude on with the gyro, so that of its sensors the delay of the rate alone is left."""
    tables = [s.to_dict() for s in scenario.sensors if isinstance(s, Component)]
    attitude = [t.get("delay", t.get("latency", 0)) for t in tables if t["type"] in ("attitude", "star_tracker")]
    rate = [t.get("delay", 0) for t in tables if t["type"] == "gyro"]
    navigator = scenario.navigator
    navigated = navigator is not None and getattr(navigator, "type", "") != "none"
    return {
        "attitude_delay": int(max(rate if navigated else attitude, default=0)),
        "rate_delay": int(max(rate, default=0)),
    }


def _friction(scenario: Scenario) -> dict[str, Any]:
    viscous = scenario.truth.viscous_friction if scenario.truth is not None else None
    inertia = np.atleast_1d(np.asarray(scenario.vehicle.wheel_inertia or 0.0, dtype=float))
    if viscous is None or not inertia.any():
        return {}
    each = np.broadcast_to(np.asarray(viscous, dtype=float), np.broadcast(inertia, np.atleast_1d(viscous)).shape)
    wheels = np.broadcast_to(inertia, each.shape)
    return {"friction": float(np.max(each[wheels > 0.0] / wheels[wheels > 0.0], initial=0.0))}


def _bends(scenario: Scenario) -> dict[str, Any]:
    if scenario.flexible is None:
        return {}
    given = scenario.flexible.to_dict()
    omega = np.atleast_1d(np.asarray(given["omega"], dtype=float))
    xi = np.broadcast_to(np.asarray(given.get("xi", 0.005), dtype=float), omega.shape)
    delta = np.atleast_2d(np.asarray(given["delta"], dtype=float))
    return {"delta": delta.tolist(), "omega": omega.tolist(), "xi": xi.tolist()}


def _valves(scenario: Scenario) -> dict[str, Any]:
    """Torque about each principal axis at which the least-norm share of some valve rounds to its shortest pulse."""
    given, own = scenario.thrusters, np.asarray(scenario.vehicle.D_B or np.zeros((3, 0)), dtype=float)
    if given is None or np.linalg.matrix_rank(own) == 3:  # small torques are those of the others
        return {}
    flight = Scenario(vehicle=Vehicle(J_B=(1.0, 1.0, 1.0)), thrusters=given, duration=scenario.dt, dt=scenario.dt)
    known = flight.compiled.flight_model()["vehicle"]
    if not known["u_quantum"]:
        return {}
    D = np.asarray(known["D_B"], dtype=float)
    quantum, dead = np.asarray(known["u_quantum"], dtype=float), np.asarray(known["u_dead"], dtype=float)
    _, axes = np.linalg.eigh(flight_inertia(scenario))
    opening, kick = [], []
    for e in axes.T:
        found = []
        for way in (e, -e):
            weight = 1e-6
            u, _ = nnls(np.vstack([D, weight * np.eye(D.shape[1])]), np.concatenate([way, np.zeros(D.shape[1])]))
            if np.linalg.norm(D @ u - way) > 1e-3:
                return {}
            used = u > 1e-3 * u.max()
            opens = float(np.min((dead - 0.5 * quantum)[used] / u[used]))
            found.append((opens, float(D[:, used] @ dead[used] @ way)))
        opening.append(min(f[0] for f in found))
        kick.append(max(f[1] for f in found) * scenario.dt)
    return {"pulse": opening, "impulse": kick}


def body_of(o: Wanted) -> Body:
    """The vehicle about its principal axes."""
    values, axes = np.linalg.eigh(checked_inertia(np.asarray(o.J_B)))
    if values[2] - values[1] - values[0] > WHEELS * values[2]:
        raise InputError(
            f"J_B is no inertia of a body: principal moments {values[0]:g} + {values[1]:g} < {values[2]:g} kg m^2"
        )
    omega = np.asarray(o.omega or [], dtype=float)
    delta = o.delta or []
    xi = np.full(len(omega), 0.005) if o.xi is None else np.asarray(o.xi, dtype=float)
    if not len(delta) == len(omega) == len(xi):
        raise InputError(f"delta, omega, xi: {len(delta)}, {len(omega)} and {len(xi)} modes; they belong together")
    if any(len(row) != 3 or not all(map(math.isfinite, row)) for row in delta):
        raise InputError("delta: a row of three numbers a mode belongs here")
    if not (np.all(omega > 0.0) and np.all(np.isfinite(omega)) and np.all((xi >= 0.0) & (xi <= 1.0))):
        raise InputError("omega, xi: frequencies must be positive, damping ratios in [0, 1]")
    for name, each in (("pulse", o.pulse), ("impulse", o.impulse)):
        if each is not None and len(each) != 3:
            raise InputError(f"{name}: {len(each)} numbers; one about each of the 3 principal axes belongs here")
    late = o.delay + o.attitude_delay, o.delay + o.rate_delay
    return Body(values, o.dt, np.reshape(delta, (-1, 3)) @ axes, omega, xi, o.friction, *late)


def _asked(o: Wanted, body: Body, rule: Rule, law: str) -> Asked:
    J = float(body.J.max())
    torque = 0.04 * J if o.torque is None else o.torque
    bandwidth = _usual(body, torque) if o.bandwidth is None else o.bandwidth
    damping = (1.1 if rule.sliding else 0.8) if o.damping is None else o.damping
    if bandwidth * o.dt > FASTEST:
        raise InputError(
            f"bandwidth = {bandwidth:g} rad/s: a period of {o.dt:g} s carries {FASTEST / o.dt:g} rad/s at most "
            f"({FASTEST:g}/dt)"
        )
    if rule.sliding and damping < 1.0:
        raise InputError(
            f"damping = {damping:g}: {law} has two real poles, the surface and the way to it; 1 or more belongs here"
        )
    return Asked(body.J, o.dt, torque, bandwidth, damping, o.amplitude)


def _flown(body: Body, torque: float, law: Component) -> Scenario:
    """The law on the vehicle about its principal axes."""
    wheels = max(0.0, 1.001 * float(body.J[2] - body.J[1] - body.J[0]))  # what makes of it the inertia of a body
    return Scenario(
        vehicle=Vehicle(J_B=(body.J + wheels).tolist(), D_B=np.eye(3).tolist(), u_max=torque, wheel_inertia=wheels),
        controller=law,
        duration=body.dt,
        dt=body.dt,
        allow_unstable=True,
    )


def _usual(body: Body, torque: float) -> float:
    """Natural frequency, rad/s, of the default gains of `mrp_feedback`."""
    gains = _flown(body, torque, controller("mrp_feedback")).resolve()["controller"]
    return math.sqrt(gains["K"] / (4.0 * float(body.J.max())))


def gains_for(law: str, options: Wanted) -> DesignReport:
    """Gains of a controller, the loop that they make, and what is to be said of it.

    Parameters
    ----------
    law
        Name of the controller, one of `RULES`.
    options
        What is asked, of which vehicle.

    Raises
    ------
    InputError
        A bandwidth that the period does not carry, a damping that the law cannot have, an inertia that no body has.
    """
    rule, where = RULES[law], f"controller {law}"
    body = body_of(options)
    asked = _asked(options, body, rule, law)
    given = rule.parameters(asked)
    stack = _flown(body, asked.torque, controller(law, **given))
    parameters = stack.resolve()["controller"]

    def loop(amplitude: float) -> Loop:
        return Loop(body, rule.gains(body.J, parameters, amplitude, asked.bandwidth))

    designed = loop(asked.amplitude)
    refused = [_refusal(where, row) for row in stack.check() if row["where"].startswith("controller") and not row["ok"]]
    stable = designed.radius < 1.0
    found = [*refused, _poles(where, designed)]
    tables = {"controller": {"type": law, **given}}
    if not stable:
        return DesignReport({} if refused else tables, found)
    found += [*_margins(where, designed), _late_by_one(where, designed), *_near_zero(where, loop, asked)]
    found += [*_modes(where, designed, asked), *_friction_finding(where, body, asked)]
    found += [*_step(where, designed, options, asked), *_pulses(where, designed, options)]
    return DesignReport(tables, found, designed.axes, lambda: _figures(law, designed, options, asked))


def _refusal(where: str, row: dict[str, Any]) -> Finding:
    text = f"{row['quantity']} = {row['value']:.3g}, must be {row['relation']} {row['limit']:.3g}"
    return Finding(where, row["name"], text, False, row["value"], row["limit"])


def _poles(where: str, loop: Loop) -> Finding:
    radius = loop.radius
    slow = float(np.sqrt(loop.gains.kp / loop.body.J).max())
    shown = [f"{w:.3g} ({xi:.2g})" for w, xi in loop.modes() if w < 100.0 * slow]
    text = f"sampled poles, rad/s (damping): {', '.join(shown[:12])}{', ...' if len(shown) > 12 else ''}"
    if radius >= 1.0:
        text += f"; unstable, the largest modulus is {radius:.6g}"
    return Finding(where, "poles", text, radius < 1.0, radius, 1.0)


def _margins(where: str, loop: Loop) -> list[Finding]:
    phase = min(a.phase_margin for a in loop.axes)
    up, down = min(a.gain_up for a in loop.axes), max(a.gain_down for a in loop.axes)
    delay = min(loop.axes, key=lambda a: a.delay_margin)
    below = f"fall to {down:.3g}" if down > 0.0 else "fall to nothing"
    gain = f"the torque about an axis may grow by {up:.3g} ({_decibel(up)}) and {below}"
    return [
        Finding(where, "phase margin", f"{math.degrees(phase):.3g} deg", phase >= PHASE, phase, PHASE),
        Finding(where, "gain margin", gain, up >= GAIN and down <= 1.0 / GAIN, up, GAIN),
        Finding(
            where,
            "delay margin",
            f"{delay.delay_margin:.3g} s, {delay.delay_samples:.3g} samples",
            delay.delay_samples >= 1.0,
            delay.delay_margin,
            loop.body.dt,
        ),
    ]


def _decibel(x: float) -> str:
    return f"{20.0 * math.log10(x):.3g} dB"


def _late_by_one(where: str, loop: Loop) -> Finding:
    b = loop.body
    later = Loop(replace(b, attitude_delay=b.attitude_delay + 1, rate_delay=b.rate_delay + 1), loop.gains)
    if later.radius >= 1.0:
        return Finding(
            where, "a sample more", "a sample more of delay makes the loop unstable", None, later.radius, 1.0
        )
    phase = min(a.phase_margin for a in later.axes)
    up = min(a.gain_up for a in later.axes)
    text = f"a sample more of delay leaves {math.degrees(phase):.3g} deg and a factor of {up:.3g}"
    return Finding(where, "a sample more", text, None, phase, PHASE)


def _near_zero(where: str, loop: Callable[[float], Loop], asked: Asked) -> list[Finding]:
    """What becomes of the margins as the error falls; nothing of a law whose slope stays."""
    small = 1e-9 * asked.amplitude
    least, here = loop(small), loop(asked.amplitude)
    steeper = float(np.max(least.gains.kd / here.gains.kd))
    if abs(steeper - 1.0) < 1e-6 and np.allclose(least.gains.kp, here.gains.kp, rtol=1e-6):
        return []
    if least.radius < 1.0:
        phase, up = (f(getattr(a, n) for a in least.axes) for f, n in ((min, "phase_margin"), (min, "gain_up")))
        text = (
            f"at an error of {asked.amplitude:g} rad; towards zero the damping grows by {steeper:.3g}, "
            f"{math.degrees(phase):.3g} deg and a factor of {up:.3g} are left"
        )
        return [Finding(where, "towards zero", text, None, up, GAIN)]
    low, high = math.log(small), math.log(asked.amplitude)
    while high - low > 0.02:
        middle = 0.5 * (low + high)
        low, high = (low, middle) if loop(math.exp(middle)).radius < 1.0 else (middle, high)
    cycle = math.exp(high)
    text = (
        f"at an error of {asked.amplitude:g} rad; the slopes grow towards zero and end in a limit cycle of some "
        f"{cycle:.1g} rad"
    )
    return [Finding(where, "towards zero", text, None, cycle)]


def _modes(where: str, loop: Loop, asked: Asked) -> list[Finding]:
    if not len(loop.resonances):
        return []
    lowest = float(loop.resonances[0, 0])
    apart = lowest / asked.bandwidth
    gains = np.abs(loop.response((1.0 + 1e-9) * loop.resonances[:, 0])).max(axis=1)
    loud = int(np.argmax(gains))
    text = f"the lowest free frequency is {lowest:.4g} rad/s, {apart:.3g} times the bandwidth; "
    if gains[loud] < 1.0:
        text += f"the loop's gain at the modes is {gains[loud]:.2g} at most: stable by gain"
    else:
        text += (
            f"the loop's gain is {gains[loud]:.2g} at {loop.resonances[loud, 0]:.4g} rad/s: stable by phase, "
            "which asks for a known mode"
        )
    found = [Finding(where, "modes", text, True if apart >= APART else None, apart, APART)]
    above = np.asarray(loop.body.omega) * loop.body.dt
    if above.size and above.max() > math.pi:
        fast = float(np.max(loop.body.omega))
        half = math.pi / loop.body.dt
        text = f"a mode of {fast:.3g} rad/s lies above half the sample rate, {half:.3g} rad/s, and shows below it"
        found.append(Finding(where, "aliasing", text, None, fast, half))
    return found


def _friction_finding(where: str, body: Body, asked: Asked) -> list[Finding]:
    if body.friction <= 0.0:
        return []
    text = f"wheels lose a command to friction within {1.0 / body.friction:.3g} s; it is in the loop"
    return [Finding(where, "friction", text, None, body.friction, asked.bandwidth)]


def _response_length(loop: Loop) -> int:
    slowest = max((w * xi for w, xi in loop.modes()[:1]), default=1.0)
    return int(min(max(8.0 / max(slowest, 1e-12) / loop.body.dt, 20.0), _samples))


def _step(where: str, loop: Loop, o: Wanted, asked: Asked) -> list[Finding]:
    """Torque and momentum of a step against those at hand."""
    angle = asked.amplitude if o.step is None else o.step
    samples = _response_length(loop)
    peaks = [loop.step(angle, i, samples) for i in range(3)]
    push = max(float(np.abs(torque).max()) for _, _, torque in peaks)
    over = max(float(max(-error.min(), 0.0)) / angle for error, _, _ in peaks)
    turn = max(float(np.abs(rate).max()) * J for (_, rate, _), J in zip(peaks, loop.body.J, strict=True))
    text = f"an error of {angle:.3g} rad asks for {push:.3g} N m at most, overshoots by {100.0 * over:.3g} %"
    if o.torque is None:
        return [Finding(where, "step", text, None, push)]
    largest = angle * o.torque / push
    text += f"; of {o.torque:.3g} N m in every direction that leaves errors up to {largest:.3g} rad unlimited"
    found = [Finding(where, "step", text, None if o.step is None else push <= o.torque, push, o.torque)]
    if o.momentum is not None:
        text = f"the turn back takes {turn:.3g} of {o.momentum:.3g} N m s"
        found.append(Finding(where, "momentum", text, None if o.step is None else turn <= o.momentum, turn, o.momentum))
    return found


def _pulses(where: str, loop: Loop, o: Wanted) -> list[Finding]:
    """The dead band and the limit cycle of on/off thrusters: the margins are those of the mean torque."""
    if o.pulse is None or o.impulse is None:
        return []
    dead = np.asarray(o.pulse, dtype=float) / loop.gains.kp
    kick = np.asarray(o.impulse, dtype=float) / loop.body.J
    i = int(np.argmax(dead))
    text = (
        f"no valve opens for an error below {_listed(dead)} rad at rest; its smallest pulse is a step of "
        f"{_listed(kick)} rad/s: undisturbed, a limit cycle of some {8.0 * dead[i] / kick[i]:.3g} s. The margins hold "
        "for errors well above"
    )
    return [Finding(where, "smallest pulse", text, None, float(dead[i]), o.amplitude)]


def _listed(x: Array) -> str:
    return ", ".join(f"{value:.3g}" for value in x)


def _figures(law: str, loop: Loop, o: Wanted, asked: Asked) -> dict[str, Figure]:
    """Frequency response of the loop about each principal axis, and its answer to an error."""
    w = loop.frequencies
    L = loop.response(w)
    title = f"{law}: {asked.bandwidth:.3g} rad/s, damping {asked.damping:.3g}"
    labels = [f"J = {J:.4g} kg m^2" for J in loop.body.J]
    bode = Figure(f"{title}, loop opened about each axis", 2, along="frequency", unit="rad/s")
    bode.line(0, w, np.abs(L), "gain", labels=labels, log=True)
    bode.level(0, 1.0, "1")
    bode.line(1, w, np.degrees(np.unwrap(np.angle(L), axis=0)), "phase", "deg", labels=labels)
    bode.level(1, -180.0, "-180 deg")
    bode.axes[0].set_xscale("log")
    angle, samples = (asked.amplitude if o.step is None else o.step), _response_length(loop)
    flown = [loop.step(angle, i, samples) for i in range(3)]
    t = loop.body.dt * np.arange(samples)
    step = Figure(f"{title}, answer to {angle:.3g} rad", 2)
    step.line(0, t, np.column_stack([x[0] for x in flown]), "error", "rad", labels=labels)
    step.line(1, t, np.column_stack([x[2] for x in flown]), "torque", "N m", labels=labels)
    if o.torque is not None:
        for side in (o.torque, -o.torque):
            step.level(1, side, f"{side:.3g} N m")
    return {"loop": bode, "step": step}


def _design(law: str) -> Design:
    return Design(
        f"{law} for a bandwidth and a damping, with the margins of the sampled loop",
        Wanted,
        lambda options: gains_for(law, options),
        _of_scenario,
    )


DESIGNS: dict[str, Design] = {law: _design(law) for law in RULES}
"""By the controller."""

__all__ = ["DESIGNS", "Wanted", "body_of", "gains_for"]
