# SPDX-License-Identifier: MIT
"""References that a mission plans, flown: attitudes of a table, and a turn in least time."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import gyrostat as gs

REST = [0.0, 0.0, 0.0]


def flown(reference: Any, duration: float) -> gs.Result:
    scenario = gs.Scenario(
        vehicle=gs.vehicle.ftc_4rw(), controller="mrp_feedback", reference=reference, duration=duration, dt=0.1
    )
    return scenario.run(channels=["reference.q_NR", "reference.omega_RN_R", "error.angle"])


def test_a_table_is_followed_through_its_rows() -> None:
    rows = np.array([[1.0, 0, 0, 0], [0.96, 0.28, 0, 0], [0.8, 0.36, 0.48, 0]])
    table = gs.references.Table(times=[5, 65, 125], q_NR=[*rows[:2], -rows[2]], omega_RN_R=[REST, [0.01, 0, 0], REST])
    result = flown(table, 150.0)
    for time, row in zip((5, 65, 125), rows, strict=True):
        np.testing.assert_allclose(result["reference.q_NR"][round(time * 10)], row, atol=1e-14)
    np.testing.assert_allclose(result["reference.omega_RN_R"][650], [0.01, 0, 0], atol=1e-16)
    assert np.rad2deg(result["error.angle"]).max() < 0.5


def test_a_turn_in_least_time_is_followed_where_the_wheels_can() -> None:
    turn = gs.references.BangBang(axis=[1, 2, 2], angle=0.6, rate_max=0.01, acceleration_max=2e-4, start=10.0)
    result = flown(turn, 150.0)  # 50 s of acceleration, 10 s of coast, 50 s of brake
    rate = np.linalg.norm(result["reference.omega_RN_R"], axis=1)
    assert rate[result.t <= 10.0].max() < 1e-15
    assert rate[650] == pytest.approx(0.01, rel=1e-12)
    assert rate[result.t >= 120.0].max() < 1e-15
    assert 2 * np.arccos(result["reference.q_NR"][-1][0]) == pytest.approx(0.6, rel=1e-12)
    assert np.rad2deg(result["error.angle"]).max() < 0.5


@pytest.mark.parametrize(
    ("reference", "message"),
    [
        ({"type": "table", "times": [0, 1], "q_NR": [[1, 0, 0, 0]]}, "2 times and 1 attitudes"),
        ({"type": "table", "times": [0, 0], "q_NR": [[1, 0, 0, 0]] * 2}, "times must increase"),
        ({"type": "table", "times": [0, 1], "q_NR": [[1, 0, 0, 0], [0, 0, 0, 1]]}, r"turns 3\.14159.* at most 2\.5"),
        ({"type": "bang_bang", "angle": 1.0, "rate_max": 0.01}, "acceleration_max is missing"),
        ({"type": "bang_bang", "angle": 90, "rate_max": 0.01, "acceleration_max": 1e-3}, "looks like degrees"),
    ],
)
def test_what_is_no_reference_is_one_line(reference: dict[str, Any], message: str) -> None:
    with pytest.raises(ValueError, match=message) as error:
        flown(reference, 10.0)
    assert "\n" not in str(error.value)
