# SPDX-License-Identifier: MIT
"""Sensors, faults and disturbances that are Python objects: they fly as those of the catalogue would."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import gyrostat as gs

CHANNELS = [
    "truth.omega_BN_B",
    "truth.q_NB",
    "measurement.omega_BN_B",
    "allocation.u",
    "truth.external_B",
    "error.angle",
]


class Noisy:
    """A gyro with a bias that jumps, and a tracker that gives out."""

    def __init__(self, at: float = 2.0) -> None:
        self.at, self.calls = at, 0

    def setup(self, setup: gs.Setup) -> None:
        self.dt = setup.dt

    def measure(self, y: gs.Measurement) -> gs.Measurement:
        self.calls += 1
        t = y.tick * self.dt
        if t >= self.at:
            y.omega_BN_B = y.omega_BN_B + np.array([1e-3, 0, 0])
        y.attitude_valid = t < 2 * self.at or t > 3 * self.at
        return y


class Weak:
    """Gives a share of the command of one actuator, late by a sample."""

    def __init__(self, actuator: int, remaining: float, t_on: float = 0.0) -> None:
        self.actuator, self.remaining, self.t_on = actuator, remaining, t_on

    def apply(self, t: float, u: np.ndarray) -> np.ndarray:
        if t >= self.t_on:
            u[self.actuator] *= self.remaining
        return u


class Push:
    """A torque in N, held over each sample."""

    def __init__(self, torque_B: Any) -> None:
        self.torque = np.asarray(torque_B, dtype=float)

    def torque_B(self, t: float, q_NB: np.ndarray, omega_BN_B: np.ndarray) -> np.ndarray:
        assert q_NB.shape == (4,)
        assert omega_BN_B.shape == (3,)
        return self.torque


def scenario(**changes: Any) -> gs.Scenario:
    return gs.Scenario(
        **{
            "vehicle": gs.vehicle.ftc_4rw(),
            "controller": "mrp_feedback",
            "observer": "finite_time_disturbance",
            "reference": gs.reference("hold", euler=[0.2, -0.1, 0.3]),
            "duration": 20.0,
            "dt": 0.05,
            "integrator": "rk4",
            **changes,
        }
    )


def same(one: gs.Result, other: gs.Result, names: list[str], tolerance: float) -> None:
    for name in names:
        np.testing.assert_allclose(one[name], other[name], atol=tolerance, rtol=0)


@pytest.mark.parametrize("integrator", ["rk4", "cvode"])
def test_a_constant_torque_equals_that_of_the_catalogue(integrator: str) -> None:
    torque = [1e-3, -2e-3, 1.5e-3]
    mine = scenario(disturbances=[Push(torque)], integrator=integrator).run(channels=CHANNELS)
    theirs = scenario(disturbances=[gs.disturbances.Constant(torque_B=torque)], integrator=integrator).run(
        channels=CHANNELS
    )
    same(mine, theirs, CHANNELS[:3], 1e-10)
    np.testing.assert_array_equal(mine["truth.external_B"][1:], np.tile(torque, (400, 1)))
    both = scenario(disturbances=[Push(torque), gs.disturbances.Constant(torque_B=torque)], integrator=integrator)
    np.testing.assert_allclose(both.run(channels=CHANNELS)["truth.external_B"][1:], 2 * np.tile(torque, (400, 1)))


def test_a_weak_actuator_equals_that_of_the_catalogue() -> None:
    mine = scenario(faults=[Weak(1, 0.4, t_on=5.0)]).run(channels=CHANNELS)
    theirs = scenario(faults=[gs.faults.LossOfEffectiveness(actuator=1, remaining=0.4, t_on=5.0)]).run(
        channels=CHANNELS
    )
    same(mine, theirs, CHANNELS[:3], 1e-12)


def test_a_sensor_changes_what_is_shown_and_flies_as_a_copy() -> None:
    sensor = Noisy()
    flown = scenario(sensors=[gs.sensors.Gyro(noise=1e-6), sensor])
    result = flown.run(channels=[*CHANNELS, "measurement.attitude_valid"])
    shift = (result["measurement.omega_BN_B"] - result["truth.omega_BN_B"])[:, 0]
    late = result.t >= 2.0
    assert np.abs(shift[late] - 1e-3).max() < 1e-5
    assert np.abs(shift[~late]).max() < 1e-5
    silent = (result.t >= 4.0) & (result.t <= 6.0)
    np.testing.assert_array_equal(result["measurement.attitude_valid"] == 0, silent)
    assert sensor.calls == 0
    assert result.components["sensors"][0].calls == 401
    again = flown.run(channels=CHANNELS)
    np.testing.assert_array_equal(result["truth.q_NB"], again["truth.q_NB"])


def test_a_campaign_flies_them_and_counts_its_own_faults_rightly() -> None:
    base = scenario(faults=[Weak(0, 0.9), gs.faults.Bias(actuator=2, torque=1e-3, t_on=1.0)], duration=5.0)
    tables = base.tables()
    assert [f["type"] for f in tables["faults"]] == ["bias"]
    assert base.replace(**{"faults.1.torque": 2e-3}).tables()["faults"][0]["torque"] == 2e-3


def test_what_cannot_be_is_one_line() -> None:
    class Wrong:
        def torque_B(self, t: float, q_NB: Any, omega_BN_B: Any) -> Any:
            return [1.0, 2.0]

        def measure(self, y: gs.Measurement) -> Any:
            return None

        def apply(self, t: float, u: Any) -> Any:
            return u[:2]

    for key, message in (
        ("disturbances", r"disturbance Wrong\.torque_B returned 2 numbers; 3 belong there"),
        ("sensors", r"sensor Wrong\.measure returned nothing \(None\); a Measurement"),
        ("faults", r"fault Wrong\.apply returned 2 numbers; 4 belong there"),
    ):
        with pytest.raises(ValueError, match=message):
            scenario(**{key: [Wrong()]}).run()
        with pytest.raises(ValueError, match="Python object; a TOML file can only hold"):
            scenario(**{key: [Wrong()]}).to_toml()
        with pytest.raises(ValueError, match=r"object is a Python object without \w+\(\.\.\.\); for"):
            scenario(**{key: [object()]})
    with pytest.raises(ValueError, match="for 'integrator' there are"):
        scenario(integrator=Wrong())
