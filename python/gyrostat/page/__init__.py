# SPDX-License-Identifier: MIT
"""Pages that re-play runs in a browser: the body in motion, plots over time that move with it, metrics and scenario."""

from __future__ import annotations

from gyrostat.page.content import wanted_channels
from gyrostat.page.tables import metric_rows
from gyrostat.page.writer import MOST_RUNS, page_path, show, write_page
from gyrostat.scenario import Scenario


def channels(scenario: Scenario) -> list[str]:
    """What to record so that a page shows everything: the scenario's own choice and what a page draws."""
    record = scenario.record
    own = None if record is None or record.channels is None else list(record.channels)
    return wanted_channels([c["name"] for c in scenario.channel_names()], own)


__all__ = ["MOST_RUNS", "channels", "metric_rows", "page_path", "show", "write_page"]
