# SPDX-License-Identifier: MIT
"""What a Python object publishes is recorded as the inner signals of a compiled component are, in every role."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import gyrostat as gs


class Publishing:
    """Counts its calls in every role, and says the time of the last one."""

    def __init__(self) -> None:
        self.calls, self.t = 0, 0.0

    def setup(self, setup: gs.Setup) -> None:
        self.setup_, self.each = setup, np.zeros(setup.vehicle.D_B.shape[1])

    def called(self, t: float) -> None:
        self.calls, self.t = self.calls + 1, t
        self.each = self.each + 1.0

    def telemetry(self) -> dict[str, Any]:
        return {"calls": self.calls, "t": np.float32(self.t), "each": self.each, "pair": (self.calls, -self.calls)}


class Navigator(Publishing):
    def step(self, y: gs.Measurement) -> gs.Measurement:
        self.called(y.tick * self.setup_.dt)
        return y


class Observer(Publishing):
    def step(self, y: gs.Measurement, last: gs.Allocation) -> gs.Estimate:
        self.called(y.tick * self.setup_.dt)
        return gs.Estimate.healthy(y)


class Detector(Publishing):
    def step(self, x: gs.Estimate, last: gs.Allocation) -> gs.Detection:
        self.called(x.tick * self.setup_.dt)
        return gs.Detection.none(self.setup_.vehicle)


class Controller(Publishing):
    def step(self, x: gs.Estimate, *_: Any) -> np.ndarray:
        self.called(x.tick * self.setup_.dt)
        return -0.1 * self.setup_.vehicle.J_B @ x.omega_BN_B


class Allocator(Publishing):
    def step(self, demand: gs.Demand, x: gs.Estimate, det: gs.Detection) -> np.ndarray:
        self.called(x.tick * self.setup_.dt)
        return np.asarray(np.linalg.pinv(self.setup_.vehicle.D_B) @ demand.tau_B)


class Reference(Publishing):
    def at(self, t: float) -> list[float]:
        self.called(t)
        return [1.0, 0.0, 0.0, 0.0]


class Sensor(Publishing):
    def measure(self, y: gs.Measurement) -> gs.Measurement:
        self.called(y.tick * self.setup_.dt)
        return y


class Acting(Publishing):
    """Fault, drive and disturbance: asked after the sample has been recorded."""

    def apply(self, t: float, u: np.ndarray) -> np.ndarray:
        self.called(t)
        return u

    def deliver(self, t: float, u: float, h_w: float, omega_BN_B: np.ndarray) -> float:
        self.called(t)
        return u

    def torque_B(self, t: float, q_NB: np.ndarray, omega_BN_B: np.ndarray) -> list[float]:
        self.called(t)
        return [0.0, 0.0, 0.0]


ROLES: dict[str, Any] = {
    "navigator": Navigator(),
    "observer": Observer(),
    "detector": Detector(),
    "controller": Controller(),
    "allocator": Allocator(),
    "reference": Reference(),
    "sensors": [gs.sensors.Gyro(noise=1e-6), Sensor(), Sensor()],
    "faults": [gs.faults.Bias(actuator=0, torque=1e-3, t_on=0.3), Acting()],
    "drives": {2: Acting()},
    "disturbances": [Acting()],
}
BEFORE = ["navigator", "observer", "detector", "controller", "allocator", "reference", "sensor0", "sensor1"]
BEHIND = ["fault0", "drive2", "disturbance0"]


@pytest.fixture(scope="module")
def flight() -> gs.Scenario:
    start = gs.Initial(omega_BN_B=(0.01, -0.02, 0.03))
    return gs.Scenario(vehicle=gs.vehicle.ftc_4rw(), initial=start, duration=1.0, dt=0.05, **ROLES)


@pytest.fixture(scope="module")
def result(flight: gs.Scenario) -> gs.Result:
    return flight.run()


def test_all_roles_are_recorded_after_their_samples(result: gs.Result) -> None:
    tick = np.arange(21)
    for name in BEFORE:
        np.testing.assert_array_equal(result[f"{name}.calls"], tick + 1, err_msg=name)
        np.testing.assert_array_equal(result[f"{name}.t"], np.float32(tick * 0.05), err_msg=name)
    for name in BEHIND:  # the truth of a sample is that of the interval that ends there
        np.testing.assert_array_equal(result[f"{name}.calls"], tick, err_msg=name)
    for name in (*BEFORE, *BEHIND):
        calls = result[f"{name}.calls"]
        np.testing.assert_array_equal(result[f"{name}.each"], np.tile(calls[:, None], (1, 4)))
        np.testing.assert_array_equal(result[f"{name}.pair"], np.stack([calls, -calls], axis=1))


def test_they_are_channels_like_all_others(flight: gs.Scenario) -> None:
    offered = {c["name"]: c for c in flight.channel_names()}
    assert offered["drive2.each"] | {"meaning": ""} == {
        "name": "drive2.each",
        "size": 4,
        "unit": "",
        "meaning": "",
        "dimension": "actuator",
    }
    assert offered["controller.t"]["size"] == 1
    chosen = flight.run(channels=["observer.*", "drive2.pair", "error.angle"], every=4)
    assert set(chosen) == {
        "observer.calls",
        "observer.t",
        "observer.each",
        "observer.pair",
        "drive2.pair",
        "error.angle",
    }
    np.testing.assert_array_equal(chosen["observer.calls"], [1, 5, 9, 13, 17, 21])
    with pytest.raises(ValueError, match=r"no channel 'observer\.cals', did you mean 'observer\.calls'"):
        flight.run(channels=["observer.cals"])
    assert ROLES["controller"].calls == 0
    assert not hasattr(ROLES["controller"], "setup_")


def test_they_survive_every_way_out(result: gs.Result, tmp_path: Path) -> None:
    frame = result.to_dataframe()
    np.testing.assert_array_equal(frame["controller.each.3"], result["controller.each"][:, 3])
    np.testing.assert_array_equal(frame["drive2.calls"], result["drive2.calls"])
    again = gs.Result.load(result.save(tmp_path / "run.npz"))
    np.testing.assert_array_equal(again["fault0.pair"], result["fault0.pair"])
    assert again.description == result.description
    assert again.description["faults"][1] == {"type": "python", "class": "Acting"}
    assert again.metrics.last_fault == 0.3
    assert result.to_xarray()["observer.each"].dims == ("time", "actuator")
    import pyarrow.parquet as pq

    table = pq.read_table(result.to_parquet(tmp_path / "run.parquet"))
    np.testing.assert_array_equal(table["reference.calls"].to_numpy(), result["reference.calls"])
    page = result.to_html(tmp_path / "run.html", single_file=True).read_text()
    assert "Acting" in page


def test_a_law_tells_the_same_as_a_compiled_one(flight: gs.Scenario) -> None:
    """Wheel torques that the allocator asks for, as it knows them and as the loop does."""

    class Telling(Allocator):
        def step(self, demand: gs.Demand, x: gs.Estimate, det: gs.Detection) -> np.ndarray:
            self.u = super().step(demand, x, det)
            return self.u

        def telemetry(self) -> dict[str, Any]:
            return {"u": getattr(self, "u", np.zeros(4)), "unknown": np.nan}

    flown = flight.replace(allocator=Telling()).run(channels=["allocator.*", "allocation.u"])
    np.testing.assert_array_equal(flown["allocator.u"], flown["allocation.u"])
    assert np.isnan(flown["allocator.unknown"]).all(), "what is not known is recorded as that"


@pytest.mark.parametrize(
    ("out", "said"),
    [
        (lambda _: None, "returned nothing (None); a dictionary of numbers and vectors belongs there"),
        (lambda _: [1.0], "returned a list; a dictionary of numbers and vectors belongs there"),
        (lambda _: {1: 2.0}, "returned the name 1; the name of a signal is a text like those of variables"),
        (lambda _: {"a.b": 2.0}, "returned the name 'a.b'; the name of a signal is a text like those of variables"),
        (lambda _: {"a": "b"}, "returned a str as 'a'; a number or a vector belongs there"),
        (lambda _: {"a": None}, "returned nothing (None) as 'a'; a number or a vector belongs there"),
        (lambda _: {"a": []}, "returned no number as 'a'"),
        (lambda _: {"a": np.eye(2)}, "returned an array of 2 dimensions as 'a'; a number or a vector belongs there"),
        (lambda k: {"a": np.zeros(2 if k < 3 else 3)}, "returned 3 numbers as 'a', and 2 at the start (at t = 0.1 s)"),
        (
            lambda k: {"a": 1.0, **({"b": 2.0} if k > 2 else {})},
            "returned 2 signals, and 1 at the start (at t = 0.1 s)",
        ),
        (lambda k: {"a" if k < 3 else "b": 1.0}, "returned no 'a' any more (at t = 0.1 s)"),
    ],
)
def test_what_cannot_be_recorded_is_one_line(flight: gs.Scenario, out: Any, said: str) -> None:
    class Telling(Controller):
        def telemetry(self) -> Any:
            return out(self.calls)

    with pytest.raises(ValueError, match=f"^controller Telling.telemetry {re.escape(said)}$") as caught:
        flight.replace(controller=Telling()).run()
    assert "\n" not in str(caught.value)


def test_what_it_raises_reaches_the_caller(flight: gs.Scenario) -> None:
    class Telling(Acting):
        def telemetry(self) -> dict[str, Any]:
            return {"inverse": 1.0 / (5 - self.calls)}

    with pytest.raises(ZeroDivisionError) as caught:
        flight.replace(drives={1: Telling()}).run()
    assert caught.value.__notes__ == ["in drive1 Telling.telemetry at t = 0.2 s"]
