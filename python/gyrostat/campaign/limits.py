# SPDX-License-Identifier: MIT
"""Whole numbers: how many runs, threads, chunks, and seeds."""

from __future__ import annotations

from typing import Any

import numpy as np

from gyrostat.errors import InputError
from gyrostat.text import shown

MOST_RUNS = 2**31 - 1
"""Numbers of flights that an `Experiment` takes."""


def whole(name: str, number: Any, least: int = 0, most: int | None = None) -> int:
    """Refuse what is no whole number from `least` to `most`; without one, of runs."""
    bound = MOST_RUNS if most is None else most
    is_whole = isinstance(number, int | np.integer) and not isinstance(number, bool)
    if not is_whole or not least <= number <= bound:
        end = "on" if most is None and not (is_whole and number > bound) else f"to {bound}"
        raise InputError(f"{name} = {shown(number)}: a whole number from {least} {end} belongs here")
    return int(number)


__all__ = ["MOST_RUNS", "whole"]
