# SPDX-License-Identifier: MIT
"""Vehicles: what flight knows of one, and ready-made actuator layouts.

A key that is not given keeps the default of the C++ description; ``gyrostat describe vehicle`` lists them.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from gyrostat.components import Matrix, Vector
from gyrostat.model import Block, Leaf


class Vehicle(Block):
    """The nominal vehicle: all that flight knows of it.

    Parameters
    ----------
    J_B
        Inertia of the whole vehicle, wheels included, kg m^2: three rows, or three numbers for a diagonal one.
    D_B
        Actuator axes in columns, body frame: three rows of as many numbers as there are actuators (1 to 16). Not given
        where `Thrusters` are all there is; they come behind these.
    u_max, u_min
        Limits of the command, N m: a number or one an actuator. Without ``u_max`` flight knows no limit.
    u_rate
        Limit of the change of a command, N m/s.
    wheel_inertia
        Axial inertia of each wheel, kg m^2; 0: an ideal torque actuator.
    momentum_max
        Momentum at which a wheel gives no more, N m s, as flight knows it: a number or one an actuator. Truth has it
        too unless it states its own.
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
    spare: Leaf[tuple[int, ...] | list[int] | None] = None
    orbit_rate: Leaf[float | None] = None
    coordinates: Leaf[Literal["body", "euler_angles"] | None] = None

    @property
    def actuators(self) -> int:
        """Number of actuators, thrusters left out."""
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


def with_thrusters(tables: Mapping[str, Any]) -> dict[str, Any]:
    """The vehicle of a scenario's tables as if its thrusters stood in it: axes, limits, wheel inertia of all actuators.

    Parameters
    ----------
    tables
        ``vehicle``, and ``thrusters`` where there are some.
    """
    vehicle = dict(tables["vehicle"])
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
