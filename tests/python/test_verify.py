# SPDX-License-Identifier: MIT
"""Requirements on flown campaigns: verdicts that are known, files that are wrong, and searches over flights.

A flight of a tenth of a second without control ends at the attitude error at which it began: so the probability of an
error above a limit is that of the drawn angle.
"""

from __future__ import annotations

import json
import math
import tomllib
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy import special
from typer.testing import CliRunner

import gyrostat as gs
from gyrostat import toml
from gyrostat.cli import app
from gyrostat.errors import InputError
from gyrostat.verification import flown
from gyrostat.verification.requirements import RequirementFile, verify
from gyrostat.verification.sequential import SequentialTest, runs_to_pass

CAMPAIGN: dict[str, Any] = {
    "base": "wheel2_degraded",
    "set": {
        "duration": 0.1,
        "dt": 0.05,
        "integrator": "rk4",
        "faults": [],
        "disturbances": [],
        "controller": {"type": "open_loop"},
    },
    "seed": 7,
    "vary": {
        "initial.q_NB": {"dist": "attitude", "angle": {"dist": "uniform", "low": 0.0, "high": 1.0}},
        "initial.omega_BN_B": {"dist": "normal", "mean": 0.0, "std": 1e-9, "each": 3},
    },
    "measure": {"final": {"metric": "final", "signal": "error.angle"}},
    "success": {"final": {"below": 0.9}},
}


def write(folder: Path, requirement: dict[str, Any], campaign: dict[str, Any] | None = None, runs: int = 3000) -> Path:
    (folder / "campaign.toml").write_text(toml.write(campaign or CAMPAIGN))
    tables = {"campaign": "campaign.toml", "max_runs": runs, "requirement": [{"id": "A"} | requirement]}
    (folder / "requirement.toml").write_text(toml.write(tables))
    return folder / "requirement.toml"


def call(*arguments: object) -> tuple[int, str]:
    done = CliRunner().invoke(app, [str(a) for a in arguments])
    if isinstance(done.exception, InputError):
        return 2, str(done.exception)
    assert done.exception is None or isinstance(done.exception, SystemExit), done.exception
    return done.exit_code, done.output


@pytest.mark.parametrize(
    ("requirement", "outcome", "status"),
    [
        ({"probability": {"at_most": 0.2}}, "PASS", 0),  # it is 0.1
        ({"probability": {"at_most": 0.05}}, "FAIL", 1),
        ({"probability": {"at_most": 0.1, "confidence": 0.999}}, "UNDECIDED", 4),
        ({"fails": {"final": {"above": 0.6}}, "probability": {"at_most": 0.3}}, "FAIL", 1),  # 0.4
        ({"fails": {"final": {"below": 0.1}}, "probability": {"at_most": 0.2}}, "PASS", 0),
        ({"percentile": {"of": "final", "level": 0.5, "at_most": 0.6}}, "PASS", 0),
        ({"percentile": {"of": "final", "level": 0.9, "at_most": 0.8}}, "FAIL", 1),
    ],
)
def test_a_verdict_is_the_known_one(requirement: dict[str, Any], outcome: str, status: int, tmp_path: Path) -> None:
    file = write(tmp_path, requirement)
    code, text = call("verify", file, "--out", tmp_path / "flown")
    assert code == status, text
    assert text.startswith(f"A: {outcome} ")
    code, text = call("verify", file, "--out", tmp_path / "flown", "--json")
    told = json.loads(text)
    assert (code, told["outcome"]) == (status, outcome)
    (one,) = told["requirements"]
    assert one["interval"][0] <= one["failures"] / one["runs"] <= one["interval"][1]
    assert (one["needed"] is None) == (outcome != "UNDECIDED")
    listed, lost = len(one["failing"]), one["lost"]
    assert listed == min(5, lost)
    assert lost >= one["failures"]  # those up to the verdict
    text = call("verify", file, "--out", tmp_path / "flown")[1]
    assert (f"and {lost - listed} more failing flights" in text) == (lost > listed)


def test_verdicts_taken_up_again_are_those_of_one_go(tmp_path: Path) -> None:
    file = write(tmp_path, {"probability": {"at_most": 0.12}}, runs=4000)
    whole = gs.verify(file, tmp_path / "whole")
    for runs in (70, 400, 4000):
        pieces = verify(file, tmp_path / "pieces", runs=runs)
    assert pieces.judgements[0].verdict == whole.judgements[0].verdict
    campaign = gs.Campaign.load(tmp_path / "campaign.toml")
    angles = campaign.evaluate(campaign.points(0, whole.runs)).measures["final"]
    assert whole.judgements[0].verdict == SequentialTest(0.12).decide(np.flatnonzero(~(angles < 0.9)), whole.runs)
    assert list(whole.judgements[0].failing) == np.flatnonzero(~(angles < 0.9))[:5].tolist()
    assert whole.judgements[0].dominant[0][0] == "initial.q_NB[2]"
    at, for_pass, _ = whole.judgements[0].evidence
    assert at[-1] == whole.runs
    crossed = at[for_pass >= math.log(20)]
    assert crossed[0] >= whole.judgements[0].verdict.runs
    assert (tmp_path / "whole" / "evidence.png").exists()


def test_a_flight_that_ends_early_fails_every_requirement(tmp_path: Path) -> None:
    campaign = CAMPAIGN | {"vary": CAMPAIGN["vary"] | {"vehicle.u_max": {"dist": "uniform", "low": -0.1, "high": 0.3}}}
    file = write(tmp_path, {"fails": {"final": {"above": 4.0}}, "probability": {"at_most": 0.1}}, campaign)
    got = verify(file, tmp_path / "flown").judgements[0]
    assert got.verdict.outcome == "FAIL"  # a quarter of the flights is refused: no angle is above pi


def test_cells_of_a_grid_are_requirements_of_their_own(tmp_path: Path) -> None:
    campaign = CAMPAIGN | {
        "grid": [{"name": "start", "of": {"a": {"vehicle.u_max": 0.2}, "b": {"vehicle.u_max": 0.1}}}]
    }
    file = write(tmp_path, {"probability": {"at_most": 0.2}}, campaign)
    got = verify(file, tmp_path / "flown")
    assert [j.name for j in got.judgements] == ["A [a]", "A [b]"]
    assert got.judgements[0].verdict.failures == got.judgements[1].verdict.failures  # the same draws
    alone = verify(write(tmp_path, {"probability": {"at_most": 0.2}, "cell": "b"}, campaign), tmp_path / "flown")
    assert [j.cell for j in alone.judgements] == ["b"]


@pytest.mark.parametrize("familywise", [False, True])
def test_the_family_shares_the_error_of_a_false_pass_when_it_is_asked_to(familywise: bool, tmp_path: Path) -> None:
    never = {"fails": {"final": {"above": 2.0}}, "probability": {"at_most": 0.01}}
    file = write(tmp_path, never)
    tables = toml.read(file)
    tables["requirement"] = [{"id": name} | never for name in "AB"]
    file.write_text(toml.write(tables | {"familywise": familywise}))
    got = verify(file, tmp_path / "flown")
    at = int(runs_to_pass(0, 0.01, 0.025 if familywise else 0.05)[0])
    assert [(j.verdict.outcome, j.verdict.runs) for j in got.judgements] == [("PASS", at)] * 2


@pytest.mark.parametrize(
    ("requirement", "campaign", "message"),
    [
        ({"probability": {"at_most": 0.2}}, {"sampling": "lhs"}, "sampling = 'lhs': its runs depend on each other"),
        ({"probability": {"at_most": 0.2}}, {"sampling": "sobol"}, "write sampling = 'plain'"),
        ({"probability": {"at_most": 1.5}}, {}, "at_most = 1.5"),
        ({"probability": {"at_most": 0.1, "confidence": 1.0}}, {}, "confidence = 1.0"),
        ({"probability": {"at_most": 0.1, "confidence": 0.05}}, {}, "confidence = 0.05"),  # alpha, by mistake
        ({"percentile": {"of": "final", "level": 0.9, "at_most": math.inf}}, {}, "at_most = inf"),
        ({"percentile": {"of": "final", "level": 0.9, "at_most": math.nan}}, {}, "at_most = nan"),
        ({}, {}, "one of 'probability' and 'percentile' belongs here"),
        ({"probability": {"at_most": 0.1, "atmost": 0.1}}, {}, "unknown key 'atmost', did you mean 'at_most'"),
        ({"percentile": {"of": "finale", "level": 0.9, "at_most": 1.0}}, {}, "no measure 'finale', did you mean"),
        ({"fails": {"final": {}}, "probability": {"at_most": 0.1}}, {}, "a finite 'above' or 'below' belongs here"),
        ({"fails": {}, "probability": {"at_most": 0.1}}, {}, "fails"),
        ({"probability": {"at_most": 0.1}}, {"success": {}}, "neither 'fails' nor the campaign's"),
        ({"probability": {"at_most": 0.1}, "cell": "x"}, {}, "no cell 'x'"),
        (
            {"percentile": {"of": "final", "level": 0.9, "at_most": 1.0}},
            {"keep": {"rows": "failures"}},
            "write \\[keep\\] rows = 'all'",
        ),
    ],
)
def test_a_wrong_file_is_one_line_and_nothing_is_written(
    requirement: dict[str, Any], campaign: dict[str, Any], message: str, tmp_path: Path
) -> None:
    file = write(tmp_path, requirement, CAMPAIGN | campaign)
    with pytest.raises(InputError, match=message) as caught:
        verify(file, tmp_path / "flown")
    assert "\n" not in str(caught.value)
    assert not (tmp_path / "flown").exists()


def test_a_file_says_where_it_is_wrong(tmp_path: Path) -> None:
    (tmp_path / "r.toml").write_text("campaign = 'c.toml'\nmax_runs = 0\nrequirement = []\n")
    with pytest.raises(InputError, match=r"r.toml: max_runs = 0"):
        RequirementFile.load(tmp_path / "r.toml")


def rare_campaign(angle: float = 0.9999) -> gs.Campaign:
    return gs.Campaign.from_dict(CAMPAIGN | {"success": {"final": {"below": angle}}, "margin": {"measure": "final"}})


def test_a_rare_loss_of_flights_has_the_probability_of_its_angle(tmp_path: Path) -> None:
    campaign = rare_campaign(0.999)
    got = gs.rare(campaign, population=100, seed=2, jobs=2, out=tmp_path)
    assert got.status == "converged"
    assert got.interval[0] < 1e-3 < got.interval[1]
    again = flown.rare(campaign, population=100, seed=2, jobs=1)
    assert again.replicates.tobytes() == got.replicates.tobytes()
    first = got.lost[0]
    flight = flown.scenario(campaign, first.z, first.number)
    assert flight.run()["error.angle"][-1] - 0.999 == pytest.approx(first.margin, abs=1e-12)


def walking(probability: float) -> gs.Campaign:
    """Lost is a flight whose gyro has walked too far: a sum of the noise of all of its seconds, and nothing else."""
    walk, steps, dt = 1e-3, 20, 0.5
    limit = -special.ndtri(probability / 2) * walk * math.sqrt(steps * dt)  # of a normal number, on either side
    changes = {
        "duration": steps * dt,
        "dt": dt,
        "initial.omega_BN_B": [0.0, 0.0, 0.0],
        "sensors": [{"type": "gyro", "rate_random_walk": walk}],
    }
    return gs.Campaign.from_dict(
        {"base": "wheel2_degraded", "set": CAMPAIGN["set"] | changes}
        | {"measure": {"walk": {"metric": "final", "signal": "measurement.omega_BN_B", "column": 0}}}
        | {"success": {"walk": {"below": float(limit)}}, "margin": {"measure": "walk"}}
    )


def test_a_loss_by_noise_alone_has_its_probability_and_can_be_flown_again(tmp_path: Path) -> None:
    campaign = walking(1e-4)
    assert (campaign.dimension, campaign.noise_blocks()) == (0, 11)
    got = gs.rare(campaign, seed=1, out=tmp_path)
    assert got.status == "converged"
    assert got.interval[0] < 1e-4 < got.interval[1]
    first = got.lost[0]
    flight = flown.scenario(campaign, first.z, first.number, None, first.versions)
    again = gs.Scenario.from_dict(tomllib.loads(flight.to_toml())).run(channels=["measurement.omega_BN_B"])
    walked = abs(again["measurement.omega_BN_B"][-1, 0])
    assert walked - campaign.spec.success["walk"].below == first.margin
    with pytest.raises(InputError, match=r"versions of shape \(2, 3\); \(2, 11\) belongs here"):
        campaign.evaluate(np.empty((2, 0)), versions=np.ones((2, 3)))


def test_noise_of_a_version_is_the_same_in_whichever_run_and_second_by_second() -> None:
    campaign = walking(1e-4)
    versions = np.arange(1.0, 12.0)[None, :]
    one, other = (campaign.evaluate(np.empty((1, 0)), first=i, versions=versions).measures["walk"] for i in (0, 7))
    assert one == other
    later = np.where(np.arange(11) < 4, versions, 99.0)
    a, b = (campaign.scenario_at([], 0, None, v[0]).run(channels=["measurement.*"]) for v in (versions, later))
    same = (a["measurement.omega_BN_B"] == b["measurement.omega_BN_B"]).all(axis=1)
    assert same.tolist() == [t < 4.0 for t in a.t]


def test_the_worst_case_of_flights_is_the_nearest_angle_and_nothing_else() -> None:
    campaign = rare_campaign(0.999)
    got = gs.worst(campaign, budget=1500, seed=1)
    found, left, words = got.found, got.shrunk, got.needs
    assert found.lost
    assert math.sqrt(found.size) == pytest.approx(float(special.ndtri(0.999)), rel=0.03)
    assert np.flatnonzero(left).tolist() == [2]  # the angle; neither axis nor rates are needed
    assert all(word.startswith("initial.q_NB") for word in words)


def test_searches_from_the_command_line_leave_flights_that_can_be_flown(tmp_path: Path) -> None:
    write(tmp_path, {"probability": {"at_most": 0.1}}, rare_campaign(0.99).to_dict())
    file, out = tmp_path / "campaign.toml", tmp_path / "rare"
    code, text = call("rare", file, "--population", 50, "--out", out)
    assert code in (0, 4)
    assert (out / "lost0.toml").exists()
    assert gs.Scenario.load(out / "lost0.toml").run()["error.angle"][-1] > 0.99
    again, told = call("rare", file, "--population", 50, "--out", out, "--json")
    assert (again, json.loads(told)["status"] == "converged") == (code, code == 0)
    code, text = call("worst", file, "--budget", 200, "--out", tmp_path / "worst")
    assert code == 0
    assert "needs initial.q_NB" in text
    assert gs.Scenario.load(tmp_path / "worst" / "shrunk.toml").run()["error.angle"][-1] > 0.99
    code, text = call("worst", file, "--budget", 200, "--size", "initial.nothing")
    assert code == 2
    assert "size: no column 'initial.nothing'" in text


def test_a_campaign_without_a_margin_is_refused() -> None:
    plain = {k: v for k, v in CAMPAIGN.items() if k != "success"}
    with pytest.raises(InputError, match=r"the campaign has no \[margin\]"):
        flown.rare(gs.Campaign.from_dict(plain))


def test_tuned_gains_can_be_pasted_and_are_reported_on_other_flights(tmp_path: Path) -> None:
    campaign = CAMPAIGN | {"set": {"duration": 40.0, "dt": 0.05, "integrator": "rk4", "faults": []}}
    campaign["vary"] = {"initial.q_NB": {"dist": "attitude", "angle": {"dist": "uniform", "low": 0.1, "high": 0.4}}}
    write(tmp_path, {"probability": {"at_most": 0.1}}, campaign)
    keys = [k for k in flown.parameters_of(gs.Scenario.load("wheel2_degraded")) if k.startswith("controller.k")][:2]
    assert len(keys) == 2
    vary = [part for key in keys for part in ("--vary", key)]
    out = tmp_path / "tuned"
    arguments = ("tune", tmp_path / "campaign.toml", *vary, "--train", 10, "--held-out", 12, "--budget", 30)
    code, text = call(*arguments, "--out", out)
    assert code == 0, text
    assert "held out, 12 flights" in text
    gains = toml.read(out / "gains.toml")["controller"]
    assert (out / "trade.png").exists()
    base = gs.Campaign.load(tmp_path / "campaign.toml").base
    assert base.replace(**{f"controller.{k}": v for k, v in gains.items()}).run().status == "completed"
    every = ("tune", tmp_path / "campaign.toml", "--train", 10, "--held-out", 10, "--budget", 30, "--out", out)
    code, text = call(*every)  # also of components that the scenario does not name
    assert code == 0, text
    tables = toml.read(out / "gains.toml")
    assert {"observer", "controller", "allocator"} <= set(tables)
    assert base.allocator is None
    assert base.replace(**tables).run().status == "completed"
    code, text = call("tune", tmp_path / "campaign.toml", "--vary", "controller.nothing")
    assert code == 2
    assert "'controller.nothing' is no gain of a component" in text


def test_a_factor_is_on_all_of_a_vector_or_matrix() -> None:
    known = flown.parameters_of(gs.Scenario.load("ftc_4rw").replace(observer="mixed_learning_disturbance"))
    assert isinstance(known["observer.K1"], list)
    assert np.array(flown.scaled(known["observer.K1"], 2.0)).tolist() == (2 * np.array(known["observer.K1"])).tolist()
    assert flown.scaled(0.3, 2.0) == 0.6
    infinite = gs.Scenario.load("wang2023/stabilisation")
    assert "controller.clamp" not in flown.parameters_of(infinite)
    assert flown.parameters_of(infinite)["controller.K3"] == [[1, 0, 0], [0, 1, 0], [0, 0, 1]]
    masked = gs.Scenario.load("ftc_4rw").replace(observer=gs.observer("iterative_learning", frozen=[0, 2]))
    assert "observer.frozen" not in flown.parameters_of(masked)
