# SPDX-License-Identifier: MIT
"""What flies keeps its bits while the code around it moves.

``tests/golden/bits.csv`` holds for every case a digest of all samples and the state at the end. Digests hold for the
arithmetic that the table names (processor, compiler and mathematical library), the state at the end to 1e-9 for any.
``python tests/python/test_bits.py`` writes the table anew, for a change that is meant to move bits.
"""

from __future__ import annotations

import csv
import hashlib
import math
import platform
import struct
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import gyrostat as gs
from gyrostat import _core
from gyrostat.scenario import shipped

TABLE = Path(__file__).parents[1] / "golden" / "bits.csv"
CHANNELS = ["truth.q_NB", "truth.omega_BN_B", "truth.h_w", "truth.delivered", "allocation.u"]
END = ["truth.q_NB", "truth.omega_BN_B", "truth.h_w"]

RK4, CVODE, AUTO = gs.integrators.Rk4(), gs.integrators.Cvode(rtol=1e-9), gs.integrators.Auto()
SLOW_SINE = gs.waveforms.Sine(offset=0.6, amplitude=0.3, omega=2.0)
LOSSES = [
    gs.faults.LossOfEffectiveness(actuator=0, t_on=3.0037, remaining=SLOW_SINE),
    gs.faults.Intermittent(actuator=1, t_on=5.0, period=1.7, duty=0.4, remaining=0.2, torque=1e-3),
    gs.faults.Lock(actuator=2, t_on=8.1),
    gs.faults.Drift(actuator=3, t_on=10.0, t_off=16.0, rate=1e-4),
]
OUTPUTS = [
    gs.faults.Bias(actuator=0, t_on=2.0, torque=gs.waveforms.Square(low=-2e-3, high=3e-3, period=1.3)),
    gs.faults.DeadZone(actuator=1, t_on=1.0, width=2e-3),
    gs.faults.Stuck(actuator=2, t_on=6.0, t_off=9.0, torque=2e-3),
    gs.faults.HardOver(actuator=2, t_on=12.0, t_off=12.6, sign=-1),
    gs.faults.Dead(actuator=3, t_on=7.00391),
]
DISTURBANCES = [
    gs.disturbances.Constant(torque_B=(1e-3, -2e-3, 1.5e-3)),
    gs.disturbances.Periodic(torque_B=[gs.waveforms.Sine(amplitude=2e-3, omega=0.7), 1e-3, SLOW_SINE]),
]


def spacecraft(wheels: Any, **changes: Any) -> gs.Scenario:
    """FTC-4RW with wheels (inertia, kg m^2) or torquers (0), a slew of 20 s."""
    vehicle = gs.vehicle.ftc_4rw().model_copy(update={"wheel_inertia": wheels})
    usual = {
        "vehicle": vehicle,
        "initial": gs.Initial(mrp=(0.1, 0.2, -0.3), omega_BN_B=(0.01, -0.02, 0.03)),
        "controller": "mrp_feedback",
        "integrator": RK4,
        "duration": 20.0,
        "dt": 0.01,
    }
    return gs.Scenario(**(usual | changes))


def cases() -> dict[str, gs.Scenario]:
    friction = gs.Truth(viscous_friction=1e-4)
    dry = gs.Truth(viscous_friction=1e-4, coulomb_friction=2e-3, momentum_max=0.6)
    mixed = (0.05, 0.0, 0.05, 0.0)
    output = gs.Truth(u_max=0.05, limit_on="output")
    noisy = [gs.sensors.Gyro(noise=1e-6), gs.sensors.Attitude(noise=1e-5)]
    out = {
        "wheels_rk4": spacecraft(0.05),
        "torquers_rk4": spacecraft(0.0),
        "mixed_rk4": spacecraft(mixed),
        "wheels_cvode": spacecraft(0.05, integrator=CVODE),
        "friction_rk4": spacecraft(0.05, truth=friction),
        "friction_cvode": spacecraft(0.05, truth=friction, integrator=CVODE),
        "faults_rk4": spacecraft(0.05, faults=LOSSES),
        "faults_cvode": spacecraft(0.05, faults=LOSSES, disturbances=DISTURBANCES, integrator=CVODE),
        "torquers_faults_rk4": spacecraft(0.0, faults=OUTPUTS, disturbances=DISTURBANCES),
        "mixed_cvode": spacecraft(mixed, faults=OUTPUTS, integrator=CVODE),
        "bearings_rk4": spacecraft(0.05, truth=dry, faults=LOSSES),
        "bearings_auto": spacecraft(0.05, truth=dry, disturbances=DISTURBANCES, integrator=AUTO),
        "output_limit_rk4": spacecraft(0.05, truth=output, faults=LOSSES),
        "noise_rk4": spacecraft(0.05, sensors=noisy, faults=OUTPUTS, seed=3),
    }
    for observer in _core.catalogue()["observer"]:
        out[f"observer_{observer}"] = spacecraft(0.05, observer=observer, faults=LOSSES, allow_unstable=True)
    for controller in _core.catalogue()["controller"]:
        out[f"controller_{controller}"] = spacecraft(0.05, controller=controller, faults=LOSSES, allow_unstable=True)
    for allocator in _core.catalogue()["allocator"]:
        learning = {"observer": "learning_effectiveness", "allocator": allocator}
        out[f"allocator_{allocator}"] = spacecraft(0.05, faults=OUTPUTS, **learning)
    for name in sorted(shipped()):
        out[f"shipped_{name}"] = gs.Scenario.load(name)
    return out


def digest(result: gs.Result) -> str:
    total = hashlib.sha256()
    for name in CHANNELS:
        total.update(np.ascontiguousarray(result[name]).tobytes())
    return total.hexdigest()[:16]


def arithmetic() -> str:
    """What bits depend on beside this project: processor, compiler, and the mathematical library."""
    functions = hashlib.sha256()
    for x in np.linspace(0.001, 3.0, 1000):
        values = (math.sin(x), math.cos(x), math.atan2(x, 2.0), math.exp(x), math.log(x), math.pow(x, 0.37))
        functions.update(struct.pack("6d", *values))
    return f"{platform.machine()} {_core.compiler()} {functions.hexdigest()[:8]}"


def end_of(result: gs.Result) -> list[float]:
    return [float(x) for name in END for x in result[name][-1]]


def read_table() -> tuple[str, dict[str, tuple[str, list[float]]]]:
    """The arithmetic that the digests hold for, and digest and end of each case."""
    lines = TABLE.read_text().splitlines()
    rows = csv.reader(line for line in lines if not line.startswith("#"))
    next(rows)
    return lines[1].removeprefix("# "), {row[0]: (row[1], [float(x) for x in row[2].split()]) for row in rows}


@pytest.fixture(scope="module")
def flown() -> dict[str, gs.Result]:
    scenarios = cases()
    with ThreadPoolExecutor() as pool:
        results = list(pool.map(lambda s: s.run(channels=CHANNELS), scenarios.values()))
    return dict(zip(scenarios, results, strict=True))


def test_every_case_ends_where_it_ended(flown: dict[str, gs.Result]) -> None:
    table = read_table()[1]
    assert set(table) == set(flown), f"write the table anew: python {Path(__file__).name}"
    for case, result in flown.items():
        # Rounding of another machine grows to some 1e-12 in these flights; a sign without a layer makes more of it.
        assert end_of(result) == pytest.approx(table[case][1], abs=1e-7), case


def test_bits_are_those_of_the_table(flown: dict[str, gs.Result]) -> None:
    where, table = read_table()
    if arithmetic() != where:
        assert digest(flown["wheels_rk4"]) == digest(cases()["wheels_rk4"].run(channels=CHANNELS))
        return  # other machines have bits of their own; `test_every_case_ends_where_it_ended` holds there
    moved = [case for case, result in flown.items() if digest(result) != table[case][0]]
    assert not moved


def write_table() -> None:
    with TABLE.open("w", newline="") as file:
        file.write("# Digest of all samples, state at the end (q_NB, omega_BN_B, h_w). Digests hold for\n")
        file.write(f"# {arithmetic()}\n")
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(["case", "digest", "end"])
        for case, scenario in cases().items():
            result = scenario.run(channels=CHANNELS)
            writer.writerow([case, digest(result), " ".join(f"{x:.12g}" for x in end_of(result))])


if __name__ == "__main__":
    write_table()
