# SPDX-License-Identifier: MIT
"""Pages of runs before a browser sees them: what is kept of the data, where it is written, what is refused."""

from __future__ import annotations

import base64
import dataclasses
import json
import re
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays

import gyrostat as gs
from gyrostat import page, plots, thinning
from gyrostat.page import content, geometry, marks, packing, panels, writer

_signals = arrays.arrays(
    np.float64,
    st.integers(1, 300),
    elements=st.one_of(st.floats(-1e3, 1e3), st.sampled_from([0.0, 1.0, np.nan])),
)


def data_of(path: Path) -> dict[str, Any]:
    found = re.search(r'id="data">(.*?)</script>', path.read_text(), re.DOTALL)
    assert found is not None
    return json.loads(found[1])


@given(_signals, st.integers(1, 50))
def test_thinning_keeps_the_extremes_of_every_stretch_both_ends_and_gaps(x: np.ndarray, stretch: int) -> None:
    kept = thinning.min_max(x, stretch)
    assert kept[0] == 0
    assert kept[-1] == len(x) - 1
    assert np.all(np.diff(kept) > 0)
    # what is drawn between two kept equal values is constant, so interpolation restores what was left out
    drawn = np.interp(np.arange(len(x)), kept, np.nan_to_num(x[kept]))
    for start in range(0, len(x), stretch):
        part = x[start : start + stretch]
        if np.all(np.isnan(part)):
            continue
        now = drawn[start : start + stretch]
        assert np.nanmax(part) <= now.max() + 1e-9
        assert np.nanmin(part) >= now.min() - 1e-9
    assert np.isnan(x).any() == np.isnan(x[kept]).any()


def test_thinning_uses_the_budget_and_not_more() -> None:
    rng = np.random.default_rng(3)
    signals = {"noise": rng.normal(size=20_001), "more": rng.normal(size=20_001), "constant": np.ones(20_001)}

    def size(kept: thinning.Indices) -> int:
        return packing.cost(20_001, kept)

    for budget in (20_000, 100_000, 10_000_000):
        found = thinning.within(signals, budget, size)
        used = sum(size(k) for k in found.kept.values())
        assert used <= budget
        assert found.stretch == 1 or used > 0.85 * budget  # the stretch is found within 5 %, and is a whole number
        assert len(found.kept["constant"]) == 2
    assert found.stretch == 1


def test_what_costs_is_what_is_written() -> None:
    for samples in (100, 70_000):
        kept = np.arange(0, samples, 7)
        written = packing.pack_indices(kept, samples) + packing.pack(kept)
        assert abs(packing.cost(samples, kept) - 90 - len(written)) <= 8  # padding of base64


def test_packed_numbers_have_seven_digits_and_no_infinity() -> None:
    x = np.array([0.1, -2e-9, 3e30, np.inf, -np.inf, np.nan, 1e300])
    read = np.frombuffer(base64.b64decode(packing.pack(x)), dtype="<f4")
    np.testing.assert_allclose(read[:3], x[:3], rtol=6e-8)  # half a unit of the last of 24 bits
    assert np.isnan(read[3:]).all()


@pytest.mark.parametrize("t", [[0.0], [0.0, 0.1], [0.0, 0.07, 0.14, 0.2], [0.0, 0.1, 0.5, 0.6], [5.0, 6.0, 7.0]])
def test_the_clock_of_a_page_gives_every_instant(t: list[float]) -> None:
    clock = packing.clock(np.array(t))
    if "times" in clock:
        again = np.frombuffer(base64.b64decode(clock["times"]), dtype="<f8")
    else:
        again = clock["start"] + clock["step"] * np.arange(clock["count"])
        again[-1] = clock["end"]
    np.testing.assert_allclose(again, t, rtol=1e-12)


@pytest.mark.parametrize("rotation", [np.eye(3), np.array([[0.8, -0.6, 0.0], [0.6, 0.8, 0.0], [0.0, 0.0, 1.0]])])
def test_the_drawn_box_has_the_vehicles_inertia(rotation: np.ndarray) -> None:
    J_B = rotation @ np.diag([20.0, 17.0, 15.0]) @ rotation.T
    half = geometry.box(J_B)
    # of a homogeneous box of mass m: J = m/3 (sum |a_i|^2 I - sum a_i a_i'), summed here over its corners' directions
    of_box = np.trace(half @ half.T) * np.eye(3) - half @ half.T
    np.testing.assert_allclose(of_box / np.trace(of_box), J_B / np.trace(J_B), rtol=1e-12, atol=1e-14)
    assert np.linalg.norm(half, axis=0).max() == pytest.approx(1.0)
    assert np.all(np.diag(half) > 0.0)


@pytest.mark.parametrize("J_B", [(1.0, 1.0, 1.0), (1.0, 1.0, 2.0), (1.0, 1.0, 1e-9), (1e-6, 2e-6, 2.5e-6)])
def test_every_inertia_has_a_box_that_can_be_seen(J_B: tuple[float, ...]) -> None:
    edges = np.linalg.norm(geometry.box(J_B), axis=0)
    assert edges.max() == pytest.approx(1.0)
    assert edges.min() >= 0.3 - 1e-12


def test_actuators_stand_outside_the_body_and_not_in_each_other() -> None:
    D = np.column_stack([np.eye(3), np.eye(3), -np.eye(3), np.zeros(3)])
    vehicle = {"J_B": [20.0, 17.0, 15.0], "D_B": D.tolist(), "wheel_inertia": [0.05] * 3 + [0.0] * 7}
    drawn = geometry.actuators(vehicle)
    assert [a["kind"] for a in drawn] == ["wheel"] * 3 + ["torquer"] * 7
    at = np.array([a["at"] for a in drawn])
    half = geometry.box(vehicle["J_B"])
    assert np.all(np.abs(np.linalg.solve(half, at[:9].T)).max(axis=0) > 1.0)
    distances = np.linalg.norm(at[:, None] - at[None], axis=2)[np.triu_indices(10, 1)]
    assert distances.min() > 0.2
    np.testing.assert_array_equal(at[9], 0.0)


def test_momentum_is_drawn_with_the_inertia_less_the_wheels() -> None:
    vehicle = gs.vehicle.ftc_4rw()
    D = np.array(vehicle.D_B)
    expected = np.array(vehicle.J_B) - 0.05 * sum(np.outer(d, d) for d in D.T)
    drawn = geometry.body_inertia({"J_B": vehicle.J_B, "D_B": D, "wheel_inertia": 0.05})
    np.testing.assert_allclose(drawn, expected, atol=1e-14)


@pytest.mark.parametrize("name", ["wheel2_degraded", "yang2023/maneuver", "cao2023/printed", "cao2022/attitude"])
def test_what_a_page_records_holds_all_that_is_usual(name: str) -> None:
    scenario = gs.Scenario.load(name)
    # the usual ones are those of a run that names none; one period shows them
    usual = set(scenario.replace(duration=scenario.dt, record=None).run())
    assert usual <= set(page.channels(scenario)) if scenario.record is None else True
    assert "truth.lumped_B" in page.channels(scenario)


def test_shadows_are_recorded_and_a_choice_is_kept(scenario: gs.Scenario) -> None:
    beside = scenario.replace(shadows=[{"observer": "learning_effectiveness"}])
    usual = set(beside.replace(duration=0.1).run())
    assert usual <= set(page.channels(beside))
    chosen = scenario.replace(record={"channels": ["error.mrp", "demand.*"]})
    recorded = page.channels(chosen)
    assert {"error.mrp", "demand.*", "truth.q_NB"} <= set(recorded)
    assert not any(name.startswith("measurement") for name in recorded)


def test_a_page_is_whole_and_loads_nothing_from_elsewhere(result: gs.Result, tmp_path: Path) -> None:
    path = result.to_html(tmp_path / "run")
    assert path == tmp_path / "run" / "index.html"
    assert sorted(p.name for p in path.parent.iterdir()) == ["index.html", writer._script_name()]
    text = path.read_text()
    assert re.findall(r'(?:src|href)="([^"]*)"', text) == ["data:,", writer._script_name()]
    assert not re.search(r"(?:src|href)=[\"']?https?:|@import|fetch\(", text)
    data = data_of(path)
    frames = np.frombuffer(base64.b64decode(data["runs"][0]["frames"]["q"]), "<f4").reshape(-1, 4)
    kept = np.frombuffer(base64.b64decode(data["runs"][0]["frames"]["k"]), "<u2")
    np.testing.assert_allclose(frames, result["truth.q_NB"][kept], atol=6e-8)


def test_one_script_serves_all_pages_of_a_folder(result: gs.Result, tmp_path: Path) -> None:
    result.to_html(tmp_path / "a.html")
    script = tmp_path / writer._script_name()
    written = script.stat().st_mtime_ns
    result.to_html(tmp_path / "b.html")
    assert script.stat().st_mtime_ns == written
    alone = result.to_html(tmp_path / "alone" / "c.html", single_file=True)
    assert [p.name for p in alone.parent.iterdir()] == ["c.html"]
    assert alone.stat().st_size > script.stat().st_size


def test_text_of_a_scenario_cannot_leave_its_place(scenario: gs.Scenario, tmp_path: Path) -> None:
    nasty = "</script><b>{{data}} & \"'"
    path = scenario.replace(name=nasty, duration=1.0).run().to_html(tmp_path)
    text = path.read_text()
    assert text.count("</script>") == 4  # the page's own: trouble, data, plotly, script
    assert "<b>{{data}}" not in text
    assert "&lt;b&gt;{{data}} &amp; &quot;&#x27;" in text


@pytest.mark.parametrize("actuators", [4, 16])
def test_two_hundred_seconds_at_100_hz_are_half_a_megabyte(actuators: int, tmp_path: Path) -> None:
    rng = np.random.default_rng(actuators)
    D = rng.normal(size=(3, actuators))
    D /= np.linalg.norm(D, axis=0)
    scenario = gs.Scenario(
        vehicle=gs.Vehicle(J_B=(20.0, 17.0, 15.0), D_B=D.tolist(), u_max=0.2, wheel_inertia=0.05),
        initial=gs.Initial(mrp=(0.1, 0.2, -0.3)),
        observer="adaptive_iterative_learning",
        detector="threshold",
        controller="finite_time",
        faults=[gs.faults.LossOfEffectiveness(actuator=2, t_on=20.0, remaining=0.4)],
        sensors=[gs.sensors.Gyro(noise=1e-4)],  # every signal is lively: nothing is cheap to keep
        duration=200.0,
        dt=0.01,
    )
    result = scenario.run(channels=page.channels(scenario))
    events = tuple(gs.Event(0.02 * k, f"guard.{k % 5}", k) for k in range(10_000))
    path = dataclasses.replace(result, events=events).to_html(tmp_path)
    found = re.search(r'id="data">(.*?)</script>', path.read_text(), re.DOTALL)
    assert found is not None
    assert 300_000 < len(found[1]) <= 500_000  # thrifty, and not empty
    assert path.stat().st_size <= 600_000
    peak = np.degrees(result["error.angle"]).max()
    line = data_of(path)["panels"][0]["lines"][0]
    assert np.frombuffer(base64.b64decode(line["y"]), "<f4").max() == np.float32(peak)


def test_limits_are_levels_once_each() -> None:
    def limits(**vehicle: Any) -> list[tuple[float, str]]:
        return panels._limits(vehicle)

    assert limits() == []
    assert limits(u_max=0.2) == [(-0.2, "-u_max"), (0.2, "u_max")]
    assert limits(u_max=[0.2, 0.1, 0.2], u_min=-0.3) == [(-0.3, "u_min"), (0.1, "u_max"), (0.2, "u_max")]
    assert limits(u_max=float("inf")) == []


def test_faults_are_bands_from_onset_to_their_end(scenario: gs.Scenario) -> None:
    flown = scenario.replace(
        duration=10.0,
        faults=[
            gs.faults.Dead(actuator=1, t_on=2.0, t_off=4.0),
            gs.faults.Bias(actuator=0, torque=0.01),
            gs.faults.Lock(actuator=3, t_on=50.0),
        ],
    ).run()
    assert [(m.t, m.end, m.text) for m in marks.faults(flown)] == [
        (0.0, 10.0, "bias, actuator 0"),
        (2.0, 4.0, "dead, actuator 1"),
    ]


def test_declarations_name_the_actuators() -> None:
    flown = gs.Scenario.load("yang2023/maneuver").run()
    assert [m.text for m in marks.declared(flown)] == [f"declared: actuator {i}" for i in (0, 1, 2)]
    unnamed = dataclasses.replace(flown, channels={"error.angle": flown["error.angle"]})
    assert [(m.t, m.text) for m in marks.declared(unnamed)] == [(m.t, "declared") for m in marks.declared(flown)]


def test_what_happens_often_is_ticks_only(result: gs.Result) -> None:
    often = tuple(gs.Event(0.01 * k, "guard.held", k) for k in range(2_000))
    seldom = (gs.Event(3.0, "mode", 1), gs.Event(4.0, "reference.event", 1), gs.Event(5.0, "controller.arms", 1))
    busy = dataclasses.replace(result, events=(*often, *seldom))
    assert [m["kind"] for m in content._marks(busy)] == ["fault", "mode", "reference"]
    rows = {name: (times, number) for name, _, times, number in marks.rows(busy)}
    times, number = rows["guard.held"]
    assert number == 2_000
    assert len(times) <= 400
    assert np.diff(times).max() < 0.2  # spread over all 20 s
    assert rows["controller.arms"] == ([5.0], 1)


def test_a_file_that_is_no_page_is_kept(result: gs.Result, tmp_path: Path) -> None:
    mine = tmp_path / "index.html"
    mine.write_text("<h1>my site</h1>")
    with pytest.raises(gs.InputError, match=r"index\.html: is there already and is not a page of gyrostat"):
        result.to_html(tmp_path)
    assert [p.name for p in tmp_path.iterdir()] == ["index.html"]
    assert mine.read_text() == "<h1>my site</h1>"
    result.to_html(tmp_path / "other.html")
    result.to_html(tmp_path / "other.html")  # its own page it writes again


def test_a_result_without_channels_says_what_to_record(scenario: gs.Scenario, tmp_path: Path) -> None:
    bare = scenario.replace(duration=1.0).run(channels=["truth.mrp"])
    with pytest.raises(gs.InputError, match=r"nothing that a page shows was recorded; record some of: truth\.q_NB, e"):
        bare.to_html(tmp_path / "new")
    assert not (tmp_path / "new").exists()
    some = scenario.replace(duration=1.0).run(channels=["error.angle"])
    text = some.to_html(tmp_path / "new").read_text()
    for channel in ("truth.q_NB", "truth.omega_BN_B", "allocation.u", "truth.effectiveness", "truth.h_w"):
        assert f"<code>{channel}</code>" in text


def test_show_prints_where_the_page_is_without_a_browser(
    result: gs.Result, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    monkeypatch.setattr(sys, "platform", "linux")
    for display in ("DISPLAY", "WAYLAND_DISPLAY"):
        monkeypatch.delenv(display, raising=False)
    path = result.show()
    assert capsys.readouterr().out == f"{path}\n"
    assert path.is_file()
    monkeypatch.setenv("DISPLAY", ":0")
    opened: list[str] = []
    monkeypatch.setattr("webbrowser.open", lambda url: bool(opened.append(url)) or True)
    path = result.show()
    assert opened == [path.as_uri()]
    assert capsys.readouterr().out == ""
    monkeypatch.setattr("webbrowser.open", lambda _: False)
    assert str(result.show()) in capsys.readouterr().out


def test_a_page_of_a_python_component_and_of_a_loaded_result(scenario: gs.Scenario, tmp_path: Path) -> None:
    class Still:
        def step(self, *_: object) -> gs.Demand:
            return gs.Demand((0.0, 0.0, 0.0))

    flown = scenario.replace(controller=Still(), duration=1.0).run()
    again = gs.Result.load(flown.save(tmp_path / "run.npz"))
    for k, one in enumerate((flown, again)):
        text = one.to_html(tmp_path / f"{k}.html").read_text()
        assert "class = &quot;Still&quot;" in text


def test_plotly_stays_unloaded(tmp_path: Path) -> None:
    program = (
        "import sys, gyrostat as gs; s = gs.Scenario.load('ftc_4rw').replace(duration=1.0)\n"
        "s.run().to_html(sys.argv[1]); assert 'plotly' not in sys.modules"
    )
    subprocess.run([sys.executable, "-c", program, str(tmp_path)], check=True)


def test_figures_are_thinned_by_the_same_rule() -> None:
    t = np.arange(50_001) * 0.01
    x = np.sin(t)
    x[12_345] = 7.0
    few, drawn = plots.thin(t, x)
    assert drawn.max() == 7.0
    assert len(few) < 5_000
    assert few[-1] == t[-1]
