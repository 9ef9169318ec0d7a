# SPDX-License-Identifier: MIT
"""The attitude filter in flight: a biased gyro under faults, silent sensors, what it takes from the sensors."""

from __future__ import annotations

import math
from collections.abc import Callable
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


def farrenkopf(T: float, sigma: float, s_v: float, s_u: float) -> Callable[[float], float]:
    """Steady attitude error of an axis at rest, rad, some time after the last fix; Farrenkopf 1978."""
    Sv, Su = s_v * math.sqrt(T) / sigma, s_u * T**1.5 / sigma
    g = math.sqrt(1.0 + Sv**2 / 4.0 + Su**2 / 48.0)
    z = g + Su / 4.0 + 0.5 * math.sqrt(2.0 * g * Su + Sv**2 + Su**2 / 3.0)
    attitude, mixed = sigma**2 * (1.0 - 1.0 / z**2), -s_u * math.sqrt(T) * sigma / z
    bias = s_u * sigma * (z - 1.0 / z) / math.sqrt(T) - s_u**2 * T / 2.0
    return lambda t: math.sqrt(attitude - 2.0 * t * mixed + t * t * bias + s_v**2 * t + s_u**2 * t**3 / 3.0)


def test_its_errors_in_flight_are_those_of_farrenkopf_through_an_outage_too() -> None:
    """Sensors of the truth, the compiled filter, the closed form: a body at rest, 80 flights, each with its bias."""
    s_v, s_u, sigma, turn_on = 1e-5, 1e-7, 2e-5, 2e-3
    rng = np.random.default_rng(0)
    settled, silent, learnt = [], [], []
    for run in range(80):
        bias = turn_on * rng.normal(size=3)
        flown = gs.Scenario(
            vehicle=gs.vehicle.ftc_4rw(),
            controller="open_loop",
            navigator="mekf",
            sensors=[
                gs.sensors.Gyro(angle_random_walk=s_v, rate_random_walk=s_u, bias=bias.tolist()),
                gs.sensors.StarTracker(noise=[sigma] * 3, every=10, blind=[[200.1, 230.1]]),
            ],
            integrator="rk4",
            duration=230.0,
            dt=0.05,
            run_number=run,
        ).run(channels=["navigator.bias", "navigator.fix", "estimate.q_NB", "truth.q_NB"])
        p, q = flown["estimate.q_NB"], flown["truth.q_NB"]
        error = 2.0 * (p[:, :1] * q[:, 1:] - q[:, :1] * p[:, 1:] - np.cross(p[:, 1:], q[:, 1:]))
        error *= np.sign(np.sum(p * q, axis=1))[:, None]
        used = (flown["navigator.fix"].ravel() == 2) & (flown.t > 60.0) & (flown.t <= 200.0)
        settled.append(error[used])
        silent.append([error[np.searchsorted(flown.t, 200.0 + t - 1e-6)] for t in (5.0, 10.0, 30.0)])
        learnt.append([flown["navigator.bias"][np.searchsorted(flown.t, t - 1e-6)] - bias for t in (5.0, 10.0, 40.0)])
    known = farrenkopf(0.5, sigma, s_v, s_u)
    assert known(5.0) == pytest.approx(2.56e-5, rel=2e-3)
    assert known(30.0) == pytest.approx(6.47e-5, rel=2e-3)
    assert np.sqrt(np.mean(np.concatenate(settled) ** 2)) / known(0.0) == pytest.approx(1.0, abs=0.02)
    outage = np.sqrt(np.mean(np.square(silent), axis=(0, 2)))
    # 240 numbers each: 4.6 %, three sigma
    np.testing.assert_allclose(outage / [known(t) for t in (5.0, 10.0, 30.0)], 1.0, atol=0.15)
    assert (np.sqrt(np.mean(np.square(learnt), axis=(0, 2))) < [2.5e-5, 1e-5, 3e-6]).all()


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


AMPLITUDE = FREQUENCY = np.array([0.05, 0.04, 0.03])


def tracker(**changes: Any) -> Any:
    """2 Hz, 2e-5 rad."""
    return gs.sensors.StarTracker(**{"noise": [2e-5] * 3, "every": 50, **changes})


def tracked(gyro: Any, attitude: Any, **changes: Any) -> gs.Scenario:
    """The flight above from the state of its reference, so that what points wrong is knowledge."""
    return flight(sensors=[gyro, attitude], initial=gs.Initial(omega_BN_B=4 * AMPLITUDE * FREQUENCY), **changes)


def test_a_tracker_at_2_hz_and_a_biased_gyro_point_as_well_as_a_gyro_without_bias() -> None:
    biased, unbiased = gs.sensors.Gyro(noise=1e-5, bias=BIAS), gs.sensors.Gyro(noise=1e-5)
    best = tracked(unbiased, gs.sensors.Attitude(noise=2e-5)).run(channels=PLAIN)
    plain = tracked(biased, tracker()).run(channels=PLAIN)
    filtered = tracked(biased, tracker(), navigator="mekf").run(channels=CHANNELS)
    for window in ((30, 60), (100, 120)):
        assert pointing(plain, *window) > 1.0
        assert pointing(filtered, *window) < 0.003
    assert torque_error(filtered, 0, 5).max() < 1.2 * torque_error(best, 0, 5).max()
    early, after = (filtered.t >= 50) & (filtered.t < 60), (filtered.t >= 60) & (filtered.t < 65)
    for part in (early, after):
        assert np.sqrt(np.mean((filtered["navigator.bias"][part] - BIAS) ** 2)) < 1e-6
    assert filtered["navigator.rejected"][-1] == 0


def rms_of_bias(result: gs.Result) -> float:
    window = (result.t >= 50) & (result.t < 60)
    return float(np.sqrt(np.mean((result["navigator.bias"][window] - BIAS) ** 2)))


def test_a_latency_that_is_known_costs_nothing_and_one_that_is_not_shows() -> None:
    gyro, late = gs.sensors.Gyro(noise=1e-5, bias=BIAS), tracker(latency=20)
    told = tracked(gyro, late, navigator="mekf").run(channels=CHANNELS)
    not_told = tracked(gyro, late, navigator=gs.navigator("mekf", latency=0)).run(channels=CHANNELS)
    assert pointing(told, 30, 60) < 0.003
    assert pointing(told, 100, 120) < 0.003
    assert rms_of_bias(told) < 1e-6
    assert told["navigator.rejected"][-1] == 0
    assert pointing(not_told, 30, 60) > 0.03
    assert not_told["navigator.rejected"][-1] > 10


def test_a_late_sensor_has_measured_nothing_before_its_delay_has_filled() -> None:
    """A body that turns: the first attitude, shown as that of now or of 0.1 s before it, would be a wrong fix."""
    late = {"initial": {"omega_BN_B": [0.05, -0.08, 0.03]}, "duration": 2.0, "navigator": "mekf"}
    sensors = [gs.sensors.Gyro(noise=1e-5, bias=BIAS, delay=3), gs.sensors.Attitude(noise=2e-5, delay=10)]
    valid = ["measurement.rate_valid", "measurement.attitude_valid"]
    result = flight(sensors=[gs.sensors.Gyro(noise=1e-5, bias=BIAS), sensors[1]], **late).run()
    assert result["navigator.rejected"][-1] == 0
    assert [(e.name, e.t, e.count) for e in result.events] == [("guard.attitude", 0.0, 10)]
    assert not np.any(result["allocation.u"][:10]), "nothing to fly on yet"
    assert np.all(result["allocation.u"][10:].any(axis=1))
    shown = flight(sensors=sensors, **late).run(channels=valid)
    tick = np.arange(201)
    np.testing.assert_array_equal(shown["measurement.rate_valid"], tick >= 3)
    np.testing.assert_array_equal(shown["measurement.attitude_valid"], tick >= 10)


def test_outliers_are_rejected_and_nothing_else_and_signs_do_not_matter() -> None:
    sensor = tracker(outlier_probability=0.1, outlier_angle=np.deg2rad(1), flip_sign=True)
    channels = [*CHANNELS, "measurement.q_NB", "measurement.attitude_valid", "truth.q_NB"]
    result = tracked(gs.sensors.Gyro(noise=1e-5, bias=BIAS), sensor, navigator="mekf").run(channels=channels)
    fix = result["measurement.attitude_valid"] == 1
    product = np.abs(np.sum(result["measurement.q_NB"][fix] * result["truth.q_NB"][fix], axis=1))
    far = 2 * np.arccos(np.minimum(product, 1)) > np.deg2rad(0.5)
    assert far.sum() > 10
    assert np.array_equal(far, result["navigator.fix"][fix] == 3)
    assert pointing(result, 30, 60) < 0.003
    assert pointing(result, 100, 120) < 0.003


def test_it_points_through_a_blind_tracker() -> None:
    sensor = tracker(blind=[[40.0, 50.0]], latency=20)
    result = tracked(gs.sensors.Gyro(noise=1e-5, bias=BIAS), sensor, navigator="mekf").run(channels=CHANNELS)
    fixes = result.t[result["navigator.fix"] > 0]
    assert not ((fixes > 40.2) & (fixes < 50.2 - 1e-9)).any(), "what was seen at 40 s is shown at 40.2 s"
    assert pointing(result, 40, 50) < 0.005
    assert pointing(result, 100, 120) < 0.003


def test_a_mounted_tracker_and_a_gyro_with_errors_that_no_data_sheet_tells() -> None:
    gyro = gs.sensors.Gyro(
        angle_random_walk=1e-6,
        rate_random_walk=1e-8,
        bias=BIAS,
        scale_factor=[1e-4, -1e-4, 1e-4],
        misalignment=[[0, 1e-4, 0], [0, 0, 1e-4], [1e-4, 0, 0]],
    )
    sensor = tracker(noise=[2e-5, 2e-5, 1.2e-4], q_BS=[0.8, 0.36, 0.48, 0.0], latency=20)
    result = tracked(gyro, sensor, navigator="mekf").run(channels=CHANNELS)
    assert pointing(result, 30, 60) < 0.003
    assert pointing(result, 100, 120) < 0.003
    told = tracked(gyro, sensor, navigator="mekf").resolve()["navigator"]
    assert told["latency"] == 20
    assert told["q_BS"] == pytest.approx([0.8, 0.36, 0.48, 0.0])
    assert told["attitude_noise"] == pytest.approx([2e-5, 2e-5, 1.2e-4])
    assert (told["angle_random_walk"], told["rate_random_walk"]) == (1e-6, 1e-8)


@pytest.mark.parametrize("every", [2, 5, 10])
def test_a_gyro_slower_than_the_stack(every: int) -> None:
    gyro = gs.sensors.Gyro(noise=1e-5, bias=BIAS, every=every)
    scenario = tracked(gyro, tracker(), navigator="mekf", faults=[])
    told = scenario.resolve()["navigator"]
    assert told["gyro_every"] == every
    assert told["angle_random_walk"] == pytest.approx(1e-5 * np.sqrt(0.01 * every), rel=1e-12)
    result = scenario.run(channels=CHANNELS)
    assert result["navigator.rejected"][-1] == 0
    assert rms_of_bias(result) < 1e-6
    assert pointing(result, 30, 60) < 0.003
    assert pointing(result, 100, 120) < 0.003


@pytest.mark.parametrize(
    ("sensors", "message"),
    [
        ([gs.sensors.Gyro(noise=1e-5, angle_random_walk=1e-6)], r"gyro: give one of noise and angle_random_walk"),
        ([gs.sensors.Gyro(dropouts=[[2.0, 1.0]])], r"gyro: dropouts: t_off must be after t_on"),
        ([gs.sensors.Gyro(dropouts=[[1.0, 3.0], [2.0, 4.0]])], r"gyro: dropouts: windows overlap"),
        ([gs.sensors.Gyro(misalignment=0.1)], r"gyro: misalignment has a diagonal"),
        ([{"type": "gyro", "every": 0}], r"every = 0 is outside \[1, 1e\+06\]"),
        ([tracker(blind=[[1.0]])], r"star_tracker: blind: a row has 1 numbers"),
        ([tracker(outlier_probability=0.1)], r"outlier_probability needs an outlier_angle"),
        ([{"type": "star_tracker", "q_BS": [1, 1, 0, 0]}], r"q_BS .* a unit quaternion belongs here"),
        ([{"type": "star_tracker", "earth_keepout": 0.5}], r"earth_keepout needs an orbit"),
        ([tracker(), gs.sensors.Attitude()], r"one attitude sensor \(attitude or star_tracker\)"),
        ([tracker(latency=65)], r"latency = 65 is outside \[0, 64\]"),
    ],
)
def test_sensors_that_cannot_be_are_one_line(sensors: list[Any], message: str) -> None:
    with pytest.raises(ValueError, match=message) as error:
        flight(sensors=sensors, navigator="mekf").run()
    assert "\n" not in str(error.value)


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
