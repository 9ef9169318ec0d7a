# SPDX-License-Identifier: MIT
"""Every component of the catalogue on control moment gyros: at random, with faults, and what has hurt."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import gyrostat as gs
from gyrostat import _core

ROLES = ("observer", "detector", "controller", "allocator")
KINDS = ("loss_of_effectiveness", "bias", "dead", "stuck", "hard_over", "drift", "lock", "rotor_slow_down")
SHOWN = ["error.angle", "truth.omega_BN_B", "allocation.u", "allocation.status", "estimate.effectiveness"]


def flown(**parts: Any) -> gs.Result:
    scenario = gs.Scenario.load("agile_cmg").replace(**{"duration": 20.0, "allow_unstable": True, **parts})
    return scenario.run(channels=SHOWN)


def random_fault(rng: np.random.Generator, actuator: int) -> dict[str, Any]:
    kind = rng.choice(KINDS)
    fault: dict[str, Any] = {"type": str(kind), "actuator": actuator, "t_on": float(rng.uniform(0.0, 15.0))}
    numbers = {
        "loss_of_effectiveness": {"remaining": rng.uniform(0.0, 1.0)},
        "bias": {"torque": rng.uniform(-2.0, 2.0)},
        "stuck": {"torque": rng.uniform(-2.0, 2.0)},
        "drift": {"rate": rng.uniform(-0.2, 0.2)},
        "rotor_slow_down": {"rate": rng.uniform(0.1, 5.0)},
    }
    return fault | {k: float(v) for k, v in numbers.get(str(kind), {}).items()}


@pytest.mark.parametrize("seed", range(24))
def test_random_stacks_fly_on_gyros_with_faults(seed: int) -> None:
    rng = np.random.default_rng(seed)
    names = _core.catalogue()
    parts = {role: str(rng.choice(names[role])) for role in ROLES}
    result = flown(faults=[random_fault(rng, int(i)) for i in rng.permutation(4)[: rng.integers(1, 3)]], **parts)
    assert result.completed, (parts, result.cause)
    u = result["allocation.u"]
    assert np.isfinite(u).all()
    assert np.abs(u).max() <= 20.0


def test_a_gyro_that_is_nearly_dead_counts_for_no_axis() -> None:
    # the estimate of a locked gimbal lies about e_min: taken for a whole axis it hid that the other three were singular
    result = flown(**(gs.recommended() | {"allocator": "singularity_robust"}), duration=60.0)
    angle = np.rad2deg(result["error.angle"])
    assert angle.max() < 10.0
    assert angle[result.t > 50.0].max() < 1e-3
    assert result["estimate.effectiveness"][-1, 1] < 0.1


@pytest.mark.parametrize("observer", ["passthrough", "joint_kalman", "finite_time_disturbance"])
@pytest.mark.parametrize("detector", ["threshold", "evidence"])
def test_axes_that_move_are_taken_for_no_fault(observer: str, detector: str) -> None:
    scenario = gs.Scenario.load("agile_cmg").replace(faults=[], observer=observer, detector=detector)
    result = scenario.run(channels=["detection.event", "error.angle", "estimate.d_B", "truth.lumped_B"])
    assert result["detection.event"][-1] == 0
    assert np.rad2deg(result["error.angle"].max()) < 7.0
    # an observer of rates takes for torque what axes do within a sample: rate u dt / 2, of 2 x 20 N m at 1 rad/s
    assert np.abs(result["estimate.d_B"] - result["truth.lumped_B"]).max() < 1.0


@pytest.mark.parametrize("observer", [n for n in _core.catalogue()["observer"] if n != "passthrough"])
def test_every_observer_helps_with_a_locked_gimbal(observer: str) -> None:
    alone, helped = flown(duration=60.0), flown(observer=observer, duration=60.0)
    assert np.rad2deg(helped["error.angle"][-1]) < min(1e-3, np.rad2deg(alone["error.angle"][-1]))
