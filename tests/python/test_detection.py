# SPDX-License-Identifier: MIT
"""Detection metrics on made-up declarations and over the catalogue, identifiability, checks of learning observers.

``python tests/python/test_detection.py`` writes ``tests/golden/detection.csv`` and ``isolation.csv`` anew.
"""

from __future__ import annotations

import csv
import functools
import re
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

import gyrostat as gs
from gyrostat import _core, detection, papers
from gyrostat.cli import app
from gyrostat.design import CHECKS, Finding, iterative_learning

GOLDEN = Path(__file__).parents[1] / "golden"
TABLE, ISOLATION = GOLDEN / "detection.csv", GOLDEN / "isolation.csv"


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


def three_actuators(seed: int, persistence: float = 0.2) -> gs.Scenario:
    """The bench of yang2023 with abrupt faults; every detector as there, heard for `persistence`."""
    bench = papers.load("yang2023").cases["fd_a"].scenario
    return bench.replace(seed=seed, **{"detector.persistence": persistence})


def four_wheels(seed: int, persistence: float = 0.2) -> gs.Scenario:
    """Square torques of all wheels of a pyramid; each loses half at 20, 40, 60, 80 s and has it back 90 s later."""
    return gs.Scenario(
        vehicle=gs.vehicle.ftc_4rw(),
        detector=gs.detector("threshold", persistence=persistence),
        controller=gs.controller(
            "open_loop",
            command=[gs.waveforms.Square(low=-0.1, high=0.1, period=20 + 4 * j, phase=5.0 + j) for j in range(4)],
        ),
        allocator=gs.allocator("pseudo_inverse", use_effectiveness=False),
        faults=[
            gs.faults.LossOfEffectiveness(actuator=j, t_on=20.0 * (j + 1), t_off=110.0 + 20.0 * j, remaining=0.5)
            for j in range(4)
        ],
        sensors=[gs.sensors.Gyro(noise=1.75e-5)],
        integrator=gs.integrators.Rk4(),
        duration=190.0,
        dt=0.01,
        seed=seed,
        allow_unstable=True,
    )


BENCHES = {"three actuators": three_actuators, "four wheels": four_wheels}
SEEDS = (1, 2, 3)
PATIENT = ("mixed_learning_disturbance", 1.5)
"""An observer that settles in a second wants a detector that waits for longer than that."""


@functools.cache
def measured() -> dict[tuple[str, str, float], tuple[detection.DetectionReport, ...]]:
    """Reports of three seeds by bench, observer and persistence: the whole catalogue, and the patient detector."""
    out: dict[tuple[str, str, float], tuple[detection.DetectionReport, ...]] = {}
    for bench, build in BENCHES.items():
        for persistence, observers in ((0.2, None), (PATIENT[1], {PATIENT[0]: PATIENT[0]})):
            runs = [detection.compare(build(seed, persistence), observers, least=0.25) for seed in SEEDS]
            for name in runs[0]:
                out[bench, name, persistence] = tuple(run[name] for run in runs)
    return out


def table_rows() -> list[dict[str, str]]:
    """What ``tests/golden/detection.csv`` holds: sums over the seeds, the longest delay, the largest error."""
    rows = []
    for (bench, name, persistence), reports in measured().items():
        delays = np.concatenate([r.delays for r in reports])
        row = {"bench": bench, "observer": name, "persistence (s)": f"{persistence:g}"}
        row |= {answer: str(sum(r.count(answer) for r in reports)) for answer in detection.ANSWERS}
        row["false alarms"] = str(sum(len(r.false_alarms) for r in reports))
        row["longest delay (s)"] = f"{delays.max():.2f}" if len(delays) else ""
        row["largest rms error"] = f"{max(r.error.max() for r in reports):.3f}"
        rows.append(row)
    return rows


def test_every_observer_of_the_catalogue_is_measured_alike() -> None:
    for bench in BENCHES:
        assert {name for b, name, _ in measured() if b == bench} == set(_core.catalogue()["observer"])
    with TABLE.open(newline="") as file:
        golden = list(csv.DictReader(line for line in file if not line.startswith("#")))
    assert len(golden) == len(table_rows())
    for row, expected in zip(table_rows(), golden, strict=True):
        for key, cell in expected.items():
            if key in {"longest delay (s)", "largest rms error"} and cell:
                assert float(row[key]) == pytest.approx(float(cell), rel=0.02, abs=0.011), (expected, key)
            else:
                assert row[key] == cell, (expected, key)


def test_isolation_answers_are_those_of_the_checked_in_matrix() -> None:
    with ISOLATION.open(newline="") as file:
        assert list(csv.DictReader(line for line in file if not line.startswith("#"))) == isolation_rows()


def isolation_rows() -> list[dict[str, str]]:
    """What ``tests/golden/isolation.csv`` holds: who was named, four wheels, three seeds."""
    rows = []
    for name in ("iterative_learning", "learning_effectiveness", "finite_time_disturbance"):
        total = np.sum([r.isolation for r in measured()["four wheels", name, 0.2]], axis=0)
        for j, counts in enumerate(total):
            row = {"observer": name, "changed": str(j)}
            columns = [f"named {i}" for i in range(4)] + ["ambiguous", "missed"]
            rows.append(row | {c: str(n) for c, n in zip(columns, counts, strict=True)})
    return rows


def test_effectiveness_observers_find_every_fault_of_three_actuators() -> None:
    for name in ("adaptive_iterative_learning", "iterative_learning", "learning_effectiveness"):
        for report in measured()["three actuators", name, 0.2]:
            assert [c.answer for c in report.changes] == ["isolated"] * 4, name
            assert report.false_alarms == (), name
            assert report.delays.max() < 0.6, name
            assert report.error.max() < 0.1, name
    for report in measured()["three actuators", "passthrough", 0.2]:
        assert report.missed == 4


def test_a_lumped_torque_is_heard_by_mapping_it_onto_the_actuators() -> None:
    quiet = three_actuators(1).replace(sensors=[])
    with_map = detection.compare(quiet, {"torque": "finite_time_disturbance"}, least=0.25)["torque"]
    without = detection.compare(
        quiet.replace(**{"detector.use_torque": False}), {"torque": "finite_time_disturbance"}, least=0.25
    )["torque"]
    assert [c.answer for c in with_map.changes] == ["isolated"] * 4
    assert with_map.false_alarms == ()
    assert without.missed == 4
    assert with_map.error.max() < 0.1
    assert without.error.max() > 0.4


def test_a_detector_must_wait_for_longer_than_the_observer_settles() -> None:
    # A torque estimate turns round a second after the command does; until then it points at a fault that is not there.
    hasty = measured()["three actuators", "mixed_learning_disturbance", 0.2]
    patient = measured()["three actuators", *PATIENT]
    assert min(len(r.false_alarms) for r in hasty) > 5
    for report in patient:
        assert [c.answer for c in report.changes] == ["isolated"] * 4
        assert report.false_alarms == ()


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


def test_a_run_reports_what_was_declared_and_how_late() -> None:
    printed = CliRunner().invoke(app, ["run", "yang2023/maneuver", "--set", "duration=100"])
    assert printed.exit_code == 0, printed.output
    assert re.search(r"actuator 0 declared at 84\.3\d s, 0\.3\d s after a fault of it", printed.output)


def finding(scenario: gs.Scenario, name: str) -> Finding | None:
    return next((f for look in CHECKS for f in look(scenario) if f.name == name), None)


@pytest.mark.parametrize(
    "observer",
    ["iterative_learning", "adaptive_sliding_mode_effectiveness", "learning_effectiveness", "finite_time_disturbance"],
)
def test_check_says_what_four_wheels_cannot_show(observer: str) -> None:
    wheels = gs.Scenario.load("ftc_4rw").replace(observer=observer, detector="threshold")
    found = finding(wheels, "identifiable")
    assert found is not None
    assert found.value == 3.0
    assert found.ok is None, "no verdict: other commands may show it"
    assert "no trace of" in found.text


def test_check_says_what_the_bench_shows() -> None:
    bench = papers.load("yang2023").cases["fd_a"].scenario
    found = finding(bench, "identifiable")
    assert found is not None
    assert found.ok is True
    assert "over the open-loop commands" in found.text
    assert finding(four_wheels(1).replace(observer="learning_effectiveness"), "identifiable").ok is True  # type: ignore[union-attr]
    for quiet in ({"observer": "passthrough"}, {"observer": "finite_time_disturbance", "detector": "none"}):
        assert finding(bench.replace(**quiet), "identifiable") is None, "nobody estimates effectiveness there"


def test_check_holds_the_error_loop_of_an_iterative_learning_observer() -> None:
    bench = papers.load("yang2023").cases["fd_a"].scenario
    names = {f.name: f for f in iterative_learning.findings(bench)}
    assert names["error loop_0"].ok is True
    assert names["error loop_max"].ok is True
    assert iterative_learning.findings(gs.Scenario.load("ftc_4rw")) == []
    leaky = bench.replace(**{"observer.k3": 0.99})
    memory = next(f for f in iterative_learning.findings(leaky) if f.name == "memory")
    assert memory.value == pytest.approx(0.14 / (0.14 + 0.49))


def write_tables() -> None:
    """What is measured, anew."""
    about = "three seeds together; threshold 0.2, changes of 0.25 and more count"
    for path, rows in ((TABLE, table_rows()), (ISOLATION, isolation_rows())):
        with path.open("w", newline="") as file:
            file.write(f"# {about}. Written by tests/python/test_detection.py.\n")
            writer = csv.DictWriter(file, list(rows[0]), lineterminator="\n")
            writer.writeheader()
            writer.writerows(rows)


if __name__ == "__main__":
    write_tables()
