# SPDX-License-Identifier: MIT
"""Missions: what their pages show is what flies, and their commands lead from an empty folder to a flight."""

from __future__ import annotations

import re
from collections.abc import Callable
from functools import cache
from importlib.machinery import SourceFileLoader
from importlib.util import module_from_spec, spec_from_loader
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest
from typer.testing import CliRunner

import gyrostat as gs
from gyrostat.cli import app

ROOT = Path(__file__).parents[2]
Fly = Callable[[str], dict[str, gs.Result]]
NAMES = ("agile_cmg", "cubesat_6u", "geo_thrusters", "smallsat_flexible")


@pytest.fixture(scope="module")
def missions() -> ModuleType:
    loader = SourceFileLoader("missions", str(ROOT / "docs" / "figures" / "missions.py"))
    module = module_from_spec(spec_from_loader("missions", loader))  # type: ignore[arg-type]
    loader.exec_module(module)
    return module


@pytest.fixture(scope="module")
def fly(missions: ModuleType) -> Fly:
    """Both flights of a mission, flown once."""
    return cache(missions.fly)


def numbers(text: str) -> dict[str, tuple[float, float]]:
    """Rows of a table: as shipped, and without faults."""
    lines = [line for line in text.splitlines() if not line.startswith("#")][1:]
    return {name: (float(a), float(b)) for name, a, b in (line.split(",") for line in lines)}


def test_the_missions_are_the_vehicles_of_the_pages(missions: ModuleType) -> None:
    pages = {p.stem for p in (ROOT / "docs" / "missions").glob("*.md")} - {"index"}
    assert set(missions.MISSIONS) == set(NAMES) == pages


@pytest.mark.parametrize("name", NAMES)
def test_a_mission_flies_what_its_page_says(missions: ModuleType, fly: Fly, name: str) -> None:
    flights = fly(name)
    assert all(flown.completed for flown in flights.values())
    written = numbers((ROOT / "docs" / "figures" / f"mission_{name}.csv").read_text(encoding="utf-8"))
    flown = numbers(missions.table(name, flights))
    assert list(written) == list(flown)
    for quantity, values in flown.items():
        # sensors' noise is the same everywhere, its sums round differently; below 1e-6 a healthy error is rounding
        assert written[quantity] == pytest.approx(values, rel=0.05, abs=1e-6), quantity
    figure = missions.draw(name, flights)
    with np.load(ROOT / "docs" / "figures" / f"mission_{name}.npz") as saved:
        assert set(saved.files) - {"units"} == set(figure.data)
        for signal, values in figure.data.items():
            drawn = saved[signal]
            np.testing.assert_allclose(drawn, values, rtol=0, atol=0.02 * np.abs(values).max(), err_msg=signal)
    assert {label for _, label in figure.marks} >= {f.type.replace("_", " ") for f in gs.Scenario.load(name).faults}


def test_the_cubesat_comes_to_rest_and_points_through_its_faults(missions: ModuleType, fly: Fly) -> None:
    told = numbers(missions.table("cubesat_6u", fly("cubesat_6u")))
    assert told["rate at the start (deg/s)"][0] > 4.0
    assert told["below 1 deg from (s)"][0] < 150.0
    assert told["largest pointing error from the dead torquer on (deg)"][0] < 0.2
    assert (
        told["momentum of the wheels at 1500 s (mN m s)"][0] < 0.05 * told["largest momentum of the wheels (mN m s)"][0]
    )


def test_the_station_is_held_through_an_eclipse_in_which_a_valve_sticks(missions: ModuleType, fly: Fly) -> None:
    scenario = gs.Scenario.load("geo_thrusters")
    stuck = next(f for f in scenario.faults if f.type == "dead")
    flights = fly("geo_thrusters")
    shipped = flights["as shipped"]
    dark = np.ravel(shipped["truth.eclipse"]) == 1.0
    began, ended = shipped.t[dark][0], shipped.t[dark][-1]
    assert began < float(stuck.params["t_on"]) < ended < scenario.duration
    # half the angle of the shadow of a sphere at that distance, over the mean motion of a day of 86164 s
    half = np.arcsin(6378137.0 / 42164170.0) / (2.0 * np.pi) * 86164.1
    assert ended - began == pytest.approx(2.0 * half, abs=2.0)
    told = numbers(missions.table("geo_thrusters", flights))
    lit, shadow = (told[f"torque from outside in {where} (uN m)"][0] for where in ("sunlight", "the shadow"))
    assert shadow < 0.01 * lit
    assert told["largest pointing error from the stuck valve on (deg)"][0] < 0.3
    assert told["propellant in all (g)"][0] > 5.0 * told["propellant in all (g)"][1], "the leak shows"


def test_the_vehicle_in_python_is_that_of_the_scenario() -> None:
    vehicle, thrusters = gs.vehicle.geo_thrusters()
    scenario = gs.Scenario.load("geo_thrusters")
    assert scenario.vehicle == vehicle
    assert scenario.thrusters is not None
    np.testing.assert_allclose(thrusters.D_B, scenario.thrusters.D_B, atol=1e-15)
    np.testing.assert_allclose(thrusters.torque, scenario.thrusters.torque, rtol=1e-15)
    assert thrusters.to_dict().keys() == scenario.thrusters.to_dict().keys()


@pytest.mark.parametrize("name", NAMES)
def test_the_commands_of_a_page_lead_from_an_empty_folder_to_a_flight(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    page = (ROOT / "docs" / "missions" / f"{name}.md").read_text(encoding="utf-8")
    (block,) = re.findall(r"```sh\n(.*?)```", page, re.DOTALL)
    lines = block.splitlines()
    assert [line.split()[:2] for line in lines] == [["gyrostat", word] for word in ("new", "check", "run")]
    told = []
    for line in lines:
        done = CliRunner().invoke(app, line.split()[1:])
        assert done.exit_code == 0, f"{line}: {done.output}"
        told.append(done.output)
    assert gs.Scenario.load("my.toml") == gs.Scenario.load(name)
    assert "fails" not in told[1]
    assert (tmp_path / "flight" / "index.html").stat().st_size > 50_000
    assert gs.Result.load(tmp_path / "flight" / "result.npz").completed
