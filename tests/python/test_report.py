# SPDX-License-Identifier: MIT
"""The report of studies: what it says, what it weighs, and what a browser makes of it."""

from __future__ import annotations

import base64
import dataclasses
import json
import math
import re
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from selenium import webdriver
from selenium.webdriver.common.by import By
from selenium.webdriver.support.ui import WebDriverWait
from typer.testing import CliRunner

import gyrostat as gs
from gyrostat import papers, report
from gyrostat.cli import app
from gyrostat.page import picture, study
from gyrostat.papers.claims import Evaluation
from gyrostat.plots import Figure

CLAIMS = """
title = "A study of one wheel"
citation = "Nobody, nowhere"
record = ["truth.omega_BN_B", "error.angle", "allocation.u"]

[story]
promised = "It points."
seen = "It is off by {off@degraded} rad."
why = "A wheel is weak."

[[findings]]
title = "It does not point"
text = "Off by {off@healthy} rad without any fault."
claim = "off@healthy"

[cases.degraded]
title = "wheel 2 <weak>"
seeds = [2, 3]
[cases.healthy]
title = "without fault"
scenario = "degraded"
set = { "faults" = [] }

[[claims]]
id = "off"
case = ["degraded", "degraded_2", "degraded_3", "healthy"]
quantity = "error at the end, rad"
published = "zero"
reported = [0, 1e-12]
accept = [1e-9, "inf"]
measure = { metric = "final", signal = "error.angle" }
note = "noise"

[[claims]]
measure = { metric = "window_max", signal = "allocation.u" }
case = "healthy"
published = 0.25
rows = [
  { id = "peak", reported = [0, 0.25], accept = [0, 0.2000001], quantity = "largest command, N m" },
  { id = "unjudged", accept = [0, 0.1], quantity = "the same, too narrow" },
  { id = "late", window = [50, 60], reported = [0, 0.25], accept = [0, 1], quantity = "the same, later" },
]
"""

FIGURES = """
import numpy as np
from gyrostat.papers import PaperFigure
from gyrostat.plots import Figure

def draw(results):
    figure = Figure("both cases", rows=2)
    for name, result in results.items():
        figure.line(0, result.t, result["error.angle"], f"error {name}", "rad", labels=[name], log=True)
    figure.line(1, result.t, result["allocation.u"], "command", "N m")
    figure.level(1, 0.2, "limit")
    figure.mark([(2.0, "fault")])
    figure.window(0, 5)
    return figure

def few(results):
    figure = Figure("few points", along="period", unit="ms")
    figure.line(0, [1, 10, 100], [1e-3, 1e-4, 1e-2], "size", log=True, style="o-")
    figure.axes[0].set_xscale("log")
    return figure

FIGURES = [
    PaperFigure("fig1", "Error in both cases.", ["degraded", "healthy"], draw),
    PaperFigure("few", "A few points.", [], few),
]
"""


@pytest.fixture(scope="module")
def reproduction(scenario: gs.Scenario, tmp_path_factory: pytest.TempPathFactory) -> papers.Reproduction:
    """A small study that has everything: seeds, a statement of each kind, a claim missed and one not measured."""
    folder = tmp_path_factory.mktemp("studies") / "one_wheel"
    (folder / "scenarios").mkdir(parents=True)
    scenario.replace(duration=6.0, **{"faults.0.t_on": 2.0}).to_toml(folder / "scenarios" / "degraded.toml")
    (folder / "claims.toml").write_text(CLAIMS)
    (folder / "figures.py").write_text(FIGURES)
    return papers.reproduce(papers.load(str(folder)))


@pytest.fixture(scope="module")
def written(reproduction: papers.Reproduction, tmp_path_factory: pytest.TempPathFactory) -> Path:
    return report.write_report(tmp_path_factory.mktemp("report"), [reproduction])


# Folding.


def test_repeats_over_seeds_are_one_row_with_their_spread(reproduction: papers.Reproduction) -> None:
    experiments = papers.folded(reproduction)
    assert [(e.id, e.cases) for e in experiments] == [
        ("degraded", ("degraded", "degraded_2", "degraded_3")),
        ("healthy", ("healthy",)),
    ]
    (row,) = experiments[0].rows
    by_id = {e.claim.id: e.measured for e in reproduction.evaluations}
    assert row.measured == (by_id["off@degraded"], by_id["off@degraded_2"], by_id["off@degraded_3"])
    assert len(set(row.measured)) == 3
    assert (row.ok, row.statement, row.verdict) == (True, "fails", "does not reproduce")
    tally = papers.Tally.of(experiments)
    assert tally == papers.Tally(claims=7, accepted=5, holds=1, fails=2, open=2)


def test_repeats_that_differ_decide_nothing(reproduction: papers.Reproduction) -> None:
    (row,) = papers.folded(reproduction)[0].rows
    first, *others = row.evaluations
    mixed = dataclasses.replace(row, evaluations=(dataclasses.replace(first, measured=0.0), *others))
    assert (mixed.statement, mixed.verdict, mixed.ok, mixed.accepted) == ("open", "differs between seeds", False, 2)
    none = dataclasses.replace(row, evaluations=tuple(dataclasses.replace(e, measured=None) for e in row.evaluations))
    assert (none.statement, none.measured) == ("open", ())


@pytest.mark.parametrize(
    ("old", "new"),
    [("{off@degraded}", "{of@degraded}"), ('claim = "off@healthy"', 'claim = "of@degraded"')],
)
def test_a_story_names_claims_that_there_are(tmp_path: Path, scenario: gs.Scenario, old: str, new: str) -> None:
    folder = tmp_path / "one_wheel"
    (folder / "scenarios").mkdir(parents=True)
    scenario.to_toml(folder / "scenarios" / "degraded.toml")
    (folder / "claims.toml").write_text(CLAIMS.replace(old, new))
    with pytest.raises(gs.InputError, match="story: no claim 'of@degraded', did you mean 'off@degraded'"):
        papers.load(str(folder))


# Figures.


def test_a_figure_keeps_its_peaks_scales_levels_and_marks() -> None:
    t = np.linspace(0.0, 10.0, 100_001)
    x = np.sin(50.0 * t)
    x[77_777] = 9.0
    figure = Figure("peaks", rows=2)
    figure.line(0, t, np.column_stack([x, x - 1.0]), "signal", labels=["a", "b"])
    figure.line(1, t, x**2, "squared", log=True, style="--")
    figure.level(0, 5.0, "limit")
    figure.mark([(3.0, "fault")])
    found = picture.picture(figure)
    first, second = found["panels"]
    lines = [*first["lines"], *second["lines"]]
    y = [np.frombuffer(base64.b64decode(line["y"]), "<f4") for line in lines]
    assert y[0].max() == 9.0
    assert sum(map(len, y)) < 1.2 * picture.POINTS
    assert [(line["name"], line["hue"], line["dash"]) for line in lines] == [
        ("a", 0, False),
        ("b", 1, False),
        ("squared", 0, True),
    ]
    assert (first["log"], second["log"]) == (False, True)
    assert (first["levels"], found["marks"]) == ([[5.0, "limit"]], [[3.0, "fault"]])
    assert found["x"] == {"title": "time (s)", "log": False, "range": None}


@pytest.mark.parametrize("x", [np.full(5, np.nan), np.zeros(5)])
def test_a_figure_with_nothing_in_it_is_refused(x: np.ndarray) -> None:
    figure = Figure("nothing")
    figure.line(0, np.arange(5.0), x, "nothing", log=True)  # of a logarithm zero is nothing
    with pytest.raises(ValueError, match="figure 'nothing': nothing is drawn"):
        picture.picture(figure)


# Files and sizes.


def test_what_lies_beside_the_page(reproduction: papers.Reproduction, written: Path, tmp_path: Path) -> None:
    folder = written.parent / "one_wheel"
    cases = ["degraded", "degraded_2", "degraded_3", "healthy"]
    assert sorted(p.name for p in folder.iterdir()) == sorted(
        ["claims.json", "few.js", "fig1.js", *(f"{c}.toml" for c in cases)]
    )
    assert json.loads((folder / "claims.json").read_text()) == reproduction.to_dict()
    for case in cases:  # what a number links to flies again what was flown
        again = gs.Scenario.load(folder / f"{case}.toml")
        assert again == reproduction.paper.cases[case].scenario
    text = written.read_text()
    assert "http" not in text, "self-contained"
    assert "<weak>" not in text
    for link in re.findall(r'(?:href|data-src)="([^"#]+)"', text):
        assert link.startswith("data:") or (written.parent / link).exists(), link
    report.write_report(tmp_path, [reproduction], with_data=True)
    with np.load(tmp_path / "one_wheel" / "fig1.npz") as data:
        np.testing.assert_array_equal(data["error healthy"], reproduction.results["healthy"]["error.angle"])


def _accepted(claim: papers.Claim) -> float:
    ends = [end for end in claim.accept if math.isfinite(end)]
    return sum(ends) / max(len(ends), 1)


@pytest.fixture(scope="module")
def shipped() -> list[papers.Reproduction]:
    """Every shipped study with numbers that nobody measured."""
    loaded = [papers.load(name) for name in papers.available()]
    return [papers.Reproduction(p, tuple(Evaluation(c, _accepted(c)) for c in p.claims), {}, {}) for p in loaded]


def test_the_report_of_all_studies_keeps_its_budget(shipped: list[papers.Reproduction]) -> None:
    told = [study.Study.of(r, {f.name: 4 for f in r.paper.figures}, with_data=False) for r in shipped]
    page = report._page(told)
    assert len(page.encode()) < 1e6  # all of the first view: figures come when they are looked at
    t = np.linspace(0.0, 300.0, 300_001)
    rng = np.random.default_rng(1)
    heavy = Figure("heavy", rows=4)
    for row in range(4):
        for _ in range(5):
            heavy.line(row, t, rng.normal(size=len(t)), "noise")
    figures = len(picture.script("heavy", heavy)) * sum(len(r.paper.figures) for r in shipped)
    beside = sum(len(json.dumps(r.to_dict(), indent=2)) for r in shipped)
    cases = [c.scenario.to_toml() for r in shipped for c in r.paper.cases.values()]
    cases += [c.campaign.to_toml() for r in shipped for c in r.paper.campaigns.values()]
    assert len(page) + figures + beside + sum(map(len, cases)) < 6e6
    for r in shipped:
        assert r.paper.story is not None, r.paper.id
        assert r.paper.findings, r.paper.id
    assert page.count("<article>") == study.MOST_FINDINGS


# The terminal.


@pytest.fixture
def flown(monkeypatch: pytest.MonkeyPatch, shipped: list[papers.Reproduction]) -> dict[str, papers.Reproduction]:
    """What `reproduce` finds, without flying; it may be changed."""
    found = {r.paper.id: r for r in shipped}

    def kept(paper: papers.Paper, **_: object) -> papers.Reproduction:
        known = {e.claim.id: e for e in found[paper.id].evaluations}
        return papers.Reproduction(paper, tuple(known[c.id] for c in paper.claims), {}, {})

    monkeypatch.setattr(papers, "reproduce", kept)
    monkeypatch.setattr(papers, "load", lambda name: found[name].paper)
    return found


def test_all_studies_are_a_line_each(flown: dict[str, papers.Reproduction]) -> None:
    lines = CliRunner().invoke(app, ["reproduce", "all"]).output.splitlines()
    assert len(lines) == len(flown)
    assert all(
        re.match(rf"{name}: (\d+) of \1 claims accepted; of its statements", line)
        for name, line in zip(flown, lines, strict=True)
    )
    everything = CliRunner().invoke(app, ["reproduce", "all", "--verbose"]).output.splitlines()
    assert len(everything) > 800


def test_whatever_fails_it_is_forty_lines_that_say_why(flown: dict[str, papers.Reproduction]) -> None:
    for name, r in flown.items():
        broken = tuple(dataclasses.replace(e, measured=None, trouble="the run ended at 3 s") for e in r.evaluations)
        flown[name] = dataclasses.replace(r, evaluations=broken)
    done = CliRunner().invoke(app, ["reproduce", "all"])
    lines = done.output.splitlines()
    assert done.exit_code == 1
    assert len(lines) <= 30  # make's own lines come to it
    assert lines[5].startswith("FAILED cao2022 ")
    assert lines[5].endswith(": the run ended at 3 s")
    assert lines[-1].startswith("FAILED 8")


def test_one_study_is_a_line_a_claim_with_the_seeds_in_one(flown: dict[str, papers.Reproduction]) -> None:
    lines = CliRunner().invoke(app, ["reproduce", "yang2023"]).output.splitlines()
    (line,) = (text for text in lines if text.startswith("fd_a.ailo_rmse_e1@fd_a "))
    assert "(3 seeds: " in line
    assert not any(text.startswith("fd_a.ailo_rmse_e1@fd_a_2") for text in lines)
    first = flown["yang2023"].evaluations[0]
    flown["yang2023"] = dataclasses.replace(
        flown["yang2023"],
        evaluations=(dataclasses.replace(first, measured=None, trouble="it ended"), *flown["yang2023"].evaluations[1:]),
    )
    lines = CliRunner().invoke(app, ["reproduce", "yang2023"]).output.splitlines()
    assert "FAILED" in lines[1]
    assert lines[1].endswith("differs between seeds: it ended")


@pytest.mark.usefixtures("flown")
def test_the_command_of_a_number_measures_it_alone() -> None:
    lines = CliRunner().invoke(app, ["reproduce", "li2018", "--claim", "t1.settling_1e-3@table1"]).output.splitlines()
    assert len(lines) == 3
    assert lines[1].startswith("t1.settling_1e-3@table1 ")
    several = CliRunner().invoke(app, ["reproduce", "all", "--verbose", "--claim", "t1.settling*"]).output.splitlines()
    assert len(several) == 11
    wrong = CliRunner().invoke(app, ["reproduce", "li2018", "--claim", "t1.setling_1e-3@table1"])
    assert "no claim 't1.setling_1e-3@table1', did you mean 't1.settling_1e-3@table1'" in str(wrong.exception)
    both = CliRunner().invoke(app, ["reproduce", "li2018", "--claim", "t1.s", "--out", "nowhere"])
    assert str(both.exception).startswith("--claim: ")


def test_only_what_a_claim_needs_flies() -> None:
    paper = papers.load("li2018")
    one = paper.only([c for c in paper.claims if c.fits("t1.gain_in_speed")])
    assert set(one.cases) == {"table1", "table1_spd_tuned"}
    assert (len(one.claims), one.figures) == (1, ())


def test_a_page_of_somebody_else_is_left_alone(reproduction: papers.Reproduction, tmp_path: Path) -> None:
    (tmp_path / "index.html").write_text("mine")
    with pytest.raises(gs.InputError, match="is there already and is not a page of gyrostat"):
        report.write_report(tmp_path, [reproduction])
    assert [p.name for p in tmp_path.iterdir()] == ["index.html"]


# The browser.


class Page:
    """The report in the browser."""

    def __init__(self, driver: webdriver.Chrome, path: Path, link: str = "") -> None:
        self.driver = driver
        driver.get("about:blank")  # another link into the same file would not load it again
        driver.get_log("browser")
        driver.get(path.as_uri() + link)
        self.until(lambda: self.run("return document.documentElement.dataset.ready") == "yes")

    def run(self, script: str, *arguments: Any) -> Any:
        return self.driver.execute_script(script, *arguments)

    def until(self, condition: Callable[[], bool]) -> None:
        WebDriverWait(self.driver, 60, poll_frequency=0.05).until(lambda _: condition())

    def figures(self) -> dict[str, Any]:
        """What is drawn, when all of it is."""
        self.run("document.querySelectorAll('figure[data-src]').forEach(gyrostat.load)")
        self.until(lambda: self.run("return !document.querySelector('figure[data-src]:not([data-drawn])')"))
        return self.run("return gyrostat.figures()")

    def rows(self) -> int:
        return self.run("return gyrostat.claims().shown")

    def quiet(self) -> None:
        assert self.driver.get_log("browser") == []


@pytest.fixture
def opened(driver: webdriver.Chrome, written: Path) -> Iterator[Page]:
    shown = Page(driver, written)
    yield shown
    shown.quiet()


def test_it_opens_with_one_table_and_what_surprises(opened: Page) -> None:
    rows = "[...document.querySelectorAll('#overview tbody tr')]"
    cells = opened.run(f"return {rows}.map(r => [...r.cells].map(c => c.innerText.trim()))")
    assert cells == [["one_wheel", "A study of one wheel", "5 of 7", "", "1", "2", "2"]]
    widths = opened.run(
        "return [...document.querySelectorAll('#overview .stack i')].map(i => i.getBoundingClientRect().width)"
    )
    assert widths[1] == pytest.approx(2 * widths[0], rel=0.1)
    (article,) = opened.driver.find_elements(By.CSS_SELECTOR, "#findings article")
    assert "Off by " in article.text
    article.find_element(By.CLASS_NAME, "more").click()
    opened.until(lambda: opened.run("return document.querySelector('tr.here')?.id") == "one_wheel:off@healthy")
    assert opened.run("return document.querySelector('tr.here').closest('details').open")


def test_every_figure_shows_something_that_changes(opened: Page) -> None:
    found = opened.figures()
    assert {name: [p["lines"] for p in panels] for name, panels in found.items()} == {
        "one_wheel/fig1": [2, 4],
        "one_wheel/few": [1],
    }
    for panels in found.values():
        for panel in panels:
            assert panel["spread"] > 0.0
            assert panel["drawn"] >= panel["lines"]
            assert panel["points"] >= 3
    assert found["one_wheel/fig1"][0]["range"] == [0.0, 5.0]
    dots = opened.run("return document.querySelectorAll('figure[data-name=\"one_wheel/few\"] circle').length")
    assert dots == 3
    assert "limit" in opened.run(
        "return document.querySelector('figure[data-name=\"one_wheel/fig1\"] .drawing').textContent"
    )


def test_a_figure_is_zoomed_read_and_thinned_out_by_hand(opened: Page) -> None:
    from selenium.webdriver.common.action_chains import ActionChains

    opened.figures()
    plots = opened.driver.find_elements(By.CSS_SELECTOR, 'figure[data-name="one_wheel/fig1"] .plotted')
    ActionChains(opened.driver).scroll_to_element(plots[1]).move_to_element_with_offset(plots[1], -50, 0).perform()
    values = opened.run(
        "return [...document.querySelectorAll('figure[data-name=\"one_wheel/fig1\"] .value')].map(v => v.textContent)"
    )
    assert all(re.fullmatch(r"-?[\d.e-]+", v) for v in values), values
    ActionChains(opened.driver).click_and_hold().move_by_offset(100, 0).release().perform()
    figure = "return gyrostat.figures()['one_wheel/fig1']"
    ranges = [p["range"] for p in opened.run(figure)]
    assert ranges[0] == ranges[1]
    assert 0.0 < ranges[0][0] < ranges[0][1] < 5.0
    ActionChains(opened.driver).double_click(plots[0]).perform()
    opened.until(lambda: opened.run(figure)[0]["range"] == [0.0, 5.0])
    opened.driver.find_element(By.CSS_SELECTOR, 'figure[data-name="one_wheel/fig1"] .key').click()
    assert [p["shown"] for p in opened.run(figure)] == [1, 4]


def test_claims_are_searched_and_filtered(opened: Page) -> None:
    assert opened.rows() == 5
    opened.driver.find_element(By.ID, "search").send_keys("largest command")
    opened.until(lambda: opened.rows() == 1)
    assert opened.run("return document.getElementById('found').textContent") == "1 of 5"
    seen = opened.run("return [...document.querySelectorAll('.experiment')].map(e => [e.hidden, e.open])")
    assert seen == [[True, False], [False, True]]
    pick = "const f = document.getElementById('filter'); f.value = arguments[0]; f.dispatchEvent(new Event('input'))"
    opened.run("const s = document.getElementById('search'); s.value = ''; s.dispatchEvent(new Event('input'))")
    for kind, rows in {"fails": 2, "holds": 1, "open": 2, "missed": 2, "": 5}.items():
        opened.run(pick, kind)
        assert opened.rows() == rows, kind


def test_a_number_says_how_it_is_measured_again(opened: Page) -> None:
    opened.run("document.querySelectorAll('.experiment').forEach(e => { e.open = true })")
    links = opened.driver.find_elements(By.CSS_SELECTOR, ".measured a")
    assert len(links) == 5
    opened.run("arguments[0].click()", links[0])
    told = opened.run("return document.querySelector('tr.how').textContent")
    assert "gyrostat reproduce one_wheel --claim off;" in told
    assert "one_wheel/degraded.toml, flown by gyrostat run one_wheel/degraded.toml --out flight" in told
    text = opened.run("return document.querySelector('.measured').innerText")
    assert re.fullmatch(r"[\d.]+\n3 seeds: [\d.]+( … [\d.]+)?", text)
    missed = opened.run("return [...document.querySelectorAll('tr.missed')].map(r => r.innerText)")
    assert len(missed) == 2
    assert "not accepted" in missed[0]
    assert "measured" in missed[1]  # and why it was not


def test_light_dark_and_narrow(driver: webdriver.Chrome, written: Path) -> None:
    colours = []
    for theme in ("light", "dark"):
        shown = Page(driver, written, f"#theme={theme}")
        shown.figures()
        colours.append(
            shown.run(
                "const s = getComputedStyle; return [s(document.body).backgroundColor,"
                " s(document.querySelector('.drawing .line')).stroke]"
            )
        )
        shown.quiet()
    assert all(a != b for a, b in zip(*colours, strict=True))
    driver.set_window_size(500, 900)
    try:
        shown = Page(driver, written)
        shown.figures()
        shown.run("document.querySelectorAll('.experiment').forEach(e => { e.open = true })")
        widths = shown.run("return [document.documentElement.scrollWidth, window.innerWidth]")
        assert widths[0] <= widths[1]
        assert shown.run("return document.querySelector('.drawing svg').getBoundingClientRect().right") <= widths[1]
    finally:
        driver.set_window_size(1400, 1000)


def test_a_figure_that_is_missing_says_so(
    driver: webdriver.Chrome, reproduction: papers.Reproduction, tmp_path: Path
) -> None:
    page = report.write_report(tmp_path, [reproduction])
    (tmp_path / "one_wheel" / "few.js").unlink()
    shown = Page(driver, page)
    shown.run("document.querySelectorAll('figure[data-src]').forEach(gyrostat.load)")
    said = "return document.querySelector('figure[data-name=\"one_wheel/few\"] .drawing').textContent"
    shown.until(lambda: shown.run(said) == "one_wheel/few.js is missing beside this page: the figure needs it.")
