# SPDX-License-Identifier: MIT
"""The campaigns that come with the package: every one flies, and rows are what its scenarios fly."""

from __future__ import annotations

import pytest

import gyrostat as gs
from gyrostat.campaign import shipped


@pytest.mark.parametrize("name", sorted(shipped()))
def test_a_shipped_campaign_flies(name: str) -> None:
    made = gs.Campaign.load(name)
    chunk = made.fly(0, 2)
    assert sum(c["runs"] for c in chunk.counts.values()) == 2 * len(made.cells)
    assert all("refused" not in c["status"] for c in chunk.counts.values())
    assert made.has_margin
    row = chunk.table.to_pylist()[-1]
    scenario = made.scenario(row["run"], row["cell"])
    alone = gs.Experiment(scenario, measure=made.spec.measure).fly(runs=1, first=row["run"])
    for measure in made.measures:
        assert alone[measure][0] == row[measure] or alone[measure][0] != alone[measure][0]
    assert made.spec.name
    assert made.spec.description


def test_a_campaign_a_paper() -> None:
    papers = {"li2018", "cao2022", "cao2023", "wang2023", "yang2023"}
    own = {"five_stacks", "five_stacks_cubesat", "wheel_faults", "faulty_ftc", "faulty_ftc_hard", "faulty_cubesat"}
    assert papers | own == set(shipped())
