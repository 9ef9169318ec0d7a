# SPDX-License-Identifier: MIT
"""Every stack can be exported: those of the papers, and as many more as hold every flight component.

A program a stack replays its recorded loop, in `double` and in `float`.

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
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import gyrostat as gs
from gyrostat import _core
from gyrostat.export import FlightCode, export
from gyrostat.export.compiler import find_eigen
from gyrostat.export.model import INPUTS, OUTPUTS

ROLES = ("observer", "detector", "controller", "allocator")
TABLE = Path(__file__).parents[1] / "golden" / "float_stacks.csv"
HEAD = ("stack", "observer", "detector", "controller", "allocator", "stated", "measured")
SAMPLES = 1000
HOST_ONLY = {"open_loop"}  # follows waveforms
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


class Replayed:
    """What the recorded inputs of a stack gave, in both scalars."""

    def __init__(self, name: str, folder: Path) -> None:
        self.code: FlightCode = export(stacks()[name], "cpp", folder / name, samples=SAMPLES, name=name)
        np.hstack([self.code.column(s) for s in INPUTS]).tofile(folder / f"{name}.in")
        _compile(name, folder)
        _run([str(folder / "replay")], folder, seconds=600)
        self.given = {
            scalar: np.fromfile(folder / f"{name}.{scalar}").reshape(SAMPLES, -1) for scalar in ("double", "float")
        }

    def recorded(self) -> NDArray[np.float64]:
        """The outputs of the scenario's own closed loop."""
        return np.hstack([self.code.column(s) for s in OUTPUTS])

    def float_deviation(self) -> float:
        """Largest difference of a command in float, relative to the largest command."""
        u = self.code.column("allocation.u")
        return float(np.abs(self.given["float"][:, : u.shape[1]] - u).max() / np.abs(u).max())


def _compile(name: str, folder: Path) -> None:
    compiler = shlex.split(f"{os.environ.get('CXX', 'c++')} {FLAGS} {os.environ.get('CXXFLAGS', '')}")
    compiler += ["-isystem", str(find_eigen()), f"-I{folder / name}", f"-I{folder / name / 'include'}"]
    calls = [f'replay<{scalar}, {name}::Flight>("{name}", "{scalar}")' for scalar in ("double", "float")]
    lines = [f'#include "{name}.hpp"', '#include "replay.hpp"', f"int main() {{ return {' + '.join(calls)}; }}"]
    (folder / "replay.cpp").write_text("\n".join([*lines, ""]))
    _run([*compiler, f"-I{Path(__file__).parent}", "replay.cpp", "-o", "replay"], folder, seconds=1800)


def _run(command: list[str], folder: Path, seconds: float) -> None:
    """To its end; a limit is for what hangs, not for a slow machine, and nothing outlives it."""
    with subprocess.Popen(command, cwd=folder, start_new_session=True) as process:
        try:
            assert process.wait(timeout=seconds) == 0
        finally:
            if process.poll() is None:
                os.killpg(process.pid, signal.SIGKILL)  # a compiler's own children too


@pytest.fixture(scope="module")
def replayed(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Replayed:
    return Replayed(request.param, tmp_path_factory.mktemp("replayed"))


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


@pytest.mark.parametrize("replayed", stacks(), indirect=True, scope="module")
class TestStack:
    """Compiled once each; workers share them out."""

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


def test_the_table_has_every_stack_and_no_other() -> None:
    assert list(stated()) == list(stacks())
    assert [name for name, row in stated().items() if row["stated"] == "hard sign"] == ["li2018_hard_sign"]


def write_table() -> None:
    """``stated`` is a power of ten with at least a factor of two above what was measured."""
    rows: list[Any] = [HEAD]
    for name in stacks():
        with tempfile.TemporaryDirectory() as folder:
            replayed = Replayed(name, Path(folder))
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
