# SPDX-License-Identifier: MIT
"""The script of docs/clusters.md, as a scheduler would call it: any number of tasks gives the folder of one."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

import gyrostat as gs

SCRIPT = Path(__file__).parents[2] / "examples" / "05_campaign_on_slurm.sh"


@pytest.mark.parametrize("tasks", [1, 3, 9])
def test_a_job_array_flies_every_chunk_once(tasks: int, tmp_path: Path) -> None:
    tables = gs.Campaign.load("wheel_faults").to_dict()
    campaign = gs.Campaign.from_dict(tables | {"set": tables["set"] | {"duration": 6.0, "dt": 0.1}})
    campaign.to_toml(tmp_path / "campaign.toml")
    command = tmp_path / "gyrostat"
    command.write_text(f'#!/bin/sh\nexec {sys.executable} -m gyrostat "$@"\n')
    command.chmod(0o755)
    for task in range(tasks):
        told = {"SLURM_ARRAY_TASK_COUNT": str(tasks), "SLURM_ARRAY_TASK_ID": str(task), "CHUNK": "20"}
        path = f"{tmp_path}{os.pathsep}{os.environ['PATH']}"
        done = subprocess.run(
            ["bash", str(SCRIPT), "campaign.toml", "110", "flown"],
            cwd=tmp_path,
            env=os.environ | told | {"PATH": path},
            capture_output=True,
            text=True,
            timeout=120,
            check=False,
        )
        assert done.returncode == 0, done.stderr
    flown = gs.CampaignResult(tmp_path / "flown")
    assert [p.first for p in flown.parts()] == [0, 20, 40, 60, 80, 100]
    assert flown.table_hash == campaign.run(110, out=tmp_path / "here").table_hash
