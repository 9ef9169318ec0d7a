# SPDX-License-Identifier: MIT
"""Vehicles with everything at once: wheels, magnetorquers, control moment gyros, thrusters, appendages, a navigator.

Drawn at random with any stack and fault, from a ten-thousandth of the size to a hundred times it, at 2 Hz to 1 kHz:
every flight ends at its end and every number is finite.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import gyrostat as gs
from gyrostat import _core

SEEDS = range(8)
FLIGHTS = 15


def actuators(rng: np.random.Generator) -> dict[str, Any]:
    """Tables of a vehicle with at least one kind that pushes in every direction, 16 actuators at most."""
    wheels, dipoles, gyros, valves = rng.random(4) < (0.6, 0.4, 0.4, 0.5)
    if not (wheels or gyros):
        valves = True
    if wheels + gyros > 0 and valves:
        gyros, dipoles = False, dipoles and not wheels
    size = 10.0 ** rng.uniform(-4, 2)
    axes: list[Any] = []
    limits: list[float] = []
    inertias: list[float] = []
    tables: dict[str, Any] = {}
    vehicle: dict[str, Any] = {"J_B": [120.0 * size, 100.0 * size, 110.0 * size]}
    if wheels:
        axes += list(np.array(gs.vehicle.PYRAMID4).T / np.sqrt(3.0))
        limits += [0.5 * size] * 4
        inertias += [0.05 * size] * 4
    if dipoles:
        vehicle["magnetorquers"] = list(range(len(axes), len(axes) + 3))
        axes += list(np.eye(3))
        limits += [50.0 * size] * 3
        inertias += [0.0] * 3
        tables["orbit"] = {"semi_major_axis": 6.9e6, "inclination": 1.2, "raan": float(rng.uniform(0, 6))}
        momentum = str(rng.choice(["wheels", "total"])) if wheels else "total"
        tables |= {"desaturation": {"momentum": momentum}} if rng.random() < 0.5 else {}
    if gyros:
        tables["cmg"] = gs.vehicle.cmg4(rotor_momentum=20.0 * size)[1].to_dict()
        limits += [1e9] * 4
        inertias += [0.0] * 4
    if axes:
        vehicle |= {"D_B": np.transpose(axes).tolist(), "u_max": limits, "wheel_inertia": inertias}
    if valves:
        modulator = str(rng.choice(["pwm", "pwpf", "proportional"]))
        tables["thrusters"] = gs.vehicle.twelve_thrusters()[1].to_dict() | {"thrust": size, "modulator": modulator}
    if rng.random() < 0.3:
        modes = gs.vehicle.flexible_4()[1].to_dict()
        tables["flexible"] = modes | {"delta": (0.5 * np.sqrt(size) * np.asarray(modes["delta"])).tolist()}
    return tables | {"vehicle": vehicle}


def drawn(rng: np.random.Generator) -> gs.Scenario:
    """A flight of sixty samples."""
    tables = actuators(rng)
    catalogue = _core.catalogue()
    left_out = {"open_loop"} | (set() if "cmg" in tables else {"singularity_robust"})
    for role in ("observer", "detector", "controller", "allocator"):
        tables[role] = str(rng.choice([name for name in catalogue[role] if name not in left_out]))
    dt = float(rng.choice([0.5, 0.1, 0.01, 0.001]))
    if "thrusters" in tables:
        tables["thrusters"]["tick"] = dt / 32
    tables |= {
        "dt": dt,
        "duration": 60 * dt,
        "initial": {"mrp": (0.1 * rng.normal(size=3)).tolist()},
        "integrator": str(rng.choice(["rk4", "cvode", "auto"])),
        "allow_unstable": True,
    }
    if rng.random() < 0.5:
        tables["sensors"] = [{"type": "gyro", "noise": 1e-5}, {"type": "star_tracker"}]
        tables["sensors"] += [{"type": "tachometer", "delay": 1}] if rng.random() < 0.5 else []
        tables |= {"navigator": "mekf"} if rng.random() < 0.5 else {}
    scenario = gs.Scenario.from_dict(tables)
    if rng.random() < 0.7:
        fault = gs.faults.LossOfEffectiveness(
            actuator=int(rng.integers(scenario.actuators)),
            t_on=float(rng.uniform(0, 30 * dt)),
            remaining=float(rng.uniform()),
        )
        scenario = scenario.replace(faults=[fault])
    return scenario


@pytest.mark.parametrize("seed", SEEDS)
def test_any_mixture_flies_to_its_end(seed: int) -> None:
    rng = np.random.default_rng(seed)
    for _ in range(FLIGHTS):
        scenario = drawn(rng)
        scenario.check()
        flown = scenario.run(channels=["error.angle", "allocation.u", "truth.omega_BN_B", "estimate.*", "demand.tau_B"])
        assert flown.completed, scenario.to_toml()
        for channel in ("error.angle", "allocation.u", "truth.omega_BN_B", "estimate.d_B", "demand.tau_B"):
            assert np.isfinite(flown[channel]).all(), (channel, scenario.to_toml())
