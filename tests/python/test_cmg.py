# SPDX-License-Identifier: MIT
"""Control moment gyros: states against two independent computations, what is conserved, singular gimbals, faults."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import gyrostat as gs
from gyrostat.design import cmg
from gyrostat.vehicle import cmg4, standing

J = np.array([[120.0, 3.0, 4.0], [3.0, 100.0, 10.0], [4.0, 10.0, 120.0]])
H0, START = 20.0, (0.1, -0.2, 0.3, 0.05)
VEHICLE, GYROS = cmg4(J_B=J)
PRECISE = {"type": "auto", "rtol": 1e-12}
CHANNELS = ["truth.q_NB", "truth.omega_BN_B", "truth.gimbal", "truth.rotor_momentum", "truth.singularity"]
# From rate form and momentum form in extended precision, which agree to 1e-16.
HEALTHY = {
    "q_NB": [8.4927461186274615e-02, 7.3826629821846960e-02, 7.9870938362622472e-01, -5.9110090134681573e-01],
    "omega_BN_B": [4.6361591019684521e-02, -7.7653668213742545e-02, 4.3335617799236148e-02],
    "gimbal": [3.0070972952732196e-01, -4.4319805092662229e-01, -8.5280954397145597e-02, -1.9753186016493401e-01],
    "singularity": 9.5976013544987545e-01,
}
FAULTY = {
    "q_NB": [-1.1226116772347661e-01, -1.6376021729803550e-01, 5.6900798774615886e-01, -7.9800371636536178e-01],
    "omega_BN_B": [6.3806996558639041e-02, 8.8430903167965531e-02, -1.2694184748155671e-01],
    "gimbal": [5.4477479668477904e-01, 7.3389555414326787e-01, -8.5280954397145597e-02, -1.9753186016493401e-01],
    "singularity": 1.1609863368354377e00,
    "rotor_momentum": [20.0, 20.0, 18.05, 20.0],
}


class Played:
    """An allocator that only plays commands back, and remembers the axes that flight had."""

    def __init__(self, u: Callable[[float], np.ndarray], dt: float) -> None:
        self.u, self.dt = u, dt
        self.axes: list[gs.Estimate] = []

    def step(self, demand: gs.Demand, x: gs.Estimate, det: gs.Detection) -> np.ndarray:
        self.axes.append((np.array(x.axes.D_B), np.array(x.axes.h_B)))
        return self.u(x.tick * self.dt)


def swinging(t: float) -> np.ndarray:
    return H0 * np.clip(0.5 * np.sin(0.6 * t + np.arange(4)), -0.4, 0.4)


def healthy(**changes: Any) -> gs.Scenario:
    """Sines on the gimbals, no torque from outside."""
    return gs.Scenario(
        vehicle=VEHICLE,
        cmg=GYROS.model_copy(update={"angles": START}),
        initial={"q_NB": [0.8, 0.2, -0.4, 0.4], "omega_BN_B": [0.002, -0.003, 0.004]},
        controller="open_loop",
        allocator=Played(swinging, 0.5),
        duration=20.0,
        dt=0.5,
    ).replace(**changes)


def faulty(**changes: Any) -> gs.Scenario:
    """A weak gimbal, one that locks, a rotor that slows down for a while, a disturbance."""
    return healthy(
        disturbances=[gs.disturbances.Constant(torque_B=[0.01, -0.02, 0.015])],
        faults=[
            gs.faults.LossOfEffectiveness(actuator=0, t_on=3.0, remaining=0.6),
            gs.faults.Dead(actuator=1, t_on=5.3),
            gs.faults.RotorSlowDown(actuator=2, t_on=8.1, t_off=12.0, rate=0.5),
        ],
    ).replace(**changes)


def errors(scenario: gs.Scenario, wanted: dict[str, Any]) -> dict[str, float]:
    result = scenario.run(channels=CHANNELS)
    return {name: float(np.max(np.abs(result[f"truth.{name}"][-1] - value))) for name, value in wanted.items()}


def momentum(result: gs.Result, gyros: gs.ControlMomentGyros = GYROS, inertia: np.ndarray = J) -> np.ndarray:
    """J w + sum h s(del), in body axes, a row a sample."""
    g, s = np.array(gyros.gimbal_axes), np.array(gyros.spin_axes)
    angle, h = result["truth.gimbal"][..., None], result["truth.rotor_momentum"][..., None]
    rotors = (h * (np.cos(angle) * s + np.sin(angle) * np.cross(g, s))).sum(axis=1)
    return np.asarray(result["truth.omega_BN_B"] @ inertia + rotors)


@pytest.mark.parametrize(("flight", "wanted"), [(healthy, HEALTHY), (faulty, FAULTY)])
@pytest.mark.parametrize(
    ("integrator", "rtol", "most"),
    [("cvode", 1e-9, 1e-8), ("cvode", 1e-12, 6e-11), ("auto", 1e-9, 1e-9), ("auto", 1e-12, 2e-12)],
)
def test_the_state_is_that_of_two_independent_computations(
    flight: Callable[..., gs.Scenario], wanted: dict[str, Any], integrator: str, rtol: float, most: float
) -> None:
    found = errors(flight(integrator={"type": integrator, "rtol": rtol, "atol": rtol / 1000}), wanted)
    assert max(found.values()) < most, found
    assert found["gimbal"] < 1e-14  # a polynomial: exact whatever the integrator


def test_rk4_is_of_order_four() -> None:
    # errors with 1 and 4 steps of a sample of 0.5 s, as an implementation of its own has them
    for steps, q, w in ((1, 9.1e-6, 2.1e-6), (4, 3.3e-8, 9.5e-9)):
        found = errors(healthy(integrator={"type": "rk4", "substeps": steps}), HEALTHY)
        assert q / 2 < found["q_NB"] < 2 * q, found
        assert w / 2 < found["omega_BN_B"] < 2 * w, found


@pytest.mark.parametrize("flight", [healthy, faulty])
def test_a_command_or_a_fault_is_no_restart(flight: Callable[..., gs.Scenario]) -> None:
    assert flight(integrator="cvode").run(channels=CHANNELS).statistics["restarts"] == 1


def test_momentum_is_kept_whatever_the_gimbals_do() -> None:
    H = np.linalg.norm(momentum(healthy(integrator=PRECISE).run(channels=CHANNELS)), axis=1)
    assert H[-1] == pytest.approx(6.328635948669720, abs=1e-11)
    np.testing.assert_allclose(H, H[0], rtol=0, atol=1e-11)


def test_a_full_turn_of_a_gimbal_is_none() -> None:
    once = healthy(integrator="rk4").run(channels=CHANNELS)
    turned = GYROS.model_copy(update={"angles": tuple(np.array(START) + 2 * np.pi)})
    twice = healthy(cmg=turned, integrator="rk4").run(channels=CHANNELS)
    np.testing.assert_allclose(twice["truth.q_NB"], once["truth.q_NB"], rtol=0, atol=1e-13)
    np.testing.assert_allclose(twice["truth.gimbal"] - once["truth.gimbal"], 2 * np.pi, rtol=0, atol=1e-13)


def test_without_momentum_there_is_none_later() -> None:
    still = healthy(cmg=GYROS, initial=None, integrator="rk4").run(channels=CHANNELS)
    assert np.linalg.norm(momentum(still), axis=1).max() < 1e-13
    assert np.linalg.norm(still["truth.omega_BN_B"], axis=1).max() > 0.05


def test_flight_knows_axes_and_stored_momentum_of_every_sample() -> None:
    result = healthy(integrator="rk4").run(channels=["truth.*", "allocation.u"])
    flown = result.components["allocator"]
    g, s = np.array(GYROS.gimbal_axes), np.array(GYROS.spin_axes)
    for (D, h_B), angle, u in zip(flown.axes, result["truth.gimbal"], result["allocation.u"], strict=True):

        def stored(t: float, angle: np.ndarray = angle, u: np.ndarray = u) -> np.ndarray:
            turned = (angle + t * u / H0)[:, None]
            return np.asarray((H0 * (np.cos(turned) * s + np.sin(turned) * np.cross(g, s))).sum(axis=0))

        np.testing.assert_allclose(D, GYROS.turned(angle)[0], atol=1e-15)
        np.testing.assert_allclose(h_B, stored(0.0), atol=1e-13)
        np.testing.assert_allclose(D @ u, -(stored(1e-3) - stored(-1e-3)) / 2e-3, atol=1e-5)  # |u|/h0 <= 0.4 rad/s
    assert np.abs(result["truth.lumped_B"][1:]).max() < 1e-12  # the nominal model explains all of a healthy flight


def test_what_is_lumped_together_is_what_the_faults_did() -> None:
    result = faulty(integrator="rk4").run(channels=["truth.*", "allocation.u"])
    g, s = np.array(GYROS.gimbal_axes), np.array(GYROS.spin_axes)
    late = 35  # gimbals weak and locked, a rotor slower
    angle, w = result["truth.gimbal"][late], result["truth.omega_BN_B"][late]
    delivered = result["allocation.u"][late - 1] * [0.6, 0.0, 18.05 / 20.0, 1.0]
    np.testing.assert_allclose(result["truth.delivered"][late], delivered, atol=1e-13)
    np.testing.assert_allclose(result["truth.effectiveness"][late], [0.6, 0.0, 18.05 / 20.0, 1.0], atol=1e-13)
    missing = (18.05 - 20.0) * (np.cos(angle[2]) * s[2] + np.sin(angle[2]) * np.cross(g[2], s[2]))
    lumped = GYROS.turned(angle)[0] @ (delivered - result["allocation.u"][late - 1]) - np.cross(w, missing)
    np.testing.assert_allclose(result["truth.lumped_B"][late], lumped + np.array([0.01, -0.02, 0.015]), atol=1e-12)


def test_rotors_that_slow_down_to_rest_leave_all_momentum_in_the_body() -> None:
    faults = [gs.faults.RotorSlowDown(actuator=i, t_on=1.0 + i, rate=3.0 + i) for i in range(4)]
    faults += [gs.faults.RotorSlowDown(actuator=0, t_on=3.0, t_off=4.0, rate=1.0)]
    result = healthy(faults=faults, integrator={"type": "cvode", "rtol": 1e-12, "atol": 1e-15}).run(channels=CHANNELS)
    assert (result["truth.rotor_momentum"][-1] == 0.0).all()
    H = momentum(result)
    np.testing.assert_allclose(result["truth.omega_BN_B"][-1] @ J, H[-1], atol=1e-12)
    assert np.linalg.norm(H[-1]) == pytest.approx(6.328635948669720, abs=1e-9)
    assert result.statistics["restarts"] == 1
    # 20 N m s at 3 N m s a second from 1 s, 4 for the second from 3 s on: at rest at 7.333 s
    first = result["truth.rotor_momentum"][:, 0]
    np.testing.assert_allclose(first[[2, 4, 6, 8, 14]], [20.0, 17.0, 14.0, 10.0, 1.0], atol=1e-12)
    assert (first[15:] == 0.0).all()


def test_a_gimbal_meets_its_stop_at_the_exact_time_and_comes_back() -> None:
    rate, stop = 0.13, 0.4
    there, back = 0.3 / rate, 5.0 + 2 * stop / rate  # s: at 0.4 from 0.1, at -0.4 from 0.4
    command = Played(lambda t: H0 * rate * np.array([1.0 if t < 5.0 else -1.0, 0.2, -0.1, 0.05]), 0.5)
    stops = GYROS.model_copy(update={"angles": START, "angle_max": (stop, np.inf, np.inf, np.inf)})
    for integrator in (PRECISE, {"type": "cvode", "rtol": 1e-12, "atol": 1e-15}, {"type": "rk4", "substeps": 4}):
        held = healthy(cmg=stops, allocator=command, integrator=integrator).run(channels=["truth.*"])
        t = held.t
        wanted = np.where(
            t < there, 0.1 + rate * t, np.where(t < 5.0, stop, np.maximum(stop - rate * (t - 5.0), -stop))
        )
        np.testing.assert_allclose(held["truth.gimbal"][:, 0], wanted, rtol=0, atol=1e-13)
        resting = ((t > there) & (t <= 5.0)) | (t > back)
        np.testing.assert_array_equal(held["truth.delivered"][:, 0] == 0.0, resting | (t == 0.0))
        # a gimbal that is locked from there on moves in the same way
        locked = [gs.faults.Dead(actuator=0, t_on=there, t_off=5.0), gs.faults.Dead(actuator=0, t_on=back)]
        same = healthy(allocator=command, faults=locked, integrator=integrator).run(channels=["truth.*"])
        np.testing.assert_allclose(held["truth.q_NB"], same["truth.q_NB"], rtol=0, atol=1e-10)
        assert held.statistics["restarts"] == same.statistics["restarts"] <= 1


def test_a_drive_that_varies_brings_a_gimbal_to_its_stop_and_off_it() -> None:
    amplitude, omega = 2.0, 0.5
    swing = amplitude / (H0 * omega)
    stops = GYROS.model_copy(update={"angles": START, "angle_max": 0.4})
    push = gs.faults.Bias(actuator=0, torque={"type": "sine", "amplitude": amplitude, "omega": omega})
    still = Played(lambda _: np.zeros(4), 0.5)
    result = healthy(cmg=stops, allocator=still, faults=[push], integrator=PRECISE, duration=12.0).run(
        channels=CHANNELS
    )
    t = result.t
    free = 0.1 + swing * (1 - np.cos(omega * t))
    leaves = np.pi / omega  # the drive turns inward
    wanted = np.where(t < leaves, np.minimum(free, 0.4), 0.4 - swing * (1 + np.cos(omega * t)))
    np.testing.assert_allclose(result["truth.gimbal"][:, 0], wanted, rtol=0, atol=1e-9)
    H = np.linalg.norm(momentum(result), axis=1)
    np.testing.assert_allclose(H, H[0], rtol=0, atol=1e-11)
    drift = [gs.faults.Drift(actuator=0, rate=0.5)]
    late = healthy(cmg=stops, allocator=still, faults=drift, integrator=PRECISE).run(channels=CHANNELS)
    wanted = np.minimum(0.1 + 0.25 * late.t**2 / H0, 0.4)
    np.testing.assert_allclose(late["truth.gimbal"][:, 0], wanted, rtol=0, atol=1e-10)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"rotor_momentum": 0.0}, r"cmg: gyro 0: rotor_momentum must be positive"),
        ({"rotor_momentum": (20.0, -1.0, 20.0, 20.0)}, r"cmg: rotor_momentum = .* is outside \[0, "),
        ({"rate_max": (1.0, 1.0, 0.0, 1.0)}, r"cmg: gyro 2: rate_max must be positive"),
        (
            {"spin_axes": GYROS.gimbal_axes},
            r"cmg: gyro 0: the spin axis must be perpendicular to the gimbal axis; .* 1$",
        ),
        ({"spin_axes": [[0, 2, 0], *GYROS.spin_axes[1:]]}, r"cmg: spin_axes = .* is outside"),
        ({"spin_axes": [[0, 0.5, 0], *GYROS.spin_axes[1:]]}, r"cmg: gyro 0: spin_axes has length 0.5; a unit vector"),
        ({"spin_axes": GYROS.spin_axes[1:]}, r"cmg: spin_axes has 3 rows; one a gyro belongs here, 4"),
        ({"gimbal_axes": np.array(GYROS.gimbal_axes).T[:, :3].tolist()[:2]}, r"cmg: "),
        ({"gimbal_axes": [[0, 1]] * 4}, r"cmg: gyro 0: gimbal_axes has 2 numbers; a row is an axis, of three"),
        ({"angles": (0.0, np.nan, 0.0, 0.0)}, r"cmg: angles"),
        (
            {"angles": START, "angle_max": (1.0, 1.0, 0.2, 1.0)},
            r"cmg: gyro 2: angles = 0.3 rad is beyond angle_max = 0.2 rad",
        ),
        ({"del_max": 1.0}, r"cmg: unknown key 'del_max'"),
    ],
)
def test_what_does_not_fit_is_one_line(changes: dict[str, Any], message: str) -> None:
    with pytest.raises(gs.InputError, match=message) as error:
        healthy(cmg={**GYROS.to_dict(), **changes})
    assert "\n" not in str(error.value)


def test_what_does_not_go_with_gyros_is_one_line() -> None:
    slow = {"type": "rotor_slow_down", "actuator": 1, "rate": 1.0}
    with pytest.raises(gs.InputError, match=r"faults\[0\] 'rotor_slow_down': actuator 1 is no control moment gyro"):
        gs.Scenario.load("ftc_4rw").replace(faults=[slow])
    with pytest.raises(gs.InputError, match=r"rotor_slow_down: rate must be positive"):
        healthy(faults=[slow | {"rate": 0.0}])
    with pytest.raises(gs.InputError, match=r"wheel_inertia of actuator 0, a control moment gyro, must be 0"):
        healthy(**{"vehicle.wheel_inertia": 0.05})
    with pytest.raises(gs.InputError, match=r"truth: dD_B of actuator 2, a control moment gyro, must be 0"):
        healthy(truth={"dD_B": [[0, 0, 0.1, 0], [0, 0, 0, 0], [0, 0, 0, 0]]})
    with pytest.raises(gs.InputError, match=r"cmg: gyros fly on body coordinates"):
        healthy(**{"vehicle.coordinates": "euler_angles", "vehicle.J_B": [120.0, 100.0, 120.0]})
    with pytest.raises(gs.InputError, match=r"vehicle: D_B is missing"):
        healthy(cmg=None)


def test_wheels_stand_beside_gyros() -> None:
    wheels = gs.Vehicle(J_B=J, D_B=np.eye(3), wheel_inertia=(0.05, 0.05, 0.05, 0, 0, 0, 0), u_max=0.5)
    u = np.concatenate([[0.1, -0.2, 0.3], np.zeros(4)])
    scenario = healthy(
        vehicle=wheels,
        allocator=Played(lambda t: u + np.concatenate([np.zeros(3), np.minimum(swinging(t), 0.5)]), 0.5),
        integrator=PRECISE,
    )
    result = scenario.run(channels=[*CHANNELS, "truth.h_w", "truth.lumped_B"])
    assert scenario.actuators == 7
    assert (result["truth.gimbal"][:, :3] == 0.0).all()
    gyros = result["truth.gimbal"][:, 3:], result["truth.rotor_momentum"][:, 3:]
    g, s = np.array(GYROS.gimbal_axes), np.array(GYROS.spin_axes)
    rotors = (
        gyros[1][..., None] * (np.cos(gyros[0])[..., None] * s + np.sin(gyros[0])[..., None] * np.cross(g, s))
    ).sum(1)
    body = J - 0.05 * np.eye(3)
    H = np.linalg.norm(result["truth.omega_BN_B"] @ body + result["truth.h_w"][:, :3] + rotors, axis=1)
    np.testing.assert_allclose(H, H[0], atol=1e-10)
    assert np.abs(result["truth.lumped_B"][1:]).max() < 1e-11


class Push:
    """Asks for the same torque for ever."""

    def step(self, *_: object) -> np.ndarray:
        return np.array([-2.0, 0.0, 0.0])


def pushed(allocator: Any) -> gs.Result:
    """What the gyros take when 2 N m about -x are asked of them for 25 s, of a body that hardly moves."""
    vehicle, gyros = cmg4(J_B=(1e9, 1e9, 1e9))
    scenario = gs.Scenario(vehicle=vehicle, cmg=gyros, controller=Push(), allocator=allocator, duration=25.0, dt=0.02)
    return scenario.replace(integrator="rk4").run(channels=[*CHANNELS, "allocation.status"])


def test_singularity_robust_locks_where_theory_says_and_its_general_form_passes() -> None:
    def taken(result: gs.Result) -> float:
        return float(momentum(result, inertia=np.zeros((3, 3)))[-1, 0])

    locked = pushed(gs.allocator("singularity_robust", method="sr"))
    assert taken(locked) == pytest.approx(2 * H0 / np.sqrt(3.0), abs=0.01)  # 23.094: saddle of the envelope
    np.testing.assert_allclose(np.rad2deg(locked["truth.gimbal"][-1]), [-90.0, 0.0, 90.0, 0.0], atol=0.1)
    in_it = locked["truth.singularity"] < 0.1
    assert 12.0 < in_it.sum() * 0.02 < 15.0
    singular = (locked["allocation.status"].astype(int).ravel() & 128) != 0
    assert (singular == in_it).all()
    assert taken(pushed(gs.allocator("singularity_robust", method="gsr"))) > 28.0


class Pd:
    """A law with feed-forward for a turn about x."""

    def setup(self, setup: gs.Setup) -> None:
        self.J, self.wc = setup.vehicle.J_B, 0.6

    def step(self, x: gs.Estimate, det: gs.Detection, ref: gs.Reference, last: gs.Allocation) -> np.ndarray:
        w, v = ref.q_NR[0], -ref.q_NR[1:]
        q = np.concatenate([[w * x.q_NB[0] - v @ x.q_NB[1:]], w * x.q_NB[1:] + x.q_NB[0] * v + np.cross(v, x.q_NB[1:])])
        q = q if q[0] >= 0.0 else -q
        rate = x.omega_BN_B - ref.omega_RN_R
        turning = np.cross(x.omega_BN_B, self.J @ x.omega_BN_B + x.axes.h_B)
        return np.asarray(self.J @ (ref.omegadot_RN_R - 2 * self.wc**2 * q[1:] - 1.6 * self.wc * rate) + turning)


def slewed(allocator: Any, locked: bool) -> gs.Result:
    scenario = gs.Scenario.load("agile_cmg").replace(controller=Pd(), allocator=allocator)
    if not locked:
        scenario = scenario.replace(faults=[])
    return scenario.run(channels=["error.angle", "truth.singularity"])


STEERINGS = {
    "pinv": gs.allocator("pseudo_inverse", rank_tolerance=1e-6),
    "sr": gs.allocator("singularity_robust", method="sr"),
    "gsr": gs.allocator("singularity_robust", method="gsr"),
}


@pytest.mark.parametrize(
    ("steering", "locked", "largest", "end"),
    [
        ("pinv", False, 6.51, 1e-5),
        ("sr", False, 6.93, 1e-5),
        ("gsr", False, 5.81, 1e-5),
        ("sr", True, 6.93, 1e-5),
        ("gsr", True, 17.7, 0.5),
    ],
)
def test_a_slew_beyond_the_singular_momentum(steering: str, locked: bool, largest: float, end: float) -> None:
    result = slewed(STEERINGS[steering], locked)
    angle = np.rad2deg(result["error.angle"])
    assert result.completed
    assert angle.max() == pytest.approx(largest, rel=0.1)  # of docs/cmg.md
    assert angle[result.t >= 50.0].max() < end


@pytest.mark.parametrize("allocator", ["pseudo_inverse", "lexicographic", "weighted_least_squares"])
def test_an_allocator_that_drops_the_lost_axis_never_leaves_the_singularity(allocator: str) -> None:
    result = slewed(allocator, False)
    assert np.rad2deg(result["error.angle"][-1]) > 90.0
    assert result["truth.singularity"][-1] < 0.05


def test_the_shipped_slew_ends_where_it_should_with_a_locked_gimbal() -> None:
    result = gs.Scenario.load("agile_cmg").run(channels=["error.angle", "truth.gimbal", "allocation.status"])
    angle = np.rad2deg(result["error.angle"])
    assert result.completed
    assert angle.max() < 25.0
    assert angle[result.t >= 50.0].max() < 0.5
    assert np.ptp(result["truth.gimbal"][result.t >= 2.0, 1]) == 0.0


def test_check_looks_at_gimbals_against_the_period() -> None:
    scenario = gs.Scenario.load("agile_cmg")
    assert [f.ok for f in cmg.findings(scenario)] == [True]
    (_, other) = cmg.findings(scenario.replace(allocator=None))
    assert other.ok is None
    assert "pseudo_inverse gives up an axis that is weak" in other.text
    slow = {f.name: f for f in cmg.findings(healthy())}
    assert slow["rate_max"].ok is None
    assert "0.5 rad in a sample" in slow["rate_max"].text
    flat = cmg.findings(scenario.replace(**{"cmg.angles": [-np.pi / 2, 0.0, np.pi / 2, 0.0]}))
    assert flat[0].ok is None
    assert cmg.findings(gs.Scenario.load("ftc_4rw")) == []


def test_what_asks_for_axes_once_sees_those_of_the_start() -> None:
    scenario = gs.Scenario.load("agile_cmg")
    still = scenario.standing()
    assert still.cmg is None
    np.testing.assert_allclose(still.vehicle.D_B, GYROS.axes_B(), atol=1e-15)
    np.testing.assert_allclose(still.vehicle.u_max, 20.0)
    np.testing.assert_allclose(scenario.compiled.flight_model()["vehicle"]["D_B"], still.vehicle.D_B, atol=1e-15)
    tables = gs.Scenario.load("ftc_4rw").to_dict()
    assert standing(tables) == tables


def test_a_page_turns_with_the_gimbals(tmp_path: Path) -> None:
    from gyrostat.page.content import _arrows

    result = healthy(integrator=PRECISE, controller="open_loop").run(channels=["truth.*", "allocation.u"])
    arrows = {name: vectors for name, _, _, vectors in _arrows(result)}
    np.testing.assert_allclose(arrows["momentum"], momentum(result), atol=1e-12)
    scenario = gs.Scenario.load("agile_cmg").replace(duration=2.0)
    page = tmp_path / "page.html"
    scenario.run().to_html(page)
    assert page.stat().st_size > 10_000


def test_experiments_vary_gyros_and_survival_asks_them() -> None:
    scenario = gs.Scenario.load("agile_cmg")
    flights = gs.Experiment(scenario, vary=["cmg.rotor_momentum"]).fly([[15.0], [30.0]])
    alone = [scenario.replace(**{"cmg.rotor_momentum": h}).run().metrics.energy for h in (15.0, 30.0)]
    np.testing.assert_allclose(flights["energy"], alone, rtol=1e-12)
    cases = gs.survive(scenario.replace(faults=[]), kinds=["dead"], severities=[1.0]).cases
    assert [case.status for case in cases] == ["completed"] * 5
    assert cases[0].torque == pytest.approx(2 * 20.0 / np.sqrt(3.0))  # of the gimbals at the start, about x and y
