# SPDX-License-Identifier: MIT
"""Vehicles: what flight knows of one, and ready-made actuator layouts.

A key that is not given keeps the default of the C++ description; ``gyrostat describe vehicle`` lists them.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from gyrostat.components import Matrix, Vector
from gyrostat.model import Block, Leaf


class Vehicle(Block):
    """The nominal vehicle: all that flight knows of it.

    Parameters
    ----------
    J_B
        Inertia of the whole vehicle, wheels included, kg m^2: three rows, or three numbers for a diagonal one.
    D_B
        Actuator axes in columns, body frame: three rows of as many numbers as there are actuators (1 to 16).
    u_max, u_min
        Limits of the command, N m: a number or one an actuator. Without ``u_max`` flight knows no limit.
    u_rate
        Limit of the change of a command, N m/s.
    wheel_inertia
        Axial inertia of each wheel, kg m^2; 0: an ideal torque actuator.
    momentum_max
        Momentum at which a wheel gives no more, N m s, as flight knows it: a number or one an actuator. Truth has it
        too unless it states its own.
    magnetorquers
        Actuators that are a dipole along their column of ``D_B``; their commands and limits are in A m^2.
    spare
        Actuators that stay off until a detector enables them.
    orbit_rate
        Rate of a circular orbit, rad/s.
    coordinates
        ``euler_angles`` for the printed Euler-angle plant of one published study; ``body`` otherwise.
    """

    J_B: Leaf[Matrix | Vector]
    D_B: Leaf[Matrix]
    u_max: Leaf[float | Vector | None] = None
    u_min: Leaf[float | Vector | None] = None
    u_rate: Leaf[float | Vector | None] = None
    wheel_inertia: Leaf[float | Vector | None] = None
    momentum_max: Leaf[float | Vector | None] = None
    magnetorquers: Leaf[tuple[int, ...] | list[int] | None] = None
    spare: Leaf[tuple[int, ...] | list[int] | None] = None
    orbit_rate: Leaf[float | None] = None
    coordinates: Leaf[Literal["body", "euler_angles"] | None] = None

    @property
    def actuators(self) -> int:
        """Number of actuators."""
        return int(np.shape(self.D_B)[1])

    @property
    def torque_axes(self) -> NDArray[np.float64]:
        """Torque of each command, body axes in columns (3, n); zero of a magnetorquer, which the field decides."""
        return torque_axes(self.to_dict())


class Truth(Block):
    """What really flies, where it differs from the nominal vehicle. Keys as in ``gyrostat describe truth``."""

    dJ_B: Leaf[Matrix | Vector | None] = None
    dD_B: Leaf[Matrix | None] = None
    u_max: Leaf[float | Vector | None] = None
    u_min: Leaf[float | Vector | None] = None
    limit_on: Leaf[Literal["command", "output"] | None] = None
    viscous_friction: Leaf[float | Vector | None] = None
    coulomb_friction: Leaf[float | Vector | None] = None
    momentum_max: Leaf[float | Vector | None] = None


class Flexible(Block):
    """Appendages of the true vehicle that bend, as modes of the clamped appendage with unit modal mass.

    Parameters
    ----------
    delta
        Coupling with the body's rotation, kg^(1/2) m: a row of three numbers a mode, at most 8 modes.
    omega
        Frequencies with the body held, rad/s.
    xi
        Damping ratios; 0.005 when not given.
    eta, eta_rate
        Displacement and its rate at t = 0, kg^(1/2) m and kg^(1/2) m/s; 0 when not given.
    """

    delta: Leaf[Matrix]
    omega: Leaf[Vector]
    xi: Leaf[Vector | None] = None
    eta: Leaf[Vector | None] = None
    eta_rate: Leaf[Vector | None] = None


class Orbit(Block):
    """An orbit round the Earth: N is then the equatorial frame, z to the north pole and x to the equinox.

    Angles in rad, at t = 0.

    Parameters
    ----------
    semi_major_axis
        m, from the centre of the Earth.
    inclination
        To the equator.
    raan
        Right ascension of the ascending node.
    argument_of_latitude
        From the ascending node to the vehicle.
    eccentricity
        0, a circle, to 0.9.
    perigee
        From the ascending node to the perigee.
    earth_angle
        From ``x_N`` to the meridian of Greenwich.
    sun_longitude
        Of the sun in the ecliptic, from the equinox.
    sun_N
        Direction of the sun, instead of ``sun_longitude``.
    """

    semi_major_axis: Leaf[float]
    inclination: Leaf[float]
    raan: Leaf[float | None] = None
    argument_of_latitude: Leaf[float | None] = None
    eccentricity: Leaf[float | None] = None
    perigee: Leaf[float | None] = None
    earth_angle: Leaf[float | None] = None
    sun_longitude: Leaf[float | None] = None
    sun_N: Leaf[Vector | None] = None


class Desaturation(Block):
    """What flight does about momentum, with its magnetorquers.

    Parameters
    ----------
    gain
        Of the cross-product law, in units of the orbit's rate; 2 when not given.
    momentum
        ``wheels``, whose momentum is taken off without moving the attitude, or ``total``, that of the vehicle, which
        comes to rest.
    keep_B
        Momentum that is left, N m s in body axes.
    """

    gain: Leaf[float | None] = None
    momentum: Leaf[Literal["wheels", "total"] | None] = None
    keep_B: Leaf[Vector | None] = None


class Initial(Block):
    """State at t = 0: one of ``q_NB``, ``mrp``, ``euler``; body rate and wheel speeds relative to the body."""

    q_NB: Leaf[Vector | None] = None
    mrp: Leaf[Vector | None] = None
    euler: Leaf[Vector | None] = None
    omega_BN_B: Leaf[Vector | None] = None
    wheel_speed: Leaf[float | Vector | None] = None


def torque_axes(vehicle: Mapping[str, Any]) -> NDArray[np.float64]:
    """`Vehicle.torque_axes` of a vehicle's table."""
    D = np.array(vehicle["D_B"], dtype=float)
    D[:, list(vehicle.get("magnetorquers") or ())] = 0.0
    return D


PYRAMID4 = ((1.0, -1.0, -1.0, 1.0), (1.0, 1.0, -1.0, -1.0), (1.0, 1.0, 1.0, 1.0))
"""Axes of the regular four-wheel pyramid, times sqrt 3: azimuths 45 + 90 k deg, elevation 35.26 deg."""


def pyramid4(*, J_B: Matrix | Vector, **blocks: Any) -> Vehicle:
    """Four actuators on a regular pyramid: ``D D' = 4/3 I``, any three of them control all axes.

    Parameters
    ----------
    J_B
        Inertia, kg m^2.
    **blocks
        Other keys of `Vehicle`: ``u_max``, ``wheel_inertia``, ...
    """
    return Vehicle(J_B=J_B, D_B=np.array(PYRAMID4) / np.sqrt(3.0), **blocks)


def orthogonal_skew4(*, J_B: Matrix | Vector, **blocks: Any) -> Vehicle:
    """Three actuators along the body axes and a fourth along their diagonal ``(1, 1, 1) / sqrt 3``.

    Parameters
    ----------
    J_B
        Inertia, kg m^2.
    **blocks
        Other keys of `Vehicle`.
    """
    return Vehicle(J_B=J_B, D_B=np.column_stack([np.eye(3), np.full(3, 1.0 / np.sqrt(3.0))]), **blocks)


def ftc_4rw() -> Vehicle:
    """The project's reference vehicle: four reaction wheels of 0.2 N m and 0.05 kg m^2 on a 20 kg m^2 body.

    Wheel axes in the order (1,1,1), (1,-1,1), (-1,-1,1), (-1,1,1), each over sqrt 3.
    """
    axes = np.array([[1, 1, -1, -1], [1, -1, -1, 1], [1, 1, 1, 1]]) / np.sqrt(3.0)
    inertia = ((20.0, 0.0, 0.9), (0.0, 17.0, 0.0), (0.9, 0.0, 15.0))
    return Vehicle(J_B=inertia, D_B=axes, u_max=0.2, wheel_inertia=0.05)


def flexible_4() -> tuple[Vehicle, Flexible]:
    """A 350 kg m^2 body with four wheels of 1 N m and two solar panels of four modes, and those modes.

    The panel data are those of Di Gennaro and of Hu and others, which most publications on fault-tolerant control of
    flexible spacecraft use.
    """
    vehicle = pyramid4(J_B=((350.0, 3.0, 4.0), (3.0, 270.0, 10.0), (4.0, 10.0, 190.0)), u_max=1.0, wheel_inertia=0.05)
    delta = (
        (6.45637, 1.27814, 2.15629),
        (-1.25819, 0.91756, -1.67264),
        (1.11687, 2.48901, -0.83674),
        (1.23637, -2.65810, -1.12530),
    )
    modes = Flexible(delta=delta, omega=(0.7681, 1.1038, 1.8733, 2.5496), xi=(0.0056, 0.0086, 0.0128, 0.0252))
    return vehicle, modes


def cubesat_6u() -> Vehicle:
    """A 6U CubeSat: four wheels of 2 mN m and 30 mN m s on a pyramid, three magnetorquers of 0.4 A m^2 on the axes.

    It flies on an orbit, whose field the magnetorquers need.
    """
    return Vehicle(
        J_B=(0.13, 0.10, 0.05),
        D_B=np.column_stack([np.array(PYRAMID4) / np.sqrt(3.0), np.eye(3)]),
        u_max=(2e-3, 2e-3, 2e-3, 2e-3, 0.4, 0.4, 0.4),
        wheel_inertia=(3e-5, 3e-5, 3e-5, 3e-5, 0.0, 0.0, 0.0),
        momentum_max=(0.03, 0.03, 0.03, 0.03, math.inf, math.inf, math.inf),
        magnetorquers=(4, 5, 6),
    )
