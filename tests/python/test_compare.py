# SPDX-License-Identifier: MIT
"""Runs beside each other: variants of a scenario, saved results, and what ``gyrostat compare`` prints and leaves."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest
from commands import gyrostat

import gyrostat as gs
from gyrostat import comparison

SHORT = ["--set", "duration=3"]


@pytest.mark.parametrize(
    ("text", "key", "values"),
    [
        ("controller=mrp_feedback,finite_time", "controller", ["mrp_feedback", "finite_time"]),
        ("observer.lambda1=1,2.5", "observer.lambda1", [1, 2.5]),
        ("initial.mrp=[0.1,0,0],[0,0.1,0]", "initial.mrp", [[0.1, 0, 0], [0, 0.1, 0]]),
        (
            "allocator={type='pseudo_inverse'}, 'lexicographic'",
            "allocator",
            [{"type": "pseudo_inverse"}, "lexicographic"],
        ),
        ("name='a,b'", "name", ["a,b"]),
    ],
)
def test_values_of_a_variation_are_toml_between_commas(text: str, key: str, values: list[Any]) -> None:
    assert comparison.read_variation(text) == (key, values)


@pytest.mark.parametrize("text", ["controller", "=a,b", "controller=", "controller=a,,b", "controller=a,"])
def test_a_variation_that_cannot_be_read_is_one_line(text: str) -> None:
    with pytest.raises(gs.InputError, match=r"--vary .*: write KEY=A,B"):
        comparison.read_variation(text)


def test_variants_are_all_combinations(scenario: gs.Scenario) -> None:
    found = comparison.variants(scenario, {"seed": [1, 2], "controller": ["mrp_feedback", "finite_time"]})
    assert list(found) == [f"seed={s}, controller={c}" for s in (1, 2) for c in ("mrp_feedback", "finite_time")]
    last = found["seed=2, controller=finite_time"]
    assert (last.seed, last.controller) == (2, gs.controller("finite_time"))
    with pytest.raises(gs.InputError, match=r"^controller=finte_time: .*did you mean 'finite_time'"):
        comparison.variants(scenario, {"controller": ["mrp_feedback", "finte_time"]})


def test_a_compared_run_is_the_run_alone(scenario: gs.Scenario) -> None:
    short = scenario.replace(duration=2.0)
    together = comparison.fly({"a": short, "b": short.replace(seed=8)})
    alone = short.run()
    assert together["a"].metrics.to_dict() == alone.metrics.to_dict()
    assert together["b"].metrics.to_dict() != alone.metrics.to_dict()


def test_compare_prints_a_table_and_leaves_a_page(tmp_path: Path) -> None:
    vary = ["compare", "wheel2_degraded", *SHORT, "--vary", "controller=mrp_feedback,finite_time"]
    done = gyrostat(*vary, "--out", str(tmp_path / "page"))
    assert done.returncode == 0, done.stderr
    head, *rows, last = done.stdout.splitlines()
    assert head.split()[:3] == ["run", "settling", "time"]
    assert [row.split()[0] for row in rows] == ["controller=mrp_feedback", "controller=finite_time"]
    assert last == f"page: {tmp_path / 'page' / 'index.html'}"
    assert (tmp_path / "page" / "index.html").is_file()
    found = json.loads(gyrostat(*vary, "--json").stdout)
    assert found["out"] is None
    for row, name in zip(found["runs"], ("mrp_feedback", "finite_time"), strict=True):
        flown = gs.Scenario.load("wheel2_degraded").replace(controller=name, duration=3.0).run()
        assert row["run"] == f"controller={name}"
        assert row["metrics"] == flown.metrics.to_dict()


def test_saved_results_and_scenarios_compare(tmp_path: Path) -> None:
    flown = gs.Scenario.load("ftc_4rw").replace(duration=3.0).run()
    flown.save(tmp_path / "before.npz")
    (tmp_path / "after").mkdir()
    flown.save(tmp_path / "after" / "result.npz")
    done = gyrostat("compare", str(tmp_path / "before.npz"), str(tmp_path / "after"), "ftc_4rw", "ftc_4rw", "--json")
    assert done.returncode == 0, done.stderr
    rows = json.loads(done.stdout)["runs"]
    assert [row["run"] for row in rows] == ["before", "after", "ftc_4rw", "ftc_4rw #2"]
    assert rows[0]["metrics"] == rows[1]["metrics"] == flown.metrics.to_dict()


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["ftc_4rw"], ["1 to compare", "2 to 40"]),
        (["ftc_4rw", "wheel2_degraded", "--vary", "seed=1,2"], ["--vary", "one scenario, not 2"]),
        (["ftc_4rw", "--vary", "seed=" + ",".join(map(str, range(41)))], ["41 to compare", "2 to 40"]),
        (["ftc_4rw", "--vary", "sed=1,2"], ["sed=1: ", "did you mean 'seed'"]),
        (["ftc_4rw", "nowhere.npz"], ["nowhere.npz: cannot be read"]),
        (["ftc_4rw", "{saved}", "--set", "seed=1"], ["is a saved result", "--set and --vary"]),
        (["ftc_4rw", "{saved}", "--out", "{foreign}"], ["is not a page of gyrostat"]),
    ],
)
def test_bad_comparisons_are_one_line_and_write_nothing(arguments: list[str], words: list[str], tmp_path: Path) -> None:
    saved = gs.Scenario.load("ftc_4rw").replace(duration=0.1).run().save(tmp_path / "saved.npz")
    (tmp_path / "foreign").mkdir()
    (tmp_path / "foreign" / "index.html").write_text("mine")
    places = {"saved": str(saved), "foreign": str(tmp_path / "foreign")}
    done = gyrostat("compare", *(a.format(**places) if a.startswith("{") else a for a in arguments))
    assert done.returncode == 2
    assert done.stdout == ""
    assert done.stderr.count("\n") == 1
    for word in words:
        assert word in done.stderr
    assert sorted(p.name for p in tmp_path.rglob("*")) == ["foreign", "index.html", "saved.npz"]


def test_a_run_that_ends_early_is_compared_up_to_there(tmp_path: Path) -> None:
    fast = ["--set", "integrator={type='rk4'}", "--set", "dt=1", "--vary", "initial.omega_BN_B=[1e3,1e3,1e3],[0,0,0]"]
    done = gyrostat("compare", "ftc_4rw", *fast, "--out", str(tmp_path / "page.html"))
    assert done.returncode == 3
    assert "ended at" in done.stderr
    assert "as planned" in done.stdout
    assert (tmp_path / "page.html").is_file()
