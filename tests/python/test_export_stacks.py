# SPDX-License-Identifier: MIT
"""Every stack can be exported: those of the papers, as many more as hold every component, every shipped scenario.

One program a scalar replays their recorded loops: what stacks share is compiled once. What is not exported is a short
list with reasons.

``tests/golden/float_stacks.csv`` states how far `float` may be from `double` for each stack;
``python tests/python/test_export_stacks.py`` writes it anew.
"""

from __future__ import annotations

import csv
import os
import shlex
import signal
import subprocess
import tempfile
from collections.abc import Iterable, Mapping
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import gyrostat as gs
from gyrostat import _core
from gyrostat.export import TARGETS, FlightCode, export
from gyrostat.export.compiler import find_eigen
from gyrostat.export.cpp import headers
from gyrostat.export.folder import copy_headers
from gyrostat.export.model import INPUTS, OUTPUTS
from gyrostat.scenario import shipped

ROLES = ("observer", "detector", "controller", "allocator")
TABLE = Path(__file__).parents[1] / "golden" / "float_stacks.csv"
HEAD = ("stack", "observer", "detector", "controller", "allocator", "stated", "measured")
SAMPLES = 1000
HOST_ONLY = {"open_loop"}  # follows waveforms
SHIPPED_SAMPLES = 400
EULER = "vehicle: coordinates euler_angles cannot be exported; flight code takes body coordinates"
OPEN_LOOP = "controller 'open_loop' runs in the host alone and cannot be exported"
SHADOWS = "shadows are not part of the flight stack: export without them (--set shadows=[])"
REFUSED = {
    "cao2022/constant_torque": OPEN_LOOP,
    "cao2023/nozzles": EULER,
    "cao2023/printed": EULER,
    "yang2023/bench_a": SHADOWS,
    "yang2023/bench_b": SHADOWS,
}
FLAGS = "-std=c++20 -O0 -fno-exceptions -fno-rtti -ffp-contract=off -Wall -Wextra -Werror"


def components(scenario: gs.Scenario) -> dict[str, str]:
    """Role -> name in the catalogue."""
    resolved = scenario.resolve()
    return {role: resolved[role]["type"] for role in ROLES}


def stacks() -> dict[str, gs.Scenario]:
    """The papers' own, one whose sign is hard, and as many more as it takes to have every component once."""
    load = gs.Scenario.load
    found = {
        "li2018": load("li2018/table1"),
        "cao2022": load("cao2022/attitude"),
        "wang2023": load("wang2023/stabilisation"),
        "cao2023": load("cao2023/rigid"),
        "yang2023": load("yang2023/maneuver").replace(allocator="robust_socp"),
    }
    used = [components(scenario) for scenario in found.values()]
    found["li2018_hard_sign"] = found["li2018"].replace(**{"controller.switching": "sign", "allow_unstable": True})
    names = {role: sorted(set(_core.catalogue()[role]) - HOST_ONLY) for role in ROLES}
    left = {role: [n for n in names[role] if n not in {u[role] for u in used}] for role in ROLES}
    base = load("ftc_4rw").replace(
        faults=[gs.faults.LossOfEffectiveness(actuator=2, t_on=5.0, remaining=0.4)],
        initial=gs.Initial(mrp=(0.1, 0.2, -0.3), omega_BN_B=(0.01, -0.02, 0.03)),
        duration=SAMPLES * 0.01,
        allow_unstable=True,
    )
    for i in range(max(map(len, left.values()))):
        chosen = {role: left[role][i] for role in ROLES if i < len(left[role])}  # once each: the rest stays the base's
        found[f"mixed_{i}"] = base.replace(**chosen)
    return {name: with_dropouts(scenario) for name, scenario in found.items()}


def with_dropouts(scenario: gs.Scenario) -> gs.Scenario:
    """Sensors that fail for a while, one after the other and then together; observers skip what was not measured."""
    windows = (
        (gs.sensors.AttitudeDropout, 300, 340),
        (gs.sensors.RateDropout, 500, 540),
        (gs.sensors.MomentumDropout, 700, 720),
        *((sensor, 800, 805) for sensor in (gs.sensors.AttitudeDropout, gs.sensors.RateDropout)),
    )
    dropouts = [sensor(t_on=a * scenario.dt, t_off=b * scenario.dt) for sensor, a, b in windows]
    return scenario.replace(sensors=[*scenario.sensors, *dropouts])


def everything() -> gs.Scenario:
    """Gimbals and torquers on a body that bends, the torquers empty the gyros, a filter hears sun and field alone."""
    vehicle, gyros = gs.vehicle.cmg4(rotor_momentum=2.0, J_B=(120.0, 100.0, 110.0))
    _, modes = gs.vehicle.flexible_4()
    return gs.Scenario(
        name="everything",
        vehicle={
            **vehicle.to_dict(),
            "D_B": [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
            "u_max": [30.0, 30.0, 30.0, 2.0, 2.0, 2.0, 2.0],
            "magnetorquers": [0, 1, 2],
        },
        cmg=gyros.model_copy(update={"angles": (0.1, -0.2, 0.3, 0.05)}),
        flexible=modes.model_copy(update={"delta": [[0.3 * x for x in row] for row in modes.delta]}),
        orbit=gs.Orbit(semi_major_axis=6.9e6, inclination=0.9, raan=0.4, earth_angle=1.2, sun_longitude=1.0),
        desaturation=gs.Desaturation(gain=20.0, keep_B=(0.1, 0.0, -0.2)),
        navigator="mekf",
        observer="joint_kalman",
        detector="evidence",
        controller="mrp_feedback",
        allocator="lexicographic",
        reference="nadir",
        sensors=[
            gs.sensors.Gyro(angle_random_walk=1e-5, rate_random_walk=1e-8, bias=(1e-3, -1e-3, 1e-3)),
            gs.sensors.SunSensor(noise=2e-3),
            gs.sensors.Magnetometer(noise=5e-8),
            gs.sensors.AttitudeDropout(t_on=0.0),
        ],
        faults=[gs.faults.Dead(actuator=1, t_on=40.0), gs.faults.Dead(actuator=4, t_on=60.0)],
        initial=gs.Initial(q_NB=[0.36, 0.48, -0.64, 0.48], omega_BN_B=[0.002, -0.003, 0.001]),
        integrator="rk4",
        duration=(SHIPPED_SAMPLES - 1) * 0.5,
        dt=0.5,
    )


def scenarios() -> dict[str, gs.Scenario]:
    """The shipped ones that are not refused, and all that a vehicle may have at once."""
    return {name: gs.Scenario.load(name) for name in shipped() if name not in REFUSED} | {"everything": everything()}


class Replayed:
    """What the recorded inputs of one stack gave, in both scalars."""

    def __init__(self, code: FlightCode, folder: Path) -> None:
        self.code = code
        self.given = {
            scalar: np.fromfile(folder / f"{code.name}.{scalar}").reshape(SAMPLES, -1) for scalar in ("double", "float")
        }

    def recorded(self) -> NDArray[np.float64]:
        """The outputs of the scenario's own closed loop."""
        return np.hstack([self.code.column(s) for s in OUTPUTS])

    def float_deviation(self) -> float:
        """Largest difference of a command in float, relative to the largest command."""
        u = self.code.column("allocation.u")
        return float(np.abs(self.given["float"][:, : u.shape[1]] - u).max() / np.abs(u).max())


class Flown:
    """Every export, played back by one program a scalar; in double the self-tests of the scenarios are in it."""

    def __init__(self, folder: Path) -> None:
        stack_codes = {
            name: export(scenario, "cpp", folder / name, samples=SAMPLES, name=name)
            for name, scenario in stacks().items()
        }
        tested = {
            name: export(scenario, "cpp", folder / f"tested_{i}", samples=SHIPPED_SAMPLES, name=f"tested_{i}")
            for i, (name, scenario) in enumerate(scenarios().items())
        }
        codes = [*stack_codes.values(), *tested.values()]
        copy_headers(
            sorted({header for code in codes for header in headers(code)}),
            folder / "include",
            max(code.capacity for code in codes),
        )
        for name, code in stack_codes.items():
            np.hstack([code.column(s) for s in INPUTS]).tofile(folder / f"{name}.in")
        programs = {"double": list(tested.values()), "float": []}
        with ThreadPoolExecutor() as pool:
            said = list(pool.map(lambda p: _built_and_run(folder, stack_codes, *p), programs.items()))
        self.replayed = {name: Replayed(code, folder) for name, code in stack_codes.items()}
        self.verdicts = dict(zip(tested, said[0].splitlines(), strict=True))
        self.rows = {name: len(code.rows) for name, code in tested.items()}


def _built_and_run(folder: Path, stack_codes: Iterable[str], scalar: str, tested: list[FlightCode]) -> str:
    """What the program of one scalar printed: a line for each self-test."""
    calls = [f'replay<{scalar}, {name}::Flight>("{name}", "{scalar}")' for name in stack_codes]
    calls += [f'told(test_{code.name}::main, "{code.name}/recorded.csv")' for code in tested]
    lines = ["#include <new>", *(f'#include "{name}/{name}.hpp"' for name in stack_codes), '#include "replay.hpp"']
    lines += [f"#include <{header}.h>" for header in ("math", "stdio", "stdlib", "string")]
    lines += [f'#include "{code.name}/{code.name}.hpp"' for code in tested]
    for code in tested:
        lines += ["#undef RECORDED_H", f"namespace test_{code.name} {{", f'#include "{code.name}/self_test.cpp"', "}"]
    lines += [
        "template <class Main> int told(Main* main, const char* path) {",
        "  char* arguments[] = {nullptr, const_cast<char*>(path)};",
        "  return main(2, arguments);",
        "}",
        "int main() {",
        "  int wrong = 0;",
        *(f"  wrong += {call};" for call in calls),
        "  return wrong;",
        "}",
        "",
    ]
    (folder / f"{scalar}.cpp").write_text("\n".join(lines))
    compiler = shlex.split(f"{os.environ.get('CXX', 'c++')} {FLAGS} {os.environ.get('CXXFLAGS', '')}")
    compiler += ["-isystem", str(find_eigen()), f"-I{folder / 'include'}", f"-I{Path(__file__).parent}"]
    _run([*compiler, f"{scalar}.cpp", "-o", f"{scalar}.out"], folder, seconds=1800)
    return _run([str(folder / f"{scalar}.out")], folder, seconds=600)


def _run(command: list[str], folder: Path, seconds: float) -> str:
    """To its end; a limit is for what hangs, not for a slow machine, and nothing outlives it."""
    with subprocess.Popen(command, cwd=folder, start_new_session=True, stdout=subprocess.PIPE, text=True) as process:
        try:
            said, _ = process.communicate(timeout=seconds)
            assert process.returncode == 0, said
            return said
        finally:
            if process.poll() is None:
                os.killpg(process.pid, signal.SIGKILL)  # a compiler's own children too


@pytest.fixture(scope="module")
def flown(tmp_path_factory: pytest.TempPathFactory) -> Flown:
    return Flown(tmp_path_factory.mktemp("flown"))


@pytest.fixture
def replayed(request: pytest.FixtureRequest, flown: Flown) -> Replayed:
    return flown.replayed[request.param]


def stated() -> dict[str, Mapping[str, str]]:
    with TABLE.open(newline="") as file:
        return {row["stack"]: row for row in csv.DictReader(line for line in file if not line.startswith("#"))}


def test_every_flight_component_is_in_a_stack() -> None:
    used = [components(scenario) for scenario in stacks().values()]
    for role in ROLES:
        assert {u[role] for u in used} == set(_core.catalogue()[role]) - HOST_ONLY


def test_parameters_of_every_kind_are_in_them() -> None:
    kinds = {
        p["kind"]
        for scenario in stacks().values()
        for role, name in components(scenario).items()
        for p in _core.describe(role, name)["params"]
    }
    assert kinds == {"number", "integer", "switch", "choice", "vector3", "matrix3", "mask", "per_actuator"}
    assert stacks()["yang2023"].resolve()["observer"]["frozen"] != []


@pytest.mark.parametrize("replayed", stacks(), indirect=True)
class TestStack:
    def test_an_exported_stack_repeats_its_recorded_loop(self, replayed: Replayed) -> None:
        # every output at every sample, 1e-12 of each number or of 1; flags, masks and infinite bounds exactly
        np.testing.assert_allclose(replayed.given["double"], replayed.recorded(), rtol=1e-12, atol=1e-12)
        assert np.abs(replayed.code.column("allocation.u")).max() > 0

    def test_dropouts_are_in_every_recording(self, replayed: Replayed) -> None:
        code = replayed.code
        valid = {s: code.column(f"measurement.{s}_valid")[:, 0] > 0 for s in ("attitude", "rate", "momentum")}
        assert [int(np.sum(~v)) for v in valid.values()] == [45, 45, 20]
        held = code.column("allocation.status")[:, 0].astype(int) & 1 > 0
        blind = ~(valid["attitude"] & valid["rate"] & valid["momentum"])
        assert held[blind].all()
        # where the model led elsewhere, the first sample that is measured again may be doubted
        assert not (held & ~blind & ~np.roll(blind, 1)).any()

    def test_in_float_it_is_as_near_as_stated(self, replayed: Replayed) -> None:
        row = stated()[replayed.code.name]
        assert {role: row[role] for role in ROLES} == components(replayed.code.scenario)
        u, box = replayed.given["float"][:, : replayed.code.actuators], replayed.code.vehicle
        assert np.all(u >= np.float32(box["u_lo"]))  # no NaN either
        assert np.all(u <= np.float32(box["u_up"]))
        if row["stated"] == "hard sign":
            return
        assert replayed.float_deviation() <= float(row["stated"])


@pytest.mark.parametrize("name", scenarios())
def test_a_shipped_scenario_repeats_its_loop_to_the_last_bit(name: str, flown: Flown) -> None:
    """By the self-test that comes with it: wheels, torquers, gimbals, valves, panels, with and without a navigator."""
    assert flown.verdicts[name].startswith(f"{flown.rows[name]} samples, largest deviation 0.00e+00")


def test_in_c_all_inputs_are_read_and_the_memory_is_large_enough(tmp_path: Path) -> None:
    """Compiled for its own eight actuators; no body of a function is needed for that."""
    code = export(everything(), "c", tmp_path / "c", samples=2, name="all_of_it")
    assert code.capacity == 8
    sizes = [f"sizeof(all_of_it_flight::Flight<{scalar}>::Stack) <= {size}" for scalar, size in code.bytes.items()]
    memory = "gyrostat::CallerMemory<all_of_it_flight::Flight<double>::Stack>::bytes"
    lines = [f'#include "{header}"' for header in ("all_of_it.hpp", "all_of_it.h", "gyrostat/flight/facade.hpp")]
    lines += [f"static_assert({claim});" for claim in (*sizes, f"sizeof(all_of_it) >= {memory}")]
    (tmp_path / "c" / "sizes.cpp").write_text("\n".join([*lines, ""]))
    compiler = shlex.split(
        f"{os.environ.get('CXX', 'c++')} {FLAGS} -fsyntax-only -Iinclude -I. -isystem {find_eigen()}"
    )
    _run([*compiler, "sizes.cpp"], tmp_path / "c", seconds=600)
    strict = ["-std=c99", "-Wall", "-Wextra", "-Wpedantic", "-Werror", "-fsyntax-only"]
    _run([os.environ.get("CC", "cc"), *strict, "self_test.c"], tmp_path / "c", seconds=60)


def test_every_navigator_is_in_them() -> None:
    assert {s.resolve()["navigator"]["type"] for s in scenarios().values()} == set(_core.catalogue()["navigator"])


@pytest.mark.parametrize("name", REFUSED)
def test_a_refusal_is_one_line_with_its_reason(name: str, tmp_path: Path) -> None:
    for target in TARGETS:
        with pytest.raises(gs.InputError) as error:
            export(gs.Scenario.load(name), target, tmp_path / "out", samples=2)
        assert str(error.value).startswith(REFUSED[name])
        assert "\n" not in str(error.value)
    assert list(tmp_path.iterdir()) == []


def test_the_table_has_every_stack_and_no_other() -> None:
    assert list(stated()) == list(stacks())
    assert [name for name, row in stated().items() if row["stated"] == "hard sign"] == ["li2018_hard_sign"]


def write_table() -> None:
    """``stated`` is a power of ten with at least a factor of two above what was measured."""
    rows: list[Any] = [HEAD]
    with tempfile.TemporaryDirectory() as folder:
        flown = Flown(Path(folder))
    for name, replayed in flown.replayed.items():
        measured = replayed.float_deviation()
        bound = f"1e{int(np.ceil(np.log10(2 * measured)))}" if "hard_sign" not in name else "hard sign"
        rows.append([name, *components(replayed.code.scenario).values(), bound, f"{measured:.1e}"])
    with TABLE.open("w", newline="") as file:
        file.write(
            f"# float against double, largest difference of a command in {SAMPLES} recorded samples played back,\n"
        )
        file.write("# relative to the largest command. Written by tests/python/test_export_stacks.py.\n")
        csv.writer(file, lineterminator="\n").writerows(rows)


if __name__ == "__main__":
    write_table()
