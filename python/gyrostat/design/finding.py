# SPDX-License-Identifier: MIT
"""What a design check says about a scenario."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Finding:
    """One line of ``gyrostat check``."""

    where: str
    """What was looked at, e.g. ``observer mixed_learning_disturbance``."""
    name: str
    """Short name of the condition or number, e.g. ``m14``."""
    text: str
    """What was found, with its numbers and units, for a reader."""
    ok: bool | None = None
    """Whether the condition holds; None: a number to know, no verdict."""
    value: float | None = None
    """The number itself, SI."""
    limit: float | None = None
    """What it was held to."""


__all__ = ["Finding"]
