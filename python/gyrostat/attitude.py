# SPDX-License-Identifier: MIT
"""Attitude conversions, vectorised over the leading axis. Quaternions are Hamilton, scalar first; angles in radians.

``q_NB`` turns body components into inertial ones (``v_N = q_NB * v_B``); Euler angles are 3-2-1, ordered roll, pitch,
yaw.
"""

from __future__ import annotations

from gyrostat._core import (
    euler_from_quat,
    mrp_from_quat,
    mrp_shadow,
    quat_from_euler,
    quat_from_mrp,
    rotation_angle,
)

__all__ = [
    "euler_from_quat",
    "mrp_from_quat",
    "mrp_shadow",
    "quat_from_euler",
    "quat_from_mrp",
    "rotation_angle",
]
