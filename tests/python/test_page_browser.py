# SPDX-License-Identifier: MIT
"""Pages as Debian's Chromium shows them: what is drawn, what moves, what is linked, and that nothing complains."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from selenium import webdriver
from selenium.webdriver.common.action_chains import ActionChains
from selenium.webdriver.common.by import By
from selenium.webdriver.support.ui import WebDriverWait

import gyrostat as gs
from gyrostat import attitude, comparison, page
from gyrostat.page import writer

SINGLE = 2e-7  # an attitude of the page is in single precision


class Page:
    """An open page."""

    def __init__(self, driver: webdriver.Chrome, path: Path | None = None, link: str = "") -> None:
        self.driver = driver
        if path is None:
            return
        driver.get("about:blank")  # another link into the same file would not load it again
        driver.get_log("browser")
        driver.get(path.as_uri() + link)
        self.until(lambda: self.run("return document.documentElement.dataset.ready") == "yes")

    def run(self, script: str, *arguments: Any) -> Any:
        return self.driver.execute_script(script, *arguments)

    def until(self, condition: Callable[[], bool]) -> None:
        WebDriverWait(self.driver, 60, poll_frequency=0.05).until(lambda _: condition())

    @property
    def report(self) -> dict[str, Any]:
        return self.run("return gyrostat.report()")

    @property
    def panels(self) -> dict[str, dict[str, Any]]:
        return {p["name"]: p for p in self.report["panels"]}

    def attitude(self, run: int = 0) -> np.ndarray:
        """Columns: the body's axes in inertial components, as they were drawn."""
        return np.array(self.report["runs"][run]["body"]["turned"]).T

    def picture(self) -> str:
        return self.run("return document.getElementById('body').toDataURL()")

    def colors(self) -> int:
        """Different colours in the picture of the body."""
        return self.run(
            "const b = document.getElementById('body'), c = new OffscreenCanvas(b.width, b.height),"
            " pen = c.getContext('2d', { willReadFrequently: true }); pen.drawImage(b, 0, 0);"
            "const d = pen.getImageData(0, 0, c.width, c.height);"
            "return new Set(new Uint32Array(d.data.buffer)).size"
        )

    def quiet(self) -> None:
        """Nothing went wrong so far."""
        assert self.report["trouble"] == []
        assert self.driver.get_log("browser") == []


@pytest.fixture(scope="module")
def degraded() -> gs.Result:
    scenario = gs.Scenario.load("wheel2_degraded")
    return scenario.run(channels=page.channels(scenario))


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Of all pages: they share a script, which the browser reads once."""
    return tmp_path_factory.mktemp("pages")


@pytest.fixture(scope="module")
def degraded_page(degraded: gs.Result, folder: Path) -> Path:
    return degraded.to_html(folder)


@pytest.fixture
def opened(driver: webdriver.Chrome, degraded_page: Path) -> Iterator[Page]:
    """The page at its beginning; opened anew only when another one is in the window."""
    shown = Page(driver, degraded_page) if driver.current_url != degraded_page.as_uri() else Page(driver)
    shown.run("gyrostat.play(false); gyrostat.seek(0)")
    shown.run("Plotly.relayout(document.querySelector('.plot'), { 'xaxis.range': [0, 120] })")
    shown.until(lambda: all(p["range"] == [0.0, 120.0] for p in shown.panels.values()))
    yield shown
    shown.quiet()


def dcm_NB(q_NB: np.ndarray) -> np.ndarray:
    return np.asarray(attitude.dcm_from_quat(q_NB)).T


def test_every_figure_shows_something_that_changes(opened: Page, degraded: gs.Result) -> None:
    found = opened.panels
    traces = {name: p["traces"] for name, p in found.items()}
    assert traces == {
        "pointing": 1,
        "rate": 3,
        "command": 4,
        "effectiveness": 4,  # true ones; this observer estimates none
        "lumped": 6,
        "momentum": 4,
        "events": 1,
    }
    for name, panel in found.items():
        assert panel["paths"] == panel["traces"], name
        assert panel["range"] == [0.0, 120.0]
        assert name == "events" or panel["spread"] > 0.0
    assert found["pointing"]["points"] > 1000
    # the largest command is among the points: thinning loses no peak
    spread = float(np.ptp(degraded["allocation.u"], axis=0).max())
    assert found["command"]["spread"] == pytest.approx(spread, rel=1e-6)


def test_the_fault_is_a_band_with_its_name(opened: Page) -> None:
    assert opened.report["runs"][0]["faults"] == 1
    shapes = opened.run(
        "return document.querySelectorAll('.plot')[1]._fullLayout.shapes.map(s => [s.type, s.x0, s.x1])"
    )
    assert sorted(shapes) == [["line", 20, 20], ["rect", 20, 120]]
    assert "loss of effectiveness, actuator 2" in opened.run("return document.querySelector('.plot').textContent")


def test_the_slider_turns_the_body_to_the_attitude_of_its_sample(opened: Page, degraded: gs.Result) -> None:
    frames = opened.report["frames"]
    before = opened.picture()
    slide = "const s = document.getElementById('time'); s.value = arguments[0]; s.dispatchEvent(new Event('input'))"
    for frame in (1, frames // 10, frames // 2, frames - 1):
        opened.run(slide, frame)
        report = opened.report
        sample = report["runs"][0]["body"]["sample"]
        assert report["frame"] == frame
        assert report["t"] == pytest.approx(degraded.t[sample])
        np.testing.assert_allclose(opened.attitude(), dcm_NB(degraded["truth.q_NB"][sample]), atol=4 * SINGLE)
        after = opened.picture()
        assert after != before
        before = after
    assert report["t"] == 120.0


def test_between_frames_the_body_turns_evenly(opened: Page, degraded: gs.Result) -> None:
    t = 7.777
    opened.run("gyrostat.seek(arguments[0])", t)
    exact = np.array([np.interp(t, degraded.t, q) for q in degraded["truth.q_NB"].T])
    off = np.abs(opened.attitude() - dcm_NB(exact / np.linalg.norm(exact))).max()
    # less than a frame's turn, 0.13 s at 0.1 rad/s, and far less for even interpolation: w' T^2 / 8
    assert off < 1e-4


def test_the_values_shown_are_those_of_the_instant(opened: Page, degraded: gs.Result) -> None:
    opened.run("gyrostat.seek(30)")
    shown = float(opened.run("return document.querySelector('.head .key').children[2].textContent"))
    assert shown == pytest.approx(np.degrees(np.interp(30.0, degraded.t, degraded["error.angle"])), rel=0.01)
    rows = opened.run("return [...document.querySelectorAll('#actuators tr')].map(r => r.textContent)")
    assert rows[3].startswith("wheel 20.4")
    assert rows[1].startswith("wheel 01")
    colour = opened.run("return [...document.querySelectorAll('#actuators .spot')].map(s => s.style.background)")
    assert colour[0] != colour[2]


def test_zoom_goes_to_all_plots_and_back(opened: Page) -> None:
    plots = opened.driver.find_elements(By.CSS_SELECTOR, ".plot .nsewdrag")
    # a drag over the second plot selects its middle
    ActionChains(opened.driver).scroll_to_element(plots[1]).move_to_element_with_offset(
        plots[1], -100, 0
    ).click_and_hold().move_by_offset(200, 0).release().perform()
    opened.until(lambda: all(p["range"] != [0.0, 120.0] for p in opened.panels.values()))
    ranges = [p["range"] for p in opened.panels.values()]
    np.testing.assert_allclose(ranges, [ranges[0]] * len(ranges))
    assert 0.0 < ranges[0][0] < 60.0 < ranges[0][1] < 120.0
    ActionChains(opened.driver).double_click(plots[1]).perform()
    opened.until(lambda: all(p["range"] == [0.0, 120.0] for p in opened.panels.values()))


def test_zoom_shows_what_is_small_there(opened: Page, degraded: gs.Result) -> None:
    zoom = "Plotly.relayout(document.querySelectorAll('.plot')[0], { 'xaxis.range': [100, 110] })"
    opened.run(zoom)
    height = "return document.querySelectorAll('.plot')[1]._fullLayout.yaxis.range.map(Number)"
    opened.until(lambda: opened.panels["rate"]["range"] == [100.0, 110.0])
    inside = degraded["truth.omega_BN_B"][(degraded.t >= 100.0) & (degraded.t <= 110.0)]
    low, high = opened.run(height)
    assert low < inside.min() < inside.max() < high
    assert high - low < 2.0 * float(np.ptp(inside))


def test_numbers_keep_their_zeros(driver: webdriver.Chrome, folder: Path) -> None:
    shown = Page(driver, case("early").to_html(folder / "early.html"))
    assert shown.panels["rate"]["keys"].split("rad/s")[1].split() == ["x", "1000y", "1000z", "1000"]


def test_pointing_at_a_plot_reads_all_and_a_click_goes_there(opened: Page) -> None:
    keys = opened.panels["rate"]["keys"]
    plots = opened.driver.find_elements(By.CSS_SELECTOR, ".plot .nsewdrag")
    ActionChains(opened.driver).move_to_element(plots[0]).perform()
    opened.until(lambda: opened.panels["rate"]["keys"] != keys)
    cursors = opened.run(
        "return [...document.querySelectorAll('.cursor.hover')].map(c => [c.style.display, c.style.left])"
    )
    assert {tuple(c) for c in cursors} == {("block", cursors[0][1])}
    ActionChains(opened.driver).click(plots[0]).perform()
    opened.until(lambda: abs(opened.report["t"] - 60.0) < 0.5)
    assert opened.run("return document.getElementById('clock').textContent").startswith(("59.", "60."))


def test_play_runs_to_the_end_and_pause_stops(opened: Page) -> None:
    button = opened.driver.find_element(By.ID, "play")
    button.click()
    opened.until(lambda: opened.report["t"] > 1.0)
    button.click()
    stopped = opened.report["t"]
    assert not opened.report["playing"]
    assert opened.report["t"] == stopped < 120.0
    opened.run("const s = document.getElementById('speed'); s.value = '1000'; s.dispatchEvent(new Event('change'))")
    button.click()
    opened.until(lambda: not opened.report["playing"])
    assert opened.report["t"] == 120.0


def test_light_and_dark(driver: webdriver.Chrome, degraded_page: Path) -> None:
    seen = {}
    for theme in ("light", "dark"):
        shown = Page(driver, degraded_page, f"#theme={theme}&t=30")
        assert shown.report["t"] == 30.0
        seen[theme] = [
            shown.run("return getComputedStyle(document.body).backgroundColor"),
            shown.run("return document.querySelector('.plot').data[0].line.color"),
            shown.picture(),
        ]
        shown.quiet()
    assert all(a != b for a, b in zip(seen["light"], seen["dark"], strict=True))
    driver.find_element(By.ID, "theme").click()
    assert shown.run("return getComputedStyle(document.body).backgroundColor") == seen["light"][0]


def test_a_narrow_window_has_one_column(driver: webdriver.Chrome, degraded_page: Path) -> None:
    driver.set_window_size(500, 900)
    try:
        shown = Page(driver, degraded_page)
        widths = shown.run("return [document.documentElement.scrollWidth, window.innerWidth]")
        assert widths[0] <= widths[1]  # nothing sticks out
        below = shown.run(
            "return document.getElementById('panels').getBoundingClientRect().top"
            " >= document.getElementById('left').getBoundingClientRect().bottom"
        )
        assert below
        assert shown.colors() > 50
        shown.quiet()
    finally:
        driver.set_window_size(1400, 1000)


def test_a_page_without_its_script_says_so(driver: webdriver.Chrome, degraded: gs.Result, tmp_path: Path) -> None:
    alone = degraded.to_html(tmp_path / "a.html", single_file=True)
    shown = Page(driver, alone)
    assert shown.panels["pointing"]["paths"] == 1
    shown.quiet()
    bare = degraded.to_html(tmp_path / "b.html")
    (tmp_path / writer._script_name()).unlink()
    driver.get("about:blank")
    driver.get(bare.as_uri())
    text = driver.find_element(By.ID, "panels").text
    assert text == f"{writer._script_name()} is missing beside this page: the plots need it."


def test_the_page_of_a_campaign_is_light_and_dark(driver: webdriver.Chrome, tmp_path: Path) -> None:
    made = gs.Campaign(
        "wheel2_degraded",
        set={"duration": 5.0, "dt": 0.1, "integrator": "rk4"},
        vary={"faults.0.remaining": gs.campaign.dist.uniform(0.0, 1.0)},
        measure={"final": {"metric": "final", "signal": "error.angle"}},
        success={"final": {"below": 0.5}},
        grids=[{"name": "controller", "of": ["mrp_feedback", "sliding_mode"]}],
    )
    path = made.run(100, out=tmp_path / "flown").to_html(tmp_path / "page.html")
    seen = {}
    for theme in ("light", "dark"):
        shown = Page(driver, path, f"#theme={theme}")
        seen[theme] = shown.run(
            "const line = document.querySelector('#distributions .line');"
            "const box = line.closest('svg').getBoundingClientRect(), style = getComputedStyle;"
            "return [style(document.body).backgroundColor, style(line).stroke, box.width > 300 && box.height > 100]"
        )
        assert seen[theme][2]
        widths = shown.run("return [document.documentElement.scrollWidth, window.innerWidth]")
        assert widths[0] <= widths[1]
        assert driver.get_log("browser") == []
    assert all(a != b for a, b in zip(seen["light"][:2], seen["dark"][:2], strict=True))
    driver.find_element(By.ID, "theme").click()
    assert shown.run("return getComputedStyle(document.body).backgroundColor") == seen["light"][0]


def crowd() -> gs.Scenario:
    """Sixteen actuators, wheels and torquers, two on one axis, one without an axis, three faults."""
    rng = np.random.default_rng(1)
    D = rng.normal(size=(3, 16))
    D /= np.linalg.norm(D, axis=0)
    D[:, 5], D[:, 6], D[:, 12] = D[:, 4], -D[:, 4], 0.0
    return gs.Scenario(
        vehicle=gs.Vehicle(J_B=(20.0, 40.0, 25.0), D_B=D.tolist(), u_max=0.2, wheel_inertia=[0.05] * 8 + [0.0] * 8),
        initial=gs.Initial(mrp=(0.1, 0.2, -0.3)),
        observer="adaptive_iterative_learning",
        detector="threshold",
        controller="finite_time",
        allocator="lexicographic",
        faults=[gs.faults.Dead(actuator=i, t_on=5.0 + i) for i in (2, 3, 9)],
        duration=20.0,
        dt=0.01,
    )


def case(name: str) -> gs.Result:
    """Runs of every kind."""
    if name == "sixteen":
        return crowd().run(channels=page.channels(crowd()))
    if name == "busy":
        flown = case("sixteen")
        kinds = ("guard.held", "mode", "controller.arms", "observer.restarts")
        return dataclasses.replace(flown, events=tuple(gs.Event(0.005 * k, kinds[k % 4], k) for k in range(4000)))
    if name == "one_sample":
        flown = case("ftc_4rw")
        return dataclasses.replace(flown, t=flown.t[:1], channels={k: x[:1] for k, x in flown.channels.items()})
    if name == "early":
        # a rate of 1e3 rad/s held by an integrator that takes one step a sample ends in infinities
        fast = {"initial.omega_BN_B": [1e3, 1e3, 1e3], "integrator": {"type": "rk4"}, "dt": 1.0}
        flown = gs.Scenario.load("ftc_4rw").replace(**fast)
        return flown.run(channels=page.channels(flown))
    if name == "usual":
        return gs.Scenario.load("wheel2_degraded").run()
    scenario = gs.Scenario.load(name)
    return scenario.run(channels=page.channels(scenario))


@pytest.mark.parametrize(
    "name",
    [
        "cao2022/attitude",
        "cao2023/printed",
        "yang2023/bench_a",
        "sixteen",
        "busy",
        "early",
        "usual",
    ],
)
def test_every_kind_of_run_has_a_page(driver: webdriver.Chrome, name: str, folder: Path) -> None:
    result = case(name)
    shown = Page(driver, result.to_html(folder / f"{name.replace('/', '_')}.html"))
    report, found = shown.report, shown.panels
    faults = [f for f in result.description.get("faults", []) if f.get("t_on", 0.0) <= result.end_time]
    assert report["runs"][0]["faults"] == len(faults)
    assert {"pointing", "rate", "command", "effectiveness", "lumped"} <= set(found)
    for panel, x in (
        ("pointing", np.degrees(result["error.angle"])),
        ("rate", result["truth.omega_BN_B"]),
        ("command", result["allocation.u"]),
    ):
        assert found[panel]["spread"] == pytest.approx(float(np.ptp(x, axis=0).max()), rel=1e-6)
        assert found[panel]["paths"] == found[panel]["traces"] > 0
    assert sum(p["points"] for p in found.values()) < 60_000  # the browser stays quick
    for step in (0, report["frames"] // 2, report["frames"]):
        shown.run("gyrostat.step(-Infinity); gyrostat.step(arguments[0])", step)
        sample = shown.report["runs"][0]["body"]["sample"]
        np.testing.assert_allclose(shown.attitude(), dcm_NB(result["truth.q_NB"][sample]), atol=4 * SINGLE)
        assert shown.colors() > 50  # faces, wheels, arrows, their edges
    shown.quiet()


def test_one_sample_is_a_page_that_stands(driver: webdriver.Chrome, folder: Path) -> None:
    result = case("one_sample")
    shown = Page(driver, result.to_html(folder / "one_sample.html"))
    assert shown.report["frames"] == 1
    assert not driver.find_element(By.ID, "time").is_enabled()
    np.testing.assert_allclose(shown.attitude(), dcm_NB(result["truth.q_NB"][0]), atol=4 * SINGLE)
    shown.quiet()


def test_without_the_attitude_there_are_plots_and_no_body(driver: webdriver.Chrome, folder: Path) -> None:
    flown = gs.Scenario.load("ftc_4rw").replace(duration=5.0).run(channels=["error.angle"])
    shown = Page(driver, flown.to_html(folder / "no_body.html"))
    assert list(shown.panels) == ["pointing"]
    assert not driver.find_element(By.ID, "left").is_displayed()
    assert "truth.q_NB" in driver.find_element(By.ID, "missing").text
    shown.quiet()


def test_what_happened_is_in_the_strip_and_in_words(driver: webdriver.Chrome, folder: Path) -> None:
    shown = Page(driver, case("yang2023/maneuver").to_html(folder / "maneuver.html"), "#t=84.34")
    strip = shown.panels["events"]
    assert strip["traces"] == 4  # faults, arms, jumps of the reference, declarations
    assert "84.34 s: declared: actuator 0" in strip["keys"]
    assert shown.panels["rate"]["shapes"] == 3 + 1 + 3 + 2  # onsets, one band of all, declarations, jumps
    shown.quiet()


def test_runs_lie_over_each_other_and_can_be_hidden(driver: webdriver.Chrome, folder: Path) -> None:
    base = gs.Scenario.load("wheel2_degraded").replace(duration=40.0)
    runs = comparison.fly(comparison.variants(base, {"controller": ["mrp_feedback", "finite_time"]}))
    shown = Page(driver, page.write_page(folder / "compared.html", runs), "#t=30")
    report, found = shown.report, shown.panels
    assert [r["label"] for r in report["runs"]] == list(runs)
    assert {name: p["traces"] for name, p in found.items()} == {
        "pointing": 2,
        "rate": 2,
        "command": 2,
        "effectiveness": 1,  # they share the truth, and neither estimates it
        "lumped": 2,
        "momentum": 2,
        "events": 1,  # one fault, the same for both
    }
    for k, result in enumerate(runs.values()):
        sample = np.searchsorted(result.t, 30.0 - 1e-9)
        np.testing.assert_allclose(shown.attitude(k), dcm_NB(result["truth.q_NB"][sample]), atol=1e-5)  # between frames
    values = [float(v) for v in found["rate"]["keys"].removeprefix("Size of the body rate, rad/s").split()]
    sizes = [np.linalg.norm(r["truth.omega_BN_B"][np.searchsorted(r.t, 30.0 - 1e-9)]) for r in runs.values()]
    assert values == pytest.approx(sizes, rel=0.01)
    before = shown.picture()
    driver.find_elements(By.CSS_SELECTOR, "#runs .chip")[0].click()
    visible = shown.run("return document.querySelector('.plot').data.map(d => d.visible)")
    assert visible == [False, True]
    assert shown.picture() != before
    table = driver.find_element(By.CSS_SELECTOR, "#tables table").text
    assert all(label in table for label in runs)
    shown.quiet()
