# SPDX-License-Identifier: MIT
# Generated from the catalogue by gyrostat.stubs.

from gyrostat.components import Component, Vector

def Hold(
    *,
    q_NR: Vector | None = ...,
) -> Component:
    """The reference 'hold'.

    Parameters
    ----------
    q_NR
        m; default [1.0, 0, 0, 0]
    """
