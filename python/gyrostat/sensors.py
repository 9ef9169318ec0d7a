# SPDX-License-Identifier: MIT
"""Sensors and their errors: ``gyrostat.sensors.Gyro(noise=1e-5)``.

One constructor a member of the catalogue's family ``sensor``; ``gyrostat list sensor`` names them.
"""

from __future__ import annotations

from gyrostat.components import constructors

_made = constructors("sensor", __name__)
globals().update(_made)
__all__ = list(_made)
