# SPDX-License-Identifier: MIT
"""Whole numbers that say how many runs, threads, chunks."""

from __future__ import annotations

from typing import Any

import numpy as np

from gyrostat.errors import InputError
from gyrostat.text import shown

MOST_RUNS = 2**31 - 1
"""Numbers of flights that an `Experiment` takes."""


def whole(name: str, number: Any, least: int = 0) -> int:
    """Refuse what is no whole number of runs."""
    if isinstance(number, bool) or not isinstance(number, int | np.integer) or not least <= number <= MOST_RUNS:
        most = f"to {MOST_RUNS}" if isinstance(number, int | np.integer) and number > MOST_RUNS else "on"
        raise InputError(f"{name} = {shown(number)}: a whole number from {least} {most} belongs here")
    return int(number)


__all__ = ["MOST_RUNS", "whole"]
