# SPDX-License-Identifier: MIT
"""Campaigns: thousands of flights with drawn inputs and sampled faults. Page: docs/campaigns.md."""

from __future__ import annotations

from typing import TYPE_CHECKING

from gyrostat.lazy import loader

if TYPE_CHECKING:
    from gyrostat.campaign import dist
    from gyrostat.campaign.campaign import Campaign
    from gyrostat.campaign.catalogue import shipped
    from gyrostat.campaign.chunks import Chunk
    from gyrostat.campaign.comparing import Comparison, compare
    from gyrostat.campaign.flights import Outcome
    from gyrostat.campaign.inputs import Draws
    from gyrostat.campaign.joining import join
    from gyrostat.campaign.results import CampaignResult, CellCounts
    from gyrostat.campaign.running import State
    from gyrostat.campaign.sketches import Sketch
    from gyrostat.campaign.torque import torque_left

__all__ = [
    "Campaign",
    "CampaignResult",
    "CellCounts",
    "Chunk",
    "Comparison",
    "Draws",
    "Outcome",
    "Sketch",
    "State",
    "compare",
    "dist",
    "join",
    "shipped",
    "torque_left",
]

_home_of = {
    "Campaign": "campaign",
    "CampaignResult": "results",
    "CellCounts": "results",
    "Chunk": "chunks",
    "Comparison": "comparing",
    "Draws": "inputs",
    "Outcome": "flights",
    "Sketch": "sketches",
    "State": "running",
    "compare": "comparing",
    "join": "joining",
    "shipped": "catalogue",
    "torque_left": "torque",
}


# SciPy and PyArrow take half a second.
__getattr__ = loader(__name__, __all__, _home_of, globals())


def __dir__() -> list[str]:
    return __all__
