# SPDX-License-Identifier: MIT
"""What a search for rare failures leaves in its folder beside the margins: its result, as JSON, to be shown later."""

from __future__ import annotations

import json
import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from gyrostat.errors import InputError
from gyrostat.files import file_errors, write_text
from gyrostat.verification.rare import Level, LostFlight, Rare

SEARCHED = "rare.json"
"""In a folder: what was searched."""


@dataclass(frozen=True)
class Searched:
    """A finished search.

    Attributes
    ----------
    found
        Its result.
    campaign
        Name of the campaign that it flew.
    identity
        Of that campaign.
    cell
        Where there is a grid: which.
    seed
        Of the search.
    """

    found: Rare
    campaign: str
    identity: str
    cell: str | None
    seed: int

    def write(self, folder: Path) -> None:
        """Into a folder that is there."""
        told = {"campaign": self.campaign, "identity": self.identity, "cell": self.cell, "seed": self.seed}
        write_text(folder / SEARCHED, json.dumps(told | to_dict(self.found), indent=1) + "\n")

    @classmethod
    def read(cls, folder: Path) -> Searched | None:
        """What a folder holds; None if nothing was searched there.

        Raises
        ------
        InputError
            What is there is not what `write` wrote.
        """
        path = folder / SEARCHED
        if not path.exists():
            return None
        with file_errors(path, "cannot be read"):
            data = path.read_bytes()
        try:
            told = json.loads(data)
            cell = None if told["cell"] is None else str(told["cell"])
            return cls(_found(told), str(told["campaign"]), str(told["identity"]), cell, int(told["seed"]))
        except (ValueError, TypeError, KeyError, OverflowError):
            raise InputError(f"{path}: is not what gyrostat rare wrote; call it again") from None


def to_dict(found: Rare) -> dict[str, Any]:
    """As JSON holds it; what is no number is null."""
    return {
        "status": found.status,
        "probability": _number(found.probability),
        "interval": [_number(x) for x in found.interval],
        "bound": found.bound,
        "replicates": found.replicates.tolist(),
        "levels": [{k: _number(v) for k, v in vars(x).items()} for x in found.levels],
        "population": found.population,
        "flights": found.flights,
        "pilot": _number(found.pilot),
        "lost": [
            {"z": f.z.tolist(), "versions": f.versions.tolist(), "margin": f.margin, "number": f.number}
            for f in found.lost
        ],
    }


def _number(x: float) -> float | None:
    return x if math.isfinite(x) else None


def _finite(x: float | None) -> float:
    return math.nan if x is None else float(x)


def _found(told: dict[str, Any]) -> Rare:
    if told["status"] not in ("converged", "not converged", "stalled"):
        raise ValueError
    low, high = told["interval"]
    lost = [
        LostFlight(np.array(f["z"], float), np.array(f["versions"], np.uint64), float(f["margin"]), int(f["number"]))
        for f in told["lost"]
    ]
    levels = [
        Level(_finite(x["margin"]), bool(x["strict"]), *(_finite(x[k]) for k in ("step", "acceptance", "share")))
        for x in told["levels"]
    ]
    return Rare(
        told["status"],
        _finite(told["probability"]),
        (_finite(low), _finite(high)),
        float(told["bound"]),
        np.array(told["replicates"], float),
        tuple(levels),
        int(told["population"]),
        int(told["flights"]),
        _finite(told["pilot"]),
        tuple(lost),
    )


__all__ = ["SEARCHED", "Searched", "to_dict"]
