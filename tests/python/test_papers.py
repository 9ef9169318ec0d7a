# SPDX-License-Identifier: MIT
"""The machinery of claims, on a small study made here."""

from __future__ import annotations

import csv
import importlib.util
import sys
from importlib.machinery import SourceFileLoader
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest

import gyrostat as gs
from gyrostat import papers

CLAIMS = """
title = "A study of one wheel"
citation = "Nobody, nowhere"
record = ["truth.omega_BN_B", "error.angle", "allocation.u", "shadow0.estimate.*"]

[cases.degraded]
[cases.healthy]
title = "without fault"
scenario = "degraded"
set = { "faults" = [] }
[cases.heavy]
like = "healthy"
seeds = [2, 3]
set = { "vehicle.u_max" = 0.1, "record.channels" = ["allocation.u"] }
[cases.watched]
like = "healthy"
seeds = [5]
keep = ["error", "shadow0"]
set = { shadows = [{ observer = "finite_time_disturbance" }] }
[cases.unwatched]
like = "watched"
set = { shadows = [] }

[[claims]]
quantity = "largest command, N m"
published = 0.25
reported = ["-inf", 0.25]
measure = { metric = "window_max", signal = "allocation.u", window = [0, 5] }
note = "early"
rows = [
  { id = "peak", case = ["degraded", "healthy"], accept = [0.0, 0.2000001] },  # the limit
  { id = "late", case = "healthy", column = 1, window = [5, 6], accept = [0, 0.1], quantity = "u1, N m", note = "" },
  { id = "limited", case = "heavy_3", published = "less", accept = [0.1, 0.1] },
]

[[claims]]
id = "too_good"
case = "degraded"
quantity = "error at the end, rad"
published = "zero"
reported = [0, 1e-12]
accept = [1e-9, "inf"]
measure = { metric = "final", signal = "error.angle" }
note = "cannot hold"

[[claims]]
id = "same"
case = "degraded"
quantity = "difference between the cases before the fault, rad/s"
accept = [0, 0]
measure = { metric = "difference", signal = "rate", against = "healthy", window = [0, 4] }

[[claims]]
id = "impossible"
case = "degraded"
quantity = "time of an error of 100 rad, s"
accept = ["-inf", "inf"]
measure = { metric = "first_reach", signal = "error.angle", level = 100 }

[[claims]]
id = "own"
case = "degraded"
quantity = "a metric of the study"
accept = [3, 3]
measure = { metric = "columns", signal = "rate" }
"""

SIGNALS = """
SIGNALS = {"rate": lambda result: result["truth.omega_BN_B"]}
METRICS = {"columns": lambda result, *, signal: signal.shape[1]}
"""

FIGURES = """
from gyrostat.papers import PaperFigure
from gyrostat.plots import Figure

def draw(results):
    figure = Figure("both cases")
    for name, result in results.items():
        figure.line(0, result.t, result["error.angle"], f"error {name}", "rad", log=True)
    return figure

FIGURES = [PaperFigure("fig1", "Error in both cases.", ["degraded", "healthy"], draw)]
"""


@pytest.fixture
def study(tmp_path: Path, scenario: gs.Scenario) -> Path:
    folder = tmp_path / "one_wheel"
    (folder / "scenarios").mkdir(parents=True)
    scenario.replace(duration=6.0).to_toml(folder / "scenarios" / "degraded.toml")
    (folder / "claims.toml").write_text(CLAIMS)
    (folder / "signals.py").write_text(SIGNALS)
    (folder / "figures.py").write_text(FIGURES)
    return folder


def test_claims_are_measured_and_judged(study: Path) -> None:
    fractions: list[float] = []
    reproduction = papers.reproduce(papers.load(str(study)), progress=fractions.append)
    found = {e["id"]: e for e in reproduction.to_dict()["claims"]}
    assert list(found) == [
        "peak@degraded",
        "peak@healthy",
        "late",
        "limited",
        "too_good",
        "same",
        "impossible",
        "own",
    ]
    keys = {"id", "case", "quantity", "published", "measured", "accept", "ok", "verdict", "note"}
    assert set(found["same"]) == keys
    assert found["peak@healthy"]["ok"]
    assert found["peak@healthy"]["verdict"] == "reproduces"
    assert found["peak@healthy"]["measured"] == 0.2
    assert found["too_good"]["ok"]
    assert found["too_good"]["verdict"] == "does not reproduce"
    assert found["too_good"]["accept"] == [1e-9, None]
    assert found["same"]["measured"] == 0.0
    assert found["same"]["published"] is None
    assert found["same"]["verdict"] == "measured only"
    assert found["impossible"]["measured"] is None
    assert not found["impossible"]["ok"]
    assert found["impossible"]["verdict"] == "not measured"
    assert found["own"]["measured"] == 3.0
    assert (reproduction.to_dict()["passed"], reproduction.failed) == (7, 1)
    assert fractions[-1] == 1.0


def test_a_case_starts_from_an_earlier_one_with_its_changes(study: Path) -> None:
    cases = papers.load(str(study)).cases
    healthy, heavy = cases["healthy"].scenario, cases["heavy"].scenario
    assert heavy == healthy.replace(**{"vehicle.u_max": 0.1, "record.channels": ["allocation.u"]})
    claims = study / "claims.toml"
    claims.write_text(claims.read_text().replace('like = "healthy"', 'like = "own"'))
    with pytest.raises(gs.InputError, match="case 'heavy': no case 'own' before it"):
        papers.load(str(study))


def test_a_row_takes_from_its_table_what_it_does_not_say(study: Path) -> None:
    peak, _, late, limited = papers.load(str(study)).claims[:4]
    assert (peak.quantity, peak.published, peak.reported, peak.note) == (
        "largest command, N m",
        0.25,
        (-np.inf, 0.25),
        "early",
    )
    assert (peak.measure.arguments, peak.measure.column) == ({"window": [0, 5]}, None)
    assert (late.quantity, late.published, late.note) == ("u1, N m", 0.25, "")
    assert (late.measure.arguments, late.measure.column) == ({"window": [5, 6]}, 1)
    assert (limited.case, limited.published, limited.accept) == ("heavy_3", "less", (0.1, 0.1))


def test_seeds_make_cases(study: Path) -> None:
    cases = papers.load(str(study)).cases
    assert list(cases) == ["degraded", "healthy", "heavy", "heavy_2", "heavy_3", "watched", "watched_5", "unwatched"]
    assert cases["heavy_2"].title == f"{cases['heavy'].title}, seed 2"
    assert (cases["heavy"].repeats, cases["heavy_2"].repeats) == ("", "heavy")
    assert cases["heavy_2"].scenario == cases["heavy"].scenario.replace(seed=2)


def test_a_case_keeps_what_it_offers_of_the_record(study: Path) -> None:
    kept = {
        key: case.scenario.record.channels if case.scenario.record else None
        for key, case in papers.load(str(study)).cases.items()
    }
    alone = ("truth.omega_BN_B", "error.angle", "allocation.u")
    assert kept["degraded"] == kept["healthy"] == alone
    assert kept["heavy"] == kept["heavy_2"] == ("allocation.u",), "its own choice"
    assert kept["watched"] == kept["watched_5"] == ("error.angle", "shadow0.estimate.*")
    assert kept["unwatched"] == ("error.angle",)


def test_a_claim_may_compare_two_cases_that_no_figure_shows(study: Path) -> None:
    (study / "figures.py").unlink()
    found = {e["id"]: e for e in papers.reproduce(papers.load(str(study))).to_dict()["claims"]}
    assert found["same"]["measured"] == 0.0


def test_a_run_that_ended_before_the_window_counts_as_failed(study: Path) -> None:
    paper = papers.load(str(study))
    result = paper.cases["degraded"].scenario.run()
    short = gs.Result(
        result.scenario,
        result.t[:300],
        {k: v[:300] for k, v in result.channels.items()},
        status="singular",
        cause="pitch at 90 deg",
        end_time=2.99,
    )
    evaluation = next(c for c in paper.claims if c.id == "peak@degraded").evaluate(short, {})
    assert not evaluation.ok
    assert "ended at 2.99 s: pitch at 90 deg" in evaluation.note


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ('metric = "final"', 'metric = "finale"', ["claim 'too_good'", "finale", "did you mean 'final'"]),
        ('case = "degraded"', 'case = "degrade"', ["claim 'too_good'", "degrade", "did you mean 'degraded'"]),
        ('signal = "error.angle" }', 'signl = "error.angle" }', ["too_good", "signl"]),
        ("accept = [1e-9,", "accept = [true,", ["claim 'too_good'", "accept"]),
        ('accept = [1e-9, "inf"]', 'accept = [1, "wide"]', ["too_good", "wide"]),
        ("accept = [1e-9,", "acept = [1e-9,", ["claim 'too_good'", "accept is missing"]),
        ("accept = [0, 0.1],", "", ["claim 'late'", "accept is missing"]),
        ("column = 1,", "colunm = 1,", ["claim 'late'", "colunm", "did you mean 'column'"]),
        ("column = 1,", 'measure = { metric = "final" },', ["claim 'late'", "no argument 'measure'"]),
        ('id = "late", ', "", ["id is missing"]),
        ("rows = [", "rows = []\nother = [", ["claims[0]: rows = []"]),
        ('"error.angle", "alloc', '"error.angel", "alloc', ["record", "error.angel", "did you mean 'error.angle'"]),
        ("seeds = [5]", 'seeds = ["five"]', ["cases.watched: seeds[0]"]),
        ('keep = ["error"', 'keep = ["eror"', ["case 'watched'", "eror", "did you mean 'error'"]),
        ("[cases.watched]", "[cases.heavy_3]", ["case 'heavy_3'", "already"]),
        ('scenario = "degraded"', 'scenario = "absent"', ["case 'healthy'", "absent.toml"]),
        ('set = { "faults" = [] }', 'set = { "faults.0.remainin" = 1 }', ["case 'healthy'", "remainin"]),
        ('id = "own"', 'id = "same"', ["'same'", "twice"]),
    ],
)
def test_a_mistake_in_the_claims_is_named_before_anything_runs(
    study: Path, old: str, new: str, words: list[str]
) -> None:
    text = CLAIMS.replace(old, new, 1)
    assert text != CLAIMS
    (study / "claims.toml").write_text(text)
    with pytest.raises(gs.InputError) as caught:
        papers.load(str(study))
    message = str(caught.value)
    assert message.startswith(str(study / "claims.toml"))
    assert "\n" not in message
    for word in words:
        assert word in message, message


def test_an_unknown_paper_is_named() -> None:
    with pytest.raises(gs.InputError, match=r"^no paper 'li2081'"):
        papers.load("li2081")


def test_the_claims_of_every_shipped_paper_can_be_read() -> None:
    for name in papers.available():
        paper = papers.load(name)
        assert paper.claims
        assert {c.case for c in paper.claims} <= set(paper.cases) | set(paper.campaigns)


def _sensitivity() -> ModuleType:
    path = Path(__file__).parents[2] / "scripts" / "claims_sensitivity"
    spec = importlib.util.spec_from_loader("claims_sensitivity", SourceFileLoader("claims_sensitivity", str(path)))
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules["claims_sensitivity"] = module
    spec.loader.exec_module(module)
    return module


def test_every_number_of_a_law_moves_a_claim_or_is_said_to_move_none() -> None:
    """The table that scripts/claims_sensitivity writes is complete, and the reasons in it are those of the script."""
    script = _sensitivity()
    lines = script.TABLE.read_text(encoding="utf-8").splitlines()
    rows = list(csv.reader(line for line in lines if not line.startswith("#")))[1:]
    known = {tuple(row[:3]): row for row in rows}
    expected = {p.key for study in papers.available() for p in script.parameters(study)}
    assert set(known) == expected
    for key, row in known.items():
        assert int(row[4]) > 0 or script.DEAD[key] == row[6], key
