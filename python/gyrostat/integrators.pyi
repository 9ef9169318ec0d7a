# SPDX-License-Identifier: MIT
# Generated from the catalogue by gyrostat.stubs.

from gyrostat.components import Component

def Cvode(
    *,
    rtol: float | None = ...,
    atol: float | None = ...,
) -> Component:
    """The integrator 'cvode'.

    Parameters
    ----------
    rtol
        relative tolerance of a step; [1e-15, 0.01]; default 1e-09
    atol
        absolute tolerance of a step, of quaternion and momentum (N m s); [1e-20, 0.01]; default 1e-12
    """

def Rk4(
    *,
    substeps: int | None = ...,
) -> Component:
    """The integrator 'rk4'.

    Parameters
    ----------
    substeps
        at least so many steps a sample; [1, 100000]; default 1
    """

def Auto(
    *,
    rtol: float | None = ...,
    atol: float | None = ...,
) -> Component:
    """The integrator 'auto'.

    Parameters
    ----------
    rtol
        error of a step, relative to the quaternion and to the largest momentum; [1e-15, 0.01]; default 1e-09
    atol
        error of a step, of quaternion and momentum (N m s); [1e-20, 0.01]; default 1e-15
    """
