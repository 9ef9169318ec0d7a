# SPDX-License-Identifier: MIT
# Generated from the catalogue by gyrostat.stubs.
from collections.abc import Sequence

from gyrostat.components import Component, Vector

def Constant(
    *,
    torque_B: float | Vector,
) -> Component:
    """The disturbance 'constant'.

    Parameters
    ----------
    torque_B
        m; N m
    """

def Periodic(
    *,
    torque_B: Sequence[float | Component],
) -> Component:
    """The disturbance 'periodic'.

    Parameters
    ----------
    torque_B
        m; N m
    """
