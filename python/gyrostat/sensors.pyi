# SPDX-License-Identifier: MIT
# Generated from the catalogue by gyrostat.stubs.

from gyrostat.components import Component, Matrix, Vector

def Gyro(
    *,
    noise: float | None = ...,
    bias: float | Vector | None = ...,
    quantisation: float | None = ...,
    delay: int | None = ...,
    angle_random_walk: float | None = ...,
    rate_random_walk: float | None = ...,
    scale_factor: float | Vector | None = ...,
    misalignment: float | Vector | Matrix | None = ...,
    range: float | None = ...,
    every: int | None = ...,
    phase: int | None = ...,
    dropouts: Matrix | None = ...,
) -> Component:
    """The sensor 'gyro'.

    Parameters
    ----------
    noise
        white, one sigma a sample and axis; rad/s; [0, 100]; default 0.0
    bias
        at the start, in body axes; rad/s; [-100, 100]; default [0.0, 0.0, 0.0]
    quantisation
        size of a step; 0: none; rad/s; [0, 100]; default 0.0
    delay
        age of what is measured; samples; [0, 1000]; default 0
    angle_random_walk
        white noise, instead of `noise`: one sigma times sqrt(every dt); rad/sqrt(s); [0, 100]; default 0.0
    rate_random_walk
        of the bias: one sigma over sqrt(dt); rad/s^1.5; [0, 100]; default 0.0
    scale_factor
        relative error of each axis; [-0.5, 0.5]; default [0.0, 0.0, 0.0]
    misalignment
        what an axis (row) shows of the others (columns); zero diagonal; [-0.5, 0.5]; default [[0.0, 0.0, 0.0], [0.0, 0.0, 0.0], [0.0, 0.0, 0.0]]
    range
        largest rate shown; with an axis beyond it the rate is not valid; rad/s; [1e-09, inf]; default inf
    every
        from one rate to the next; samples; [1, 1e+06]; default 1
    phase
        tick of the first rate; samples; [0, 1e+06]; default 0
    dropouts
        rows [t_on, t_off] in which nothing is measured; s; [0, inf]; default []
    """

def Attitude(
    *,
    noise: float | None = ...,
    quantisation: float | None = ...,
    delay: int | None = ...,
) -> Component:
    """The sensor 'attitude'.

    Parameters
    ----------
    noise
        white, one sigma a sample and axis of the error rotation; rad; [0, 1]; default 0.0
    quantisation
        step of the angle near zero rotation (quaternion elements: half of it); 0: none; rad; [0, 1]; default 0.0
    delay
        age of what is measured; samples; [0, 1000]; default 0
    """

def StarTracker(
    *,
    noise: float | Vector | None = ...,
    q_BS: Vector | None = ...,
    latency: int | None = ...,
    every: int | None = ...,
    phase: int | None = ...,
    blind: Matrix | None = ...,
    rate_max: float | None = ...,
    sun_keepout: float | None = ...,
    earth_keepout: float | None = ...,
    outlier_probability: float | None = ...,
    outlier_angle: float | None = ...,
    flip_sign: bool | None = ...,
) -> Component:
    """The sensor 'star_tracker'.

    Parameters
    ----------
    noise
        white, one sigma a fix across (x, y) and about (z) the boresight; rad; [0, 1]; default [0.0, 0.0, 0.0]
    q_BS
        mounting: axes of the tracker, boresight z; scalar first; [-1.1, 1.1]; default [1.0, 0.0, 0.0, 0.0]
    latency
        age of what is shown; no fix until it has filled; samples; [0, 1000]; default 0
    every
        from one fix to the next; samples; [1, 1e+06]; default 1
    phase
        tick of the first fix; samples; [0, 1e+06]; default 0
    blind
        rows [t_on, t_off] in which no star is seen; s; [0, inf]; default []
    rate_max
        body rate above which no star is seen; rad/s; [0, inf]; default inf
    sun_keepout
        angle from the sun below which no star is seen; 0: none; rad; [0, 3.14159]; default 0.0
    earth_keepout
        angle from the edge of the Earth below which no star is seen; 0: none; rad; [0, 3.14159]; default 0.0
    outlier_probability
        of a fix that is wrong and called valid; [0, 1]; default 0.0
    outlier_angle
        turn of an outlier, about an axis drawn from the sphere; rad; [0, 3.14159]; default 0.0
    flip_sign
        give q or -q, drawn for each fix; default False
    """

def SunSensor(
    *,
    noise: float | None = ...,
    boresight_B: float | Vector | None = ...,
    field_of_view: float | None = ...,
    every: int | None = ...,
    phase: int | None = ...,
    blind: Matrix | None = ...,
) -> Component:
    """The sensor 'sun_sensor'.

    Parameters
    ----------
    noise
        white, one sigma a sample and axis of the unit vector; rad; [0, 1]; default 0.0
    boresight_B
        middle of the field of view, of any length; [-1e+12, 1e+12]; default [0.0, 0.0, 1.0]
    field_of_view
        half-angle of the cone in which the sun is seen; pi: everywhere; rad; [0, 3.14159]; default 3.141592653589793
    every
        from one direction to the next; samples; [1, 1e+06]; default 1
    phase
        tick of the first direction; samples; [0, 1e+06]; default 0
    blind
        rows [t_on, t_off] in which nothing is seen; s; [0, inf]; default []
    """

def Magnetometer(
    *,
    noise: float | None = ...,
    offset: float | Vector | None = ...,
    every: int | None = ...,
    phase: int | None = ...,
    blind: Matrix | None = ...,
) -> Component:
    """The sensor 'magnetometer'.

    Parameters
    ----------
    noise
        white, one sigma a sample and axis; T; [0, 0.001]; default 0.0
    offset
        of the vehicle's own magnetism, in body axes; T; [-0.001, 0.001]; default [0.0, 0.0, 0.0]
    every
        from one field to the next; samples; [1, 1e+06]; default 1
    phase
        tick of the first field; samples; [0, 1e+06]; default 0
    blind
        rows [t_on, t_off] in which nothing is measured; s; [0, inf]; default []
    """

def Tachometer(
    *,
    noise: float | None = ...,
    quantisation: float | None = ...,
    delay: int | None = ...,
) -> Component:
    """The sensor 'tachometer'.

    Parameters
    ----------
    noise
        white, one sigma a sample and wheel; N m s; [0, 1e+06]; default 0.0
    quantisation
        size of a step; 0: none; N m s; [0, 1e+06]; default 0.0
    delay
        age of what is measured; samples; [0, 1000]; default 0
    """

def RateBias(
    *,
    t_on: float | None = ...,
    t_off: float | None = ...,
    bias: float | Vector | None = ...,
) -> Component:
    """The sensor 'rate_bias'.

    Parameters
    ----------
    t_on
        onset; s; [0, inf]; default 0.0
    t_off
        end; infinity: permanent; s; [0, inf]; default inf
    bias
        added to each axis; rad/s; [-100, 100]; default [0.0, 0.0, 0.0]
    """

def RateFreeze(
    *,
    t_on: float | None = ...,
    t_off: float | None = ...,
) -> Component:
    """The sensor 'rate_freeze'.

    Parameters
    ----------
    t_on
        onset; s; [0, inf]; default 0.0
    t_off
        end; infinity: permanent; s; [0, inf]; default inf
    """

def RateScale(
    *,
    t_on: float | None = ...,
    t_off: float | None = ...,
    scale: float | Vector | None = ...,
) -> Component:
    """The sensor 'rate_scale'.

    Parameters
    ----------
    t_on
        onset; s; [0, inf]; default 0.0
    t_off
        end; infinity: permanent; s; [0, inf]; default inf
    scale
        factor of each axis; 1 is healthy; [-1000, 1000]; default [1.0, 1.0, 1.0]
    """

def RateDropout(
    *,
    t_on: float | None = ...,
    t_off: float | None = ...,
) -> Component:
    """The sensor 'rate_dropout'.

    Parameters
    ----------
    t_on
        onset; s; [0, inf]; default 0.0
    t_off
        end; infinity: permanent; s; [0, inf]; default inf
    """

def AttitudeDropout(
    *,
    t_on: float | None = ...,
    t_off: float | None = ...,
) -> Component:
    """The sensor 'attitude_dropout'.

    Parameters
    ----------
    t_on
        onset; s; [0, inf]; default 0.0
    t_off
        end; infinity: permanent; s; [0, inf]; default inf
    """

def MomentumDropout(
    *,
    t_on: float | None = ...,
    t_off: float | None = ...,
) -> Component:
    """The sensor 'momentum_dropout'.

    Parameters
    ----------
    t_on
        onset; s; [0, inf]; default 0.0
    t_off
        end; infinity: permanent; s; [0, inf]; default inf
    """
