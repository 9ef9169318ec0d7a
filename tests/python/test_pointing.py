# SPDX-License-Identifier: MIT
"""References on an orbit, and of one's own, flown: the Earth, a place on it and the sun stay where the axes point."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import gyrostat as gs
from gyrostat.attitude import dcm_from_quat

ORBIT = gs.Orbit(semi_major_axis=6.9e6, inclination=0.9, raan=0.4, argument_of_latitude=0.3, earth_angle=1.2)
SITE = {"latitude": 0.55, "longitude": -0.55}
LAWS = ["mrp_feedback", "saturated_pd", "integral_sliding_mode", "sliding_mode"]
FAULTS = [
    gs.faults.LossOfEffectiveness(actuator=1, t_on=120.0, remaining=0.4),
    gs.faults.Bias(actuator=0, t_on=150.0, torque=0.01),
]


def flown(reference: Any, channels: list[str], **changes: Any) -> gs.Result:
    """Tracks from the reference's own start, two wheels weak or biased on the way."""
    first = start(reference, **changes)
    scenario = gs.Scenario(
        **{
            "vehicle": gs.vehicle.ftc_4rw(),
            "orbit": ORBIT,
            "observer": "finite_time_disturbance",
            "controller": "mrp_feedback",
            "reference": reference,
            "initial": first,
            "duration": 400.0,
            "dt": 0.1,
            **changes,
        }
    )
    result = scenario.run(channels=channels)
    assert result.completed
    return result


def start(reference: Any, **changes: Any) -> gs.Initial:
    scenario = gs.Scenario(
        vehicle=gs.vehicle.ftc_4rw(), orbit=changes.get("orbit", ORBIT), reference=reference, duration=0.1, dt=0.1
    )
    result = scenario.run(channels=["reference.q_NR", "reference.omega_RN_R"])
    return gs.Initial(q_NB=result["reference.q_NR"][0], omega_BN_B=result["reference.omega_RN_R"][0])


def degrees(result: gs.Result, t0: float) -> float:
    return float(np.rad2deg(result["error.angle"][result.t >= t0]).max())


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("reference", [gs.references.Nadir(), gs.references.Target(**SITE)], ids=["nadir", "target"])
def test_laws_follow_the_earth_through_faults(reference: Any, law: str) -> None:
    result = flown(reference, ["error.angle"], controller=law, faults=FAULTS)
    assert degrees(result, 0.0) < 1.0, "the faults are seen"
    assert degrees(result, 300.0) < 0.1, "and made good for"


def test_the_boresight_hits_the_site() -> None:
    result = flown(gs.references.Target(**SITE), ["truth.q_NB", "truth.r_N"])
    angle = 1.2 + 7.292115e-5 * result.t + SITE["longitude"]
    up = SITE["latitude"]
    site = 6378137.0 * np.stack(
        [np.cos(up) * np.cos(angle), np.cos(up) * np.sin(angle), np.full_like(angle, np.sin(up))], 1
    )
    sight = site - result["truth.r_N"]
    boresight = np.swapaxes(dcm_from_quat(result["truth.q_NB"]), 1, 2) @ np.array([0, 0, 1], dtype=float)
    miss = np.linalg.norm(np.cross(boresight, sight / np.linalg.norm(sight, axis=1)[:, None]), axis=1)
    assert np.rad2deg(miss).max() < 0.02


def test_nadir_and_sun_are_where_they_are_said_to_be() -> None:
    elliptic = gs.Orbit(semi_major_axis=9e6, inclination=0.5, eccentricity=0.2, sun_longitude=1.0)
    down = flown(gs.references.Nadir(), ["truth.q_NB", "truth.r_N", "error.angle"], orbit=elliptic)
    r = down["truth.r_N"] / np.linalg.norm(down["truth.r_N"], axis=1)[:, None]
    z = np.swapaxes(dcm_from_quat(down["truth.q_NB"]), 1, 2) @ np.array([0, 0, 1], dtype=float)
    assert np.abs(z + r).max() < 1e-3
    sun = flown(gs.references.Sun(axis=[1, 0, 0]), ["truth.q_NB", "measurement.sun_N", "error.angle"], orbit=elliptic)
    x = np.swapaxes(dcm_from_quat(sun["truth.q_NB"]), 1, 2) @ np.array([1, 0, 0], dtype=float)
    assert np.abs(x - sun["measurement.sun_N"]).max() < 1e-3


def test_nadir_needs_no_more_than_an_orbit_rate() -> None:
    body = gs.vehicle.ftc_4rw().model_copy(update={"orbit_rate": 1e-3})
    scenario = gs.Scenario(
        vehicle=body, reference="nadir", initial=gs.Initial(omega_BN_B=[0, -1e-3, 0]), duration=200.0, dt=0.1
    )
    result = scenario.run(channels=["reference.q_NR", "error.angle"])
    np.testing.assert_allclose(result["reference.q_NR"][1000], [np.cos(0.05), 0, -np.sin(0.05), 0], atol=1e-14)
    assert degrees(result, 0.0) < 0.01


@pytest.mark.parametrize(
    ("reference", "changes", "message"),
    [
        ("nadir", {"orbit": None}, "nadir needs an orbit, or the vehicle's orbit_rate"),
        ("sun", {"orbit": None}, "'sun': needs an orbit"),
        ("target", {}, "latitude is missing"),
        ({"type": "target", "latitude": 45, "longitude": 0}, {}, "looks like degrees"),
        ({"type": "two_vector", "first": "nadir", "second": "zenith"}, {}, r"0\.0+ deg from one line at t = 0"),
        ({"type": "two_vector", "first": "nadir", "second": "moon"}, {}, "moon"),
        ({"type": "two_vector", "axis": [1, 0, 0]}, {}, "one direction; two belong here"),
    ],
)
def test_what_cannot_be_pointed_at_is_one_line(reference: Any, changes: dict[str, Any], message: str) -> None:
    with pytest.raises(ValueError, match=message) as error:
        gs.Scenario(
            **{"vehicle": gs.vehicle.ftc_4rw(), "orbit": ORBIT, "reference": reference, "duration": 1.0, "dt": 0.1}
            | changes
        ).check()
    assert "\n" not in str(error.value)


# ---- of one's own ----


class Spin:
    """About z, ever faster, up to a rate."""

    def __init__(self, rate: float = 0.01, acceleration: float = 2e-4) -> None:
        self.rate, self.acceleration, self.calls = rate, acceleration, 0

    def setup(self, setup: gs.Setup) -> None:
        self.dt = setup.dt

    def at(self, t: float) -> tuple[Any, Any, Any]:
        self.calls += 1
        ramp = self.rate / self.acceleration
        rate, acceleration = (self.acceleration * t, self.acceleration) if t < ramp else (self.rate, 0.0)
        angle = rate * t / 2 if t < ramp else self.rate * (t - ramp / 2)
        return [np.cos(angle / 2), 0, 0, np.sin(angle / 2)], [0, 0, rate], [0, 0, acceleration]


def own(reference: Any, **changes: Any) -> gs.Scenario:
    return gs.Scenario(
        **{"vehicle": gs.vehicle.ftc_4rw(), "reference": reference, "duration": 100.0, "dt": 0.1, **changes}
    )


def test_a_python_object_is_followed_and_flies_as_a_copy() -> None:
    spin = Spin()
    scenario = own(spin)
    result = scenario.run(channels=["reference.q_NR", "reference.omega_RN_R", "error.angle"])
    assert degrees(result, 0.0) < 0.1
    np.testing.assert_allclose(result["reference.omega_RN_R"][-1], [0, 0, 0.01], atol=1e-16)
    assert spin.calls == 0
    assert result.components["reference"].calls == 1001
    again = scenario.run(channels=["error.angle"])
    np.testing.assert_array_equal(result["error.angle"], again["error.angle"])


def test_an_attitude_alone_rests_and_equals_hold() -> None:
    class Stays:
        def at(self, t: float) -> list[float]:
            return [0.96, 0.28, 0.0, 0.0]

    mine = own(Stays()).run(channels=["error.angle"])
    theirs = own(gs.references.Hold(q_NR=[0.96, 0.28, 0.0, 0.0])).run(channels=["error.angle"])
    np.testing.assert_array_equal(mine["error.angle"], theirs["error.angle"])


def test_what_a_python_reference_does_wrong_is_one_line() -> None:
    class Short:
        def at(self, t: float) -> list[float]:
            return [1.0, 0.0, 0.0]

    class Raises:
        def at(self, t: float) -> list[float]:
            raise RuntimeError("lost the ephemeris")

    with pytest.raises(ValueError, match=r"reference Short\.at returned 3 numbers; 4 belong there"):
        own(Short()).run()
    with pytest.raises(RuntimeError, match="lost the ephemeris"):
        own(Raises()).run()
    with pytest.raises(ValueError, match="is a class; an object of it belongs here"):
        own(Spin)
    with pytest.raises(ValueError, match=r"object is a Python object without at\(t\)"):
        own(object())
    with pytest.raises(ValueError, match="reference is a Python object; a TOML file"):
        own(Spin()).to_toml()
