# SPDX-License-Identifier: MIT
"""The campaigns that come with the package: every one flies, and rows are what its scenarios fly."""

from __future__ import annotations

from pathlib import Path

import pytest

import gyrostat as gs
from gyrostat.campaign import shipped
from gyrostat.verification import requirements


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
    assert papers | own | {"single_fault_ftc", "single_fault_cubesat"} == set(shipped())


@pytest.mark.parametrize("name", sorted(requirements.shipped()))
def test_shipped_requirements_are_on_the_recommended_stack_and_hold_so_far(name: str, tmp_path: Path) -> None:
    """600 flights decide the easy ones; docs/figures/requirements.csv holds all verdicts."""
    report = gs.verify(name, tmp_path, runs=600)
    campaign = gs.CampaignResult(tmp_path).campaign
    stack = {role: getattr(campaign.base, role) for role in gs.recommended()}
    assert stack == gs.recommended()
    outcomes = {j.name: j.verdict.outcome for j in report.judgements}
    assert outcomes["PNT-1"] == "UNDECIDED"  # 3787 flights without a loss are the fewest
    assert outcomes["PNT-3"] == "PASS"
    assert "FAIL" not in outcomes.values()
    assert all(j.requirement.text for j in report.judgements)


def test_requirements_that_are_not_there_are_named() -> None:
    with pytest.raises(gs.InputError, match="no requirements 'pointing_ft', did you mean 'pointing_ftc'"):
        requirements.RequirementFile.load("pointing_ft")
