# SPDX-License-Identifier: MIT
"""Names that components had before. They are understood for one version more, with a warning.

Whatever names a component comes by here: `gyrostat.observer` and its like, scenario and campaign files, ``--set``, the
scenario inside a saved result, `gyrostat describe`.
"""

from __future__ import annotations

import sys
import warnings

UNTIL = "0.3"
"""The version that no longer knows them."""

RENAMED = {
    "adaptive_sliding_mode": "adaptive_sliding_mode_effectiveness",
    "mixed_learning": "mixed_learning_disturbance",
}
"""Old name -> name. An old name must not be that of another component."""


def current(name: str) -> str:
    """The name that a component has now.

    Warns
    -----
    FutureWarning
        `name` is an old one.
    """
    if name not in RENAMED:
        return name
    text = f"'{name}' is called '{RENAMED[name]}' now; the old name is understood until version {UNTIL}"
    warnings.warn(text, FutureWarning, stacklevel=_callers())
    return RENAMED[name]


def _callers() -> int:
    """Level of the first frame of the caller's own, so that the warning names the line that is to be changed."""
    level, frame = 1, sys._getframe(1)
    while frame.f_back is not None and frame.f_globals.get("__name__", "").partition(".")[0] in (
        "gyrostat",
        "pydantic",
    ):
        level, frame = level + 1, frame.f_back
    return level
