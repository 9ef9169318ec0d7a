# SPDX-License-Identifier: MIT
"""What the truth's own time constants ask of the integrator, as ``gyrostat check`` says it."""

from __future__ import annotations

import numpy as np
import pytest

import gyrostat as gs
from gyrostat.design import time_constants


@pytest.fixture
def vehicle() -> gs.Scenario:
    return gs.Scenario.load("ftc_4rw").replace(initial={}, integrator="rk4")


def test_says_nothing_where_a_step_a_sample_is_enough(vehicle: gs.Scenario) -> None:
    assert time_constants.findings(vehicle) == []
    assert time_constants.findings(vehicle.replace(**{"truth.viscous_friction": 1e-3})) == []


def test_friction_is_the_largest_eigenvalue_of_the_wheels_own_dynamics(vehicle: gs.Scenario) -> None:
    friction = np.array([10.0, 20.0, 0.0, 5.0])
    D = np.array(vehicle.vehicle.D_B)
    J = np.array(vehicle.vehicle.J_B) - 0.05 * D @ D.T
    coupled = (np.eye(4) / 0.05 + D.T @ np.linalg.inv(J) @ D) @ np.diag(friction)
    (found,) = time_constants.findings(vehicle.replace(**{"truth.viscous_friction": list(friction)}))
    assert found.value == pytest.approx(0.01 * np.linalg.eigvals(coupled).real.max(), rel=1e-12)
    assert found.ok
    assert "mostly of viscous friction" in found.text


def test_rk4_takes_the_steps_that_are_announced(vehicle: gs.Scenario) -> None:
    quick = vehicle.replace(**{"truth.viscous_friction": 10.0, "duration": 1.0})
    (found,) = time_constants.findings(quick)
    assert "rk4 takes 5 steps for them instead of 1" in found.text
    assert quick.run().statistics["steps"] == 500
    assert time_constants.findings(quick.replace(**{"integrator.substeps": 5})) == []


def test_a_vehicle_that_no_integrator_can_follow_fails(vehicle: gs.Scenario) -> None:
    (found,) = time_constants.findings(vehicle.replace(**{"initial.omega_BN_B": [1000.0, 0.0, 0.0], "dt": 1.0}))
    assert found.ok is False
    assert "mostly of turning and precession; beyond 1000 the run ends" in found.text
    with pytest.raises(gs.InputError, match=r"stops the wheel of actuator 0 .* nothing quicker than a thousandth"):
        vehicle.replace(**{"truth.viscous_friction": 1e5}).check()
