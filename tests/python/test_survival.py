# SPDX-License-Identifier: MIT
"""The map of faults that are survived: cases whose verdict is known beforehand, and data that say what is drawn."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np
import pyarrow.parquet as pq
import pytest
from typer.testing import CliRunner

import gyrostat as gs
from gyrostat.allocation import attainable_set
from gyrostat.cli import app
from gyrostat.survival import Survival, survive

D_B = np.array([[1, 1, -1, -1], [1, -1, -1, 1], [1, 1, 1, 1]]) / np.sqrt(3.0)


@pytest.fixture(scope="module")
def scenario() -> gs.Scenario:
    """Four wheels, any three of which can point."""
    return gs.Scenario.load("wheel2_degraded").replace(
        duration=60.0, dt=0.05, integrator="rk4", **{"initial.mrp": [0.02, 0.01, -0.02]}
    )


@pytest.fixture(scope="module")
def singles(scenario: gs.Scenario) -> Survival:
    stacks = {
        "good": {"observer": "finite_time_disturbance", "controller": "integral_sliding_mode"},
        "idle": {"observer": "passthrough", "controller": "open_loop"},
    }
    return survive(scenario, stacks, kinds=["loss_of_effectiveness", "dead", "hard_over"], severities=[0.0, 0.5, 1.0])


def test_obvious_cases(singles: Survival) -> None:
    said = {(c.stack, c.first.kind, c.first.severity): c.verdict for c in singles.cases}
    assert len(singles.cases) == 2 * (1 + 4 * (3 + 1 + 1))
    assert said["good", "none", 0.0] == "saved"
    assert said["good", "loss_of_effectiveness", 0.0] == "saved"
    assert said["good", "loss_of_effectiveness", 0.5] == "saved"
    # one wheel at its limit takes all that the three others have along its axis
    assert {c.verdict for c in singles.cases if c.first.kind == "hard_over"} == {"impossible"}
    # nothing is commanded: nobody points, although anybody could
    idle = [c for c in singles.cases if c.stack == "idle" and c.first.kind != "hard_over"]
    assert {c.verdict for c in idle} == {"lost though possible"}
    assert all(c.status == "completed" and c.error > singles.limit for c in idle)


def test_each_actuator_has_the_faults_that_it_can_have(scenario: gs.Scenario) -> None:
    thrusters = gs.Scenario.load("twelve_thrusters").replace(duration=20.0)
    found = survive(thrusters, kinds=["bias", "leak"], severities=[1.0])
    assert [(c.first.kind, c.first.actuator) for c in found.cases[1:]] == [("leak", i) for i in range(12)]
    # two turn the vehicle each way about each axis: one that never closes takes its torque from the two against it
    assert {round(c.torque / found.cases[0].torque, 9) for c in found.cases[1:]} == {0.5}
    with pytest.raises(gs.InputError, match="no actuator can have leak"):
        survive(scenario, kinds=["leak"])


def test_the_torque_left_is_that_of_the_attainable_set(singles: Survival) -> None:
    for case in singles.cases:
        if case.first.kind == "hard_over":
            assert abs(case.torque) < 1e-12
            continue
        effectiveness = np.ones(4)
        if case.first.kind != "none":
            effectiveness[case.first.actuator] -= case.first.severity
        left = attainable_set(D_B, 0.2, effectiveness=effectiveness).in_every_direction
        assert case.torque == pytest.approx(left, rel=1e-9)
    # the constant disturbance of the scenario
    assert singles.needed == pytest.approx(np.linalg.norm([0.001, -0.002, 0.0015]), rel=1e-6)


def test_two_dead_wheels_of_four_are_impossible_and_one_of_three(scenario: gs.Scenario) -> None:
    found = survive(scenario, kinds=["dead"], second=True)
    assert len(found.cases) == 1 + 4 + 12
    pairs = [c for c in found.cases if c.second.kind != "none"]
    assert {c.verdict for c in pairs} <= {"impossible", "saved though impossible"}
    assert all(c.torque <= found.needed for c in pairs)
    assert {c.verdict for c in found.cases if c.second.kind == "none"} == {"saved"}
    three = gs.Scenario(
        vehicle=gs.Vehicle(J_B=(20.0, 17.0, 15.0), D_B=np.eye(3).tolist(), u_max=0.2, wheel_inertia=0.05),
        initial=gs.Initial(mrp=(0.1, 0.2, -0.1), omega_BN_B=(0.02, 0.02, 0.02)),
        observer="passthrough", controller="mrp_feedback", duration=60.0, dt=0.05, integrator="rk4",
    )  # fmt: skip
    two_dead = survive(three, kinds=["dead"], second=True)
    assert {c.verdict for c in two_dead.cases if c.second.kind != "none"} == {"impossible"}
    assert len([c for c in two_dead.cases if c.second.kind != "none"]) == 6


def test_data_and_picture_say_the_same(singles: Survival, tmp_path: Path) -> None:
    singles.save(tmp_path)
    table = pq.read_table(tmp_path / "survival.parquet")
    assert table.column("verdict").to_pylist() == [c.verdict for c in singles.cases]
    with (tmp_path / "survival.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert [(r["stack"], r["first.kind"], int(r["first.actuator"])) for r in rows] == [
        (c.stack, c.first.kind, c.first.actuator) for c in singles.cases
    ]
    assert [float(r["error"]) for r in rows] == [c.error for c in singles.cases]
    from matplotlib.image import imread

    picture = imread(tmp_path / "survival.png")[..., :3]
    for color, n in zip(("#2b8a3e", "#e8890c", "#868e96"), (8, 17, 4), strict=True):
        rgb = [int(color[i : i + 2], 16) / 255 for i in (1, 3, 5)]
        assert int(np.all(np.abs(picture - rgb) < 0.01, axis=2).sum()) > 200 * n


def test_the_command_and_bad_input(scenario: gs.Scenario, tmp_path: Path) -> None:
    scenario.replace(duration=10.0).to_toml(tmp_path / "short.toml")
    call = ["survive", str(tmp_path / "short.toml"), "--kind", "dead", "--out", str(tmp_path / "map")]
    done = CliRunner().invoke(app, [*call, "--vary", "controller=mrp_feedback,open_loop"])
    assert done.exit_code == 0, done.output
    assert "controller=open_loop" in done.output
    assert sorted(p.name for p in (tmp_path / "map").iterdir()) == ["survival.csv", "survival.parquet", "survival.png"]
    for changes, says in (
        (["--kind", "dad"], "no kind 'dad'"),
        (["--severities", "2"], "severities from 0 to 1"),
        (["--severities", "x"], "--severities x: numbers"),
        (["--stacks", "wheel_faults"], "has no grid 'stack'"),
        (["--limit", "0"], "limit must be above 0 rad"),
    ):
        other = [*call[:-1], str(tmp_path / "no")]
        done = CliRunner().invoke(app, [*other, *changes])
        assert isinstance(done.exception, gs.InputError), done.output
        assert says in str(done.exception)
        assert not (tmp_path / "no").exists()
    with pytest.raises(gs.InputError, match="an actuator without limit"):
        survive(scenario.replace(**{"vehicle.u_max": float("inf")}))
