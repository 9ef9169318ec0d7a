# SPDX-License-Identifier: MIT
"""Typed actuator faults: ``gyrostat.faults.LossOfEffectiveness(actuator=2, t_on=30.0, remaining=0.4)``.

One constructor a member of the catalogue's family ``fault``; ``gyrostat list fault`` names them.
"""

from __future__ import annotations

from gyrostat.components import constructors

_made = constructors("fault", __name__)
globals().update(_made)
__all__ = list(_made)
