# SPDX-License-Identifier: MIT
"""Integrators of the truth: ``gyrostat.integrators.Rk4()``.

One constructor a member of the catalogue's family ``integrator``; ``gyrostat list integrator`` names them.
"""

from __future__ import annotations

from gyrostat.components import constructors

_made = constructors("integrator", __name__)
globals().update(_made)
__all__ = list(_made)
