# SPDX-License-Identifier: MIT
"""A mistake in the file of a campaign is one line, before anything flies; nothing is written."""

from __future__ import annotations

import json
from copy import deepcopy
from pathlib import Path
from typing import Any

import pytest
from commands import gyrostat

import gyrostat as gs

GOOD: dict[str, Any] = {
    "base": "wheel2_degraded",
    "set": {"duration": 2.0, "dt": 0.1, "integrator": "rk4", "faults": []},
    "vary": {
        "initial.omega_BN_B": {"dist": "normal", "mean": 0.0, "std": 0.01, "each": 3},
        "truth.viscous_friction": {"dist": "loguniform", "low": 1e-6, "high": 1e-4, "each": 4},
        "vehicle.u_max": {"dist": "mixture", "of": [{"weight": 0.5, "value": 0.2}, {"weight": 0.5, "value": 0.1}]},
    },
    "correlated": [
        {"keys": ["truth.viscous_friction.0", "truth.viscous_friction.1"], "matrix": [[1.0, 0.5], [0.5, 1.0]]}
    ],
    "fault": [
        {
            "name": "wheel",
            "probability": 0.3,
            "actuator": {"dist": "choice", "of": [0, 1, 2, 3]},
            "t_on": {"dist": "uniform", "low": 0.5, "high": 1.0},
            "kind": [{"weight": 0.5, "type": "lock"}, {"weight": 0.5, "type": "stuck", "torque": 0.01}],
        }
    ],
    "grid": [{"name": "allocator", "of": ["pseudo_inverse", "lexicographic"]}],
    "measure": {
        "final": {"metric": "final", "signal": "error.angle"},
        "settling": {"metric": "settling_time", "signal": "error.angle", "band": 0.1},
    },
    "success": {"final": {"below": 0.1, "scale": "log"}},
    "margin": {"measure": "final"},
    "keep": {"rows": "all"},
}

NORMAL = {"dist": "normal", "mean": 0.0, "std": 0.01}
UNIFORM = {"dist": "uniform", "low": 0.0, "high": 1.0}

MISTAKES: dict[str, tuple[tuple[str, ...], Any, str]] = {
    "unknown key": (("vry",), {}, "unknown key 'vry', did you mean 'vary'?"),
    "no base": (("base",), None, "base is missing"),
    "unknown base": (
        ("base",),
        "wheel2_degrade",
        "base: no scenario 'wheel2_degrade', did you mean 'wheel2_degraded'?",
    ),
    "unknown path": (("vary", "initial.omega_BN"), NORMAL, "did you mean 'omega_BN_B'?"),
    "unknown distribution": (
        ("vary", "seed"),
        {"dist": "norml"},
        "vary: 'seed': no distribution 'norml', did you mean 'normal'?",
    ),
    "unknown parameter": (
        ("vary", "seed"),
        {"dist": "normal", "mean": 0.0, "std": 1.0, "eech": 3},
        "unknown key 'eech', did you mean 'each'?",
    ),
    "missing parameter": (("vary", "seed"), {"dist": "normal", "mean": 0.0}, "vary: 'seed': normal: std is missing"),
    "std below zero": (("vary", "initial.omega_BN_B", "std"), -1.0, "vary: 'initial.omega_BN_B': normal: std = -1.0"),
    "infinite": (("vary", "initial.omega_BN_B", "mean"), float("nan"), "normal: mean = nan"),
    "empty interval": (("vary", "truth.viscous_friction", "low"), 1e-4, "low = 0.0001 must lie below high = 0.0001"),
    "logarithm of nothing": (("vary", "truth.viscous_friction", "low"), 0.0, "loguniform: low = 0.0"),
    "other length": (("vary", "initial.omega_BN_B", "each"), 4, "'3' is no position in a list of 3"),
    "no length": (("vary", "initial.omega_BN_B"), NORMAL, "holds 3 numbers, and 1 are drawn; write each = 3"),
    "no distribution": (("vary", "seed"), 3, "vary: 'seed': 3 is no distribution"),
    "an attitude elsewhere": (("vary", "vehicle.u_max"), {"dist": "attitude"}, "fits q_NB, mrp and euler"),
    "an inertia elsewhere": (("vary", "vehicle.u_max"), {"dist": "inertia", "spread": 0.1}, "fits truth.dJ_B"),
    "weights of a mixture": (
        ("vary", "vehicle.u_max", "of", 0, "weight"),
        0.6,
        "weights sum to 1.1; they must sum to 1",
    ),
    "weights of kinds": (("fault", 0, "kind", 1, "weight"), 0.4, "fault[0]: kind: the weights sum to 0.9"),
    "two words in a mixture": (
        ("vary", "vehicle.u_max", "of", 1),
        {"weight": 0.5, "dist": "mixture", "of": [{"weight": 1.0, "value": 1.0}]},
        "takes one uniform number",
    ),
    "probabilities that fall": (
        ("vary", "vehicle.u_max"),
        {"dist": "table", "values": [0.1, 0.2, 0.3], "probabilities": [0.0, 0.7, 0.5]},
        "probabilities must rise from 0 to 1",
    ),
    "not definite": (
        ("correlated", 0, "matrix"),
        [[1.0, 1.0], [1.0, 1.0]],
        "correlated[0]: the matrix is not positive definite: its smallest eigenvalue is ",
    ),
    "not symmetric": (("correlated", 0, "matrix"), [[1.0, 0.1], [0.2, 1.0]], "must be symmetric"),
    "no element": (("correlated", 0, "keys", 1), "vehicle.u_max", "correlated[0]: 'vehicle.u_max' is no element"),
    "unknown kind": (("fault", 0, "kind", 0, "type"), "lok", "did you mean 'lock'?"),
    "unknown parameter of a kind": (("fault", 0, "kind", 1, "torqe"), 0.1, "did you mean 'torque'?"),
    "unknown key of a fault": (
        ("fault", 0, "probabilty"),
        0.1,
        "fault[0]: unknown key 'probabilty', did you mean 'probability'?",
    ),
    "probability": (("fault", 0, "probability"), 1.5, "fault[0]: probability = 1.5"),
    "both": (
        ("fault", 0, "count"),
        {"dist": "poisson", "mean": 1.0, "most": 2},
        "probability and count exclude each other",
    ),
    "an actuator that is not there": (
        ("fault", 0, "actuator", "of"),
        [0, 4],
        "fault 'wheel': actuator 4 is not there; the vehicle has 4 (0 to 3)",
    ),
    "no actuator": (("fault", 0, "actuator"), None, "either actuator or actuators must be given"),
    "delay alone": (("fault", 0, "delay"), UNIFORM, "delay belongs to a common cause"),
    "too few to be distinct": (("fault", 0, "distinct"), 3, "fault[0]: distinct = 3"),
    "two of a name": (("fault",), [GOOD["fault"][0], GOOD["fault"][0]], "fault: a name stands twice"),
    "empty grid": (("grid", 0, "of"), [], "grid 'allocator': has no levels"),
    "unknown component": (("grid", 0, "of"), ["pseudo_inverse", "lexicografic"], "did you mean 'lexicographic'?"),
    "unknown metric": (("measure", "final", "metric"), "fnal", "measure 'final'"),
    "no table of a metric": (("measure", "final"), 3, "measure.final = 3"),
    "unknown signal": (("measure", "final", "signal"), "error.angel", "error.angel"),
    "a column twice": (("measure", "run"), {"metric": "final", "signal": "error.angle"}, "'run' would be two columns"),
    "unknown criterion": (("success", "finl"), {"below": 1.0}, "success: no measure 'finl', did you mean 'final'?"),
    "no limit": (("success", "final"), {"scale": "log"}, "success.final: a limit is missing"),
    "log of a negative": (("success", "final", "below"), -1.0, "scale = 'log' wants positive limits"),
    "unknown margin": (("margin", "measure"), "finl", "margin: no measure 'finl', did you mean 'final'?"),
    "unknown kept": (("keep", "trajectories"), {"worst": {"measure": "finl"}}, "keep: no measure 'finl'"),
    "no number of a run": (("keep", "every"), 2**70, "keep: every = "),
    "unknown rows": (("keep", "rows"), "some", "keep: rows = 'some'"),
    "sampling": (("sampling",), "lhss", "sampling = 'lhss'"),
    "replicates of plain": (("replicates",), 4, "replicates and points belong to sampling"),
    "negative seed": (("seed",), -1, "seed = -1"),
    "a list for a table": (("vary",), [1], "vary = [1]: a table belongs here"),
    "a table for a list": (("fault",), {"name": "a"}, "write [[fault]]"),
}


def changed(where: tuple[Any, ...], value: Any) -> dict[str, Any]:
    tables = deepcopy(GOOD)
    *path, last = where
    at: Any = tables
    for step in path:
        at = at[step]
    if value is None:
        del at[last]
    else:
        at[last] = value
    return tables


def test_the_good_one_is_good() -> None:
    gs.Campaign.from_dict(GOOD)


@pytest.mark.parametrize("name", MISTAKES)
def test_a_mistake_is_one_line(name: str) -> None:
    where, value, expected = MISTAKES[name]
    with pytest.raises(gs.InputError) as refusal:
        gs.Campaign.from_dict(changed(where, value))
    assert expected in str(refusal.value)
    assert str(refusal.value).isprintable()


def test_a_scenario_is_no_campaign() -> None:
    with pytest.raises(gs.InputError, match="this is a scenario; a campaign names one"):
        gs.Campaign.from_dict(gs.Scenario.load("wheel2_degraded").to_dict())


def test_a_margin_must_be_finite_for_every_flight(tmp_path: Path) -> None:
    """A metric that may have no value is refused at once; a measure that has none in a flight when it is flown."""
    tables = changed(("success",), {"settling": {"below": 1.0}}) | {"margin": {"measure": "settling"}}
    with pytest.raises(gs.InputError, match="margin: 'settling' is not finite for every flight"):
        gs.Campaign.from_dict(tables)
    tables = changed(("measure", "final"), {"metric": "window_max", "signal": "error.angle", "t0": 5.0})
    with pytest.raises(gs.InputError, match="margin: 'final' of run 0 is nan, and the flight completed"):
        gs.Campaign.from_dict(tables).run(10, out=tmp_path / "out")
    assert not (tmp_path / "out").exists()


def test_another_campaign_is_refused_with_the_key_that_differs(tmp_path: Path) -> None:
    found = gs.Campaign.from_dict(GOOD).run(10, out=tmp_path / "out")
    before = {p: p.read_bytes() for p in found.folder.rglob("*") if p.is_file()}
    others = {
        r"campaign\.vary\.initial\.omega_BN_B\.std: 0\.01 there, 0\.02 here": (
            ("vary", "initial.omega_BN_B", "std"),
            0.02,
        ),
        r"seed: 0 there, 3 here": (("seed",), 3),
        r"cells\..*duration: 2\.0 there, 3\.0 here": (("set", "duration"), 3.0),
        r"campaign\.fault\.0\.probability: 0\.3 there, 0\.4 here": (("fault", 0, "probability"), 0.4),
    }
    for why, (where, value) in others.items():
        with pytest.raises(gs.InputError, match=f"out: holds another campaign; .*{why}"):
            gs.Campaign.from_dict(changed(where, value)).run(20, out=tmp_path / "out")
    assert {p: p.read_bytes() for p in found.folder.rglob("*") if p.is_file()} == before


@pytest.mark.parametrize(
    ("arguments", "expected"),
    [
        ({"runs": 0}, "runs = 0: a whole number from 1 on"),
        ({"runs": 2.5}, "runs = 2.5"),
        ({"jobs": 0}, "jobs = 0"),
        ({"chunk": 0}, "chunk = 0"),
        ({"only": "0:10"}, "only = '0:10': two numbers of chunks"),
        ({"only": (0.0, 1.0)}, "chunks = 0.0"),
        ({"only": (1, 2), "chunk": 100}, "10 runs are chunks 0:1 of 100"),
    ],
)
def test_arguments_are_checked_before_anything_flies(tmp_path: Path, arguments: dict[str, Any], expected: str) -> None:
    with pytest.raises(gs.InputError) as refusal:
        gs.Campaign.from_dict(GOOD).run(**{"runs": 10, "out": tmp_path / "out", **arguments})
    assert expected in str(refusal.value)
    assert not (tmp_path / "out").exists()


def test_a_scheduler_that_does_not_answer_is_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("gyrostat.campaign.cluster.PATIENCE", 1.0)
    with pytest.raises(gs.InputError, match=r"--scheduler tcp://127\.0\.0\.1:1: "):
        gs.Campaign.from_dict(GOOD).run(runs=10, out=tmp_path / "out", scheduler="tcp://127.0.0.1:1")
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize(
    "key", ["set", "vary", "correlated", "faults", "grids", "measure", "success", "margin", "keep"]
)
def test_what_is_no_table_is_refused(key: str) -> None:
    with pytest.raises(gs.InputError, match=key.removesuffix("s") if key in ("faults", "grids") else key):
        gs.Campaign("wheel2_degraded", **{key: 3})


def test_the_command_says_it_in_one_line_with_the_file(tmp_path: Path) -> None:
    file = tmp_path / "bad.toml"
    file.write_text('base = "wheel2_degraded"\n[vary]\n"seed" = { dist = "normal", mean = 0.0, std = -1.0 }\n')
    out = tmp_path / "out"
    for arguments, expected in [
        ((file, "--runs", 10, "--out", out), f"error: {file}: vary: 'seed': normal: std = -1.0"),
        (("five_stack", "--runs", 10, "--out", out), "error: no campaign 'five_stack'"),
        ((file, "--out", out), "error: Missing option '--runs'"),
        (("show", tmp_path), f"error: {tmp_path}: holds no campaign"),
        (("rerun", tmp_path, 3), f"error: {tmp_path}: holds no campaign"),
        (("join", tmp_path), f"error: {tmp_path}: holds no campaign"),
    ]:
        done = gyrostat("campaign", *arguments)
        assert done.returncode == 2, done.stderr
        assert done.stderr.startswith(expected), done.stderr
        assert done.stderr.count("\n") == 1
        assert done.stdout == ""
    assert not out.exists()


def test_a_manifest_that_is_none_is_refused(tmp_path: Path) -> None:
    made = gs.Campaign.from_dict(GOOD)
    good = json.loads((made.run(10, out=tmp_path).folder / "manifest.json").read_text())
    none = "is no manifest of a campaign"
    for spoilt, why in [
        ({}, none),
        ([], none),
        (good | {"runs": "many"}, none),
        (good | {"resolved": None}, none),
        (good | {"resolved": good["resolved"] | {"seed": 9}}, "is not what was written: its campaign is not the one"),
        (good | {"chunk": 0}, "chunk = 0: a whole number from 1 on belongs here"),
        (good | {"runs": 10**12}, "runs = 1000000000000: a whole number from 1 to 2147483647 belongs here"),
    ]:
        (tmp_path / "manifest.json").write_text(json.dumps(spoilt))
        for door in (lambda: gs.CampaignResult(tmp_path), lambda: made.run(20, out=tmp_path)):
            with pytest.raises(gs.InputError, match=rf"manifest\.json: {why}"):
                door()


def test_what_is_not_there_is_said(tmp_path: Path) -> None:
    single = gs.Campaign.from_dict({k: v for k, v in GOOD.items() if k != "grid"})
    single.run(10, out=tmp_path)
    with pytest.raises(gs.InputError, match="no cell 'x'; there is no grid"):
        single.scenario(0, "x")
    done = gyrostat("campaign", "rerun", tmp_path, 10)
    assert (done.returncode, done.stderr) == (2, f"error: {tmp_path}: run 10 was not flown here; 10 were\n")
    with pytest.raises(gs.InputError) as refusal:
        gs.Campaign.from_dict(GOOD).run(10, out=tmp_path)
    assert len(str(refusal.value)) < 300  # both values, shortened
    with pytest.raises(gs.InputError, match=r"tune: 'controller\.k1' stands twice"):
        gs.tune(single, ["controller.k1", "controller.k1"])
