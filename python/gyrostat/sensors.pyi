# SPDX-License-Identifier: MIT
# Generated from the catalogue by gyrostat.stubs.

from gyrostat.components import Component, Vector

def Gyro(
    *,
    noise: float | None = ...,
    bias: float | Vector | None = ...,
    quantisation: float | None = ...,
    delay: int | None = ...,
) -> Component:
    """The sensor 'gyro'.

    Parameters
    ----------
    noise
        white, one sigma a sample and axis; rad/s; [0, 100]; default 0.0
    bias
        constant, in body axes; rad/s; [-100, 100]; default [0.0, 0.0, 0.0]
    quantisation
        size of a step; 0: none; rad/s; [0, 100]; default 0.0
    delay
        age of what is measured; samples; [0, 1000]; default 0
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
