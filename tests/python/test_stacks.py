# SPDX-License-Identifier: MIT
"""The recommended stack and the file that ``gyrostat new`` writes."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

import gyrostat as gs
from gyrostat.cli import app
from gyrostat.errors import InputError
from gyrostat.first_scenario import first_scenario, has_wheels_alone, like, vehicles


@pytest.mark.parametrize("tachometers", [True, False])
def test_the_stack_points_with_a_stuck_wheel(*, tachometers: bool) -> None:
    scenario = gs.Scenario(
        vehicle=gs.vehicle.ftc_4rw(),
        initial=gs.Initial(mrp=(0.1, 0.2, -0.3)),
        faults=[gs.faults.Stuck(actuator=2, t_on=20.0, torque=-0.05)],
        integrator="rk4",
        duration=200.0,
        dt=0.1,
        **gs.recommended(tachometers=tachometers),
    )
    result = scenario.run(channels=["error.angle", "detection.failed"])
    assert result["error.angle"][result.t > 160.0].max() < math.radians(0.1)
    assert not result["detection.failed"].any()


@pytest.mark.parametrize("vehicle", [name for name, one in vehicles().items() if has_wheels_alone(one)])
def test_a_new_scenario_flies_what_it_says(vehicle: str, tmp_path: Path) -> None:
    file = tmp_path / "my.toml"
    done = CliRunner().invoke(app, ["new", str(file), "--vehicle", vehicle])
    assert done.exit_code == 0, done.output
    assert f"gyrostat run {file}" in done.output
    scenario = gs.Scenario.load(str(file))
    for role, component in gs.recommended().items():
        assert scenario.resolve()[role]["type"] == component.type
    result = scenario.run(channels=["error.angle"])
    assert result.completed
    assert np.sqrt(np.mean(result["error.angle"][result.t > 160.0] ** 2)) < math.radians(0.1)


def test_every_shipped_vehicle_can_be_started_from(tmp_path: Path) -> None:
    assert {"cubesat_6u", "flexible_4", "ftc_4rw"} <= set(vehicles())
    for name, scenario in vehicles().items():
        file = tmp_path / f"{name}.toml"
        file.write_text(first_scenario(name))
        assert gs.Scenario.from_toml(file).vehicle == scenario.vehicle, name
    assert first_scenario("cubesat") == first_scenario("cubesat_6u")  # the beginning of a name is enough
    for start in ("f", ""):
        with pytest.raises(InputError, match=r"no vehicle|several vehicles 'f': flexible_4, ftc_4rw"):
            first_scenario(start)


@pytest.mark.parametrize("name", ["wheel2_degraded", "li2018/table2"])
def test_a_scenario_like_another_is_that_one(name: str, tmp_path: Path) -> None:
    file = tmp_path / "my.toml"
    done = CliRunner().invoke(app, ["new", str(file), "--like", name])
    assert done.exit_code == 0, done.output
    assert gs.Scenario.load(str(file)) == gs.Scenario.load(name)
    assert file.read_text().startswith(f"# As {name}. ")
    again = CliRunner().invoke(app, ["new", str(tmp_path / "again.toml"), "--like", str(file)])
    assert again.exit_code == 0, again.output


def test_what_cannot_be_started_from_is_one_line(tmp_path: Path) -> None:
    file = str(tmp_path / "my.toml")
    for arguments, words in {
        ("--like", "wheel2"): "no scenario 'wheel2'",
        ("--like", "ftc_4rw", "--vehicle", "ftc_4rw"): "--vehicle and --like: give one of them",
    }.items():
        done = CliRunner().invoke(app, ["new", file, *arguments])
        assert str(done.exception).startswith(words)
    assert not list(tmp_path.iterdir())
    with pytest.raises(InputError, match="no scenario 'nobody'"):
        like("nobody")


def test_nothing_is_overwritten(tmp_path: Path) -> None:
    file = tmp_path / "my.toml"
    file.write_text("mine")
    done = CliRunner().invoke(app, ["new", str(file)])
    assert isinstance(done.exception, InputError)
    assert "is there already" in str(done.exception)
    assert file.read_text() == "mine"


def test_an_unknown_vehicle_or_ending_is_one_line(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="did you mean 'ftc_4rw'"):
        first_scenario("ftc_4w")
    done = CliRunner().invoke(app, ["new", str(tmp_path / "my.txt")])
    assert "ends in .toml" in str(done.exception)
    assert not list(tmp_path.iterdir())
