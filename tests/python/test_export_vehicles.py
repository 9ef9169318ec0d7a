# SPDX-License-Identifier: MIT
"""Every shipped scenario is exported and repeats its recorded loop to the last bit, whatever its vehicle flies on; what is not
exported is a short list, each with its reason.

One program has the self-tests of all exports: what they share is compiled once.
"""

from __future__ import annotations

import shlex
import subprocess
from functools import cache
from pathlib import Path
from typing import Any

import pytest

import gyrostat as gs
from gyrostat import _core
from gyrostat.export import FlightCode, c, export
from gyrostat.export.compiler import find_compiler, find_eigen
from gyrostat.export.model import GIMBALS, SKY, flight_code
from gyrostat.scenario import shipped

SAMPLES = 400
FLAGS = "-std=c++20 -O0 -fno-exceptions -fno-rtti -ffp-contract=off -Wall -Wextra -Werror"
OPEN_LOOP = "controller 'open_loop' runs in the host alone and cannot be exported"
REFUSED = {
    "cao2022/constant_torque": OPEN_LOOP,
    "cao2023/printed": "vehicle: coordinates euler_angles cannot be exported",
    "yang2023/bench_a": OPEN_LOOP,
    "yang2023/bench_b": OPEN_LOOP,
}


def everything() -> gs.Scenario:
    """Gimbals and torquers turn on bending panels, the torquers empty the gyros, a filter flies on sun and field alone."""
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
        duration=(SAMPLES - 1) * 0.5,
        dt=0.5,
    )


@cache
def exported() -> dict[str, gs.Scenario]:
    """What one program flies: the shipped scenarios that are not refused, and all kinds of inputs at once."""
    return {name: gs.Scenario.load(name) for name in shipped() if name not in REFUSED} | {"everything": everything()}


@pytest.fixture(scope="module")
def codes(tmp_path_factory: pytest.TempPathFactory) -> dict[str, tuple[FlightCode, Path]]:
    folder = tmp_path_factory.mktemp("exported")
    found = {}
    for i, (name, scenario) in enumerate(exported().items()):
        at = folder / f"of_{i}"
        found[name] = export(scenario, "cpp", at, samples=SAMPLES, name=f"flight_{i}"), at
    return found


@pytest.mark.parametrize("name", REFUSED)
def test_a_refusal_is_one_line_with_its_reason(name: str, tmp_path: Path) -> None:
    for target in ("cpp", "c", "fmu"):
        with pytest.raises(gs.InputError) as error:
            export(gs.Scenario.load(name), target, tmp_path / "out", samples=2)
        assert str(error.value).startswith(REFUSED[name])
        assert "\n" not in str(error.value)
    assert list(tmp_path.iterdir()) == []


def test_every_exported_scenario_repeats_its_loop_to_the_last_bit(
    codes: dict[str, tuple[FlightCode, Path]], tmp_path: Path
) -> None:
    """Compiled for the most actuators that one of them has: the first include folder is that of the largest."""
    largest = max(codes.values(), key=lambda one: one[0].capacity)[1]
    lines = ["#include <new>", '#include "gyrostat/flight/facade.hpp"']
    lines += [f'#include "{code.name}.hpp"' for code, _ in codes.values()]
    lines += ["#include <math.h>", "#include <stdio.h>", "#include <stdlib.h>", "#include <string.h>"]
    for code, at in codes.values():
        lines += ["#undef RECORDED_H", f"namespace test_{code.name} {{", f'#include "{at}/self_test.cpp"', "}"]
    calls = [f"    {{ char path[] = \"{at}/recorded.csv\"; char* of[] = {{path, path}}; printf(\"{name}: \");"
             f" wrong += test_{code.name}::main(2, of); }}" for name, (code, at) in codes.items()]
    lines += ["int main() {", "  int wrong = 0;", *calls, "  return wrong;", "}", ""]
    source = tmp_path / "all.cpp"
    source.write_text("\n".join(lines))
    includes = [f"-I{largest / 'include'}", *(f"-I{at}" for _, at in codes.values())]
    command = [*find_compiler(), *shlex.split(FLAGS), "-isystem", str(find_eigen()), *includes, str(source), "-o"]
    subprocess.run([*command, str(tmp_path / "all")], check=True, timeout=1800)
    done = subprocess.run([tmp_path / "all"], capture_output=True, text=True, timeout=600, check=False)
    said = done.stdout.splitlines()
    assert done.returncode == 0, done.stdout
    assert len(said) == len(codes)
    for (name, (code, _)), line in zip(codes.items(), said, strict=True):
        assert line.startswith(f"{name}: {len(code.rows)} samples, largest deviation 0.00e+00"), line
