# SPDX-License-Identifier: MIT
"""Functions of time: ``gyrostat.waveforms.Sine(offset=0.9, amplitude=0.07, omega=0.2)``.

One constructor a member of the catalogue's family ``waveform``; ``gyrostat list waveform`` names them.
"""

from __future__ import annotations

from gyrostat.components import constructors

_made = constructors("waveform", __name__)
globals().update(_made)
__all__ = list(_made)
