# SPDX-License-Identifier: MIT
"""The picture of a vehicle, from what its scenario says: a box of its inertia, actuators along their axes."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]

_thinnest = 0.3
"""Edges shorter than this part of the longest are drawn so: a needle shows nothing."""


def matrix3(value: ArrayLike) -> Array:
    """An inertia as a matrix; three numbers are its diagonal."""
    x = np.asarray(value, dtype=float)
    return np.diag(np.broadcast_to(x, 3)) if x.ndim < 2 else x


def box(J_B: ArrayLike) -> Array:
    """Half edges of the solid box that has this inertia up to its scale, as columns in body axes.

    A homogeneous box with half edges ``a_i`` along axes ``v_i`` has the second moments ``S = tr(J)/2 I - J =
    (m/3) sum a_i^2 v_i v_i'``; the longest is scaled to 1.

    Parameters
    ----------
    J_B
        kg m^2, a matrix or its diagonal.

    Returns
    -------
    Array
        Shape (3, 3), each column within 45 deg of the body axis of its number where the axes allow it.
    """
    J = matrix3(J_B)
    moments, axes = np.linalg.eigh(np.trace(J) / 2.0 * np.eye(3) - (J + J.T) / 2.0)
    edges = np.sqrt(np.maximum(moments, 0.0))
    edges = np.maximum(edges / max(float(edges.max()), 1e-300), _thinnest)
    order = _nearest_axes(axes)
    signs = np.sign(axes[np.arange(3), order])
    drawn: Array = axes[:, order] * np.where(signs == 0.0, 1.0, signs) * edges[order]
    return drawn


def _nearest_axes(axes: Array) -> list[int]:
    """Which column to take for x, y and z so that each lies nearest to its axis."""
    orders = [[0, 1, 2], [0, 2, 1], [1, 0, 2], [1, 2, 0], [2, 0, 1], [2, 1, 0]]
    return max(orders, key=lambda order: float(np.abs(axes[np.arange(3), order]).sum()))


def actuators(vehicle: Mapping[str, Any]) -> list[dict[str, Any]]:
    """Where each actuator is drawn: its kind, axis and place outside the body, one behind the other on a common axis.

    Parameters
    ----------
    vehicle
        The table of a scenario.

    Returns
    -------
    list
        ``kind`` (``wheel`` or ``torquer``), ``axis`` (unit, body frame; zero if it has none) and ``at``.
    """
    D = np.asarray(vehicle["D_B"], dtype=float)
    wheels = np.broadcast_to(np.asarray(vehicle.get("wheel_inertia", 0.0), dtype=float), D.shape[1:]) > 0.0
    half = box(vehicle["J_B"])
    drawn: list[dict[str, Any]] = []
    for column, is_wheel in zip(D.T, wheels, strict=True):
        length = float(np.linalg.norm(column))
        axis = column / length if length > 0.0 else np.zeros(3)
        before = sum(float(np.dot(axis, other["axis"])) > 0.999 for other in drawn)
        distance = _reach(half, axis) + 0.14 + 0.24 * before
        drawn.append(
            {
                "kind": "wheel" if is_wheel else "torquer",
                "axis": axis.round(9).tolist(),
                "at": (axis * distance).round(6).tolist(),
            }
        )
    return drawn


def _reach(half: Array, direction: Array) -> float:
    """Distance from the centre of the box to its surface along a unit direction."""
    if not direction.any():
        return 0.0
    parts = np.abs(np.linalg.solve(half, direction))
    return 1.0 / float(parts.max())


def body_inertia(vehicle: Mapping[str, Any]) -> Array:
    """``J`` of the equation of motion: the vehicle's less what its wheels have about their axes."""
    D = np.asarray(vehicle["D_B"], dtype=float)
    axial = np.broadcast_to(np.asarray(vehicle.get("wheel_inertia", 0.0), dtype=float), D.shape[1:])
    body: Array = matrix3(vehicle["J_B"]) - (D * axial) @ D.T
    return body
