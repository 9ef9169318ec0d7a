# SPDX-License-Identifier: MIT
"""Campaigns: thousands of flights with drawn inputs and sampled faults. Page: docs/campaigns.md."""

from gyrostat.campaign import dist
from gyrostat.campaign.campaign import Campaign, shipped
from gyrostat.campaign.chunks import Chunk
from gyrostat.campaign.flights import Outcome
from gyrostat.campaign.inputs import Draws
from gyrostat.campaign.joining import join
from gyrostat.campaign.results import CampaignResult, CellCounts
from gyrostat.campaign.running import State
from gyrostat.campaign.sketches import Sketch

__all__ = [
    "Campaign",
    "CampaignResult",
    "CellCounts",
    "Chunk",
    "Draws",
    "Outcome",
    "Sketch",
    "State",
    "dist",
    "join",
    "shipped",
]
