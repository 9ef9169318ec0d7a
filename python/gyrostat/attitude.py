# SPDX-License-Identifier: MIT
"""Attitude conversions, vectorised over the leading axis. Quaternions are Hamilton, scalar first; angles in radians.

``q_NB`` turns body components into inertial ones (``v_N = q_NB * v_B``); Euler angles are 3-2-1, ordered roll, pitch,
yaw.

One rule for length and edges: a quaternion of any length but zero stands for its direction. What comes out is of the
same attitude, accurate to rounding also beside a full turn, half a turn and gimbal lock; on a singularity it is the
nearest description that exists. NaN, infinity and the zero quaternion describe no attitude and give NaN.
"""

from __future__ import annotations

from gyrostat._core import (
    dcm_from_quat,
    euler_from_quat,
    mrp_from_quat,
    mrp_shadow,
    quat_from_euler,
    quat_from_mrp,
    quat_from_rotation_vector,
    rotation_angle,
    rotation_vector_from_quat,
)

__all__ = [
    "dcm_from_quat",
    "euler_from_quat",
    "mrp_from_quat",
    "mrp_shadow",
    "quat_from_euler",
    "quat_from_mrp",
    "quat_from_rotation_vector",
    "rotation_angle",
    "rotation_vector_from_quat",
]
