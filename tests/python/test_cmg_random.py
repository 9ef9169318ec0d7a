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
