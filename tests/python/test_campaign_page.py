# SPDX-License-Identifier: MIT
"""The page of a campaign: every number on it is that of the rows, and what the rows do not allow is not shown."""

from __future__ import annotations

import json
import re
from html import unescape
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy import stats
from typer.testing import CliRunner

import gyrostat as gs
from gyrostat import toml
from gyrostat.cli import app
from gyrostat.page.fault_maps import LEAST
from gyrostat.verification.sequential import quantile_interval, rate_interval

TABLES: dict[str, Any] = {
    "name": "short <flights>",
    "base": "wheel2_degraded",
    "set": {"duration": 6.0, "dt": 0.1, "integrator": "rk4", "faults": []},
    "seed": 7,
    "vary": {
        "initial.omega_BN_B": {"dist": "normal", "mean": 0.0, "std": 0.02, "each": 3},
        "initial.q_NB": {"dist": "attitude", "angle": {"dist": "uniform", "low": 0.1, "high": 1.2}},
    },
    "fault": [
        {
            "name": "wheel",
            "probability": 0.9,
            "actuator": {"dist": "choice", "of": [0, 1, 2, 3]},
            "t_on": {"dist": "uniform", "low": 1.0, "high": 4.0},
            "kind": [
                {"weight": 0.6, "type": "loss_of_effectiveness", "remaining": {"dist": "beta", "a": 1.0, "b": 1.0}},
                {"weight": 0.4, "type": "lock"},
            ],
        },
        {"name": "bus", "probability": 0.05, "actuators": [0, 1], "t_on": 2.0, "kind": [{"type": "dead"}]},
    ],
    "measure": {
        "settling": {"metric": "settling_time", "signal": "error.angle", "band": 0.4},
        "final": {"metric": "window_max", "signal": "error.angle", "last": 1.0},
    },
    "success": {"final": {"below": 0.5, "scale": "log"}},
    "keep": {"trajectories": {"failures": 2, "every": 100}},
}  # fmt: skip
GRID = [{"name": "law", "of": {"plain": {"controller": "mrp_feedback"}, "robust": {"controller": "sliding_mode"}}}]
RUNS = 400


def campaign(**changes: Any) -> gs.Campaign:
    return gs.Campaign.from_dict(TABLES | changes)


@pytest.fixture(scope="module")
def flown(tmp_path_factory: pytest.TempPathFactory) -> gs.CampaignResult:
    return campaign(grid=GRID).run(RUNS, out=tmp_path_factory.mktemp("flown") / "two laws", jobs=2)


@pytest.fixture(scope="module")
def page(flown: gs.CampaignResult) -> str:
    return flown.to_html(flown.folder / "report.html", "robust").read_text()


def section(page: str, name: str) -> str:
    found = re.search(rf'<section id="{name}">(.*?)</section>', page, re.DOTALL)
    assert found is not None, name
    return found[1]


def rows(text: str) -> list[list[str]]:
    """The cells of all rows of its tables."""
    lines = re.findall(r"<tr>(.*?)</tr>", text, re.DOTALL)
    return [[unescape(cell) for cell in re.findall(r"<t[hd][^>]*>(.*?)</t[hd]>", line)] for line in lines]


def test_what_matters_is_the_same_on_the_page_and_in_the_terminal(page: str, flown: gs.CampaignResult) -> None:
    done = CliRunner().invoke(app, ["campaign", "show", str(flown.folder), "--inputs"])
    assert done.exit_code == 0, done.output
    printed = {tuple(line.split()) for line in done.output.splitlines()}
    head, *lines = (r for r in rows(section(page, "sensitivity")) if len(r) == 3)
    assert head == ["input", "plain", "robust"]
    assert len(lines) >= 4
    for line in lines:
        assert tuple(" ".join(line).split()) in printed


def test_a_search_for_rare_failures_is_on_the_page_of_its_campaign_and_has_one_of_its_own(tmp_path: Path) -> None:
    made = campaign(success={"final": {"below": 0.9, "scale": "log"}})
    found = made.run(64, out=tmp_path / "flown")
    got = gs.rare(made, population=40, out=found.folder)
    text = section(found.to_html(found.folder / "report.html").read_text(), "rare")
    levels, replicates, lost = (
        [r for r in rows(text) if len(r) == n and r[0] not in ("level", "replicate", "distance of the inputs")]
        for n in (5, 2, 3)
    )
    assert [r[1] for r in levels] == [f"{x.margin:.4g}" for x in got.levels]
    assert [r[1] for r in replicates] == [f"{p:.3g}" for p in got.replicates]
    assert [r[1] for r in lost] == [f"{f.margin:.3g}" for f in got.lost]
    assert f"{got.flights} flights" in text
    gs.rare(campaign(seed=8, success={"final": {"below": 0.9, "scale": "log"}}), population=40, out=tmp_path)
    done = CliRunner().invoke(app, ["report", str(tmp_path)])
    assert done.exit_code == 0, done.output
    alone = (tmp_path / "report.html").read_text()
    assert section(alone, "rare")
    assert "http" not in alone
    (tmp_path / "rare.json").rename(found.folder / "rare.json")  # of another campaign: it has no place there
    assert 'id="rare"' not in found.to_html(found.folder / "report.html").read_text()
    for spoilt in ("", "[]", '{"status": "converged"}', "\x00"):
        (found.folder / "rare.json").write_text(spoilt)
        with pytest.raises(gs.InputError, match=r"rare\.json: is not what gyrostat rare wrote; call it again"):
            found.to_html(found.folder / "report.html")


def test_one_small_file_that_asks_for_nothing(page: str, flown: gs.CampaignResult) -> None:
    assert 20_000 < len(page.encode()) < 1_000_000
    assert not re.search(r"(?:src|href)=\"(?!data:)", page)
    assert "http" not in page
    assert "{{" not in page
    assert "<flights>" not in page
    for id_ in ("what", "cells", "quantiles", "paired", "faults", "distributions", "envelope", "sensitivity", "worst"):
        assert section(page, id_), id_
    assert flown.identity in section(page, "what")
    assert flown.table_hash in section(page, "what")
    assert 'id="verdict"' not in page


def test_the_file_on_the_page_is_the_campaign(page: str, flown: gs.CampaignResult, tmp_path: Path) -> None:
    written = re.search(r"<pre>(.*?)</pre>", section(page, "what"), re.DOTALL)
    assert written is not None
    (tmp_path / "campaign.toml").write_text(unescape(written[1]))
    again = gs.Campaign.load(tmp_path / "campaign.toml").fly(0, 5).table
    kept = flown.table().slice(0, 10)
    assert again.column("final").to_pylist() == kept.column("final").to_pylist()


def test_failures_quantiles_and_pairs_are_those_of_the_rows(page: str, flown: gs.CampaignResult) -> None:
    table = flown.table().to_pandas()
    lost = {label: ~table[table.cell == label].success.to_numpy(bool) for label in ("plain", "robust")}
    said = {row[0]: row for row in rows(section(page, "cells"))[1:]}
    for label, failed in lost.items():
        low, high = rate_interval(RUNS, int(failed.sum()))
        interval = f"{100 * low:.3g} % to {100 * high:.3g} %"
        assert said[label][1:] == [str(RUNS), str(failed.sum()), f"{100 * failed.mean():.3g} %", interval]
        x = table[table.cell == label].settling.to_numpy(float)
        low, high = quantile_interval(x, 0.5)
        middle = np.sort(np.nan_to_num(x, nan=np.inf))[RUNS // 2 - 1]
        cell = next(r for r in rows(section(page, "quantiles")) if r[:2] == ["settling", label])[2]
        assert cell == " ".join([f"{middle:.4g}", f"({low:.4g} to {high:.4g})"]).replace("inf", "none")
    alone = int((lost["plain"] & ~lost["robust"]).sum())
    back = int((~lost["plain"] & lost["robust"]).sum())
    assert alone + back > 0
    (pair,) = rows(section(page, "paired"))[1:]
    p = min(1.0, 2 * stats.binom(alone + back, 0.5).cdf(min(alone, back)))
    assert pair[:5] == ["plain", f"{100 * (alone - back) / RUNS:+.3g} %", str(alone), str(back), f"{p:.2g}"]


def test_a_rate_by_severity_and_onset_is_of_twenty_flights_at_least(page: str, flown: gs.CampaignResult) -> None:
    table = flown.table().to_pandas()
    mine = table[(table.cell == "plain") & (table["fault.wheel.0.kind"] == "lock")]
    text = section(page, "faults")
    (block,) = re.findall(r"<h3>wheel, plain</h3>(.*?)</table>", text, re.DOTALL)
    head, *lines = rows(block)
    edges = [tuple(map(float, re.findall(r"[\d.]+", cell))) for cell in head[1:]]
    assert len(edges) > 2
    said = next(line for line in lines if line[0] == "lock")[1:]
    total = 0
    for cell, (low, high) in zip(said, edges, strict=True):
        inside = mine[(mine["fault.wheel.0.t_on"] >= low - 6e-3) & (mine["fault.wheel.0.t_on"] < high + 6e-3)]
        total += len(inside)
        if cell.startswith("("):
            assert int(cell.strip("()")) < LEAST
        else:
            assert float(cell.removesuffix(" %")) == pytest.approx(100 * (~inside.success).mean(), abs=6.0)
    assert abs(total - len(mine)) <= 4  # edges are shown in three digits
    exact = [(int(a), int(b)) for a, b in re.findall(r'title="(\d+) of (\d+)"', block)]
    assert all(n >= LEAST for _, n in exact)
    assert sum(lost for lost, _ in exact) > 0
    assert any("remaining" in line[0] for line in lines)


def test_the_figures_show_what_there_is(page: str) -> None:
    shown = section(page, "distributions")
    assert shown.count('class="line"') == 2 * 2  # final and settling, two cells
    assert shown.count('class="band"') == 2 * 2
    assert shown.count('class="level"') == 1
    assert "limit 0.5" in shown
    line = re.search(r'class="line" [^>]*points="([^"]*)"', shown)
    assert line is not None
    points = np.array([[float(x) for x in pair.split(",")] for pair in line[1].split()])
    assert len(points) > 100
    assert np.all(np.diff(points[:, 0]) >= 0.0)
    assert np.all(np.diff(points[:, 1]) <= 0.0)  # a distribution function, downwards on the screen
    assert section(page, "envelope").count('class="line"') == 3
    matters = rows(section(page, "sensitivity"))
    assert matters[0] == ["input", "plain", "robust"]
    assert {"initial.q_NB[2]", "fault.bus.0.probability"} & {row[0] for row in matters[1:4]}
    assert section(page, "sensitivity").count('class="column"') >= 16


def test_the_worst_ten_can_be_flown_again(page: str, flown: gs.CampaignResult) -> None:
    head, *lines = rows(section(page, "worst"))
    assert len(lines) == 10
    table = (
        flown.table()
        .to_pandas()
        .query("status != 'refused'")
        .sort_values(["margin", "run", "cell"], ascending=[False, True, True])
    )
    assert [(int(r[0]), r[1]) for r in lines] == list(zip(table.run[:10], table.cell[:10], strict=True))
    run, cell = lines[0][:2]
    command = lines[0][head.index("again")]
    assert command == f"gyrostat campaign rerun '{flown.folder}' {run} --cell {cell}"
    done = CliRunner().invoke(app, ["campaign", "rerun", str(flown.folder), run, "--cell", cell])
    assert done.exit_code == 0
    assert "equal to the bit" in done.output


def test_a_verdict_stands_on_top(tmp_path: Path) -> None:
    (tmp_path / "campaign.toml").write_text(toml.write(TABLES))
    wanted = [
        {"id": "A-1", "text": "mostly there", "probability": {"at_most": 0.99}},
        {"id": "A-2", "probability": {"at_most": 0.001}},
    ]
    tables = {"campaign": "campaign.toml", "max_runs": 500, "requirement": wanted}
    (tmp_path / "requirement.toml").write_text(toml.write(tables))
    told = gs.verify(tmp_path / "requirement.toml", tmp_path / "flown")
    done = CliRunner().invoke(app, ["report", str(tmp_path / "flown")])
    assert done.exit_code == 0
    assert done.output == f"page: {tmp_path / 'flown' / 'report.html'}\n"
    page = (tmp_path / "flown" / "report.html").read_text()
    assert page.index('<section id="verdict">') < page.index('<section id="what">')
    said = rows(section(page, "verdict"))[1:]
    for row, j in zip(said, told.judgements, strict=True):
        assert row[0] == j.name
        assert row[1] == f"{j.verdict.outcome} at run {j.verdict.runs}"
        assert row[3] == str(j.verdict.failures)
    assert [row[1].split()[0] for row in said] == ["PASS", "FAIL"]
    assert "<b>FAIL</b>" in page  # of both together
    evidence = section(page, "evidence")
    assert evidence.count("<svg") == 2
    assert "1/α = 20" in evidence
    assert "1/β = 40" in evidence  # any FAIL of two
    left = json.loads((tmp_path / "flown" / "requirements.json").read_text())
    for spoilt in ({}, left | {"runs": 10**9, "max_runs": 10**9}, left | {"runs": 0}, left | {"runs": 1e999}):
        (tmp_path / "flown" / "requirements.json").write_text(json.dumps(spoilt))
        with pytest.raises(gs.InputError, match=r"requirements\.json: is not what gyrostat verify wrote"):
            gs.CampaignResult(tmp_path / "flown").to_html(tmp_path / "other.html")
    assert not (tmp_path / "other.html").exists()


def test_what_rows_do_not_allow_is_not_shown(tmp_path: Path) -> None:
    few = campaign(keep={"rows": "failures"}).run(60, out=tmp_path / "few")
    page = few.to_html(tmp_path / "few.html").read_text()
    assert "[keep] rows = &#x27;all&#x27;" in section(page, "faults")
    assert "without intervals" in section(page, "quantiles")
    assert "<svg" not in section(page, "distributions")
    counts = few.counts[""]
    assert rows(section(page, "cells"))[1][1:3] == ["60", str(counts.failures)]
    net = campaign(sampling="lhs", replicates=4).run(80, out=tmp_path / "net")
    page = net.to_html(tmp_path / "net.html").read_text()
    lost = ~net.table().column("success").to_numpy().reshape(4, 20)
    rates = lost.mean(axis=1)
    half = stats.t.ppf(0.975, 3) * rates.std(ddof=1) / 2.0
    low, high = max(rates.mean() - half, 0.0), min(rates.mean() + half, 1.0)
    assert rows(section(page, "cells"))[1][4] == f"{100 * low:.3g} % to {100 * high:.3g} %"
    assert "depend on each other" in section(page, "assumptions")
    assert 'class="band"' not in page


def test_bad_input_writes_nothing(flown: gs.CampaignResult, tmp_path: Path) -> None:
    with pytest.raises(gs.InputError, match="no cell 'robst', did you mean 'robust'"):
        flown.to_html(tmp_path / "a.html", "robst")
    (tmp_path / "mine.html").write_text("<h1>mine</h1>")
    with pytest.raises(gs.InputError, match="is there already and is not a page of gyrostat"):
        flown.to_html(tmp_path / "mine.html")
    done = CliRunner().invoke(app, ["report", str(tmp_path)])
    assert isinstance(done.exception, gs.InputError)
    assert [p.name for p in tmp_path.iterdir()] == ["mine.html"]
