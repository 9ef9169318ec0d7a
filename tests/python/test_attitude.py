# SPDX-License-Identifier: MIT
"""Attitude conversions against scipy's Rotation.

scipy's rotation of q_NB takes body components to inertial ones, as ours does; only the order of the numbers differs.
"""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from gyrostat import attitude

TIGHT = 1e-12  # double rounding through a few trigonometric functions


def _unit(numbers: tuple[float, ...]) -> np.ndarray:
    q = np.array(numbers)
    return q / np.linalg.norm(q)


_component = st.floats(-1.0, 1.0, allow_subnormal=False)
quaternions = st.tuples(*[_component] * 4).filter(lambda q: np.linalg.norm(q) > 1e-3).map(_unit)
vectors = st.tuples(*[st.floats(-3.0, 3.0, allow_subnormal=False)] * 3).map(np.array)


_lengths = st.floats(-200.0, 200.0).map(lambda decade: 10.0**decade)


def scipy_of(q: np.ndarray) -> Rotation:
    return Rotation.from_quat(np.roll(q, -1, axis=-1))


@given(quaternions)
def test_the_direction_cosines_take_inertial_to_body(q: np.ndarray) -> None:
    np.testing.assert_allclose(attitude.dcm_from_quat(q), scipy_of(q).as_matrix().T, atol=TIGHT)


@given(quaternions)
def test_rotation_vector_and_angle_agree(q: np.ndarray) -> None:
    angle = attitude.rotation_angle(q)
    assert angle == pytest.approx(scipy_of(q).magnitude(), abs=1e-7)  # acos-like loss near 0 in the oracle
    back = attitude.quat_from_rotation_vector(attitude.rotation_vector_from_quat(q))
    np.testing.assert_allclose(back * np.sign(back @ q), q, atol=TIGHT)


@given(quaternions)
def test_mrp_of_the_short_way_agree(q: np.ndarray) -> None:
    short = q if q[0] >= 0.0 else -q
    np.testing.assert_allclose(attitude.mrp_from_quat(short), scipy_of(q).as_mrp(), atol=TIGHT)


@given(quaternions.filter(lambda q: q[0] > -0.99))
def test_mrp_and_back_is_the_same_quaternion(q: np.ndarray) -> None:
    # 1 / (1 + q0) amplifies rounding 100 times at most
    np.testing.assert_allclose(attitude.quat_from_mrp(attitude.mrp_from_quat(q)), q, atol=100 * TIGHT)


@given(vectors.filter(lambda s: np.linalg.norm(s) > 0.05))
def test_the_shadow_is_the_same_attitude(sigma: np.ndarray) -> None:
    shadow = attitude.mrp_shadow(sigma)
    np.testing.assert_allclose(shadow, -sigma / (sigma @ sigma), rtol=1e-12)
    one, other = attitude.quat_from_mrp(sigma), attitude.quat_from_mrp(shadow)
    np.testing.assert_allclose(one, -other, atol=TIGHT)


@given(quaternions)
def test_euler_angles_are_the_321_sequence(q: np.ndarray) -> None:
    angles = attitude.euler_from_quat(q)
    if abs(abs(angles[1]) - math.pi / 2) < 1e-4:
        return  # gimbal lock: the split between roll and yaw is a convention
    yaw, pitch, roll = scipy_of(q).as_euler("ZYX")
    turns = (angles - (roll, pitch, yaw)) / (2.0 * math.pi)  # -pi and pi are one angle
    np.testing.assert_allclose(turns, np.round(turns), atol=1e-10)  # 1 / cos(pitch) amplifies up to 1e4


@given(st.tuples(st.floats(-3.1, 3.1), st.floats(-1.57, 1.57), st.floats(-3.1, 3.1)))
def test_euler_angles_make_the_same_rotation(angles: tuple[float, float, float]) -> None:
    roll, pitch, yaw = angles
    ours = attitude.quat_from_euler(np.array(angles))
    expected = np.roll(Rotation.from_euler("ZYX", (yaw, pitch, roll)).as_quat(), 1)
    np.testing.assert_allclose(ours * np.sign(ours @ expected), expected, atol=TIGHT)


@given(quaternions, _lengths)
def test_a_quaternion_of_any_length_stands_for_its_direction(q: np.ndarray, length: float) -> None:
    long = length * q
    np.testing.assert_allclose(attitude.dcm_from_quat(long), attitude.dcm_from_quat(q), atol=TIGHT)
    np.testing.assert_allclose(attitude.rotation_angle(long), attitude.rotation_angle(q), atol=TIGHT)
    one, other = attitude.rotation_vector_from_quat(long), attitude.rotation_vector_from_quat(q)
    assert min(np.abs(one - other).max(), np.abs(one + other).max() if abs(q[0]) < TIGHT else math.inf) < TIGHT
    np.testing.assert_allclose(
        scipy_euler_matrix(attitude.euler_from_quat(long)), attitude.dcm_from_quat(q), atol=TIGHT
    )
    one, other = attitude.mrp_from_quat(long), attitude.mrp_from_quat(q)
    # near a full turn sigma goes with 1 / |v|, and so does what rounding of q is worth
    np.testing.assert_allclose(one, other, rtol=TIGHT, atol=TIGHT * (1.0 + other @ other))


def scipy_euler_matrix(angles: np.ndarray) -> np.ndarray:
    """C_BN of roll, pitch, yaw."""
    return Rotation.from_euler("ZYX", angles[::-1]).as_matrix().T


@pytest.mark.parametrize("side", [1.0, -1.0])
@pytest.mark.parametrize("from_lock_deg", [0.0, 1e-9, 1e-6, 6e-5, 1e-3, 0.1, 5.0])
def test_euler_angles_hold_at_and_around_the_lock(side: float, from_lock_deg: float) -> None:
    """Rounded to float32, as it is read from a file: scipy's rotation of the angles is that of the quaternion."""
    pitch = side * math.radians(90.0 - from_lock_deg)
    for roll, yaw in np.random.default_rng(5).uniform(-3.1, 3.1, size=(50, 2)):
        q = np.roll(Rotation.from_euler("ZYX", (yaw, pitch, roll)).as_quat(), 1)
        for given_q in (q, q.astype(np.float32).astype(np.float64)):
            angles = attitude.euler_from_quat(given_q)
            np.testing.assert_allclose(scipy_euler_matrix(angles), scipy_of(given_q).as_matrix().T, rtol=0, atol=TIGHT)
            assert abs(angles[1] - pitch) < 4e-4  # float32 moves q by 6e-8, and pitch by the root of it at the lock


def test_full_turns_have_the_nearest_mrp_that_exists() -> None:
    np.testing.assert_array_equal(attitude.mrp_from_quat(np.array([-1.0, 0.0, 0.0, 0.0])), np.zeros(3))
    np.testing.assert_allclose(attitude.mrp_from_quat(np.array([-1.0, 1e-9, 0.0, 0.0])), [2e9, 0.0, 0.0], rtol=1e-15)
    np.testing.assert_array_equal(attitude.mrp_shadow(np.zeros(3)), np.zeros(3))
    np.testing.assert_allclose(attitude.mrp_shadow(np.array([0.0, 0.0, 1e-200])), [0.0, 0.0, -1e200], rtol=1e-15)
    np.testing.assert_allclose(
        attitude.quat_from_mrp(np.array([1e200, 0.0, 0.0])), [-1.0, 2e-200, 0.0, 0.0], rtol=1e-15
    )


@pytest.mark.parametrize("q", [[0.0] * 4, [1.0, math.inf, 0.0, 0.0], [math.nan, 0.0, 0.0, 1.0]])
def test_what_describes_no_attitude_gives_nan(q: list[float]) -> None:
    for function in (
        attitude.dcm_from_quat,
        attitude.mrp_from_quat,
        attitude.euler_from_quat,
        attitude.rotation_angle,
        attitude.rotation_vector_from_quat,
    ):
        assert np.isnan(function(np.array(q))).all()


def test_every_conversion_works_on_stacks_of_any_shape() -> None:
    q = np.random.default_rng(3).normal(size=(2, 5, 4))
    q /= np.linalg.norm(q, axis=-1, keepdims=True)
    assert attitude.mrp_from_quat(q).shape == (2, 5, 3)
    assert attitude.dcm_from_quat(q).shape == (2, 5, 3, 3)
    assert attitude.rotation_angle(q).shape == (2, 5)
    np.testing.assert_array_equal(attitude.euler_from_quat(q)[1, 2], attitude.euler_from_quat(q[1, 2]))


def test_a_wrong_last_axis_is_named() -> None:
    with pytest.raises(ValueError, match="q: the last axis must hold 4 numbers"):
        attitude.mrp_from_quat(np.zeros(3))
