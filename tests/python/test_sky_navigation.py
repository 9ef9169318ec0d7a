# SPDX-License-Identifier: MIT
"""The attitude filter on sun and magnetic field, and a star tracker that sun and Earth blind, in orbit."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import gyrostat as gs
from gyrostat.export import export

BIAS = [1e-3, -1e-3, 1e-3]
ORBIT = gs.Orbit(semi_major_axis=6.9e6, inclination=0.9, raan=0.4, earth_angle=1.2, sun_longitude=1.0)
GYRO = gs.sensors.Gyro(angle_random_walk=1e-5, rate_random_walk=1e-8, bias=BIAS)
SUN = gs.sensors.SunSensor(noise=2e-3)
FIELD = gs.sensors.Magnetometer(noise=5e-8)
NO_TRACKER = gs.sensors.AttitudeDropout(t_on=0.0)
CHANNELS = ["error.angle", "navigator.*", "truth.eclipse", "truth.q_NB", "estimate.q_NB", "measurement.sun_valid"]


def flight(sensors: list[Any], **changes: Any) -> gs.Scenario:
    return gs.Scenario(
        **{
            "vehicle": gs.vehicle.ftc_4rw(),
            "orbit": ORBIT,
            "navigator": "mekf",
            "observer": "finite_time_disturbance",
            "controller": "mrp_feedback",
            "reference": "nadir",
            "sensors": sensors,
            "initial": gs.Initial(q_NB=[0.36, 0.48, -0.64, 0.48], omega_BN_B=[0.002, -0.003, 0.001]),
            "duration": 3000.0,
            "dt": 0.5,
            **changes,
        }
    )


def knowledge(result: gs.Result) -> Any:
    """Angle between what is known and what is, deg."""
    product = np.abs(np.sum(result["truth.q_NB"] * result["estimate.q_NB"], axis=1))
    return np.rad2deg(2 * np.arccos(np.minimum(product, 1.0)))


@pytest.mark.parametrize("acquisition", ["quest", "triad"])
def test_it_points_on_sun_and_field_alone_through_an_eclipse(acquisition: str) -> None:
    scenario = flight([GYRO, SUN, FIELD, NO_TRACKER], navigator=gs.navigator("mekf", acquisition=acquisition))
    told = scenario.resolve()["navigator"]
    assert told["sun_noise"] == 2e-3
    assert told["field_noise"] == 5e-8
    result = scenario.run(channels=CHANNELS)
    assert result.completed
    dark = result["truth.eclipse"] == 1
    assert 1000 < dark.sum() < 5000
    assert not result["measurement.sun_valid"][dark].any()
    late = result.t > 600
    assert knowledge(result)[late].max() < 0.3
    assert np.abs(result["navigator.bias"][late] - BIAS).max() < 3e-5
    assert np.rad2deg(result["error.angle"][late]).max() < 0.5
    assert result["navigator.vectors_rejected"][-1] <= 2


def test_without_the_option_they_are_not_used() -> None:
    silent = flight([GYRO, SUN, FIELD], navigator=gs.navigator("mekf", sun_noise=0.0, field_noise=0.0), duration=50.0)
    without = flight([GYRO], duration=50.0)
    channels = ["error.angle", "navigator.bias"]
    one, other = silent.run(channels=channels), without.run(channels=channels)
    for name in channels:
        np.testing.assert_array_equal(one[name], other[name])


def test_a_tracker_that_sun_and_earth_blind_is_helped_out() -> None:
    tracker = gs.sensors.StarTracker(noise=[2e-5, 2e-5, 1.2e-4], q_BS=[0.0, 1.0, 0.0, 0.0], every=4, sun_keepout=0.7)
    channels = [*CHANNELS, "measurement.attitude_valid"]
    result = flight([GYRO, tracker, SUN, FIELD]).run(channels=channels)
    assert result.completed
    assert result["navigator.fix"][0] in (1, 0, -1)
    fixes = result["measurement.attitude_valid"] == 1
    assert 100 < fixes.sum() < 1400, "blinded for some of its 1501 fixes"
    assert knowledge(result)[result.t > 600].max() < 0.1
    low = gs.sensors.StarTracker(noise=[2e-5] * 3, q_BS=[1.0, 0.0, 0.0, 0.0], earth_keepout=0.2)
    down = flight([GYRO, low, SUN, FIELD]).run(channels=channels)
    assert not down["measurement.attitude_valid"][down.t > 600].any(), "a boresight to nadir sees no star"
    assert knowledge(down)[down.t > 600].max() < 0.3


@pytest.mark.parametrize(
    ("sensors", "orbit", "message"),
    [
        ([SUN], None, "sensor sun_sensor needs an orbit"),
        ([FIELD], None, "sensor magnetometer needs an orbit"),
        ([gs.sensors.StarTracker(sun_keepout=0.5)], None, "star_tracker: sun_keepout needs an orbit"),
        ([gs.sensors.StarTracker(earth_keepout=0.5)], None, "star_tracker: earth_keepout needs an orbit"),
        ([{"type": "star_tracker", "sun_keepout": 4}], ORBIT, r"sun_keepout = 4 is outside \[0, 3\.14159\]"),
        ([{"type": "sun_sensor", "boresight_B": [0, 0, 0]}], ORBIT, "boresight_B is zero"),
        ([{"type": "sun_sensor", "blind": [[2, 1]]}], ORBIT, "sun_sensor: blind: t_off must be after t_on"),
        ([{"type": "magnetometer", "noise": 1}], ORBIT, r"noise = 1 is outside \[0, 0\.001\]"),
        ([SUN, SUN], ORBIT, "one sun_sensor"),
    ],
)
def test_what_cannot_be_is_one_line(sensors: list[Any], orbit: gs.Orbit | None, message: str) -> None:
    with pytest.raises(ValueError, match=message) as error:
        flight(sensors, orbit=orbit, reference="hold").check()
    assert "\n" not in str(error.value)


def test_an_exported_stack_hears_sun_and_field(tmp_path: Path) -> None:
    """What it does with them is flown in test_export_stacks.py, by a stack that has nothing else to go by."""
    scenario = flight([GYRO, SUN, FIELD, NO_TRACKER], name="sky", duration=100.0)
    export(scenario, "c", tmp_path / "c")
    assert "uint8_t field_valid, sun_valid;" in (tmp_path / "c" / "sky.h").read_text()
    plain = flight([GYRO], name="plain", orbit=None, reference="hold", duration=100.0)
    export(plain, "c", tmp_path / "plain")
    assert "sun" not in (tmp_path / "plain" / "plain.h").read_text()
