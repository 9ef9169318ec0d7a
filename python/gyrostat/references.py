# SPDX-License-Identifier: MIT
"""Attitudes to follow: ``gyrostat.references.Hold()``.

One constructor a member of the catalogue's family ``reference``; ``gyrostat list reference`` names them.
"""

from __future__ import annotations

from gyrostat.components import constructors

_made = constructors("reference", __name__)
globals().update(_made)
__all__ = list(_made)
