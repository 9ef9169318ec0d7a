# SPDX-License-Identifier: MIT
"""Gains by bandwidth: the loop that is designed is the loop that flies, and its margins are where flights say."""

from __future__ import annotations

import json
import math
import sys
import tomllib
from collections.abc import Callable
from importlib.machinery import SourceFileLoader
from importlib.util import module_from_spec, spec_from_loader
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import signal

import gyrostat as gs
from gyrostat import _core, cli, design
from gyrostat.design.bandwidth import Wanted, gains_for
from gyrostat.design.bandwidth_rules import RULES, WITHOUT_RULE
from gyrostat.design.linear_loop import Body, Gains, Loop

ROOT = Path(__file__).parents[2]
NONE = (np.zeros((0, 3)), np.zeros(0), np.zeros(0))
sizes = st.floats(-4.0, 4.0).map(lambda x: 10.0**x)
periods = st.floats(-3.0, math.log10(0.5)).map(lambda x: 10.0**x)


@pytest.fixture
def command(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> Callable[..., tuple[int, str, str]]:
    """Runs `gyrostat`; exit status and what it printed."""

    def run(*arguments: str) -> tuple[int, str, str]:
        monkeypatch.setattr(sys, "argv", ["gyrostat", *arguments])
        capsys.readouterr()
        code = 0
        try:
            cli.main()
        except SystemExit as end:
            code = int(end.code or 0)
        told = capsys.readouterr()
        return code, told.out, told.err

    return run


Command = Callable[..., tuple[int, str, str]]


def rigid(J: float, dt: float, w: float, xi: float, **late: int) -> Loop:
    """Of a body that is equal about its axes."""
    return Loop(Body(np.full(3, J), dt, *NONE, **late), Gains(np.full(3, J * w * w), np.full(3, 2.0 * xi * J * w)))


# ---- the linear loop, against closed forms and scipy


def polynomial(kp: float, kd: float, delay: int) -> np.ndarray:
    """Characteristic polynomial of ``theta'' = -kp theta - kd theta'`` held for a period of 1, `delay` samples late.

    From the tables of z transforms: angle ``(z + 1) / (2 (z - 1)^2)``, rate ``1 / (z - 1)``.
    """
    late = np.zeros(delay + 1)
    late[0] = 1.0
    plant = np.polymul(np.polymul([1.0, -1.0], [1.0, -1.0]), late)
    return np.polyadd(plant, np.polyadd(0.5 * kp * np.array([1.0, 1.0]), kd * np.array([1.0, -1.0])))


@settings(max_examples=25, deadline=None)
@given(sizes, periods, st.floats(-3.0, math.log10(0.5)), st.floats(0.3, 2.0), st.integers(0, 3))
def test_margins_of_a_rigid_axis_put_a_pole_on_the_unit_circle(
    J: float, dt: float, x: float, xi: float, late: int
) -> None:
    turn = 10.0**x  # bandwidth times period
    loop = rigid(J, dt, turn / dt, xi, attitude_delay=late, rate_delay=late)
    kp, kd = turn * turn, 2.0 * xi * turn

    def radius(factor: float, delay: int = late) -> float:
        return float(np.abs(np.roots(polynomial(factor * kp, factor * kd, delay))).max())

    assert loop.radius == pytest.approx(radius(1.0), abs=1e-6)  # double roots have half the digits
    if loop.radius >= 1.0:
        return
    axis = loop.axes[0]
    assert axis.gain_down == 0.0
    assert radius(axis.gain_up) == pytest.approx(1.0, abs=1e-6)
    assert radius(0.99 * axis.gain_up) < 1.0 < radius(1.01 * axis.gain_up)
    whole = math.floor(axis.delay_samples)
    if whole < 300:  # roots of long polynomials lose their digits
        assert radius(1.0, late + whole) < 1.0 + 1e-6
        assert radius(1.0, late + whole + 1) > 1.0 - 1e-6


def test_the_response_of_a_rigid_axis_is_that_of_scipy() -> None:
    J, dt, kp, kd = 3.0, 0.2, 0.5, 2.0
    continuous = (
        np.array([[0.0, 1.0], [0.0, 0.0]]),
        np.array([[0.0], [1.0 / J]]),
        np.array([[kp, kd]]),
        np.zeros((1, 1)),
    )
    A, B, C, *_ = signal.cont2discrete(continuous, dt)
    w = np.geomspace(1e-2, math.pi / dt, 50)
    expected = [(C @ np.linalg.solve(np.exp(1j * x * dt) * np.eye(2) - A, B)).item() for x in w]
    found = Loop(Body(np.full(3, J), dt, *NONE), Gains(np.full(3, kp), np.full(3, kd))).response(w)
    np.testing.assert_allclose(found, np.repeat(np.array(expected)[:, None], 3, axis=1), rtol=1e-9)


def test_without_sampling_the_margins_are_those_of_the_textbook() -> None:
    # crossover and phase of L = (kd s + kp) / (J s^2): wc^2 = w^2 (2 xi^2 + sqrt(4 xi^4 + 1)), phase atan(2 xi wc / w)
    for xi in (0.3, 0.7, 1.5):
        axis = rigid(2.0, 1e-5, 1.0, xi).axes[0]
        wc = math.sqrt(2.0 * xi**2 + math.sqrt(4.0 * xi**4 + 1.0))
        assert axis.crossover == pytest.approx(wc, rel=1e-4)
        assert axis.phase_margin == pytest.approx(math.atan(2.0 * xi * wc), abs=1e-4)
        assert axis.delay_margin == pytest.approx(math.atan(2.0 * xi * wc) / wc, rel=1e-3)


def test_friction_takes_a_command_away_and_leaves_the_total_momentum() -> None:
    f, dt = 0.01, 0.1
    A, B = Body(np.full(3, 2.0), dt, *NONE, friction=f).sampled
    x = np.zeros(len(A))
    for _ in range(1000):  # 1 rad per period and second of a constant torque
        x = A @ x + B[:, 0]
    assert x[3] + x[-3] == pytest.approx(0.0, abs=1e-9)
    assert x[3] == pytest.approx((1.0 - math.exp(-f * 100.0)) / (f * dt), rel=1e-6)


def test_the_resonances_are_the_free_frequencies_of_the_truth() -> None:
    scenario = gs.Scenario.load("flexible_4").replace(dt=0.01)
    options = Wanted(**design.DESIGNS["mrp_feedback"].of_scenario(scenario), bandwidth=0.1)
    loop = Loop(design.bandwidth.body_of(options), Gains(np.full(3, 1.0), np.full(3, 1.0)))
    # damped, 1 - xi^2 / 2 of the undamped ones: xi is 0.026 at most
    np.testing.assert_allclose(loop.resonances[:, 0], scenario.compiled.free_frequencies(), rtol=5e-4)


# ---- what a compiled law does near its reference


def first_demand(law: dict[str, Any], J: list[float], axis: int, swing: tuple[float, float]) -> float:
    """N m, of the compiled controller at its first sample."""
    turn, omega = np.zeros(3), np.zeros(3)
    turn[axis], omega[axis] = math.tan(0.25 * swing[0]), swing[1]
    scenario = gs.Scenario(
        vehicle=gs.Vehicle(J_B=J, D_B=np.eye(3).tolist(), u_max=1e9),
        initial=gs.Initial(mrp=turn.tolist(), omega_BN_B=omega.tolist()),
        controller=law,
        allow_unstable=True,
        duration=0.01,
        dt=0.01,
    )
    return float(scenario.run(channels=["demand.tau_B"])["demand.tau_B"][0, axis])


@pytest.mark.parametrize(
    ("law", "amplitude", "within"),
    [
        ("mrp_feedback", 1e-3, 1e-5),
        ("saturated_pd", 1e-3, 1e-4),
        ("finite_time", 0.1, 1e-2),
        ("sliding_mode", 1e-3, 1e-5),
        # powers of a sum of sines are not the sum of their first harmonics
        ("fast_terminal_sliding_mode", 0.05, 0.05),
        ("terminal_sliding_mode", 0.01, 0.1),
        ("predefined_time", 1e-4, 1e-5),
    ],
)
def test_the_gains_are_the_first_harmonic_of_the_compiled_law(law: str, amplitude: float, within: float) -> None:
    J, dt, w = [2.0, 3.0, 4.0], 0.01, 0.5
    options = Wanted(J_B=J, dt=dt, bandwidth=w, amplitude=amplitude, torque=1.0)
    report = gains_for(law, options)
    phases = (np.arange(16) + 0.5) * (2.0 * math.pi / 16)
    for i, axis in enumerate(report.axes):
        swings = [(amplitude * math.sin(p), amplitude * w * math.cos(p)) for p in phases]
        torque = np.array([first_demand(report.components["controller"], J, i, swing) for swing in swings])
        kp = -2.0 * np.mean(torque * np.sin(phases)) / amplitude
        kd = -2.0 * np.mean(torque * np.cos(phases)) / (amplitude * w)
        assert kp == pytest.approx(J[i] * axis.frequency**2, rel=within)
        assert kd == pytest.approx(2.0 * axis.damping * axis.frequency * J[i], rel=within)
    largest = report.axes[-1]
    assert largest.frequency == pytest.approx(w, rel=1e-6)
    assert largest.damping == pytest.approx(1.1 if RULES[law].sliding else 0.8, rel=1e-6)


# ---- flights


def flight(options: Wanted, law: dict[str, Any], **changes: Any) -> gs.Scenario:
    """The designed law on a vehicle that is as the options say, with an error about each axis."""
    scenario = gs.Scenario(
        vehicle=gs.Vehicle(J_B=options.J_B, D_B=np.eye(3).tolist(), u_max=1e9),
        initial=gs.Initial(mrp=(1e-4, 1e-4, 1e-4)),
        controller=law,
        sensors=[gs.sensors.Gyro(delay=options.rate_delay), gs.sensors.Attitude(delay=options.attitude_delay)],
        integrator="rk4",
        allow_unstable=True,
        duration=300 * options.dt,
        dt=options.dt,
    )
    return scenario.replace(**changes)


@pytest.mark.parametrize(("size", "dt"), [(1e-4, 0.5), (1e-4, 1e-3), (1.0, 0.1), (1e4, 0.5), (1e4, 1e-3)])
@pytest.mark.parametrize(("turn", "xi", "late"), [(0.05, 0.8, (0, 0)), (0.1, 0.5, (1, 0)), (0.05, 1.0, (1, 2))])
def test_a_step_flies_as_designed(size: float, dt: float, turn: float, xi: float, late: tuple[int, int]) -> None:
    options = Wanted(
        J_B=[1.0 * size, 1.4 * size, 2.0 * size], dt=dt, bandwidth=turn / dt, damping=xi,
        attitude_delay=late[0], rate_delay=late[1],
    )  # fmt: skip
    law = gains_for("mrp_feedback", options).components["controller"]
    flown = flight(options, law).run(channels=["error.mrp", "demand.tau_B"])
    loop = Loop(design.bandwidth.body_of(options), Gains(np.full(3, 0.25 * law["K"]), np.full(3, law["P"])))
    until = max(late)  # the body rests until attitude and rate have arrived
    for i in range(3):
        error, _, torque = loop.step(4e-4, i, 301 - until)
        # second order in the error, 1e-4 squared, and what axes do to each other through the gyroscopic torque
        np.testing.assert_allclose(4.0 * flown["error.mrp"][until:, i], error, atol=4e-8)
        np.testing.assert_allclose(flown["demand.tau_B"][until:, i], torque, atol=1e-3 * np.abs(torque).max())


def test_bandwidth_damping_and_overshoot_are_those_asked_for() -> None:
    w, xi = 0.5, 0.4
    options = Wanted(J_B=[2.0, 2.0, 2.0], dt=0.01, bandwidth=w, damping=xi)
    law = gains_for("mrp_feedback", options).components["controller"]
    assert (law["K"], law["P"]) == pytest.approx((4.0 * 2.0 * w * w, 2.0 * xi * w * 2.0))
    error = flight(options, law, duration=20.0).run(channels=["error.mrp"])["error.mrp"][:, 0]
    # of s^2 + 2 xi w s + w^2 from rest: the first swing past zero is exp(-pi xi / sqrt(1 - xi^2)), half a period later
    past, t = -error.min() / error[0], 0.01 * int(np.argmin(error))
    root = math.sqrt(1.0 - xi * xi)
    assert past == pytest.approx(math.exp(-math.pi * xi / root), rel=0.02)  # the hold takes up to w dt / 4 of damping
    assert t == pytest.approx(math.pi / (w * root), rel=0.01)


@pytest.mark.parametrize(
    "law", ["mrp_feedback", "sliding_mode", "preassigned_time_sliding_mode", "integral_sliding_mode"]
)
@pytest.mark.parametrize("late", [(0, 0), (1, 1), (2, 0)])
def test_a_flight_dies_out_inside_the_gain_margin_and_grows_beyond(law: str, late: tuple[int, int]) -> None:
    options = Wanted(
        J_B=[2.0, 3.0, 4.0], dt=0.1, bandwidth=1.0, damping=1.2, amplitude=1e-3, torque=2.0,
        attitude_delay=late[0], rate_delay=late[1],
    )  # fmt: skip
    report = gains_for(law, options)
    up = min(a.gain_up for a in report.axes)
    scenario = flight(options, report.components["controller"], duration=400 * options.dt)
    scenario = scenario.replace(initial=gs.Initial(mrp=(1e-7, 1e-7, 1e-7)))  # rad: well inside every layer
    if law == "preassigned_time_sliding_mode":  # the path is over when the error of the margins begins
        scenario = scenario.replace(**{"controller.T": 0.3, "controller.stretch": 0.0})
    if law == "integral_sliding_mode":  # without its powers, which have no slope, and with a gain that stands still
        still = scenario.resolve()["controller"] | {"K4": [0.0] * 3, "zeta1": 0.0, "zeta2": 0.0, "beta1": 1.0}
        scenario = scenario.replace(controller=still)
        linear = RULES[law].gains(np.array(options.J_B), still, 1e-3, 1.0)
        up = min(a.gain_up for a in Loop(design.bandwidth.body_of(options), linear).axes)
    for share, grows in ((0.95, False), (1.05, True)):
        scaled = scenario.replace(truth={"dD_B": ((share * up - 1.0) * np.eye(3)).tolist()}, **{"vehicle.u_max": 1e9})
        flown = scaled.run(channels=["error.mrp", "truth.omega_BN_B"])
        # what turns back within a sample shows in the rate alone
        swing = np.hypot(4.0 * flown["error.mrp"], options.dt * flown["truth.omega_BN_B"]).max(axis=1)
        started, ended = swing[20:60].max(), swing[-40:].max()
        assert (ended > 3.0 * started) == grows, (share, up, started, ended)
        assert (ended < 0.3 * started) != grows, (share, up, started, ended)


def test_a_flight_bears_the_delay_margin_and_not_more() -> None:
    options = Wanted(J_B=[2.0, 3.0, 4.0], dt=0.1, bandwidth=1.0, damping=0.8)
    report = gains_for("mrp_feedback", options)
    margin = min(a.delay_samples for a in report.axes)
    assert 3.0 < margin < 12.0
    for samples, grows in ((math.floor(0.95 * margin), False), (math.ceil(1.05 * margin), True)):
        late = [gs.sensors.Gyro(delay=samples), gs.sensors.Attitude(delay=samples)]
        flown = flight(options, report.components["controller"], sensors=late, duration=60.0)
        error = np.linalg.norm(flown.run(channels=["error.mrp"])["error.mrp"], axis=1)
        assert (error[-60:].max() > error[100:160].max()) == grows


def test_a_bending_vehicle_is_lost_at_the_delay_that_its_mode_leaves() -> None:
    """Stable by phase at the mode: the delay margin is that of the mode and not that of the rigid body."""
    scenario = gs.Scenario.load("flexible_4")
    options = Wanted(**design.DESIGNS["mrp_feedback"].of_scenario(scenario), bandwidth=0.2)
    report = gains_for("mrp_feedback", options)
    stiff = gains_for("mrp_feedback", options.model_copy(update={"delta": None, "omega": None, "xi": None}))
    margin = min(a.delay_samples for a in report.axes)
    assert margin < 0.9 * min(a.delay_samples for a in stiff.axes)
    quiet = scenario.replace(
        faults=[], disturbances=[], controller=report.components["controller"],
        initial=gs.Initial(mrp=(1e-4, 1e-4, 1e-4)), duration=400.0,
    )  # fmt: skip
    for samples, grows in ((math.floor(0.85 * margin), False), (math.ceil(1.15 * margin), True)):
        late = [gs.sensors.Gyro(delay=samples), gs.sensors.Attitude(delay=samples)]
        error = np.linalg.norm(quiet.replace(sensors=late).run(channels=["error.mrp"])["error.mrp"], axis=1)
        assert (error[-500:].max() > error[1500:2000].max()) == grows


# ---- shipped vehicles, commands, bad input


SHIPPED = ("cubesat_6u", "smallsat_flexible", "geo_thrusters", "agile_cmg", "twelve_thrusters", "ftc_4rw", "flexible_4")


@pytest.mark.parametrize("vehicle", SHIPPED)
def test_every_shipped_vehicle_gets_gains_that_settle_when_flown(vehicle: str) -> None:
    scenario = gs.Scenario.load(vehicle)
    for law in ("mrp_feedback", "saturated_pd"):
        chosen = design.DESIGNS[law]
        report = chosen.run(chosen.options(**chosen.of_scenario(scenario)))
        assert report.ok, [f.text for f in report.findings if f.ok is False]
        slowest = min(a.frequency for a in report.axes)
        length = math.ceil(15.0 / slowest / scenario.dt) * scenario.dt
        flown = scenario.replace(
            controller=report.components["controller"], observer=None, detector=None, navigator=None, allocator=None
            if vehicle not in ("agile_cmg", "geo_thrusters", "twelve_thrusters") else scenario.allocator,
            faults=[], sensors=[], disturbances=[], reference=None, desaturation=None,
            initial=gs.Initial(mrp=(0.02, -0.02, 0.02)), duration=length,
        ).run(channels=["error.angle"])  # fmt: skip
        dead = next((f.value or 0.0 for f in report.findings if f.name == "smallest pulse"), 0.0)
        assert flown["error.angle"][-1] < max(1e-2 * flown["error.angle"][0], 2.0 * dead)


def test_the_dead_band_and_the_step_of_a_pulse_are_those_of_the_textbook() -> None:
    # 12 thrusters of 1 N at 0.8 m, 1/32 s at least: 2 F l t / J and 2 F l (2 - 1/2) tick / dt / kp
    scenario = gs.Scenario.load("twelve_thrusters")
    options = Wanted(**design.DESIGNS["mrp_feedback"].of_scenario(scenario), bandwidth=0.3, damping=0.4)
    assert options.impulse == pytest.approx([0.05] * 3)
    report = gains_for("mrp_feedback", options)
    found = next(f for f in report.findings if f.name == "smallest pulse")
    assert found.value == pytest.approx(6.944e-3, rel=1e-3)
    assert options.impulse[2] / 120.0 == pytest.approx(4.1667e-4, rel=1e-4)


def test_a_vehicle_without_torque_about_every_axis_gets_none() -> None:
    cubesat = gs.Scenario.load("cubesat_6u")
    torquers = gs.Vehicle(J_B=(0.1, 0.1, 0.1), D_B=np.eye(3).tolist(), u_max=0.4, magnetorquers=[0, 1, 2])
    scenario = gs.Scenario(
        vehicle=torquers, orbit=cubesat.orbit, controller="open_loop", desaturation=gs.Desaturation(momentum="total"),
        duration=1.0, dt=0.5,
    )  # fmt: skip
    with pytest.raises(gs.InputError, match="no torque about every axis"):
        design.DESIGNS["mrp_feedback"].of_scenario(scenario)


def test_wheels_may_leave_less_than_the_inertia_of_a_body() -> None:
    wheels = gs.Vehicle(J_B=(1.0, 1.0, 2.0), D_B=np.eye(3).tolist(), u_max=0.1, wheel_inertia=[0.05, 0.05, 0.0])
    chosen = design.DESIGNS["mrp_feedback"]
    report = chosen.run(chosen.options(**chosen.of_scenario(gs.Scenario(vehicle=wheels, duration=1.0, dt=0.1))))
    assert report.ok
    assert [a.J for a in report.axes] == pytest.approx([0.95, 0.95, 2.0])


def test_the_table_of_the_shipped_vehicles_is_what_the_script_finds() -> None:
    path = ROOT / "scripts" / "shipped_gains"
    loader = SourceFileLoader("shipped_gains", str(path))
    module = module_from_spec(spec_from_loader("shipped_gains", loader))  # type: ignore[arg-type]
    loader.exec_module(module)
    assert set(module.VEHICLES) == set(SHIPPED)
    _, *written = module.TABLE.read_text(encoding="utf-8").splitlines()
    for here, there in zip(written[1:], map(module.row, module.VEHICLES), strict=True):
        # three digits, of which another compiler may round the last
        assert [x == "" for x in here.split(",")] == [x == "" for x in there.split(",")]
        old, new = ([float(x) for x in line.split(",")[1:] if x] for line in (here, there))
        assert old == pytest.approx(new, rel=0.011), here


def test_every_controller_has_a_rule_or_a_reason() -> None:
    assert set(RULES) | set(WITHOUT_RULE) == set(_core.catalogue()["controller"])
    assert not set(RULES) & set(WITHOUT_RULE)


@pytest.mark.parametrize("law", sorted(RULES))
@pytest.mark.parametrize(("size", "dt"), [(1e-4, 0.5), (1e-4, 1e-3), (1e4, 0.5), (1e4, 1e-3), (1.0, 0.02)])
def test_every_law_gets_stable_gains_for_every_size_and_period(law: str, size: float, dt: float) -> None:
    for turn in (1e-3, 0.03):
        report = gains_for(law, Wanted(J_B=[size, 1.5 * size, 2.0 * size], dt=dt, bandwidth=turn / dt))
        assert report.ok, [f.text for f in report.findings if f.ok is False]
        assert report.components["controller"]["type"] == law
        gs.Scenario(
            vehicle=gs.Vehicle(J_B=[size, 1.5 * size, 2.0 * size], D_B=np.eye(3).tolist()),
            controller=report.components["controller"],
            dt=dt,
            duration=dt,
        ).check()


def test_python_and_the_command_say_the_same(command: Command, tmp_path: Path) -> None:
    code, text, _ = command(
        "design", "mrp_feedback", "flexible_4", "--set", "bandwidth=0.1", "--set", "damping=0.7", "--out", str(tmp_path)
    )
    assert code == 0
    pasted = tomllib.loads(text[text.index("[controller]") :])["controller"]
    chosen = design.DESIGNS["mrp_feedback"]
    options = chosen.of_scenario(gs.Scenario.load("flexible_4"))
    report = chosen.run(chosen.options(**options, bandwidth=0.1, damping=0.7))
    assert pasted == report.components["controller"]
    assert all(f.text in text for f in report.findings)
    _, plain, _ = command(
        "design", "mrp_feedback", "flexible_4", "--set", "bandwidth=0.1", "--set", "damping=0.7", "--json"
    )
    told = json.loads(plain)
    assert told["axes"][2]["frequency"] == pytest.approx(0.1)
    assert [f["name"] for f in told["findings"]] == [f.name for f in report.findings]
    loop, step = np.load(tmp_path / "loop.npz"), np.load(tmp_path / "step.npz")
    assert (tmp_path / "loop.png").stat().st_size > 10_000
    assert (tmp_path / "step.png").stat().st_size > 10_000
    # the drawn response crosses 1 where the table says, and the drawn step starts at its error
    gain, w = loop["gain"][:, 2], loop["frequency"]
    last = np.flatnonzero(gain > 1.0).max()
    assert w[last] == pytest.approx(report.axes[2].crossover, rel=0.01)
    assert step["error"][0] == pytest.approx([0.1] * 3)
    assert gs.Scenario.load("flexible_4").replace(controller=pasted, duration=1.0).run().completed


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        (("mrp_feedback", "ftc_4rw", "--set", "bandwidth=100"), "0.5/dt"),
        (("mrp_feedback", "ftc_4rw", "--set", "bandwidth=0"), "bandwidth = 0"),
        (("mrp_feedback", "ftc_4rw", "--set", "damping=-1"), "damping = -1"),
        (("mrp_feedback", "ftc_4rw", "--set", "bandwith=1"), "did you mean 'bandwidth'"),
        (("sliding_mode", "ftc_4rw", "--set", "damping=0.7"), "two real poles"),
        (("mrp_feedback", "ftc_5rw"), "no scenario 'ftc_5rw'"),
        (("mrp_feedback",), "J_B is missing"),
        (("mrp_feedback", "ftc_4rw", "bandwidth"), "KEY=VALUE"),
        (("mrp_feedback", "cao2023/nozzles"), "Euler angles"),
        (("mrp_feedback", "ftc_4rw", "--set", "J_B=[1.0, -1.0, 1.0]"), "positive definite"),
        (("mrp_feedback", "ftc_4rw", "--set", "J_B=[1.0, 1.0, 3.0]"), "1 + 1 < 3"),
        (("mrp_feedback", "ftc_4rw", "--set", "bandwidth=1e-9"), "K = "),
        (("mrp_feedback", "ftc_4rw", "--set", "omega=[1.0]"), "modes"),
        (("mrp_feedback", "flexible_4", "--set", "omega=[-1.0, 1.0, 1.0, 1.0]"), "must be positive"),
        (("mrp_feedback", "flexible_4", "--set", "delta=[[1.0], [1.0], [1.0], [1.0]]"), "three numbers a mode"),
        (("mrp_feedback", "ftc_4rw", "--set", "pulse=[1.0]", "--set", "impulse=[1.0]"), "pulse"),
        (("open_loop", "ftc_4rw"), "closes no loop"),
        (("prescribed_performance", "ftc_4rw"), "funnel"),
        (("mixed_learning_sliding_mode", "ftc_4rw"), "gyrostat design mixed_learning"),
    ],
)
def test_bad_input_is_one_line(command: Command, arguments: tuple[str, ...], told: str) -> None:
    code, text, error = command("design", *arguments)
    assert code == 2
    assert text == ""
    assert told in error
    assert error.count("\n") == 1


def test_a_vehicle_is_given_by_its_numbers_alone(command: Command) -> None:
    code, text, _ = command("design", "mrp_feedback", "J_B=[1.0, 1.0, 1.0]", "dt=0.1", "bandwidth=0.5", "damping=0.7")
    assert code == 0
    # K = 4 J w^2, P = 2 damping J w
    assert tomllib.loads(text[text.index("[controller]") :])["controller"] == {
        "type": "mrp_feedback",
        "K": pytest.approx(1.0),
        "P": pytest.approx(0.7),
    }


def test_what_cannot_hold_fails_with_its_number(command: Command) -> None:
    code, text, _ = command("design", "mrp_feedback", "ftc_4rw", "--set", "bandwidth=40", "--set", "damping=3")
    assert code == 1
    assert "fails: P * dt" in text
    assert "unstable, the largest modulus is" in text
    code, text, _ = command("design", "mrp_feedback", "ftc_4rw", "--set", "step=2.0")
    assert code == 1
    assert "fails: an error of 2 rad asks for" in text
