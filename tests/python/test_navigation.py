# SPDX-License-Identifier: MIT
"""The attitude filter in flight: a biased gyro under faults, silent sensors, what it takes from the sensors."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import gyrostat as gs
from gyrostat import _core

BIAS = np.array([1e-3, -1e-3, 1e-3])


def flight(**changes: Any) -> gs.Scenario:
    """Sines to follow, a torque bias and a weak wheel from 60 s on; the observer feeds what it finds forward."""
    scenario = gs.Scenario(
        vehicle=gs.vehicle.ftc_4rw().model_copy(update={"J_B": (20.0, 17.0, 15.0)}),
        controller="mrp_feedback",
        observer="finite_time_disturbance",
        sensors=[gs.sensors.Gyro(noise=1e-5, bias=BIAS), gs.sensors.Attitude(noise=2e-5)],
        reference=gs.reference("mrp_sine", amplitude=[0.05, 0.04, 0.03], frequency=[0.05, 0.04, 0.03]),
        faults=[
            gs.faults.Bias(actuator=0, t_on=60.0, torque=0.02),
            gs.faults.LossOfEffectiveness(actuator=1, t_on=60.0, remaining=0.4),
        ],
        duration=120.0,
        dt=0.01,
        integrator="rk4",
    )
    return scenario.replace(**changes)


def pointing(result: gs.Result, t0: float, t1: float) -> float:
    window = (result.t >= t0) & (result.t < t1)
    return float(np.rad2deg(np.sqrt(np.mean(result["error.angle"][window] ** 2))))


def torque_error(result: gs.Result, t0: float, t1: float) -> np.ndarray:
    window = (result.t >= t0) & (result.t < t1)
    return np.linalg.norm((result["estimate.d_B"] - result["truth.lumped_mean_B"])[window], axis=1)


PLAIN = ["error.angle", "estimate.d_B", "truth.lumped_mean_B"]
CHANNELS = [*PLAIN, "navigator.*"]


def test_a_bias_under_faults_ends_at_the_pointing_of_a_gyro_without() -> None:
    unbiased = flight(sensors=[gs.sensors.Gyro(noise=1e-5), gs.sensors.Attitude(noise=2e-5)]).run(channels=PLAIN)
    plain = flight().run(channels=PLAIN)
    filtered = flight(navigator=gs.navigator("mekf")).run(channels=CHANNELS)
    assert pointing(plain, 100, 120) > 0.5, "a bias is an offset that no observer of torques sees"
    for window in ((30, 60), (100, 120)):
        assert pointing(filtered, *window) < 1.2 * pointing(unbiased, *window)
        assert pointing(filtered, *window) < 0.05
    # what the filter learns is no torque: the observer's worst error of the first seconds is that of an unbiased gyro
    assert torque_error(filtered, 0, 5).max() < 1.2 * torque_error(unbiased, 0, 5).max()
    bias = filtered["navigator.bias"][(filtered.t > 50) & (filtered.t < 65)]
    assert np.abs(bias - BIAS).max() < 3e-6, "the faults at 60 s are no bias"
    healthy = flight(navigator=gs.navigator("mekf"), faults=[]).run(channels=CHANNELS)
    late = filtered.t > 60
    np.testing.assert_allclose(filtered["navigator.bias"][late], healthy["navigator.bias"][late], atol=2e-7)


def test_what_is_not_given_is_taken_from_the_sensors() -> None:
    sensors = [gs.sensors.Gyro(noise=3e-5, quantisation=1e-5), gs.sensors.Attitude(noise=4e-5, delay=7)]
    taken = flight(navigator="mekf", sensors=sensors).resolve()["navigator"]
    assert taken["angle_random_walk"] == pytest.approx(np.sqrt((3e-5**2 + 1e-5**2 / 12) * 0.01), rel=1e-12)
    assert taken["attitude_noise"] == pytest.approx([4e-5] * 3)
    assert taken["latency"] == 7
    given = flight(navigator=gs.navigator("mekf", latency=3), sensors=sensors).resolve()["navigator"]
    assert given["latency"] == 3


def test_it_flies_through_silence_and_a_late_tracker() -> None:
    sensors = [
        gs.sensors.Gyro(noise=1e-5, bias=BIAS),
        gs.sensors.Attitude(noise=2e-5, delay=20),
        gs.sensors.AttitudeDropout(t_on=40.0, t_off=50.0),
        gs.sensors.RateDropout(t_on=70.0, t_off=70.3),
    ]
    result = flight(navigator="mekf", sensors=sensors, initial={"q_NB": [1, 0, 0, 0]}).run(channels=CHANNELS)
    assert result.completed
    assert pointing(result, 30, 60) < 0.05
    assert pointing(result, 100, 120) < 0.05
    deaf = flight(sensors=sensors).run(channels=CHANNELS[:1])
    assert pointing(deaf, 100, 120) > 0.5


def test_every_observer_flies_behind_it() -> None:
    for observer in _core.catalogue()["observer"]:
        for dt in (0.1, 0.01):
            scenario = flight(
                navigator="mekf", observer=observer, dt=dt, duration=40.0, controller="integral_sliding_mode"
            )
            result = scenario.run(channels=CHANNELS[:1])
            assert result.completed, observer
            assert pointing(result, 30, 40) < 0.5, (observer, dt)


@pytest.mark.parametrize(
    ("parameters", "message"),
    [
        ({"rate_random_walk": 0.0}, r"rate_random_walk = 0 is outside"),
        ({"latency": 65}, r"latency = 65 is outside \[0, 64\]"),
        ({"attitude_noise": [1e-5, 0.0, 1e-5]}, r"attitude_noise"),
        ({"q_BS": [1.0, 0.2, 0.0, 0.0]}, r"q_BS .* has norm 1\.0198; a unit quaternion"),
        ({"gate": 0.5}, r"gate = 0\.5 is outside"),
        ({"sigma": 1.0}, r"sigma"),
    ],
)
def test_what_cannot_be_is_one_line(parameters: dict[str, Any], message: str) -> None:
    with pytest.raises(ValueError, match=message) as error:
        flight(navigator=gs.navigator("mekf", **parameters)).run()
    assert "\n" not in str(error.value)
