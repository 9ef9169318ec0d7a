# SPDX-License-Identifier: MIT
# Generated from the catalogue by gyrostat.stubs.
from collections.abc import Sequence

from gyrostat.components import Component, Vector

def Constant(
    *,
    torque_B: float | Vector | None = ...,
) -> Component:
    """The disturbance 'constant'.

    Parameters
    ----------
    torque_B
        in body axes; N m; default [0.0, 0.0, 0.0]
    """

def Periodic(
    *,
    torque_B: Sequence[float | Component] | None = ...,
) -> Component:
    """The disturbance 'periodic'.

    Parameters
    ----------
    torque_B
        one waveform a body axis; N m; default [0.0, 0.0, 0.0]
    """

def GravityGradient() -> Component:
    """The disturbance 'gravity_gradient'."""

def RatePhase(
    *,
    gain: float | None = ...,
    offset_B: float | Vector | None = ...,
    axis: Vector | None = ...,
    amplitude: Vector | None = ...,
    multiple: Vector | None = ...,
    phase: Vector | None = ...,
) -> Component:
    """The disturbance 'rate_phase'.

    Parameters
    ----------
    gain
        phase rate per body rate; default 10.0
    offset_B
        constant part, in body axes; N m; default [0.0, 0.0, 0.0]
    axis
        body axis of each term; [0, 2]; default []
    amplitude
        of each term; N m; default []
    multiple
        of gain |omega| t, in each term; default []
    phase
        of each term; pi/2 makes a cosine; rad; default []
    """

def RateScaled(
    *,
    at_rest: float | None = ...,
    growth: float | None = ...,
    wave_B: Sequence[float | Component] | None = ...,
) -> Component:
    """The disturbance 'rate_scaled'.

    Parameters
    ----------
    at_rest
        factor at zero rate; N m; default 0.0
    growth
        of the factor with the squared rate; N m s^2/rad^2; default 0.0
    wave_B
        one waveform a body axis; default [0.0, 0.0, 0.0]
    """
