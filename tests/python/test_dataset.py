# SPDX-License-Identifier: MIT
"""Labelled data sets: what is written is what was flown, and scores of declarations that are known."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pyarrow.parquet as pq
import pytest
from typer.testing import CliRunner

import gyrostat as gs
from gyrostat import dataset
from gyrostat.cli import app

RUNS = 6
GYRO = [{"type": "gyro", "noise": 1e-6}]
REMAINING = {"dist": "uniform", "low": 0.0, "high": 0.5}
TABLES: dict[str, Any] = {
    "base": "wheel2_degraded",
    "set": {"duration": 12.0, "dt": 0.05, "integrator": "rk4", "faults": [], "sensors": GYRO},
    "seed": 3,
    "vary": {"initial.omega_BN_B": {"dist": "normal", "mean": 0.0, "std": 0.01, "each": 3}},
    "fault": [
        {
            "name": "wheel",
            "probability": 0.7,
            "actuator": {"dist": "choice", "of": [0, 1, 2, 3]},
            "t_on": {"dist": "uniform", "low": 2.0, "high": 6.0},
            "kind": [
                {"weight": 0.5, "type": "loss_of_effectiveness", "remaining": REMAINING},
                {"weight": 0.5, "type": "dead"},
            ],
        }
    ],
}  # fmt: skip


@pytest.fixture(scope="module")
def campaign() -> gs.Campaign:
    return gs.Campaign.from_dict(TABLES)


@pytest.fixture(scope="module")
def folder(campaign: gs.Campaign, tmp_path_factory: pytest.TempPathFactory) -> Path:
    return dataset.make(campaign, RUNS, tmp_path_factory.mktemp("sets") / "set")


def labels(folder: Path) -> list[dict[str, Any]]:
    return list(pq.read_table(folder / "labels.parquet").to_pylist())


def test_samples_and_labels_are_those_of_the_flights(campaign: gs.Campaign, folder: Path) -> None:
    table = pq.read_table(folder / "samples.parquet").to_pandas()
    drawn = campaign.draws(0, RUNS)
    found = {row["run"]: row for row in labels(folder)}
    assert 0 < len(found) < RUNS  # some flights have none
    for run in range(RUNS):
        flown = campaign.scenario(run).run(channels=["measurement.omega_BN_B", "allocation.u"])
        mine = table[table.run == run]
        assert np.array_equal(mine.t, flown.t)
        for i in range(3):
            assert np.array_equal(mine[f"measurement.omega_BN_B.{i}"], flown["measurement.omega_BN_B"][:, i])
        assert np.array_equal(mine["allocation.u.3"], flown["allocation.u"][:, 3])
        kind = drawn["fault.wheel.0.kind"][run]
        assert (kind != "none") == (run in found)
        if kind != "none":
            row = found[run]
            assert (row["kind"], row["actuator"]) == (kind, drawn["fault.wheel.0.actuator"][run])
            assert row["t_on"] == drawn["fault.wheel.0.t_on"][run]
            lost = 1.0 if kind == "dead" else 1.0 - drawn["fault.wheel.0.loss_of_effectiveness.remaining"][run]
            assert row["severity"] == pytest.approx(lost, rel=1e-12)


def test_a_leak_is_as_severe_as_the_thrust_that_leaks(tmp_path: Path) -> None:
    leak = {"type": "leak", "actuator": 3, "t_on": 2.0, "fraction": 0.3}
    scenario = gs.Scenario.load("twelve_thrusters").replace(duration=5.0, faults=[leak])
    (row,) = labels(dataset.make(gs.Campaign(scenario), 1, tmp_path / "set"))
    assert (row["kind"], row["actuator"], row["severity"]) == ("leak", 3, 0.3)


def test_one_seed_makes_the_same_set(campaign: gs.Campaign, folder: Path, tmp_path: Path) -> None:
    again = dataset.make(campaign, RUNS, tmp_path / "again")
    for name in ("samples.parquet", "labels.parquet", "flights.parquet", "dataset.json"):
        assert (again / name).read_bytes() == (folder / name).read_bytes()


def test_a_perfect_detector_and_a_nervous_one(folder: Path) -> None:
    rows = labels(folder)
    perfect = [(r["run"], r["t_on"] + 0.5, 1 << r["actuator"]) for r in rows]
    nervous = [*perfect[1:], *((run, 0.5, 1) for run in range(RUNS))]
    found = dataset.score(folder, declared={"perfect": perfect, "nervous": nervous})
    good, bad = found.scores
    hours = RUNS * 12.0 / 3600.0
    assert (good.count("isolated"), good.false_alarms) == (len(rows), 0)
    assert good.delay == pytest.approx(0.5)
    assert np.array_equal(np.diag(good.isolation[:, :4]), np.bincount([r["actuator"] for r in rows], minlength=4))
    assert good.isolation.sum() == len(rows)
    assert (bad.count("missed"), bad.false_alarms) == (1, RUNS)
    assert bad.false_alarms_per_hour == pytest.approx(RUNS / hours)
    assert found.faults == len(rows)
    assert found.silent <= len(rows)


def test_the_catalogue_is_the_baseline(folder: Path) -> None:
    found = dataset.score(folder, observers=["learning_effectiveness", "joint_kalman"], detectors=["threshold"])
    assert [s.name for s in found.scores] == ["learning_effectiveness + threshold", "joint_kalman + threshold"]
    for s in found.scores:
        assert s.refused is None
        assert len(s.changes) == len(labels(folder)) == s.isolation.sum()
    assert sum(s.count("isolated") + s.count("ambiguous") + s.count("wrong") for s in found.scores) > 0


def test_a_scenario_is_a_source_and_commands_say_it(tmp_path: Path) -> None:
    scenario = gs.Scenario.load("wheel2_degraded").replace(duration=22.0, dt=0.1, integrator="rk4")
    scenario.to_toml(tmp_path / "mine.toml")
    done = CliRunner().invoke(
        app, ["dataset", str(tmp_path / "mine.toml"), "--runs", "2", "--out", str(tmp_path / "s")]
    )
    assert done.exit_code == 0, done.output
    assert [(r["run"], r["actuator"], r["t_on"]) for r in labels(tmp_path / "s")] == [(0, 2, 20.0), (1, 2, 20.0)]
    (tmp_path / "mine.csv").write_text("run,t,mask\n0,20.5,4\n1,1.0,4\n")
    done = CliRunner().invoke(app, ["dataset", "score", str(tmp_path / "s"), "--declared", str(tmp_path / "mine.csv")])
    assert done.exit_code == 0, done.output
    line = next(line for line in done.output.splitlines() if line.strip().startswith("mine"))
    assert line.split()[1:5] == ["1", "0", "0", "1"]  # isolated, ambiguous, wrong, missed
    assert "not identifiable within 4 s: of 2 faults" in done.output


def test_faults_that_contradict_are_a_refused_flight(tmp_path: Path) -> None:
    one = {"probability": 0.6, "actuator": 1, "t_on": 3.0}
    both = [one | {"name": "a", "kind": [{"type": "dead"}]}, one | {"name": "b", "kind": [{"type": "lock"}]}]
    campaign = gs.Campaign.from_dict(TABLES | {"fault": both})
    kinds = campaign.draws(0, 12)
    twice = (kinds["fault.a.0.kind"] != "none") & (kinds["fault.b.0.kind"] != "none")
    assert 0 < twice.sum() <= 6
    folder = dataset.make(campaign, 12, tmp_path / "set")
    flights = pq.read_table(folder / "flights.parquet").to_pandas()
    assert np.array_equal(flights.status == "refused", twice)
    assert set(pq.read_table(folder / "samples.parquet").column("run").to_pylist()) == set(np.flatnonzero(~twice))
    perfect = [(r["run"], r["t_on"] + 0.5, 1 << r["actuator"]) for r in labels(folder)]
    (told,) = dataset.score(folder, declared={"perfect": perfect}).scores
    assert told.count("isolated") == len(perfect) > 0
    always = [fault | {"probability": 1.0} for fault in both]
    with pytest.raises(gs.InputError, match="4 of 4 flights are refused, the first because: "):
        dataset.make(gs.Campaign.from_dict(TABLES | {"fault": always}), 4, tmp_path / "none")
    assert not (tmp_path / "none").exists()
    assert told.hours == pytest.approx(12.0 * (12 - twice.sum()) / 3600.0)


def test_bad_input_is_one_line_and_nothing_is_written(folder: Path, tmp_path: Path) -> None:
    with pytest.raises(gs.InputError, match=r"dataset\.json: cannot be read"):
        dataset.score(tmp_path)
    with pytest.raises(gs.InputError, match="no observer 'joint_kalmn', did you mean 'joint_kalman'"):
        dataset.score(folder, observers=["joint_kalmn"])
    with pytest.raises(gs.InputError, match="runs = 0"):
        dataset.make(gs.Campaign.from_dict(TABLES), 0, tmp_path / "no")
    (tmp_path / "bad.csv").write_text("a,b\n1,2\n")
    done = CliRunner().invoke(app, ["dataset", "score", str(folder), "--declared", str(tmp_path / "bad.csv")])
    assert "columns run, t (s) and mask" in str(done.exception)
    assert not (tmp_path / "no").exists()
