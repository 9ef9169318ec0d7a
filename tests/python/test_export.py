# SPDX-License-Identifier: MIT
"""Exported code does what the scenario's closed loop did: built by the compiler of this machine, run, and compared."""

from __future__ import annotations

import os
import re
import shlex
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import gyrostat as gs
from gyrostat import _core
from gyrostat.export import export
from gyrostat.export.compiler import find_eigen
from gyrostat.export.model import SAMPLES, flight_code

ROLES = ("observer", "detector", "controller", "allocator")
# wheel2_degraded loses its wheel at 20 s = sample 2000, table1 has the first faults at 10 s = sample 10 000; in both
# attitude, rate and wheel momentum are not measured for a while. test_export_stacks.py has every stack.
CASES = {"cpp": ("wheel2_degraded", SAMPLES), "c": ("li2018/table1", 11_000)}
DROPOUTS = [
    gs.sensors.AttitudeDropout(t_on=2.0, t_off=3.0),
    gs.sensors.RateDropout(t_on=4.0, t_off=4.5),
    gs.sensors.MomentumDropout(t_on=6.0, t_off=6.5),
    gs.sensors.RateDropout(t_on=8.0, t_off=8.1),
    gs.sensors.AttitudeDropout(t_on=8.0, t_off=8.1),
]


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
    scenario = load(case)
    scenario = scenario.replace(sensors=[*scenario.sensors, *DROPOUTS])
    code = export(scenario, target, tmp_path / "out", samples=samples)
    said = built_and_tested(tmp_path / "out")
    assert f"{samples} samples, largest deviation" in said  # and the self-test itself passed: within 1e-12
    # It reads what was not measured: told that all was, it flies on numbers that stood still, and says so.
    path = tmp_path / "out" / "recorded.csv"
    rows = [line.split(",") for line in path.read_text().splitlines()]
    for signal, seconds in (("attitude", 1.1), ("rate", 0.6), ("momentum", 0.5)):
        at = rows[0].index(f"measurement.{signal}_valid")
        assert [row[at] for row in rows].count("0") == round(seconds / code.dt)
        told = [rows[0], *([*row[:at], "1", *row[at + 1 :]] for row in rows[1:])]
        path.write_text("\n".join([*map(",".join, told), ""]))
        done = subprocess.run(
            [tmp_path / "out" / "build" / "self_test", path], capture_output=True, text=True, check=False
        )
        assert done.returncode == 1, signal


def test_exports_for_vehicles_of_four_and_six_actuators_fly_in_one_program(tmp_path: Path) -> None:
    """Each is compiled for its own size; together they command what they command alone."""
    six = gs.Vehicle(
        J_B=(20.0, 17.0, 15.0), D_B=np.hstack([np.eye(3), np.eye(3)[:, ::-1]]).tolist(), u_max=0.2, wheel_inertia=0.05
    )
    four = load("ftc_4rw")
    scenarios = {"four": four, "six": four.replace(vehicle=six)}
    codes = {name: export(s, "c", tmp_path / name, samples=2, name=name) for name, s in scenarios.items()}
    assert [code.capacity for code in codes.values()] == [4, 8]
    assert codes["four"].bytes["double"] < codes["six"].bytes["double"]
    compiler = shlex.split(os.environ.get("CXX", "c++"))
    objects = {}
    for name in codes:
        folder = tmp_path / name
        objects[name] = str(folder / "stack.o")
        includes = [f"-I{folder}", f"-I{folder / 'include'}", "-isystem", str(find_eigen())]
        subprocess.run(
            [*compiler, "-std=c++20", "-O0", *includes, "-c", str(folder / f"{name}.cpp"), "-o", objects[name]],
            check=True,
            timeout=600,
        )

    def commands(*names: str) -> list[str]:
        steps = "\n".join(
            f"""
  static {n} {n}_flight;
  if ({n}_init(&{n}_flight) != 0) return 1;
  for (int k = 0; k < 50; ++k) {{
    {n}_measurement y = {{0}};
    {n}_reference r = {{0}};
    {n}_command c;
    y.tick = k;
    y.q_NB[0] = r.q_NR[0] = 0.8; y.q_NB[1] = 0.6; r.q_NR[2] = 0.6;
    y.omega_BN_B[2] = 1e-3 * k;
    if ({n}_step(&{n}_flight, &y, &r, &c) != 0) return 1;
    if (k == 49) for (int i = 0; i < {n.upper()}_ACTUATORS; ++i) printf("{n} %.17g\\n", c.u[i]);
  }}"""
            for n in names
        )
        source, program = tmp_path / "main.c", tmp_path / "main"
        heads = "".join(f'#include "{n}.h"\n' for n in names)
        source.write_text(f"#include <stdio.h>\n{heads}int main(void) {{{steps}\n  return 0;\n}}\n")
        folders = [f"-I{tmp_path / n}" for n in names]
        main = str(tmp_path / "main.o")
        subprocess.run([os.environ.get("CC", "cc"), *folders, "-c", str(source), "-o", main], check=True, timeout=60)
        subprocess.run([*compiler, main, *(objects[n] for n in names), "-o", str(program)], check=True, timeout=60)
        return subprocess.run([program], capture_output=True, text=True, check=True, timeout=60).stdout.splitlines()

    together = commands("four", "six")
    assert together == commands("four") + commands("six")
    assert len(together) == 10
    assert all(float(line.split()[1]) != 0.0 for line in together)


def test_in_float_it_is_the_same_law(tmp_path: Path) -> None:
    """Of gyros, whose angles come with every sample; test_export_stacks.py flies the same in double."""
    code = export(load("agile_cmg"), "c", tmp_path / "out", scalar="float", samples=500)
    assert code.columns["measurement.gimbal"] == 4
    assert "typedef float" in (tmp_path / "out" / "agile_cmg.h").read_text()
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
