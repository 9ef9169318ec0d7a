# SPDX-License-Identifier: MIT
# Generated from the catalogue by gyrostat.stubs.

from gyrostat.components import Component

def LossOfEffectiveness(
    *,
    actuator: int,
    remaining: float | Component,
    t_on: float | None = ...,
    t_off: float | None = ...,
) -> Component:
    """The fault 'loss_of_effectiveness'.

    Parameters
    ----------
    actuator
        which actuator, from 0; [0, 15]
    remaining
        fraction delivered; [0, 1]
    t_on
        onset; s; [0, inf]; default 0.0
    t_off
        end; s; [0, inf]; default inf
    """

def Bias(
    *,
    actuator: int,
    torque: float | Component,
    t_on: float | None = ...,
    t_off: float | None = ...,
) -> Component:
    """The fault 'bias'.

    Parameters
    ----------
    actuator
        which actuator, from 0; [0, 15]
    torque
        m; N m
    t_on
        onset; s; [0, inf]; default 0.0
    t_off
        end; s; [0, inf]; default inf
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
        which actuator, from 0; [0, 15]
    t_on
        onset; s; [0, inf]; default 0.0
    t_off
        end; s; [0, inf]; default inf
    """
