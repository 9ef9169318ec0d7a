# SPDX-License-Identifier: MIT
# Generated from the catalogue by gyrostat.stubs.

from gyrostat.components import Component

def LossOfEffectiveness(
    *,
    actuator: int,
    t_on: float | None = ...,
    t_off: float | None = ...,
    remaining: float | Component | None = ...,
) -> Component:
    """The fault 'loss_of_effectiveness'.

    Parameters
    ----------
    actuator
        which one, counted from 0; [0, 15]
    t_on
        onset; s; [0, inf]; default 0.0
    t_off
        end; infinity: permanent; s; [0, inf]; default inf
    remaining
        delivered / commanded; 1 is healthy, 0 delivers no command; [-2, 2]; default 0.5
    """

def Bias(
    *,
    actuator: int,
    t_on: float | None = ...,
    t_off: float | None = ...,
    torque: float | Component | None = ...,
) -> Component:
    """The fault 'bias'.

    Parameters
    ----------
    actuator
        which one, counted from 0; [0, 15]
    t_on
        onset; s; [0, inf]; default 0.0
    t_off
        end; infinity: permanent; s; [0, inf]; default inf
    torque
        added to what is delivered; N m; default 0.0
    """

def Stuck(
    *,
    actuator: int,
    t_on: float | None = ...,
    t_off: float | None = ...,
    torque: float | None = ...,
) -> Component:
    """The fault 'stuck'.

    Parameters
    ----------
    actuator
        which one, counted from 0; [0, 15]
    t_on
        onset; s; [0, inf]; default 0.0
    t_off
        end; infinity: permanent; s; [0, inf]; default inf
    torque
        delivered whatever is commanded; N m; default 0.0
    """

def HardOver(
    *,
    actuator: int,
    t_on: float | None = ...,
    t_off: float | None = ...,
    sign: float | None = ...,
) -> Component:
    """The fault 'hard_over'.

    Parameters
    ----------
    actuator
        which one, counted from 0; [0, 15]
    t_on
        onset; s; [0, inf]; default 0.0
    t_off
        end; infinity: permanent; s; [0, inf]; default inf
    sign
        positive: at the upper limit; negative: at the lower one; [-1, 1]; default 1.0
    """

def Dead(
    *,
    actuator: int,
    t_on: float | None = ...,
    t_off: float | None = ...,
) -> Component:
    """The fault 'dead'.

    Parameters
    ----------
    actuator
        which one, counted from 0; [0, 15]
    t_on
        onset; s; [0, inf]; default 0.0
    t_off
        end; infinity: permanent; s; [0, inf]; default inf
    """

def Lock(
    *,
    actuator: int,
    t_on: float | None = ...,
    t_off: float | None = ...,
) -> Component:
    """The fault 'lock'.

    Parameters
    ----------
    actuator
        which one, counted from 0; [0, 15]
    t_on
        onset; s; [0, inf]; default 0.0
    t_off
        end; infinity: permanent; s; [0, inf]; default inf
    """

def Drift(
    *,
    actuator: int,
    t_on: float | None = ...,
    t_off: float | None = ...,
    rate: float | None = ...,
) -> Component:
    """The fault 'drift'.

    Parameters
    ----------
    actuator
        which one, counted from 0; [0, 15]
    t_on
        onset; s; [0, inf]; default 0.0
    t_off
        end; infinity: permanent; s; [0, inf]; default inf
    rate
        growth of the bias; N m/s; default 0.0
    """

def Intermittent(
    *,
    actuator: int,
    t_on: float | None = ...,
    t_off: float | None = ...,
    period: float | None = ...,
    duty: float | None = ...,
    remaining: float | None = ...,
    torque: float | None = ...,
) -> Component:
    """The fault 'intermittent'.

    Parameters
    ----------
    actuator
        which one, counted from 0; [0, 15]
    t_on
        onset; s; [0, inf]; default 0.0
    t_off
        end; infinity: permanent; s; [0, inf]; default inf
    period
        of the faulty and healthy parts together; s; [1e-06, inf]; default 1.0
    duty
        fraction of a period that is faulty; [0, 1]; default 0.5
    remaining
        delivered / commanded while faulty; [-2, 2]; default 0.0
    torque
        added to what is delivered while faulty; N m; default 0.0
    """

def DeadZone(
    *,
    actuator: int,
    t_on: float | None = ...,
    t_off: float | None = ...,
    width: float | None = ...,
) -> Component:
    """The fault 'dead_zone'.

    Parameters
    ----------
    actuator
        which one, counted from 0; [0, 15]
    t_on
        onset; s; [0, inf]; default 0.0
    t_off
        end; infinity: permanent; s; [0, inf]; default inf
    width
        smallest command that is delivered; N m; [0, inf]; default 0.0
    """

def Leak(
    *,
    actuator: int,
    t_on: float | None = ...,
    t_off: float | None = ...,
    fraction: float | None = ...,
) -> Component:
    """The fault 'leak'.

    Parameters
    ----------
    actuator
        which one, counted from 0; [0, 15]
    t_on
        onset; s; [0, inf]; default 0.0
    t_off
        end; infinity: permanent; s; [0, inf]; default inf
    fraction
        of full thrust, while the valve is closed; [0, 1]; default 0.02
    """

def SlowValve(
    *,
    actuator: int,
    t_on: float | None = ...,
    t_off: float | None = ...,
    delay_open: float | None = ...,
    delay_close: float | None = ...,
) -> Component:
    """The fault 'slow_valve'.

    Parameters
    ----------
    actuator
        which one, counted from 0; [0, 15]
    t_on
        onset; s; [0, inf]; default 0.0
    t_off
        end; infinity: permanent; s; [0, inf]; default inf
    delay_open
        from the drive to the opening; s; [0, 1000]; default 0.02
    delay_close
        from the end of the drive to the closing; s; [0, 1000]; default 0.0
    """

def RotorSlowDown(
    *,
    actuator: int,
    t_on: float | None = ...,
    t_off: float | None = ...,
    rate: float | None = ...,
) -> Component:
    """The fault 'rotor_slow_down'.

    Parameters
    ----------
    actuator
        which one, counted from 0; [0, 15]
    t_on
        onset; s; [0, inf]; default 0.0
    t_off
        end; infinity: permanent; s; [0, inf]; default inf
    rate
        momentum that the rotor loses a second, > 0; N m; [0, inf]; default 0.0
    """
