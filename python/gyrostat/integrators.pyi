# SPDX-License-Identifier: MIT
# Generated from the catalogue by gyrostat.stubs.

from gyrostat.components import Component

def Cvode(
    *,
    rtol: float | None = ...,
) -> Component:
    """The integrator 'cvode'.

    Parameters
    ----------
    rtol
        m; [1e-14, 0.01]; default 1e-09
    """

def Rk4(
    *,
    substeps: int | None = ...,
) -> Component:
    """The integrator 'rk4'.

    Parameters
    ----------
    substeps
        m; [1, 1000]; default 1
    """
