# SPDX-License-Identifier: MIT
"""What a campaign is: two folders hold the same campaign exactly when this is equal.

It is all that the numbers in the table depend on: the file with every default filled in, and the versions of what
computes. How many runs, on how many threads, in which chunks and where, is no part of it.
"""

from __future__ import annotations

import json
from functools import cache
from hashlib import sha256
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import scipy

from gyrostat import _core

if TYPE_CHECKING:
    from gyrostat.campaign.campaign import Campaign


def resolved(campaign: Campaign) -> dict[str, Any]:
    """The campaign with every default filled in, and what it was computed with."""
    tables = campaign.spec.model_dump()
    for said in ("name", "description"):
        tables.pop(said)
    components = {role: _name(c) for role, c in campaign.base.python_components().items()}
    cells = {label: cell.plain.resolve() | {"python": components} for label, cell in campaign.cells.items()}
    told = {
        "seed": campaign.spec.seed,
        "sampling": campaign.spec.sampling,
        "campaign": tables,
        "cells": cells,
        "gyrostat": _core.__version__,
        "core": core_hash(),
        "numpy": np.__version__,
        "scipy": scipy.__version__,
    }
    return dict(json.loads(canonical(told)))


def canonical(value: Any) -> str:
    """JSON of one form."""
    return json.dumps(value, sort_keys=True, separators=(",", ":"), default=_plain)


def identity(told: dict[str, Any]) -> str:
    """SHA-256 of the canonical JSON of `resolved`."""
    return sha256(canonical(told).encode()).hexdigest()


@cache
def core_hash() -> str:
    """SHA-256 of the compiled module."""
    return sha256(Path(str(_core.__file__)).read_bytes()).hexdigest()


def _plain(value: Any) -> Any:
    if isinstance(value, np.ndarray | np.generic):
        return value.tolist()
    return _name(value)


def _name(value: Any) -> Any:
    if isinstance(value, list):
        return [_name(v) for v in value]
    if isinstance(value, dict):
        return {str(k): _name(v) for k, v in value.items()}
    kind = type(value)
    return f"python:{kind.__module__}.{kind.__qualname__}"


__all__ = ["canonical", "core_hash", "identity", "resolved"]
