# SPDX-License-Identifier: MIT
"""Exported code does what the scenario's closed loop did: built by the compiler of this machine, run, and compared."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import gyrostat as gs
from gyrostat import _core
from gyrostat.export import export
from gyrostat.export.model import SAMPLES, flight_code

ROLES = ("observer", "detector", "controller", "allocator")
# wheel2_degraded loses its wheel at 20 s = sample 2000, table1 has the first faults at 10 s = sample 10 000;
# test_export_stacks.py has every stack
CASES = {"cpp": ("wheel2_degraded", SAMPLES), "c": ("li2018/table1", 11_000)}


def load(case: str) -> gs.Scenario:
    return gs.Scenario.load(case)


def built_and_tested(folder: Path) -> str:
    """What ``ctest`` printed after a build by cmake, both as the folder's page says."""
    build = folder / "build"
    for command in (
        ["cmake", "-S", str(folder), "-B", str(build)],
        ["cmake", "--build", str(build)],
        ["ctest", "--test-dir", str(build), "--verbose", "--no-tests=error"],
    ):
        done = subprocess.run(command, capture_output=True, text=True, timeout=300, check=False)
        assert done.returncode == 0, done.stdout + done.stderr
        assert "warning" not in (done.stdout + done.stderr).lower()
    return done.stdout


@pytest.mark.parametrize("target", CASES)
def test_an_exported_stack_repeats_the_recorded_loop(target: str, tmp_path: Path) -> None:
    case, samples = CASES[target]
    export(load(case), target, tmp_path / "out", samples=samples)
    said = built_and_tested(tmp_path / "out")
    assert f"{samples} samples, largest deviation" in said  # and the self-test itself passed: within 1e-12


def test_in_float_it_is_the_same_law(tmp_path: Path) -> None:
    export(load("wheel2_degraded"), "c", tmp_path / "out", scalar="float", samples=500)
    assert "typedef float" in (tmp_path / "out" / "wheel2_degraded.h").read_text()
    assert "500 samples in float" in built_and_tested(tmp_path / "out")
    # The self-test can fail: a record of something else is refused.
    path = tmp_path / "out" / "recorded.csv"
    rows = path.read_text().splitlines()
    at = rows[0].split(",").index("allocation.u[0]")
    changed = [
        [*cells[:at], str(float(cells[at]) + 0.1), *cells[at + 1 :]] for cells in (r.split(",") for r in rows[1:])
    ]
    path.write_text("\n".join([rows[0], *map(",".join, changed), ""]))
    done = subprocess.run([tmp_path / "out" / "build" / "self_test", path], capture_output=True, text=True, check=False)
    assert done.returncode == 1
    assert "allocation.u" in done.stdout


def catalogue() -> list[tuple[str, str]]:
    return [(role, name) for role in ROLES for name in _core.catalogue()[role]]


@pytest.mark.parametrize(("role", "name"), catalogue(), ids="-".join)
def test_every_flight_component_has_its_class_header_and_parameters(role: str, name: str, tmp_path: Path) -> None:
    scenario = load("ftc_4rw").replace(**{role: name}, duration=0.02)
    model = next(c for c in scenario.compiled.flight_model()["components"] if c["role"] == role)
    if model["cpp"].startswith("gyrostat::host::"):
        with pytest.raises(gs.InputError, match=f"{role} '{name}' runs in the host alone"):
            export(scenario, "cpp", tmp_path / "out")
        return
    export(scenario, "cpp", tmp_path / "out")
    written = (tmp_path / "out" / "ftc_4rw.hpp").read_text()
    header = re.search(rf'#include "(gyrostat/flight/{role}s/{name}.hpp)"', written)
    assert header is not None
    text = (tmp_path / "out" / "include" / header[1]).read_text()
    assert re.search(rf"class {model['cpp'].removeprefix('gyrostat::')}\b", text)
    assert f'name = "{name}"' in text
    for p in _core.describe(role, name)["params"]:
        assert f'set_parameter(p.{role}, "{p["name"]}", ' in written


def test_the_folder_needs_nothing_but_eigen(tmp_path: Path) -> None:
    export(load("wheel2_degraded"), "c", tmp_path / "out", samples=2)
    for path in (tmp_path / "out").rglob("*.[hc]*"):
        for included in re.findall(r'#include "(.*)"', path.read_text()):
            assert any((root / included).exists() for root in (tmp_path / "out", tmp_path / "out" / "include")), (
                included
            )
        assert str(tmp_path) not in path.read_text()
    assert "MIT License" in (tmp_path / "out" / "include" / "gyrostat" / "LICENSE").read_text()


def test_the_recorded_rows_read_back_exactly(tmp_path: Path) -> None:
    code = export(load("wheel2_degraded"), "cpp", tmp_path / "out", samples=50)
    rows = np.loadtxt(tmp_path / "out" / "recorded.csv", delimiter=",", skiprows=1)
    np.testing.assert_array_equal(rows, code.rows)
    flown = load("wheel2_degraded").replace(duration=49 * code.dt).run(channels=["allocation.u", "measurement.q_NB"])
    for name in ("allocation.u", "measurement.q_NB"):
        np.testing.assert_array_equal(code.column(name), flown[name])
    assert gs.Scenario.from_toml(tmp_path / "out" / "scenario.toml") == load("wheel2_degraded")


def test_the_whole_run_is_recorded_when_asked() -> None:
    scenario = load("ftc_4rw").replace(duration=0.5)
    assert len(flight_code(scenario, scalar="double", samples=0, name=None).rows) == 51
    assert len(flight_code(scenario, scalar="double", samples=SAMPLES, name=None).rows) == 51


class Damping:
    def step(self, x: gs.Estimate, *_: object) -> np.ndarray:
        return -x.omega_BN_B


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"controller": Damping()}, "controller: Damping is a Python object"),
        ({"shadows": [{"observer": "passthrough"}]}, "shadows are not part of the flight stack"),
    ],
)
def test_what_is_not_flight_code_is_refused(changes: dict[str, Any], said: str, tmp_path: Path) -> None:
    with pytest.raises(gs.InputError, match=said):
        export(load("ftc_4rw").replace(**changes), "cpp", tmp_path / "out")
    assert list(tmp_path.iterdir()) == []


def test_euler_angle_vehicles_and_unstable_settings_are_refused_in_a_line(tmp_path: Path) -> None:
    with pytest.raises(gs.InputError, match="coordinates euler_angles cannot be exported"):
        export(load("cao2023/printed"), "cpp", tmp_path / "out")
    unstable = load("li2018/table1").replace(**{"controller.eps": 1e-9})
    with pytest.raises(gs.InputError, match=re.escape("(K3 + mu / eps) * dt")):
        export(unstable, "cpp", tmp_path / "out")
    assert list(tmp_path.iterdir()) == []
    export(unstable.replace(allow_unstable=True), "cpp", tmp_path / "out", samples=2, name="told")
    assert "allow_unstable = true" in (tmp_path / "out" / "told.hpp").read_text()


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        ({"target": "rust"}, "no target 'rust'; there are: c, cpp, fmu"),
        ({"scalar": "half"}, "no scalar 'half'"),
        ({"target": "fmu", "scalar": "float"}, "an FMU exchanges double"),
        ({"samples": 1}, "samples = 1"),
        ({"name": "my stack"}, "name 'my stack'"),
        ({"name": "union"}, "name 'union'"),
    ],
)
def test_a_wrong_argument_is_said(arguments: dict[str, Any], said: str, tmp_path: Path) -> None:
    with pytest.raises(gs.InputError, match=re.escape(said)):
        export(load("ftc_4rw"), **{"target": "cpp", "out": tmp_path / "out", **arguments})
    assert list(tmp_path.iterdir()) == []


def test_a_folder_with_something_in_it_is_left_alone(tmp_path: Path) -> None:
    (tmp_path / "mine.txt").write_text("mine")
    for out in (tmp_path, tmp_path / "mine.txt"):
        with pytest.raises(gs.InputError, match="name a new or empty one"):
            export(load("ftc_4rw"), "cpp", out, samples=2)
    assert [p.name for p in tmp_path.iterdir()] == ["mine.txt"]
    (tmp_path / "empty").mkdir()
    export(load("ftc_4rw"), "cpp", tmp_path / "empty", samples=2)


def command_line(*arguments: str, **environment: str) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-c", "from gyrostat.cli import main; main()", "export", *arguments]
    variables = {**{k: v for k, v in os.environ.items() if k not in ("CXX", "EIGEN3_INCLUDE_DIR")}, **environment}
    return subprocess.run(command, capture_output=True, text=True, env=variables, timeout=120, check=False)


@pytest.mark.parametrize(
    ("environment", "said"),
    [
        ({"PATH": "/nowhere"}, "no C++ compiler found (c++, g++, clang++)"),
        ({"CXX": "nocc -O3"}, "CXX = nocc -O3: no such compiler"),
        ({"CXX": "false"}, "false does not compile the FMU"),
        ({"EIGEN3_INCLUDE_DIR": "/nowhere"}, "EIGEN3_INCLUDE_DIR = /nowhere: holds no Eigen/Core"),
    ],
)
def test_a_missing_compiler_is_one_line(environment: dict[str, str], said: str, tmp_path: Path) -> None:
    done = command_line("ftc_4rw", "--target", "fmu", "--out", str(tmp_path / "out"), "--samples", "2", **environment)
    assert done.returncode == 2
    assert done.stderr.startswith("error: ")
    assert done.stderr.count("\n") == 1
    assert said in done.stderr
    assert list(tmp_path.iterdir()) == []


def test_the_command_line_exports_what_it_says(tmp_path: Path) -> None:
    out = tmp_path / "new" / "folder"
    settings = ["--set", "observer.lambda1=2", "--samples", "10", "--name", "safe_mode", "--scalar", "float"]
    done = command_line("wheel2_degraded", "--target", "c", "--out", str(out), *settings)
    assert done.returncode == 0, done.stderr
    assert "10 recorded samples" in done.stdout
    assert {p.name for p in out.iterdir()} == {
        *("CMakeLists.txt", "README.md", "include", "recorded.csv", "recorded.h", "scenario.toml", "self_test.c"),
        *("safe_mode.cpp", "safe_mode.h", "safe_mode.hpp"),
    }
    assert '"lambda1", 2.0)' in (out / "safe_mode.hpp").read_text()
