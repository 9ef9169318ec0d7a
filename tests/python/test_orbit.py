# SPDX-License-Identifier: MIT
"""An orbit in a scenario, magnetorquers on it, and what else of the catalogue flies beside them."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import gyrostat as gs
from gyrostat import _core
from gyrostat.design import findings, momentum

ORBIT = gs.Orbit(semi_major_axis=6871200.0, inclination=1.7, raan=0.7, argument_of_latitude=0.35, earth_angle=1.2)
RATE = np.sqrt(3.986004418e14 / 6871200.0**3)
AXES = np.hstack([np.eye(3), np.eye(3)])
WHEELS = gs.Vehicle(
    J_B=(6.0, 5.0, 4.0),
    D_B=AXES,
    u_max=(0.1, 0.1, 0.1, 15.0, 15.0, 15.0),
    wheel_inertia=(0.002, 0.002, 0.002, 0.0, 0.0, 0.0),
    magnetorquers=[3, 4, 5],
)


# Deg: what wheels cancel of a torquer that fails unseen, 15 A m^2 in 5e-5 T, over the law's 0.06 N m an MRP, and half
# as much again on its way there.
UNSEEN = 1.5 * np.rad2deg(4.0 * 15.0 * 5e-5 / 0.06)


def flying(**changes: Any) -> gs.Scenario:
    """Three wheels and three torquers, with momentum in the wheels."""
    return gs.Scenario(
        vehicle=WHEELS,
        orbit=ORBIT,
        desaturation=gs.Desaturation(),
        controller=gs.controller("mrp_feedback", K=0.06, P=0.48),
        initial={"wheel_speed": [150.0, -100.0, 125.0, 0.0, 0.0, 0.0]},
        integrator="rk4",
        duration=2000.0,
        dt=4.0,
    ).replace(**changes)


def refused(**changes: Any) -> str:
    with pytest.raises(gs.InputError) as error:
        flying(**changes)
    text = str(error.value)
    assert "\n" not in text
    return text


# ---- scenario -------------------------------------------------------------------------------------------------------


def test_a_scenario_with_an_orbit_is_the_same_from_its_tables() -> None:
    """Tables and Python say the same things."""
    scenario = flying(**{"orbit.sun_N": [0.48, -0.6, 0.64], "desaturation.momentum": "total"})
    assert gs.Scenario.from_dict(scenario.to_dict()) == scenario


def test_channels_of_an_orbit_are_offered_where_there_is_one() -> None:
    """And none of them without."""
    of_orbit = {
        "truth.r_N",
        "truth.v_N",
        "truth.field_B",
        "truth.eclipse",
        "measurement.field_B",
        "measurement.field_valid",
    }
    assert of_orbit <= {c["name"] for c in flying().channel_names()}
    plain = gs.Scenario(vehicle=gs.vehicle.ftc_4rw(), duration=1.0, dt=0.1)
    assert not of_orbit & {c["name"] for c in plain.channel_names()}


def test_position_field_and_shadow() -> None:
    """Period, radius, one shadow a turn that lasts what the geometry says, and the field in the body as in space."""
    result = flying(duration=11000.0, dt=10.0, **{"orbit.sun_N": [0.48, -0.6, 0.64]}).run(
        channels=["truth.r_N", "truth.v_N", "truth.field_B", "truth.eclipse", "measurement.field_B", "truth.q_NB"]
    )
    r = result["truth.r_N"]
    assert np.allclose(np.linalg.norm(r, axis=1), 6871200.0, rtol=1e-14)
    assert np.allclose(np.linalg.norm(result["truth.v_N"], axis=1), RATE * 6871200.0, rtol=1e-13)
    assert np.array_equal(result["truth.field_B"], result["measurement.field_B"])
    plane = np.cross(r[0], result["truth.v_N"][0])
    share = np.sqrt(1.0 - (np.array([0.48, -0.6, 0.64]) @ plane / np.linalg.norm(plane)) ** 2)
    half = np.pi - np.arccos(-np.sqrt(1.0 - (6378137.0 / 6871200.0) ** 2) / share)
    turn = result["truth.eclipse"][: round(2 * np.pi / RATE / 10.0)]
    assert turn.sum() * 10.0 == pytest.approx(2 * half / RATE, abs=11.0)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"orbit.semi_major_axis": 6.5e6, "orbit.eccentricity": 0.1}, "the orbit passes through the Earth"),
        ({"orbit.inclination": 97.0}, "looks like degrees"),
        ({"orbit.sun_N": [1.0, 0.0, 0.0], "orbit.sun_longitude": 0.1}, "give one of sun_N and sun_longitude"),
        ({"orbit.height": 5e5}, "height"),
        ({"vehicle.orbit_rate": 2e-3}, "that of the orbit is 0.00110"),
        ({"orbit": None}, "magnetorquers need an orbit"),
        ({"vehicle.magnetorquers": [2, 3]}, "actuator 2 cannot be a wheel and a magnetorquer"),
        ({"vehicle.D_B": (AXES * [1, 1, 1, 2, 1, 1]).tolist()}, "column 3 is a dipole axis of length 2"),
        ({"vehicle.magnetorquers": []}, "desaturation: the vehicle has no magnetorquers"),
    ],
)
def test_what_cannot_be_is_refused_in_one_line(changes: dict[str, Any], message: str) -> None:
    """With the place, the number and what is allowed."""
    assert message in refused(**changes)


def test_a_gain_that_swings_is_refused() -> None:
    """More than a sample can hold: 300 n dt > 1."""
    wild = flying(**{"desaturation.gain": 300.0})
    assert [row["name"] for row in wild.check() if not row["ok"]] == ["cross_product"]
    with pytest.raises(gs.InputError, match=r"gain \* orbit_rate \* dt = 1.3"):
        wild.run()


def test_torques_of_an_orbit_need_one() -> None:
    """A plate and a dipole have nothing to act on otherwise."""
    dipole = gs.disturbances.ResidualDipole(dipole_B=(0.1, 0.0, 0.0))
    with pytest.raises(gs.InputError, match="residual_dipole needs an orbit"):
        gs.Scenario(vehicle=gs.vehicle.ftc_4rw(), disturbances=[dipole], duration=1.0, dt=0.1)


def test_flight_code_has_the_dipoles_of_torquers_alone() -> None:
    """What its stack turns across the field; the other columns are the vehicle's."""
    model = flying().compiled.flight_model()
    assert model["vehicle"]["magnetorquers"] == [3, 4, 5]
    np.testing.assert_array_equal(model["dipole_B"], AXES * [0, 0, 0, 1, 1, 1])
    np.testing.assert_array_equal(model["vehicle"]["D_B"], AXES * [1, 1, 1, 0, 0, 0])
    assert [c["name"] for c in model["components"] if c["role"] == "desaturation"] == ["desaturation"]


# ---- flight ---------------------------------------------------------------------------------------------------------


def test_momentum_goes_down_and_the_attitude_does_not_move() -> None:
    """The wheels cancel what the torquers do in the same sample; what is left is the field's turn within one."""
    channels = ["truth.h_w", "error.angle", "allocation.u"]
    on, off = flying().run(channels=channels), flying(desaturation=None).run(channels=channels)
    h = np.linalg.norm(on["truth.h_w"], axis=1)
    assert np.linalg.norm(off["truth.h_w"][-1]) == pytest.approx(h[0], rel=1e-6)
    assert h[-1] < 0.35 * h[0]
    assert np.rad2deg(on["error.angle"].max()) < 0.01
    assert np.abs(on["allocation.u"][:, 3:]).max() < 15.0


def test_what_the_channels_say_of_torque_counts_the_field() -> None:
    """Healthy actuators leave no fault torque, and no lumped one."""
    result = flying(duration=400.0).run(channels=["truth.fault_B", "truth.lumped_B", "truth.delivered", "allocation.u"])
    assert np.abs(result["truth.delivered"][1:, 3:]).max() > 1.0
    assert np.abs(result["truth.fault_B"]).max() == 0.0
    assert np.abs(result["truth.lumped_B"][1:]).max() < 1e-9


@pytest.mark.parametrize(
    "fault",
    [
        gs.faults.Stuck(actuator=4, t_on=101.3, torque=5.0),
        gs.faults.HardOver(actuator=3, t_on=101.3, t_off=300.0, sign=1),
        gs.faults.Lock(actuator=5, t_on=101.3),
        gs.faults.Bias(actuator=3, t_on=0.0, torque=1.0),
        gs.faults.Drift(actuator=3, t_on=10.0, rate=1e-3),
        gs.faults.DeadZone(actuator=3, t_on=10.0, width=5.0),
        gs.faults.Intermittent(actuator=5, t_on=10.0, period=100.0, duty=0.4),
        gs.faults.LossOfEffectiveness(actuator=4, t_on=10.0, remaining=0.3),
        gs.faults.Dead(actuator=4, t_on=10.0),
    ],
    ids=lambda fault: fault.type,
)
@pytest.mark.parametrize("integrator", ["rk4", "cvode"])
def test_every_fault_acts_on_a_torquer(fault: gs.Component, integrator: str) -> None:
    """In A m^2, across the field, and the wheels still point: they cancel at most 15 A m^2 that never come."""
    result = flying(faults=[fault], integrator=integrator, duration=800.0).run(
        channels=["truth.fault_B", "truth.field_B", "error.angle"]
    )
    torque, field = result["truth.fault_B"], result["truth.field_B"]
    assert 1e-7 < np.abs(torque).max() < 1e-3
    assert np.abs(np.einsum("ij,ij->i", torque, field)).max() < 1e-16
    assert np.rad2deg(result["error.angle"].max()) < UNSEEN


def test_a_tumble_dies_out_on_torquers_alone() -> None:
    """No wheel, no attitude law: the total momentum is what is taken off."""
    cube = gs.Vehicle(J_B=(0.13, 0.1, 0.05), D_B=np.eye(3), u_max=0.4, magnetorquers=[0, 1, 2])
    scenario = gs.Scenario(
        vehicle=cube,
        orbit=ORBIT,
        desaturation=gs.Desaturation(gain=3.5, momentum="total"),
        controller="open_loop",
        initial={"omega_BN_B": [0.05, -0.06, 0.04]},
        integrator="rk4",
        duration=12000.0,
        dt=1.0,
    )
    result = scenario.run(channels=["truth.omega_BN_B"])
    assert np.linalg.norm(result["truth.omega_BN_B"][-1]) < 2e-3
    (torque,) = findings(scenario)
    assert torque.ok is None
    assert "none along the magnetic field" in torque.text


# ---- check ----------------------------------------------------------------------------------------------------------


def limited(**changes: Any) -> gs.Scenario:
    """Wheels that can fill, under a constant torque."""
    push = gs.disturbances.Constant(torque_B=(4e-5, 3e-5, -2e-5))
    most = {"vehicle.momentum_max": [0.4, 0.4, 0.4, np.inf, np.inf, np.inf]}
    return flying(disturbances=[push], initial=None, duration=6000.0, **most).replace(**changes)


def test_check_says_when_the_wheels_are_full_and_what_empties_them() -> None:
    """5.4e-5 N m fill 0.4 N m s in 7400 s."""
    (alone,) = [f for f in findings(limited(desaturation=None)) if f.where == "momentum"]
    assert alone.value == pytest.approx(0.4 / np.linalg.norm([4e-5, 3e-5, -2e-5]), rel=0.02)
    assert "nothing empties them" in alone.text
    assert alone.ok is None
    (late,) = momentum.findings(limited(desaturation=None, duration=8000.0))
    assert late.ok is False
    (held,) = momentum.findings(limited())
    assert held.ok
    assert "magnetorquers hold them near" in held.text
    (none,) = momentum.findings(limited(**{"desaturation.gain": 0.0}))
    assert none.ok is False


def test_what_check_promises_is_what_flies() -> None:
    """Level of the momentum, within a factor of two; and the wheels that nothing empties are full when it said."""
    (held,) = momentum.findings(limited())
    flown = limited(duration=12000.0).run(channels=["truth.h_w"])
    level = np.linalg.norm(flown["truth.h_w"], axis=1)[-1500:].max()
    assert held.value is not None
    assert 0.5 * level < held.value < 2.0 * level
    assert momentum.findings(gs.Scenario(vehicle=WHEELS, orbit=ORBIT, duration=8.0, dt=4.0)) == []


# ---- the catalogue beside torquers -----------------------------------------------------------------------------------


@pytest.mark.parametrize("controller", [c for c in _core.catalogue()["controller"] if c != "open_loop"])
def test_every_controller_points_while_the_wheels_are_emptied(controller: str) -> None:
    """With its defaults, which count on the wheels alone."""
    scenario = flying(controller=controller, duration=1600.0, dt=0.5, **{"initial.mrp": [0.05, -0.02, 0.03]})
    result = scenario.run(channels=["error.angle", "truth.h_w"])
    assert result.completed
    assert np.rad2deg(result["error.angle"][-200:].max()) < 0.5
    assert np.linalg.norm(result["truth.h_w"][-1]) < 0.45 * np.linalg.norm(result["truth.h_w"][0])


@pytest.mark.parametrize("allocator", _core.catalogue()["allocator"])
def test_every_allocator_leaves_the_torquers_what_is_preferred(allocator: str) -> None:
    """Wheels of 1 beside columns of 3e-5. The robust one trusts less in what nobody has seen work (infinite bounds)."""
    result = flying(allocator=allocator).run(channels=["error.angle", "truth.h_w"])
    assert np.rad2deg(result["error.angle"].max()) < 0.05
    left = 0.8 if allocator == "robust_socp" else 0.4
    assert np.linalg.norm(result["truth.h_w"][-1]) < left * np.linalg.norm(result["truth.h_w"][0])


@pytest.mark.parametrize("observer", _core.catalogue()["observer"])
def test_every_observer_beside_torquers(observer: str) -> None:
    """A wheel at a third and a torquer that dies: the vehicle points, the wheels empty."""
    faults = [
        gs.faults.LossOfEffectiveness(actuator=1, t_on=100.0, remaining=0.35),
        gs.faults.Dead(actuator=4, t_on=300.0),
    ]
    result = flying(observer=observer, faults=faults, duration=1600.0, dt=0.5).run(
        channels=["error.angle", "truth.h_w"]
    )
    assert result.completed
    assert np.rad2deg(result["error.angle"].max()) < UNSEEN
    assert np.linalg.norm(result["truth.h_w"][-1]) < 0.7 * np.linalg.norm(result["truth.h_w"][0])


def test_cubesat_6u_comes_to_rest_and_its_wheels_empty() -> None:
    """The shipped scenario, on the vehicle of the same name."""
    scenario = gs.Scenario.load("cubesat_6u")
    same = scenario.replace(vehicle=gs.vehicle.cubesat_6u().to_dict())
    assert np.allclose(same.vehicle.D_B, scenario.vehicle.D_B)
    assert same.vehicle.model_copy(update={"D_B": scenario.vehicle.D_B}) == scenario.vehicle
    result = scenario.run(channels=["error.angle", "truth.h_w", "truth.omega_BN_B"])
    assert result.completed
    h = np.linalg.norm(result["truth.h_w"], axis=1)
    assert h.max() > 5e-3
    assert h[-1] < 0.25 * h.max()
    assert np.rad2deg(result["error.angle"][-2000:].max()) < 0.5


def test_experiments_vary_the_orbit_and_the_gain() -> None:
    """Each flight is the run of its scenario."""
    vary = ["orbit.argument_of_latitude", "orbit.inclination", "desaturation.gain"]
    values = [[0.3, 1.2, 2.0], [2.0, 0.1, 1.0], [4.0, 1.7, 4.0]]
    base = flying(duration=400.0)
    flights = gs.Experiment(base, vary=vary).fly(values, threads=2)
    for i, row in enumerate(values):
        alone = base.replace(**dict(zip(vary, row, strict=True)), run_number=i)
        assert flights["energy"][i] == alone.run(channels=["allocation.u", "error.angle"]).metrics.energy


@pytest.mark.parametrize("seed", range(24))
def test_torquers_lose_no_vehicle_that_wheels_alone_hold(seed: int) -> None:
    """Four wheels and three torquers under any stack and any faults, against the same with the wheels alone.

    A torquer that is hard over, unseen, leaves laws without an estimate of the torque some degrees off.
    """
    rng = np.random.default_rng(seed)
    kinds, most = _core.catalogue(), np.array([0.02] * 4 + [10.0] * 3)
    parts = {role: str(rng.choice(kinds[role])) for role in ("observer", "detector", "controller", "allocator")}
    if parts["controller"] == "open_loop":
        parts["controller"] = "predefined_time"
    made = {
        "bias": lambda m: {"torque": 0.2 * m},
        "stuck": lambda m: {"torque": 0.2 * m},
        "drift": lambda m: {"rate": 3e-4 * m},
        "dead_zone": lambda m: {"width": 0.1 * m},
        "hard_over": lambda _: {"sign": -1},
        "intermittent": lambda _: {"period": 17.0, "duty": 0.5},
    }
    faults_of_any = [f for f in kinds["fault"] if f not in ("leak", "slow_valve", "rotor_slow_down")]
    faults = []
    for actuator in (int(rng.integers(4)), int(rng.integers(4, 7))):
        kind = str(rng.choice([f for f in faults_of_any if actuator > 3 or f != "hard_over"]))
        own = made.get(kind, lambda _: {})(most[actuator])
        faults.append({"type": kind, "actuator": actuator, "t_on": float(rng.uniform(5.0, 200.0)), **own})
    wheels = gs.vehicle.pyramid4(J_B=(1.3, 1.0, 0.8), u_max=0.02, wheel_inertia=3e-4)
    alone = gs.Scenario(
        vehicle=wheels,
        faults=[gs.Component.of(f["type"], {k: v for k, v in f.items() if k != "type"}) for f in faults[:1]],
        initial={"mrp": (0.2 * rng.normal(size=3)).tolist(), "omega_BN_B": (0.005 * rng.normal(size=3)).tolist()},
        integrator="rk4",
        duration=600.0,
        dt=0.5,
        **parts,
    )
    both = alone.replace(
        **{
            "vehicle.D_B": np.hstack([np.asarray(wheels.D_B), np.eye(3)]).tolist(),
            "vehicle.u_max": most.tolist(),
            "vehicle.wheel_inertia": [3e-4] * 4 + [0.0] * 3,
            "vehicle.magnetorquers": [4, 5, 6],
            "orbit": ORBIT.to_dict(),
            "desaturation": {"gain": float(rng.choice([2.0, 10.0]))},
            "faults": faults,
            "disturbances": [{"type": "gravity_gradient"}, {"type": "residual_dipole", "dipole_B": [0.1, 0.0, 0.0]}],
        }
    )
    error = [np.rad2deg(s.run(channels=["error.angle"])["error.angle"][-100:].max()) for s in (alone, both)]
    assert error[1] < 5.0 or error[0] > 1.0, (parts, faults, error)
