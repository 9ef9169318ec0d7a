# SPDX-License-Identifier: MIT
"""Disturbance torques on the body: ``gyrostat.disturbances.Constant(torque_B=(1e-3, -2e-3, 1.5e-3))``.

One constructor a member of the catalogue's family ``disturbance``; ``gyrostat list disturbance`` names them.
"""

from __future__ import annotations

from gyrostat.components import constructors

_made = constructors("disturbance", __name__)
globals().update(_made)
__all__ = list(_made)
