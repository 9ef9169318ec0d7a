# SPDX-License-Identifier: MIT
"""Vehicles: what flight knows of one, and ready-made actuator layouts.

A key that is not given keeps the default of the C++ description; ``gyrostat describe vehicle`` lists them.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from gyrostat.components import Matrix, Vector
from gyrostat.model import Block, Leaf

Array = NDArray[np.float64]


class Vehicle(Block):
    """The nominal vehicle: all that flight knows of it.

    Parameters
    ----------
    J_B
        Inertia of the whole vehicle, wheels included, kg m^2: three rows, or three numbers for a diagonal one.
    D_B
        Actuator axes in columns, body frame: three rows of as many numbers as there are actuators (1 to 16). Not given
        where `ControlMomentGyros` or `Thrusters` are all there is; they come behind these, in this order.
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
    D_B: Leaf[Matrix | None] = None
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
        """Number of actuators in ``D_B``."""
        return 0 if self.D_B is None else int(np.shape(self.D_B)[1])


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


class ControlMomentGyros(Block):
    """Single-gimbal control moment gyros: actuators behind those of the vehicle's ``D_B``, known to flight as they are.

    A command (N m) turns gimbal i at ``u_i / rotor_momentum_i``; its limit is ``rotor_momentum rate_max``.

    Parameters
    ----------
    gimbal_axes, spin_axes
        A row a gyro: unit vector along its gimbal axis, and along its rotor at gimbal angle zero, perpendicular to it.
    rotor_momentum
        Of each rotor, N m s: a number or one a gyro.
    rate_max
        Fastest gimbal, rad/s: a number or one a gyro.
    angles
        Of the gimbals at t = 0, rad; 0 when not given.
    angle_max
        Of the stops of the gimbals, on both sides, rad; flight does not know of them. None when not given.
    """

    gimbal_axes: Leaf[Matrix]
    spin_axes: Leaf[Matrix]
    rotor_momentum: Leaf[float | Vector]
    rate_max: Leaf[float | Vector]
    angles: Leaf[float | Vector | None] = None
    angle_max: Leaf[float | Vector | None] = None

    @property
    def count(self) -> int:
        """Number of gyros."""
        return len(np.atleast_2d(np.asarray(self.gimbal_axes, dtype=float)))

    def turned(self, angles: ArrayLike) -> tuple[Array, Array]:
        """(..., 3, n) axes of commands, and of rotors, at gimbal angles (..., n), rad."""
        g, s = (np.atleast_2d(np.asarray(rows, dtype=float)) for rows in (self.gimbal_axes, self.spin_axes))
        angle = np.asarray(angles, dtype=float)[..., None, :]
        cos, sin, spin, across = np.cos(angle), np.sin(angle), s.T, np.cross(g, s).T
        return sin * spin - cos * across, cos * spin + sin * across

    def axes_B(self) -> Array:
        """(3, n) axes along which commands act at the start."""
        start = 0.0 if self.angles is None else np.asarray(self.angles, dtype=float)
        return self.turned(np.broadcast_to(start, self.count))[0]

    @property
    def u_max(self) -> Array:
        """(n,) N m, largest commands."""
        product = np.asarray(self.rotor_momentum, dtype=float) * np.asarray(self.rate_max, dtype=float)
        return np.array(np.broadcast_to(product, self.count))


def standing(tables: Mapping[str, Any]) -> dict[str, Any]:
    """Tables of a scenario whose gimbals do not turn: each gyro is an ideal torquer along its axis at the start.

    What asks for the axes of a vehicle's actuators once looks at this; without gyros it is the scenario itself.
    """
    given = dict(tables)
    block = given.pop("cmg", None)
    if block is None:
        return given
    gyros = block if isinstance(block, ControlMomentGyros) else ControlMomentGyros(**block)
    vehicle = dict(given["vehicle"])
    others = np.zeros((3, 0)) if vehicle.get("D_B") is None else np.asarray(vehicle["D_B"], dtype=float)
    n = others.shape[1] + gyros.count
    u_max = np.array(np.broadcast_to(np.asarray(vehicle.get("u_max") or np.inf, dtype=float), n))
    u_max[others.shape[1] :] = np.minimum(u_max[others.shape[1] :], gyros.u_max)
    vehicle["D_B"] = np.hstack([others, gyros.axes_B()]).tolist()
    vehicle["u_max"] = u_max.tolist()
    faults = [fault for fault in given.get("faults", ()) if fault["type"] != "rotor_slow_down"]
    return given | {"vehicle": vehicle, "faults": faults}


class Thrusters(Block):
    """On/off thrusters of the vehicle: the actuators behind those of its ``D_B``.

    Flight knows of each the axis of its torque, that it pushes one way, and the ticks of its valve.

    Parameters
    ----------
    positions, directions
        Where each sits (m), and where its force on the body points: rows of three numbers, body axes.
    thrust
        Force while the valve is open, N: a number or one each.
    centre_of_mass
        Of the vehicle, m, body axes.
    tick
        A pulse is a whole number of ticks, s; so is a period.
    min_on, min_off
        Shortest pulse and shortest pause, ticks.
    align
        Where in its period a pulse lies: ``start`` or ``centre``.
    modulator
        ``pwm``: a pulse a period; ``pwpf``: pulse width and frequency; ``proportional``: no valve, thrust as commanded.
    pwpf_gain, pwpf_time_constant, pwpf_on, pwpf_off
        Of the pwpf modulator: gain and time constant (s) of its lag, and the two levels of its trigger.
    Isp
        Specific impulse, s: a number or one each.
    propellant_mass
        At t = 0, kg; not given: it never runs dry.
    """

    positions: Leaf[Matrix]
    directions: Leaf[Matrix]
    thrust: Leaf[float | Vector]
    centre_of_mass: Leaf[Vector | None] = None
    tick: Leaf[float | None] = None
    min_on: Leaf[int | None] = None
    min_off: Leaf[int | None] = None
    align: Leaf[Literal["start", "centre"] | None] = None
    modulator: Leaf[Literal["pwm", "pwpf", "proportional"] | None] = None
    pwpf_gain: Leaf[float | None] = None
    pwpf_time_constant: Leaf[float | None] = None
    pwpf_on: Leaf[float | None] = None
    pwpf_off: Leaf[float | None] = None
    Isp: Leaf[float | Vector | None] = None
    propellant_mass: Leaf[float | None] = None

    @property
    def D_B(self) -> NDArray[np.float64]:
        """Axes of their torques in columns, body frame, (3, k)."""
        arms = self._arms()
        return np.asarray((arms / np.linalg.norm(arms, axis=1, keepdims=True)).T)

    @property
    def torque(self) -> NDArray[np.float64]:
        """Of each while its valve is open, N m."""
        return np.asarray(np.linalg.norm(self._arms(), axis=1) * np.asarray(self.thrust, dtype=float))

    def _arms(self) -> NDArray[np.float64]:
        n = np.asarray(self.directions, dtype=float)
        at = np.asarray(self.positions, dtype=float) - np.asarray(self.centre_of_mass or (0.0, 0.0, 0.0), dtype=float)
        return np.cross(at, n / np.linalg.norm(n, axis=1, keepdims=True))


def all_actuators(tables: Mapping[str, Any]) -> dict[str, Any]:
    """The vehicle of a scenario's tables as if all its actuators stood in it: axes, limits, wheel inertia.

    Parameters
    ----------
    tables
        ``vehicle``, and ``cmg`` and ``thrusters`` where there are such. Gyros act along their axes at the start; the
        axis of a magnetorquer, whose torque the field decides, is zero.
    """
    vehicle = dict(standing(tables)["vehicle"])
    if vehicle.get("magnetorquers"):
        axes = np.array(vehicle["D_B"], dtype=float)
        axes[:, list(vehicle["magnetorquers"])] = 0.0
        vehicle["D_B"] = axes.tolist()
    given = tables.get("thrusters")
    if not given:
        return vehicle
    thrusters = Thrusters(**given)
    k = thrusters.torque.size
    own = np.asarray(vehicle.get("D_B") or np.zeros((3, 0)), dtype=float)

    def all_of(name: str, absent: float, behind: ArrayLike) -> list[float]:
        value = vehicle.get(name)
        mine = np.broadcast_to(np.asarray(absent if value is None else value, dtype=float), own.shape[1])
        return [float(x) for x in np.concatenate([mine, np.broadcast_to(behind, k)])]

    up = all_of("u_max", np.inf, thrusters.torque)
    if vehicle.get("u_min") is None:
        low = [*(-x for x in up[: own.shape[1]]), *(0.0 for _ in range(k))]
    else:
        low = all_of("u_min", 0.0, 0.0)
    return vehicle | {
        "D_B": np.hstack([own, thrusters.D_B]).tolist(),
        "u_max": up,
        "u_min": low,
        "u_rate": all_of("u_rate", np.inf, np.inf),
        "wheel_inertia": all_of("wheel_inertia", 0.0, 0.0),
        "momentum_max": all_of("momentum_max", np.inf, np.inf),
    }


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


def smallsat_flexible() -> tuple[Vehicle, Flexible]:
    """A spacecraft of 150 kg with four wheels of 0.1 N m and 1.5 N m s, and the first three modes of its two panels."""
    vehicle = pyramid4(
        J_B=((18.0, 0.2, -0.1), (0.2, 14.0, 0.3), (-0.1, 0.3, 12.0)), u_max=0.1, wheel_inertia=3e-3, momentum_max=1.5
    )
    delta = ((1.6, 0.0, 0.3), (0.2, 0.0, 1.1), (0.0, 0.5, 0.0))
    return vehicle, Flexible(delta=delta, omega=(4.4, 5.7, 9.4), xi=(0.005, 0.005, 0.005))


def twelve_thrusters() -> tuple[Vehicle, Thrusters]:
    """A 120 kg m^2 body with twelve thrusters of 1 N in pairs about each axis, 0.8 m out, and those thrusters.

    Pairs about +x, -x, +y, -y, +z, -z; a pair is a pure torque of 1.6 N m.
    """
    axes = np.eye(3)
    positions, directions = [], []
    for a in range(3):
        b, c = axes[(a + 1) % 3], axes[(a + 2) % 3]
        for s in (1.0, -1.0):
            for k in (1.0, -1.0):
                positions.append((0.8 * k * b).tolist())
                directions.append((s * k * c).tolist())
    thrusters = Thrusters(
        positions=positions, directions=directions, thrust=1.0, tick=1.0 / 64.0, min_on=2, min_off=2, Isp=220.0
    )
    return Vehicle(J_B=(120.0, 100.0, 110.0)), thrusters


def geo_thrusters() -> tuple[Vehicle, Thrusters]:
    """A geostationary body of 3200, 900, 3000 kg m^2, and twelve thrusters of 5 N in pairs about each axis, 1.2 m out.

    They stand around a point off the centre of mass: a pair turns, and pushes a little.
    """
    _, smaller = twelve_thrusters()
    thrusters = smaller.model_copy(
        update={
            "positions": tuple(tuple(1.5 * x for x in row) for row in smaller.positions),
            "centre_of_mass": (0.02, -0.03, 0.05),
            "thrust": 5.0,
            "tick": 0.005,
            "Isp": 285.0,
            "propellant_mass": 20.0,
        }
    )
    return Vehicle(J_B=((3200.0, 20.0, -15.0), (20.0, 900.0, 10.0), (-15.0, 10.0, 3000.0))), thrusters


def cmg4(
    *, J_B: Matrix | Vector = (120.0, 100.0, 120.0), rotor_momentum: float = 20.0, rate_max: float = 1.0
) -> tuple[Vehicle, ControlMomentGyros]:
    """Four control moment gyros on the pyramid of 54.74 deg, whose envelope is nearly a sphere, and the body they turn.

    The arrangement of most publications on singular gimbals (Kurokawa 1998; Wie 2008).
    """
    across, up = np.sqrt(2.0 / 3.0), np.sqrt(1.0 / 3.0)
    gimbal = ((across, 0.0, up), (0.0, across, up), (-across, 0.0, up), (0.0, -across, up))
    spin = ((0.0, 1.0, 0.0), (-1.0, 0.0, 0.0), (0.0, -1.0, 0.0), (1.0, 0.0, 0.0))
    gyros = ControlMomentGyros(gimbal_axes=gimbal, spin_axes=spin, rotor_momentum=rotor_momentum, rate_max=rate_max)
    return Vehicle(J_B=J_B), gyros


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
