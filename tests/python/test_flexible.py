# SPDX-License-Identifier: MIT
"""Appendages that bend: states against two independent computations, limits, and a slew under wheel faults."""

from __future__ import annotations

from collections.abc import Callable
from importlib.machinery import SourceFileLoader
from importlib.util import module_from_spec, spec_from_loader
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import gyrostat as gs
from gyrostat import _core
from gyrostat.design import flexible
from gyrostat.vehicle import flexible_4

ROOT = Path(__file__).resolve().parents[2]
VEHICLE, MODES = flexible_4()
J, D, JS = np.array(VEHICLE.J_B), np.array(VEHICLE.D_B), 0.05
W0 = np.array([0.02, -0.03, 0.04])
START = MODES.model_copy(update={"eta": (0.5, -0.2, 0.1, 0.05), "eta_rate": (0.05, 0.0, -0.02, 0.01)})


class Commands:
    """A law that only plays commands back."""

    def __init__(self, u: Callable[[float], np.ndarray], dt: float) -> None:
        self.u, self.dt = u, dt

    def step(self, x: gs.Estimate, *_: object) -> gs.Demand:
        u = self.u(x.tick * self.dt)
        return gs.Demand(D @ u, u)


def free(**changes: Any) -> gs.Scenario:
    """No torque at all."""
    vehicle = gs.Vehicle(J_B=J, D_B=np.eye(3))
    initial = {"q_NB": [0.8, 0.2, -0.4, 0.4], "omega_BN_B": W0}
    return gs.Scenario(
        vehicle=vehicle, flexible=START, initial=initial, duration=40.0, dt=0.5, controller="open_loop"
    ).replace(**changes)


def driven(**changes: Any) -> gs.Scenario:
    """Four wheels under sines, three faults, a disturbance."""
    initial = {
        "q_NB": [0.8, 0.2, -0.4, 0.4],
        "omega_BN_B": W0,
        "wheel_speed": np.array([2.0, -1.0, 1.5, 0.5]) / JS - D.T @ W0,
    }
    return gs.Scenario(
        vehicle=VEHICLE,
        flexible=START,
        initial=initial,
        controller=Commands(lambda t: 0.4 * np.sin(0.3 * t + 0.7 * np.arange(4)), 0.25),
        disturbances=[gs.disturbances.Constant(torque_B=[0.01, -0.02, 0.015])],
        faults=[
            gs.faults.LossOfEffectiveness(actuator=1, t_on=7.3, remaining=0.4),
            gs.faults.Bias(actuator=3, t_on=10.0, torque=0.05),
            gs.faults.Dead(actuator=2, t_on=15.05, t_off=22.4),
        ],
        duration=30.0,
        dt=0.25,
    ).replace(**changes)


CHANNELS = ["truth.q_NB", "truth.omega_BN_B", "truth.h_w", "truth.eta", "truth.eta_rate"]
# From rate form and momentum form in extended precision, which agree to 6e-17.
FREE = {
    "q_NB": [-1.5461319054006288e-01, 3.7327728822938500e-01, -6.8060221059019540e-01, 6.1117874500253864e-01],
    "omega_BN_B": [1.5610105464960097e-02, -4.1812045794531281e-02, 3.5299093211711013e-02],
    "eta": [-2.2496256267048479e-02, -1.1237125202780207e-01, 2.7149925322603834e-02, -2.8588665601964214e-03],
    "eta_rate": [-3.3386603185344865e-01, 9.9453027024998256e-02, -5.3181121258208276e-02, 3.6498116070804372e-04],
}
DRIVEN = {
    "q_NB": [3.9440639053085997e-02, 2.4096251559876268e-01, -6.8418550846096542e-01, 6.8722026460183088e-01],
    "omega_BN_B": [3.0994778133219640e-03, -4.0092254729093286e-02, 4.7693845408323690e-02],
    "h_w": [-5.2637318984184883e-01, -3.3366137666657936e00, 1.9619505834495632e00, 2.1884069885274289e-01],
    "eta": [3.8141627153992703e-01, 1.0471596160509484e-01, 3.5322849881807075e-02, -3.6785467063160027e-03],
    "eta_rate": [1.0249242850552403e-01, 1.6630185414991306e-01, -5.5724425793649139e-02, -1.1918500251579121e-02],
}


def C(q: np.ndarray) -> np.ndarray:
    """C_BN of a quaternion, written out."""
    w, v = q[0], q[1:]
    cross = np.array([[0, -v[2], v[1]], [v[2], 0, -v[0]], [-v[1], v[0], 0]])
    return np.asarray((w * w - v @ v) * np.eye(3) + 2 * np.outer(v, v) - 2 * w * cross)


def errors(scenario: gs.Scenario, wanted: dict[str, list[float]]) -> dict[str, float]:
    result = scenario.run(channels=CHANNELS)
    return {name: float(np.linalg.norm(result[f"truth.{name}"][-1] - value)) for name, value in wanted.items()}


def test_the_table_of_controllers_is_whole_and_was_flown() -> None:
    script = ROOT / "scripts" / "flexible_controllers"
    loader = SourceFileLoader("flexible_controllers", str(script))
    module = module_from_spec(spec_from_loader("flexible_controllers", loader))  # type: ignore[arg-type]
    loader.exec_module(module)
    lines = [line.split(",") for line in module.TABLE.read_text().splitlines() if not line.startswith("#")]
    assert [line[0] for line in lines[1:]] == [n for n in _core.catalogue()["controller"] if n != "open_loop"]
    for name in ("mrp_feedback", "integral_sliding_mode"):
        flown = [float(x) for x in module.row(name).split(",")[1:]]
        np.testing.assert_allclose(flown, [float(x) for x in {r[0]: r[1:] for r in lines}[name]], rtol=0.1)


@pytest.mark.parametrize(("flight", "wanted"), [(free, FREE), (driven, DRIVEN)])
@pytest.mark.parametrize(("rtol", "most"), [(1e-9, 1e-8), (1e-12, 2e-11)])
def test_the_state_is_that_of_two_independent_computations(
    flight: Callable[..., gs.Scenario], wanted: dict[str, list[float]], rtol: float, most: float
) -> None:
    found = errors(flight(integrator={"type": "cvode", "rtol": rtol, "atol": rtol / 1000}), wanted)
    rate = found.pop("eta_rate")
    assert max(found.values()) < most, found
    assert rate < MODES.omega[-1] * most


def test_rk4_is_of_order_four() -> None:
    # error of the rate with 1, 2, 4, 8 steps of a sample of 0.25 s, as an implementation of its own has it
    stated = {1: 2.8e-5, 2: 2e-6, 4: 1.3e-7, 8: 8e-9}
    found = {n: errors(driven(integrator={"type": "rk4", "substeps": n}), DRIVEN)["omega_BN_B"] for n in stated}
    for n, error in found.items():
        assert error < 2.0 * stated[n], found
    assert 3.8 < np.log2(found[2] / found[8]) / 2 < 4.2, found


def test_a_command_or_a_fault_is_no_restart() -> None:
    assert driven(integrator={"type": "cvode", "rtol": 1e-9}).run(channels=CHANNELS).statistics["restarts"] == 1


def energy(result: gs.Result) -> np.ndarray:
    w, eta, rate = result["truth.omega_BN_B"], result["truth.eta"], result["truth.eta_rate"]
    delta, stiffness = np.array(MODES.delta), np.array(MODES.omega) ** 2
    body = 0.5 * np.einsum("ki,ij,kj->k", w, J, w) + np.einsum("ki,ji,kj->k", w, delta, rate)
    return np.asarray(body + 0.5 * (rate**2).sum(1) + 0.5 * (eta**2 * stiffness).sum(1))


def test_energy_and_momentum_are_kept_as_damping_says() -> None:
    precise = {"type": "cvode", "rtol": 1e-12, "atol": 1e-15}
    damped = free(integrator=precise).run(channels=CHANNELS)
    E = energy(damped)
    assert E[0] == pytest.approx(0.46934890369999993, rel=1e-12)
    assert E[-1] == pytest.approx(0.40712231919749, rel=1e-9)
    undamped = free(integrator=precise, flexible=START.model_copy(update={"xi": (0.0,) * 4})).run(channels=CHANNELS)
    np.testing.assert_allclose(energy(undamped), E[0], rtol=1e-10)
    H = damped["truth.omega_BN_B"] @ J + damped["truth.eta_rate"] @ np.array(MODES.delta)
    in_space = np.array([C(q).T @ h for q, h in zip(damped["truth.q_NB"], H, strict=True)])
    np.testing.assert_allclose(in_space, np.broadcast_to(in_space[0], in_space.shape), atol=1e-9)


def test_rk4_loses_little_energy_and_momentum() -> None:
    undamped = START.model_copy(update={"xi": (0.0,) * 4})
    flown = free(flexible=undamped, integrator={"type": "rk4", "substeps": 8}).run(channels=CHANNELS)
    assert energy(flown)[-1] / energy(flown)[0] - 1.0 == pytest.approx(-1.8e-6 / 0.469, rel=0.1)  # steps of 1/16 s
    H = flown["truth.omega_BN_B"] @ J + flown["truth.eta_rate"] @ np.array(MODES.delta)
    in_space = np.array([C(q).T @ h for q, h in zip(flown["truth.q_NB"], H, strict=True)])
    assert np.abs(in_space - in_space[0]).max() < 1e-8


def test_rows_of_delta_are_modes_and_not_axes() -> None:
    """With three modes the wrong way round would fit as well, and is another vehicle."""
    three = gs.Flexible(delta=MODES.delta[:3], omega=MODES.omega[:3])
    other = three.model_copy(update={"delta": tuple(map(tuple, np.array(MODES.delta)[:3].T.tolist()))})
    one, two = (free(flexible=f, integrator="rk4").compiled.free_frequencies() for f in (three, other))
    scaled = np.array(MODES.delta)[:3]
    square = np.linalg.inv(np.eye(3) - scaled @ np.linalg.solve(J, scaled.T)) @ np.diag(np.array(MODES.omega[:3]) ** 2)
    np.testing.assert_allclose(np.sort(one), np.sort(np.sqrt(np.linalg.eigvals(square).real)), rtol=1e-9)
    assert np.abs(np.array(one) - two).max() > 1e-3


def test_a_torque_from_rest_bends_a_mode_by_twice_its_static_deflection_at_most() -> None:
    torque = np.array([0.3, -0.2, 0.4])
    rest = MODES.model_copy(update={"xi": (0.0,) * 4})
    pushed = free(
        flexible=rest, initial={}, disturbances=[gs.disturbances.Constant(torque_B=torque)], integrator="rk4", dt=0.1
    ).run(channels=CHANNELS)
    static = np.abs(np.array(MODES.delta) @ np.linalg.solve(J, torque)) / np.array(MODES.omega) ** 2
    largest = np.abs(pushed["truth.eta"]).max(axis=0)
    # of clamped modes; coupling through the body moves energy between them, most into the softest
    assert (largest < 2.4 * static.max()).all()
    assert 1.2 < largest[0] / static[0] < 2.4


def test_stiff_appendages_are_a_rigid_body_and_soft_ones_hang_on_none() -> None:
    still = MODES.model_copy(update={"eta": None, "eta_rate": None})
    precise = {"type": "cvode", "rtol": 1e-11, "atol": 1e-14}
    rigid = driven(flexible=None, integrator=precise).run(channels=CHANNELS[:3])["truth.q_NB"][-1]
    off = []
    for scale in (1.0, 10.0, 100.0):
        stiff = still.model_copy(update={"omega": tuple(scale * np.array(MODES.omega))})
        q = driven(flexible=stiff, integrator=precise).run(channels=CHANNELS)["truth.q_NB"][-1]
        off.append(np.abs(q - rigid).max())
    np.testing.assert_allclose(off, [7.6e-5, 1.06e-6, 1.24e-8], rtol=0.05)
    soft = still.model_copy(update={"omega": tuple(1e-6 * np.array(MODES.omega)), "xi": (0.0,) * 4})
    w = driven(flexible=soft, integrator=precise).run(channels=CHANNELS)["truth.omega_BN_B"][-1]
    np.testing.assert_allclose(w, [2.7612e-03, -4.027282e-02, 4.317001e-02], atol=2e-7)


def test_modes_that_are_coupled_to_nothing_leave_the_rigid_flight_to_the_last_digit() -> None:
    loose = gs.Flexible(delta=np.zeros((2, 3)), omega=(1.0, 2.0), eta=(0.1, 0.2))
    with_modes = driven(flexible=loose, integrator="rk4").run(channels=CHANNELS)
    rigid = driven(flexible=None, integrator="rk4").run(channels=CHANNELS[:3])
    for name in CHANNELS[:3]:
        np.testing.assert_allclose(with_modes[name], rigid[name], rtol=0, atol=2e-14)


def test_turning_the_axes_turns_the_motion() -> None:
    R = C(np.array([0.5, -0.5, 0.1, np.sqrt(0.49)]))
    base = free(integrator="rk4").run(channels=CHANNELS)
    turned = free(
        integrator="rk4",
        vehicle=gs.Vehicle(J_B=R @ J @ R.T, D_B=np.eye(3)),
        flexible=START.model_copy(update={"delta": np.array(MODES.delta) @ R.T}),
        initial={"omega_BN_B": R @ W0},
    ).run(channels=CHANNELS)
    np.testing.assert_allclose(turned["truth.omega_BN_B"] @ R, base["truth.omega_BN_B"], atol=1e-13)
    np.testing.assert_allclose(turned["truth.eta"], base["truth.eta"], atol=1e-12)


def test_free_frequencies_are_those_of_the_literature_model() -> None:
    found = driven().compiled.free_frequencies()
    np.testing.assert_allclose(found, [0.830516, 1.118653, 1.903634, 2.598146], atol=2e-3)  # less the wheels' share
    heavy = free(vehicle=gs.Vehicle(J_B=J, D_B=np.eye(3))).compiled.free_frequencies()
    np.testing.assert_allclose(heavy, [0.830516, 1.118653, 1.903634, 2.598146], atol=1e-6)
    light = free(vehicle=gs.Vehicle(J_B=[[120, 3, 4], [3, 100, 10], [4, 10, 120]], D_B=np.eye(3)))
    np.testing.assert_allclose(light.compiled.free_frequencies(), [0.964850, 1.155789, 1.964021, 2.685329], atol=1e-6)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        (
            {"delta": 20 * np.array(MODES.delta)},
            r"the appendages carry more inertia than the vehicle: smallest",
        ),
        ({"delta": np.array(MODES.delta).T[:3]}, r"flexible: mode 0: delta has 4 numbers; a row is a mode, of three"),
        ({"delta": np.zeros((9, 3)), "omega": np.ones(9)}, r"flexible: delta has 9 rows; at most 8 modes"),
        ({"omega": (1.0, 0.0, 1.0, 1.0)}, r"flexible: mode 1: frequency must be positive"),
        ({"omega": (1.0, 2.0)}, r"flexible: omega has 2 numbers; one a mode belongs here, 4"),
        ({"xi": (0.1, 0.2, 1.2, 0.0)}, r"flexible: xi = \[.*1\.2, 0\] is outside \[0, 1\]"),
        ({"eta": (0.1,)}, r"flexible: eta has 1 numbers; one a mode"),
        ({"eta_rate": (np.nan, 0, 0, 0)}, r"flexible: eta_rate"),
    ],
)
def test_what_does_not_fit_is_one_line(changes: dict[str, Any], message: str) -> None:
    with pytest.raises(gs.InputError, match=message) as error:
        free(flexible={**{k: v for k, v in MODES.to_dict().items() if k != "xi"}, **changes})
    assert "\n" not in str(error.value)


def test_rk4_steps_that_would_diverge_are_refused() -> None:
    with pytest.raises(gs.InputError, match=r"rk4: a step of 1\.25 s is 3\.25 rad of the quickest mode"):
        free(integrator="rk4", dt=1.25, duration=40.0)
    free(integrator={"type": "rk4", "substeps": 2}, dt=1.25, duration=40.0)


def slew(wc: float, faults: bool, *, rigid: bool = False) -> gs.Result:
    """A quaternion law of bandwidth wc turns the vehicle by 82 deg."""

    class Law:
        def setup(self, setup: gs.Setup) -> None:
            self.J, self.D = setup.vehicle.J_B, setup.vehicle.D_B

        def step(self, x: gs.Estimate, *_: object) -> np.ndarray:
            q = x.q_NB if x.q_NB[0] >= 0.0 else -x.q_NB
            w = x.omega_BN_B
            gyro = np.cross(w, self.J @ w + self.D @ x.h_w)
            return np.asarray(-2 * wc**2 * self.J @ q[1:] - 1.6 * wc * self.J @ w + gyro)

    scenario = gs.Scenario.load("flexible_4").replace(controller=Law())
    if not faults:
        scenario = scenario.replace(faults=[])
    if rigid:
        return scenario.replace(flexible=None).run(channels=["error.angle"])
    return scenario.run(channels=["error.angle", "truth.eta"])


def settling(result: gs.Result) -> float:
    above = np.flatnonzero(result["error.angle"] > np.deg2rad(0.1))
    return float(result.t[above[-1] + 1])


def test_a_slew_under_wheel_faults_settles_with_little_vibration() -> None:
    healthy, faulty = slew(0.2, False), slew(0.2, True)
    assert 50.0 < settling(healthy) < 52.5
    assert 120.0 < settling(faulty) < 127.0
    assert settling(slew(0.2, True, rigid=True)) == pytest.approx(settling(faulty), abs=1.0)
    for result in (healthy, faulty):
        eta = np.abs(result["truth.eta"])
        assert 0.12 < eta[:500, 0].max() < 0.16
        late = eta[result.t > 150.0]
        assert late[:, 0].max() < 1e-3
        assert late[:, 1].max() < 2e-3


def test_check_holds_the_bandwidth_against_the_modes() -> None:
    scenario = gs.Scenario.load("flexible_4")
    found = {f.name: f for f in flexible.findings(scenario)}
    assert found["free frequencies"].ok
    assert found["free frequencies"].value > 5.0
    fast = scenario.replace(controller={"type": "mrp_feedback", "K": 300.0, "P": 250.0}, integrator="cvode")
    (near,) = flexible.findings(fast)
    assert near.ok is None
    assert "the loop drives the mode" in near.text
    assert flexible.findings(scenario.replace(flexible=None)) == []
    loose = MODES.model_copy(update={"delta": (*MODES.delta[:3], (0.0, 0.0, 0.0))})
    assert "mode 3 is not coupled to the body" in {f.text for f in flexible.findings(scenario.replace(flexible=loose))}
    turning = scenario.replace(initial={"omega_BN_B": [0.3, 0.0, 0.0]})
    assert "initial rate" in {f.name for f in flexible.findings(turning)}


def test_the_bandwidth_is_that_of_a_known_loop() -> None:
    # J s^2 + P s + K/4 about an axis, critically damped at 0.3 rad/s
    vehicle = gs.Vehicle(J_B=[10.0, 10.0, 10.0], D_B=np.eye(3))
    law = gs.controller("mrp_feedback", K=4 * 10.0 * 0.09, P=2 * 10.0 * 0.3)
    scenario = gs.Scenario(vehicle=vehicle, controller=law, duration=10.0, dt=0.01)
    assert flexible.bandwidth(scenario) == pytest.approx(0.3, rel=0.02)


def test_a_small_spacecraft_turns_through_the_loss_of_a_wheel() -> None:
    """Bias, star tracker, bending and a dead wheel at once: as without the fault, and the panels rest at the end."""
    scenario = gs.Scenario.load("smallsat_flexible")
    vehicle, modes = gs.vehicle.smallsat_flexible()
    assert (scenario.vehicle, scenario.flexible) == (vehicle, modes)
    channels = ["error.angle", "truth.eta", "detection.class", "truth.h_w"]
    lost, healthy = (s.run(channels=channels) for s in (scenario, scenario.replace(faults=[])))
    for flown in (lost, healthy):
        assert np.degrees(flown["error.angle"][flown.t > 5.0].max()) < 0.05
        assert np.degrees(np.sqrt(np.mean(flown["error.angle"][flown.t > 150.0] ** 2))) < 0.005
        assert np.abs(flown["truth.eta"][flown.t > 150.0]).max() < np.abs(flown["truth.eta"]).max()
        assert np.abs(flown["truth.h_w"]).max() < 1.5
    assert list(np.flatnonzero(lost["detection.class"].any(axis=0))) == [2]
    assert not healthy["detection.class"].any()
