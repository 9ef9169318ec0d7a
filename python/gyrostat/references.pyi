# SPDX-License-Identifier: MIT
# Generated from the catalogue by gyrostat.stubs.
from typing import Literal

from gyrostat.components import Component, Matrix, Vector

def Hold(
    *,
    q_NR: Vector | None = ...,
    mrp: float | Vector | None = ...,
    euler: float | Vector | None = ...,
) -> Component:
    """The reference 'hold'.

    Parameters
    ----------
    q_NR
        attitude as a quaternion, scalar first; [-1, 1]; default [1.0, 0.0, 0.0, 0.0]
    mrp
        attitude as MRP, instead of q_NR
    euler
        attitude as roll, pitch, yaw, instead of q_NR; rad; [-6.28319, 6.28319]
    """

def Steps(
    *,
    times: Vector | None = ...,
    euler: Matrix | None = ...,
    mrp: Matrix | None = ...,
) -> Component:
    """The reference 'steps'.

    Parameters
    ----------
    times
        instants of the jumps, increasing; the first attitude holds before them too; s; >= 0; default []
    euler
        one row [roll, pitch, yaw] a time; rad; [-6.28319, 6.28319]; default []
    mrp
        one row a time, instead of euler; default []
    """

def Slew(
    *,
    duration: float,
    from_euler: float | Vector | None = ...,
    to_euler: float | Vector | None = ...,
    start: float | None = ...,
) -> Component:
    """The reference 'slew'.

    Parameters
    ----------
    duration
        how long it takes; s; >= 1e-09
    from_euler
        roll, pitch, yaw before; rad; [-6.28319, 6.28319]; default [0.0, 0.0, 0.0]
    to_euler
        roll, pitch, yaw after; rad; [-6.28319, 6.28319]; default [0.0, 0.0, 0.0]
    start
        when it begins; s; >= 0; default 0.0
    """

def MrpSine(
    *,
    offset: float | Vector | None = ...,
    amplitude: float | Vector | None = ...,
    frequency: float | Vector | None = ...,
    phase: float | Vector | None = ...,
) -> Component:
    """The reference 'mrp_sine'.

    Parameters
    ----------
    offset
        mean MRP; [-10, 10]; default [0.0, 0.0, 0.0]
    amplitude
        of each component; [-10, 10]; default [0.0, 0.0, 0.0]
    frequency
        of each component; rad/s; [-1000, 1000]; default [0.0, 0.0, 0.0]
    phase
        of each component; rad; default [0.0, 0.0, 0.0]
    """

def EulerSine(
    *,
    offset: float | Vector | None = ...,
    amplitude: float | Vector | None = ...,
    frequency: float | Vector | None = ...,
    phase: float | Vector | None = ...,
) -> Component:
    """The reference 'euler_sine'.

    Parameters
    ----------
    offset
        mean roll, pitch, yaw; rad; [-6.28319, 6.28319]; default [0.0, 0.0, 0.0]
    amplitude
        of each angle; rad; [-6.28319, 6.28319]; default [0.0, 0.0, 0.0]
    frequency
        of each angle; rad/s; [-1000, 1000]; default [0.0, 0.0, 0.0]
    phase
        of each angle; rad; default [0.0, 0.0, 0.0]
    """

def Sine(
    *,
    euler: float | Vector | None = ...,
    amplitude: float | Vector | None = ...,
    frequency: float | Vector | None = ...,
    phase: float | Vector | None = ...,
) -> Component:
    """The reference 'sine'.

    Parameters
    ----------
    euler
        roll, pitch, yaw at the start; rad; [-6.28319, 6.28319]; default [0.0, 0.0, 0.0]
    amplitude
        of each rate; rad/s; [-10, 10]; default [0.0, 0.0, 0.0]
    frequency
        of each rate; rad/s; [-1000, 1000]; default [0.0, 0.0, 0.0]
    phase
        of each rate; rad; default [0.0, 0.0, 0.0]
    """

def Table(
    *,
    times: Vector | None = ...,
    q_NR: Matrix | None = ...,
    omega_RN_R: Matrix | None = ...,
) -> Component:
    """The reference 'table'.

    Parameters
    ----------
    times
        of the rows, increasing, at least two; s; >= 0; default []
    q_NR
        one quaternion a time, scalar first; either sign; [-1.1, 1.1]; default []
    omega_RN_R
        one rate a time, in axes of the reference; absent: from the neighbouring rows; rad/s; [-10, 10]; default []
    """

def BangBang(
    *,
    angle: float,
    rate_max: float,
    acceleration_max: float,
    from_euler: float | Vector | None = ...,
    axis: float | Vector | None = ...,
    start: float | None = ...,
) -> Component:
    """The reference 'bang_bang'.

    Parameters
    ----------
    angle
        of the turn; rad; [1e-09, 6.28319]
    rate_max
        largest rate; rad/s; [1e-09, 10]
    acceleration_max
        acceleration and deceleration; rad/s^2; [1e-12, 100]
    from_euler
        roll, pitch, yaw before; rad; [-6.28319, 6.28319]; default [0.0, 0.0, 0.0]
    axis
        of the turn, in axes of the reference; of any length; default [0.0, 0.0, 1.0]
    start
        when it begins; s; >= 0; default 0.0
    """

def Nadir(
    *,
    q_OR: Vector | None = ...,
) -> Component:
    """The reference 'nadir'.

    Parameters
    ----------
    q_OR
        attitude in the orbital frame, scalar first; [-1, 1]; default [1.0, 0.0, 0.0, 0.0]
    """

def Target(
    *,
    latitude: float,
    longitude: float,
    altitude: float | None = ...,
    axis: float | Vector | None = ...,
    second_axis: float | Vector | None = ...,
) -> Component:
    """The reference 'target'.

    Parameters
    ----------
    latitude
        of the site, geocentric; rad; [-1.5708, 1.5708]
    longitude
        of the site, to the east of Greenwich; rad; [-6.28319, 6.28319]
    altitude
        of the site above the sphere; m; [-100000, 100000]; default 0.0
    axis
        of the reference, that points there; of any length; default [0.0, 0.0, 1.0]
    second_axis
        of the reference, as near to the second direction as it goes; default [1.0, 0.0, 0.0]
    """

def Sun(
    *,
    axis: float | Vector | None = ...,
    second_axis: float | Vector | None = ...,
) -> Component:
    """The reference 'sun'.

    Parameters
    ----------
    axis
        of the reference, that points there; of any length; default [0.0, 0.0, 1.0]
    second_axis
        of the reference, as near to the second direction as it goes; default [0.0, 1.0, 0.0]
    """

def TwoVector(
    *,
    first: Literal["nadir", "zenith", "velocity", "orbit_normal", "sun", "site"] | None = ...,
    second: Literal["nadir", "zenith", "velocity", "orbit_normal", "sun", "site"] | None = ...,
    axis: float | Vector | None = ...,
    second_axis: float | Vector | None = ...,
    latitude: float | None = ...,
    longitude: float | None = ...,
    altitude: float | None = ...,
) -> Component:
    """The reference 'two_vector'.

    Parameters
    ----------
    first
        where `axis` points; one of nadir, zenith, velocity, orbit_normal, sun, site; default nadir
    second
        where `second_axis` points as nearly as it can; one of nadir, zenith, velocity, orbit_normal, sun, site; default velocity
    axis
        of the reference, that points there; of any length; default [0.0, 0.0, 1.0]
    second_axis
        of the reference, as near to the second direction as it goes; default [1.0, 0.0, 0.0]
    latitude
        of the site, geocentric; rad; [-1.5708, 1.5708]; default 0.0
    longitude
        of the site, to the east of Greenwich; rad; [-6.28319, 6.28319]; default 0.0
    altitude
        of the site above the sphere; m; [-100000, 100000]; default 0.0
    """
