# SPDX-License-Identifier: MIT
# Generated from the catalogue by gyrostat.stubs.

from gyrostat.components import Component

def Gyro(
    *,
    noise: float | None = ...,
) -> Component:
    """The sensor 'gyro'.

    Parameters
    ----------
    noise
        m; rad/s; [0, 1]; default 0.0
    """
