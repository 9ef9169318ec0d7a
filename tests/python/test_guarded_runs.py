# SPDX-License-Identifier: MIT
"""What the guard did in a run is told: events, share of samples, the line of `run`, and whether it flew at all."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

import gyrostat as gs
from gyrostat.cli import app


@pytest.fixture(scope="module")
def small(scenario: gs.Scenario) -> gs.Scenario:
    return scenario.replace(duration=1.0)


def told(result: gs.Result) -> dict[str, tuple[float, int]]:
    """What the guard did: first time and number of samples."""
    events = [e for e in result.events if e.name.startswith("guard.")]
    assert len({e.name for e in events}) == len(events), "one event for each thing"
    return {e.name: (round(e.t, 9), e.count) for e in events}


class Spoilt:
    """A rate damper that returns no number at some samples."""

    def __init__(self, *ticks: int) -> None:
        self.ticks = ticks

    def step(self, x: gs.Estimate, *_: object) -> np.ndarray:
        return np.full(3, np.nan) if x.tick in self.ticks else -5.0 * x.omega_BN_B


def test_each_thing_that_the_guard_did_is_an_event_with_its_first_time_and_count(small: gs.Scenario) -> None:
    assert told(small.run()) == {}
    sensors = [
        gs.sensors.RateDropout(t_on=0.2, t_off=0.3),
        gs.sensors.RateDropout(t_on=0.5, t_off=0.6),
        gs.sensors.AttitudeDropout(t_on=0.55, t_off=0.65),
        gs.sensors.MomentumDropout(t_on=0.9),
    ]
    result = small.replace(sensors=sensors).run()
    assert result.completed
    assert told(result) == {
        "guard.rate": (0.2, 20),
        "guard.attitude": (0.55, 10),
        "guard.momentum": (0.9, 11),
    }
    assert result.metrics.held_fraction == pytest.approx((20 + 10 + 11 - 5) / 101)  # five samples without both
    held = [e.t for e in result.events if e.name.startswith("guard.")]
    assert held == sorted(held)


def test_components_that_were_started_again_are_events_too(small: gs.Scenario) -> None:
    # start fails as step does, so that the command before is issued at each of these samples
    result = small.replace(controller=Spoilt(30, 31, 50)).run()
    assert result.completed
    assert told(result) == {"guard.controller": (0.3, 3), "guard.command": (0.3, 3)}
    assert result.metrics.held_fraction == pytest.approx(3 / 101)


def test_a_reference_that_cannot_be_is_held_and_told(small: gs.Scenario) -> None:
    # 90 deg in two samples: beyond a radian a sample
    fast = gs.reference("slew", to_euler=(0.0, 0.0, 1.5), start=0.5, duration=0.02)
    events = told(small.replace(reference=fast).run())
    assert set(events) == {"guard.reference"}
    assert events["guard.reference"][0] in (0.5, 0.51)


@pytest.mark.parametrize("python", [True, False], ids=["controller", "sensor"])
def test_a_run_without_a_command_of_the_stack_is_no_success(small: gs.Scenario, python: bool, tmp_path: Path) -> None:
    never = (
        {"controller": Spoilt(*range(200))} if python else {"sensors": [gs.sensors.RateDropout()]}
    )  # not even at the first sample
    result = small.replace(**never).run()
    assert (result.status, result.completed) == ("no_command", False)
    assert result.cause.startswith("the stack never issued a command of its own: ")
    assert ("controller started again" if python else "rate not measured") in result.cause
    assert result.end_time == 1.0
    assert result.metrics.held_fraction == 1.0
    again = gs.Result.load(result.save(tmp_path / "run.npz"))
    assert (again.status, again.cause, again.metrics.held_fraction) == (result.status, result.cause, 1.0)
    assert told(again) == told(result)


def test_one_command_of_its_own_is_enough(small: gs.Scenario) -> None:
    result = small.replace(controller=Spoilt(*range(1, 200))).run()
    assert result.completed
    assert result.metrics.held_fraction == pytest.approx(100 / 101)


def test_run_says_what_the_guard_did(tmp_path: Path) -> None:
    runner = CliRunner()
    window = 'sensors=[{type="rate_dropout", t_on=0.2, t_off=0.3}]'
    flown = runner.invoke(app, ["run", "ftc_4rw", "--set", "duration=1", "--set", window])
    assert flown.exit_code == 0
    assert "rate not measured at 9.9 % of the samples, first at 0.2 s" in " ".join(flown.output.split())
    never = ["--set", 'sensors=[{type="attitude_dropout"}]', "--out", str(tmp_path / "run.npz")]
    failed = runner.invoke(app, ["run", "ftc_4rw", "--set", "duration=1", *never])
    assert failed.exit_code == 3
    assert "the stack never issued a command of its own: attitude not measured" in " ".join(failed.output.split())
    assert gs.Result.load(tmp_path / "run.npz").status == "no_command"


def test_a_gyro_slower_than_the_stack_is_heard_by_who_carries_a_model_on() -> None:
    """The table of docs/components/sensor/gyro.md: error over 80 to 100 s, deg."""
    vehicle = {**gs.vehicle.ftc_4rw().to_dict(), "wheel_inertia": None}
    push = gs.disturbances.Constant(torque_B=(2e-2, -1e-2, 1e-2))
    base = gs.Scenario.load("wheel2_degraded").replace(
        vehicle=vehicle, controller="mrp_feedback", disturbances=[push], duration=100.0
    )

    def flown(observer: str, every: int, dt: float) -> tuple[float, list[str]]:
        sensors = [gs.sensors.Gyro(noise=1e-5, every=every), gs.sensors.Attitude(noise=2e-5)]
        scenario = base.replace(observer=observer, dt=dt, sensors=sensors)
        result = scenario.run(channels=["error.angle"])
        return float(np.degrees(result["error.angle"][result.t > 80.0].max())), scenario.remarks()

    deaf, remarks = flown("finite_time_disturbance", 2, 0.01)
    assert 3.3 < deaf < 3.6
    assert [remark.partition(", and observer")[0] for remark in remarks] == [
        "sensors[0] 'gyro' has a rate every 2 samples"
    ]
    assert remarks[0].endswith("it learns nothing; dt = 0.02 s is the gyro's, or take joint_kalman")
    for observer, every, dt in (
        ("finite_time_disturbance", 1, 0.02),
        ("joint_kalman", 2, 0.01),
        ("joint_kalman", 5, 0.01),
    ):
        error, remarks = flown(observer, every, dt)
        assert error < 0.004
        assert remarks == []
