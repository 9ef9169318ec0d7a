# SPDX-License-Identifier: MIT
# Generated from the catalogue by gyrostat.stubs.
from collections.abc import Sequence

from gyrostat.components import Component, Matrix, Vector

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

def ResidualDipole(
    *,
    dipole_B: float | Vector | None = ...,
) -> Component:
    """The disturbance 'residual_dipole'.

    Parameters
    ----------
    dipole_B
        in body axes; A m^2; default [0.0, 0.0, 0.0]
    """

def Plates(
    *,
    area: Vector | None = ...,
    normal_B: Matrix | None = ...,
    centre_B: Matrix | None = ...,
    specular: Vector | None = ...,
    diffuse: Vector | None = ...,
    density: float | None = ...,
    altitude: float | None = ...,
    scale_height: float | None = ...,
    drag_coefficient: float | None = ...,
    solar_pressure: float | None = ...,
) -> Component:
    """The disturbance 'plates'.

    Parameters
    ----------
    area
        of each plate; m^2; [0, 1e+06]; default []
    normal_B
        of each plate, outward, a row a plate; [-1, 1]; default []
    centre_B
        of each plate, from the centre of mass; m; [-1000, 1000]; default []
    specular
        share of light that a plate reflects like a mirror; absent: 0; [0, 1]; default []
    diffuse
        share that it scatters; absent: 0; [0, 1]; default []
    density
        of the air; 0: none; kg/m^3; [0, 1]; default 0.0
    altitude
        at which it has this density; m; [0, 1e+08]; default 0.0
    scale_height
        over which it falls to 1/e; infinite: nowhere; m; [1, inf]; default inf
    drag_coefficient
        C_D; [0, 10]; default 2.2
    solar_pressure
        P, of sunlight; 0: none; N/m^2; [0, 1]; default 4.56e-06
    """
