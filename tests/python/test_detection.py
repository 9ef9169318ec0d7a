# SPDX-License-Identifier: MIT
"""Detection metrics on made-up declarations, identifiability against closed forms, checks of learning observers."""

from __future__ import annotations

import numpy as np
import pytest

import gyrostat as gs
from gyrostat import _core, detection, papers
from gyrostat.design import iterative_learning


def test_declarations_are_matched_with_changes() -> None:
    changes = [(10.0, 0, -0.5), (20.0, 1, -0.4), (30.0, 2, -0.3), (40.0, 3, -0.6), (50.0, 0, 0.2)]
    declared = [(5.0, 0b0001), (10.4, 0b0001), (20.5, 0b0110), (30.3, 0b1000), (60.0, 0b0001)]
    found, false, isolation = detection.evaluate(changes, declared, 4, horizon=4.0)
    assert [c.answer for c in found] == ["isolated", "ambiguous", "wrong", "missed", "missed"]
    assert [c.delay for c in found] == [pytest.approx(0.4), pytest.approx(0.5), pytest.approx(0.3), None, None]
    assert false == (5.0, 60.0)
    np.testing.assert_array_equal(
        isolation, [[1, 0, 0, 0, 0, 1], [0, 0, 0, 0, 1, 0], [0, 0, 0, 1, 0, 0], [0, 0, 0, 0, 0, 1]]
    )


def test_changes_at_once_share_one_declaration() -> None:
    found, false, _ = detection.evaluate([(1.0, 0, -0.5), (1.0, 2, -0.5)], [(1.3, 0b101)], 4)
    assert [c.answer for c in found] == ["ambiguous", "ambiguous"]
    assert false == ()


def test_every_observer_of_the_catalogue_is_measured_alike() -> None:
    names = _core.catalogue()["observer"]
    base = papers.load("yang2023").cases["fd_a"].scenario
    shadow = [{"observer": {"type": name}, "detector": base.resolve()["detector"]} for name in names]
    scenario = base.replace(shadows=shadow, sensors=[], duration=60.0)
    wanted = ("estimate.effectiveness", "detection.event", "detector.declared")
    roles = [f"shadow{i}" for i in range(len(names))]
    result = scenario.run(channels=["truth.effectiveness", *(f"{r}.{c}" for r in roles for c in wanted)])
    reports = {
        name: detection.detection_report(result, role, least=0.25) for name, role in zip(names, roles, strict=True)
    }
    for name in ("adaptive_iterative_learning", "iterative_learning", "finite_time_disturbance"):
        assert [c.answer for c in reports[name].changes] == ["isolated"] * 3, name
        assert reports[name].false_alarms == (), name
        assert reports[name].delays.max() < 0.6, name
    assert reports["passthrough"].missed == 3
    # An observer of effectiveness says how much is left; one of torque leaves it at one.
    assert reports["iterative_learning"].error.max() < 0.1 < reports["finite_time_disturbance"].error.max()


def test_one_command_shows_three_of_four_effectiveness_values() -> None:
    D = np.asarray(gs.vehicle.pyramid4(J_B=(1.0, 1.0, 1.0)).D_B)
    u = np.array([0.1, -0.05, 0.2, 0.07])
    report = detection.identifiability(D, u)
    assert report.rank == 3
    assert report.silent == report.confused == ()
    np.testing.assert_allclose(D @ (u * report.hidden[0]), 0.0, atol=1e-12)  # it makes no torque: that is why
    assert np.linalg.norm(report.hidden[0]) == pytest.approx(1.0)
    exciting = np.array([u, [0.1, 0.2, -0.1, 0.05], [0.0, 0.1, 0.1, -0.2]])
    assert detection.identifiability(D, exciting).rank == 4
    assert detection.identifiability(D, np.outer([1.0, -2.0, 0.5], u)).rank == 3, "proportional commands add nothing"


def test_silent_and_parallel_actuators_are_named() -> None:
    D = np.array([[1.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [0.0, 0.0, 0.0, 1.0]])
    report = detection.identifiability(D, [0.1, 0.2, 0.1, 0.01], gate=0.05)
    assert report.silent == (3,)
    assert report.confused == ((0, 1),)
    assert report.rank == 2
    assert "silent: actuators 3" in str(report)
    assert "not told apart: 0 and 1" in str(report)


def test_roots_of_the_error_loop_are_those_of_its_recursion() -> None:
    h, k1, k3, k4 = 0.01, 14.0, 1.0, 0.49
    one_step = np.array([[1.0 - h * k1, h], [-k4 * (1.0 - h * k1), k3 - k4 * h]])  # rate error, effectiveness error
    np.testing.assert_allclose(
        np.sort_complex(iterative_learning.learning_roots(h, k1, k3, k4)),
        np.sort_complex(np.linalg.eigvals(one_step)),
        atol=1e-9,
    )
    assert np.abs(iterative_learning.learning_roots(h, 100.0, 1.0, 100.0)).max() < 1e-6  # dead beat
    assert len(iterative_learning.learning_roots(h, k1, k3, k4, k5=1.0, delay=5)) == 6


@pytest.mark.parametrize(
    ("gains", "holds"),
    [
        ((10.0, 1.0, 0.25, 0.0), False),  # k3 = 1: b1 is at least 1, whatever else
        ((10.0, 0.99, 0.25, 0.0), False),
        ((10.0, 0.9, 0.25, 0.0), True),
        ((200.0, 0.999, 0.01, 0.0), True),
        ((200.0, 0.99, 0.25, 0.0), True),
        ((200.0, 0.99, 4.0, 0.0), False),
    ],
)
def test_the_published_stability_condition(gains: tuple[float, float, float, float], *, holds: bool) -> None:
    assert (iterative_learning.theorem_slack(*gains) < 0.0) is holds


def test_check_says_what_a_learning_observer_can_find() -> None:
    wheels = gs.Scenario.load("ftc_4rw").replace(observer="iterative_learning")
    found = {f.name: f for f in iterative_learning.findings(wheels)}
    assert found["error loop"].ok is True
    assert found["identifiable"].value == 3.0
    assert "no trace of" in found["identifiable"].text
    bench = papers.load("yang2023").cases["fd_a"].scenario
    found = {f.name: f for f in iterative_learning.findings(bench)}
    assert found["identifiable"].ok is True
    assert iterative_learning.findings(gs.Scenario.load("ftc_4rw")) == []
    leaky = bench.replace(**{"observer.k3": 0.99})
    memory = next(f for f in iterative_learning.findings(leaky) if f.name == "memory")
    assert memory.value == pytest.approx(0.14 / (0.14 + 0.49))
