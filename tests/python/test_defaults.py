# SPDX-License-Identifier: MIT
"""Default parameters work on any vehicle: a scaled loop flies the scaled path, and quite other vehicles settle."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterable
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
from numpy.typing import NDArray

import gyrostat as gs
from gyrostat import _core

Stack = tuple[str, str, str]

NOT_HOMOGENEOUS = {
    # Powers of quantities with units, as published: no constant makes them the same law on every vehicle.
    "integral_sliding_mode": 1e-3,  # rad; s^kappa with kappa from 0 to 1 in the adaptation of the switching gain
    "predefined_time": 0.35,  # V2^h2 with V2 in 1/s^2: 0.33 where time runs ten times as fast
    # How fast an actuator may fail is in seconds, whatever the vehicle.
    "joint_kalman": 1e-3,
}


def stacks() -> list[Stack]:
    """Every observer with every controller, and every allocator at least under one controller of each kind."""
    names = _core.catalogue()
    laws = [c for c in names["controller"] if _core.describe("controller", c)["traits"]["regulates"]]
    pairs = itertools.product(names["observer"], laws, ["pseudo_inverse"])
    return [*pairs, *itertools.product(["iterative_learning"], ["mrp_feedback", "sliding_mode"], names["allocator"])]


def all_of(fly: Callable[[Stack], gs.Result], which: Iterable[Stack]) -> dict[Stack, gs.Result]:
    chosen = list(dict.fromkeys(which))
    with ThreadPoolExecutor() as pool:  # the loop runs without the GIL
        return dict(zip(chosen, pool.map(fly, chosen), strict=True))


def loop(stack: Stack, vehicle: gs.Vehicle, *, torque: float, time: float, dt: float) -> gs.Scenario:
    """Sixty natural units of time: a slew from 80 deg, one actuator at 40 % from a third on, a constant torque."""
    observer, controller, allocator = stack
    return gs.Scenario(
        vehicle=vehicle,
        initial=gs.Initial(mrp=(0.1, 0.2, -0.3), omega_BN_B=(0.01 / time, -0.02 / time, 0.03 / time)),
        observer=gs.observer(observer),
        controller=gs.controller(controller),
        allocator=gs.allocator(allocator),
        detector=gs.detector("threshold" if vehicle.spare else "none"),
        faults=[gs.faults.LossOfEffectiveness(actuator=2, t_on=20.0 * time, remaining=0.4)],
        disturbances=[gs.disturbances.Constant(torque_B=(5e-3 * torque, -1e-2 * torque, 7.5e-3 * torque))],
        integrator=gs.integrators.Rk4(),
        duration=round(60.0 * time / dt) * dt,
        dt=dt,
        allow_unstable=True,
    )


@pytest.fixture(scope="module")
def reference() -> dict[Stack, NDArray[np.float64]]:
    """Pointing error of FTC-4RW."""
    flown = all_of(
        lambda s: loop(s, gs.vehicle.ftc_4rw(), torque=0.2, time=1.0, dt=0.01).run(channels=["error.angle"]), stacks()
    )
    return {s: r["error.angle"] for s, r in flown.items()}


@pytest.mark.parametrize(("mass", "time"), [(1e-3, 1.0), (1e3, 1.0), (1.0, 0.1), (1.0, 10.0)])
def test_a_scaled_vehicle_flies_the_scaled_path(
    mass: float, time: float, reference: dict[Stack, NDArray[np.float64]]
) -> None:
    # J -> mass J, t -> time t, torque -> mass / time^2: nothing in the equations of motion tells the two apart.
    plain, torque = gs.vehicle.ftc_4rw(), 0.2 * mass / time**2
    scaled = gs.Vehicle(
        J_B=(mass * np.asarray(plain.J_B)).tolist(), D_B=plain.D_B, u_max=torque, wheel_inertia=0.05 * mass
    )
    fly = all_of(
        lambda s: loop(s, scaled, torque=torque, time=time, dt=0.01 * time).run(channels=["error.angle"]), stacks()
    )
    for stack, result in fly.items():
        assert result.status == "completed", (stack, result.cause)
        apart = np.abs(result["error.angle"] - reference[stack]).max()
        assert apart < max(NOT_HOMOGENEOUS.get(name, 1e-9) for name in stack), stack
        assert result["error.angle"][-1] < np.deg2rad(1.0), stack


def identity(columns: int) -> list[list[float]]:
    return np.hstack([np.eye(3)] * columns).tolist()


VEHICLES = {
    "cubesat, three wheels, 10 Hz": (
        gs.Vehicle(J_B=(0.05, 0.05, 0.01), D_B=identity(1), u_max=2e-3, wheel_inertia=1e-5),
        0.1,
    ),
    "large, six actuators, 1 Hz": (gs.Vehicle(J_B=(8e3, 9e3, 3e3), D_B=identity(2), u_max=1.0), 1.0),
    "three and a spare, 100 Hz": (
        gs.Vehicle(
            J_B=((43.0, 0.3, 1.2), (0.3, 52.0, -0.5), (1.2, -0.5, 40.0)),
            D_B=np.hstack([np.eye(3), np.full((3, 1), 3**-0.5)]).tolist(),
            u_max=0.25,
            spare=(3,),
        ),
        0.01,
    ),
    "no limit known, 20 Hz": (gs.Vehicle(J_B=(10.0, 12.0, 9.0), D_B=identity(1)), 0.05),
}


@pytest.mark.parametrize("name", VEHICLES)
def test_quite_other_vehicles_settle(name: str) -> None:
    vehicle, dt = VEHICLES[name]
    inertia = np.asarray(vehicle.J_B, float)
    largest = float(np.linalg.eigvalsh(inertia if inertia.ndim == 2 else np.diag(inertia))[-1])
    torque = 0.04 * largest if vehicle.u_max is None else float(np.max(vehicle.u_max))
    time = 1.5 * float(np.sqrt(0.0163 * largest / torque))  # FTC-4RW has 0.0163 rad/s^2 at hand
    fly = all_of(lambda s: loop(s, vehicle, torque=torque, time=time, dt=dt).run(channels=["error.angle"]), stacks())
    for stack, result in fly.items():
        assert result.status == "completed", (stack, result.cause)
        # Laws without integral action are left with the constant torque over their stiffness, 1 deg of a 45 deg law.
        assert result["error.angle"][-1] < np.deg2rad(2.0), stack
