# SPDX-License-Identifier: MIT
"""The page of ``gyrostat check``: torques within reach as a solid, margins as bars, figures of the design checks."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from selenium import webdriver
from selenium.webdriver.common.action_chains import ActionChains
from selenium.webdriver.common.by import By
from typer.testing import CliRunner

import gyrostat as gs
from gyrostat import design
from gyrostat.cli import app
from gyrostat.design.finding import Finding
from gyrostat.page.check import write_check_page


def opened(driver: webdriver.Chrome, path: Path, link: str = "") -> Callable[[str], Any]:
    driver.get("about:blank")
    driver.get_log("browser")
    driver.get(path.as_uri() + link)
    assert driver.execute_script("return document.documentElement.dataset.ready") == "yes"
    return driver.execute_script


@pytest.fixture(scope="module")
def degraded(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """As the command leaves it, with a demand."""
    folder = tmp_path_factory.mktemp("checked")
    done = CliRunner().invoke(app, ["check", "wheel2_degraded", "--torque", "0.1", "0.2", "0", "--out", str(folder)])
    assert done.exit_code == 0, done.output
    assert done.output.endswith(f"page: {folder / 'index.html'}\n")
    return folder / "index.html"


def test_the_torques_are_those_that_the_design_finds(driver: webdriver.Chrome, degraded: Path) -> None:
    run = opened(driver, degraded)
    sets = run("return gyrostat.solid().sets")
    found = design.attainable_after_faults(gs.Scenario.load("wheel2_degraded"))
    assert found is not None
    assert [s["name"] for s in sets] == ["healthy", "after the faults"]
    for shown, one in zip(sets, found, strict=True):
        assert shown["ball"] == pytest.approx(one.in_every_direction)
        assert shown["faces"] == len(one.normals)
        assert shown["drawn"] >= shown["faces"] / 2  # of what is not glass the side that is seen
    rings = run("return [...document.querySelectorAll('#solid circle')].map(c => Number(c.getAttribute('r')))")
    assert rings[1] / rings[0] == pytest.approx(found[1].in_every_direction / found[0].in_every_direction, rel=0.01)
    rows = run("return [...document.querySelectorAll('#torques tr')].map(r => [...r.cells].map(c => c.textContent))")
    assert rows[2][0] == "along +x"
    assert float(rows[2][2].removesuffix(" N m")) == pytest.approx(float(found[1].radius([1, 0, 0])), rel=1e-3)
    assert driver.get_log("browser") == []


def test_the_solid_turns_under_the_pointer_and_back(driver: webdriver.Chrome, degraded: Path) -> None:
    run = opened(driver, degraded)
    frame, corners = (
        "return gyrostat.solid().frame",
        "return document.querySelector('#solid polygon').getAttribute('points')",
    )
    before = np.array(run(frame)), run(corners)
    np.testing.assert_allclose(before[0] @ before[0].T, np.eye(3), atol=1e-12)  # nothing is sheared
    assert np.linalg.det(before[0]) == pytest.approx(1.0)
    solid = driver.find_element(By.ID, "solid")
    ActionChains(driver).move_to_element(solid).click_and_hold().move_by_offset(80, 40).release().perform()
    assert run(corners) != before[1]
    after = np.array(run(frame))
    np.testing.assert_allclose(after @ after.T, np.eye(3), atol=1e-12)
    assert np.abs(after - before[0]).max() > 0.1
    ActionChains(driver).double_click(solid).perform()
    assert run(corners) == before[1]


def test_bars_reach_from_zero_to_the_number_with_a_mark_at_the_limit(driver: webdriver.Chrome, tmp_path: Path) -> None:
    scenario = gs.Scenario.load("ftc_4rw")
    findings = [
        Finding("loop", "half", "a <number>", True, 1.0, 2.0),
        Finding("loop", "below", "another", False, -1.0, 1.0),
        Finding("loop", "to know", "a third", None, 4.0, 1.0),
        Finding("loop", "no limit", "no bar", None, 4.0),
        Finding("loop", "yes", "no bar either", True, 1.0, 1.0),
    ]
    run = opened(driver, write_check_page(tmp_path, scenario, scenario.check(), findings, {}))
    bars = run(
        "return [...document.querySelectorAll('.margin')].map(m => {"
        " const [t, b, u] = ['.track', 'i', 'u'].map(name => m.querySelector(name).getBoundingClientRect());"
        " return [m.className, ...[b.left, b.right, u.left + 1].map(x => (x - t.left) / t.width)]; })"
    )
    assert [b[0] for b in bars] == ["margin good", "margin bad", "margin none"]
    np.testing.assert_allclose([b[1:] for b in bars], [[0, 0.5, 1], [0, 0.5, 1], [0, 1, 0.25]], atol=0.01)
    assert run("return document.querySelectorAll('#findings tbody tr').length") == len(scenario.check()) + 5
    assert run("return gyrostat.solid().sets.length") == 1  # no faults: one set


def test_a_learning_observer_has_its_response_and_gains(driver: webdriver.Chrome, tmp_path: Path) -> None:
    scenario = gs.Scenario.load("cao2023/printed").replace(**{"vehicle.u_max": 8})
    figures = {name: figure for draw in design.FIGURES for name, figure in draw(scenario).items()}
    write_check_page(tmp_path, scenario, scenario.check(), [], figures)
    seen = {}
    for theme in ("light", "dark"):
        run = opened(driver, tmp_path / "index.html", f"#theme={theme}")
        found = run("return gyrostat.figures()")
        assert {name: [p["lines"] for p in panels] for name, panels in found.items()} == {
            "response": [3],
            "gain_region": [5],
        }
        for (panel,) in found.values():
            assert panel["spread"] > 0.0
            assert panel["drawn"] >= panel["lines"]
        seen[theme] = run(
            "return [getComputedStyle(document.body).backgroundColor,"
            " getComputedStyle(document.querySelector('#solid polygon')).stroke]"
        )
        assert driver.get_log("browser") == []
    assert all(a != b for a, b in zip(*seen.values(), strict=True))
    assert (tmp_path / "index.html").stat().st_size < 200_000
    driver.set_window_size(500, 900)
    try:
        run = opened(driver, tmp_path / "index.html")
        widths = run("return [document.documentElement.scrollWidth, window.innerWidth]")
        assert widths[0] <= widths[1]
    finally:
        driver.set_window_size(1400, 1000)


def test_without_limits_there_is_no_solid(tmp_path: Path) -> None:
    scenario = gs.Scenario.load("ftc_4rw").replace(**{"vehicle.u_max": float("inf")})
    text = write_check_page(tmp_path, scenario, scenario.check(), [], {}).read_text()
    assert 'id="solid"' not in text
    assert 'id="margins"' not in text


def test_a_page_of_somebody_else_is_left_alone(tmp_path: Path) -> None:
    (tmp_path / "index.html").write_text("mine")
    done = CliRunner().invoke(app, ["check", "ftc_4rw", "--out", str(tmp_path)])
    assert "is there already and is not a page of gyrostat" in str(done.exception)
    assert [p.name for p in tmp_path.iterdir()] == ["index.html"]
