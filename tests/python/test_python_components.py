# SPDX-License-Identifier: MIT
"""Components written in Python fly in the same loop as compiled ones."""

from __future__ import annotations

import threading
from concurrent.futures import ThreadPoolExecutor
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

import gyrostat as gs


class MrpFeedback:
    """The catalogue's mrp_feedback again, from its published form: tau = -K sigma - P omega."""

    def __init__(self, stiffness: float, damping: float) -> None:
        self.stiffness, self.damping = stiffness, damping
        self.starts = 0

    def start(self, x: gs.Estimate, det: gs.Detection, ref: gs.Reference) -> Any:
        self.starts += 1
        return self.step(x, det, ref, None)

    def step(self, x: gs.Estimate, det: gs.Detection, ref: gs.Reference, last: Any) -> Any:
        q = x.q_NB if x.q_NB[0] >= 0.0 else -x.q_NB
        return -self.stiffness * q[1:] / (1.0 + q[0]) - self.damping * x.omega_BN_B


@pytest.fixture
def ideal(scenario: gs.Scenario) -> gs.Scenario:
    """Without wheels and noise: the compiled law then has no gyroscopic feedforward to differ in."""
    vehicle = gs.vehicle.ftc_4rw().model_copy(update={"wheel_inertia": None})
    return scenario.replace(vehicle=vehicle.to_dict(), sensors=[], duration=10.0)


def test_a_python_controller_flies_the_same_path_as_the_compiled_one(ideal: gs.Scenario) -> None:
    compiled = ideal.replace(controller=gs.controller("mrp_feedback"))
    gains = compiled.resolve()["controller"]
    law = MrpFeedback(gains["K"], gains["P"])
    ours = ideal.replace(controller=law).run()
    # the closed loop contracts: rounding of one sample does not grow
    np.testing.assert_allclose(ours["omega_BN_B"], compiled.run()["omega_BN_B"], rtol=0, atol=1e-12)
    assert ours.components["controller"].starts == 1
    assert law.starts == 0, "the scenario's own object does not fly"


def test_the_exception_of_a_python_component_reaches_the_caller_unchanged(ideal: gs.Scenario) -> None:
    class TroubleError(Exception):
        pass

    problem = TroubleError("wheel 2 is on fire")

    class Failing:
        def step(self, x: gs.Estimate, *_: object) -> np.ndarray:
            if x.tick == 100:
                raise problem
            return np.zeros(3)

    with pytest.raises(TroubleError) as caught:
        ideal.replace(controller=Failing()).run()
    assert caught.value is problem


def test_setup_tells_the_vehicle_and_the_period(ideal: gs.Scenario) -> None:
    seen: dict[str, Any] = {}

    class Curious:
        def setup(self, setup: gs.Setup) -> None:
            seen.update(J_B=setup.vehicle.J_B, D_B=setup.vehicle.D_B, u_up=setup.vehicle.u_up, dt=setup.dt)

        def step(self, *_: object) -> np.ndarray:
            return np.zeros(3)

    ideal.replace(controller=Curious(), duration=0.1).run()
    np.testing.assert_array_equal(seen["J_B"], ideal.vehicle.J_B)
    np.testing.assert_array_equal(seen["D_B"], ideal.vehicle.D_B)
    np.testing.assert_array_equal(seen["u_up"], np.full(4, 0.2))
    assert seen["dt"] == 0.01


class Integrating:
    """An integral law with all of its state in the object: what one run leaves would show in the next."""

    def __init__(self) -> None:
        self.sum = np.zeros(3)
        self.calls: list[str] = []

    def setup(self, setup: gs.Setup) -> None:
        self.calls.append("setup")
        self.dt = setup.dt

    def start(self, x: gs.Estimate, det: gs.Detection, ref: gs.Reference) -> np.ndarray:
        self.calls.append("start")
        return self.step(x, det, ref, None)

    def step(self, x: gs.Estimate, det: gs.Detection, ref: gs.Reference, last: Any) -> np.ndarray:
        q = x.q_NB if x.q_NB[0] >= 0.0 else -x.q_NB
        self.sum = self.sum + self.dt * q[1:]
        return -2.0 * q[1:] - 0.05 * self.sum - 8.0 * x.omega_BN_B


def test_setup_is_called_once_before_the_run_and_looking_calls_nothing(ideal: gs.Scenario) -> None:
    law = Integrating()
    flown = ideal.replace(controller=law, duration=0.1)
    flown.channel_names()
    flown.check()
    flown.resolve()
    result = flown.run()
    assert result.unit("omega_BN_B") == "rad/s"
    assert result.components["controller"].calls == ["setup", "start"]
    assert law.calls == []


def test_the_state_of_what_flew_is_in_the_result(ideal: gs.Scenario) -> None:
    result = ideal.replace(controller=Integrating(), duration=2.0).run(channels=["estimate.q_NB"])
    q = result["estimate.q_NB"]
    expected = (np.where(q[:, :1] < 0.0, -q[:, 1:], q[:, 1:])).sum(axis=0) * 0.01
    np.testing.assert_allclose(result.components["controller"].sum, expected, rtol=1e-12)  # 200 terms in another order


def test_one_object_flies_the_same_numbers_in_series_and_in_four_threads(ideal: gs.Scenario) -> None:
    flown = ideal.replace(controller=Integrating(), duration=3.0)
    once = flown.run(channels=["error.angle"])["error.angle"]
    again = flown.run(channels=["error.angle"])["error.angle"]
    np.testing.assert_array_equal(again, once)
    with ThreadPoolExecutor(4) as threads:
        for result in threads.map(lambda _: flown.run(channels=["error.angle"]), range(8)):
            np.testing.assert_array_equal(result["error.angle"], once)


def test_components_that_share_something_share_it_in_their_copies_too(ideal: gs.Scenario) -> None:
    class Watching:
        def __init__(self, notes: list[int]) -> None:
            self.notes = notes

        def step(self, y: gs.Measurement, last: gs.Allocation) -> gs.Estimate:
            self.notes.append(y.tick)
            return gs.Estimate.healthy(y)

    class Reading(Integrating):
        def __init__(self, notes: list[int]) -> None:
            super().__init__()
            self.notes = notes

        def step(self, x: gs.Estimate, det: gs.Detection, ref: gs.Reference, last: Any) -> np.ndarray:
            assert self.notes[-1] == x.tick
            return super().step(x, det, ref, last)

    notes: list[int] = []
    result = ideal.replace(observer=Watching(notes), controller=Reading(notes), duration=0.1).run()
    assert notes == []
    assert result.components["controller"].notes == list(range(11))


@pytest.mark.parametrize("held", [threading.Lock(), (number for number in range(3)), np])
def test_an_object_without_a_copy_is_refused_in_one_line(ideal: gs.Scenario, held: object) -> None:
    class Holding(Integrating):
        def __init__(self) -> None:
            super().__init__()
            self.held = held

    flown = ideal.replace(controller=Holding(), observer=SimpleNamespace(step=lambda y, _: gs.Estimate.healthy(y)))
    with pytest.raises(
        gs.InputError, match=r"^controller Holding cannot be copied \(.*\); a run flies its own copy.*$"
    ):
        flown.run()


def test_python_observer_and_allocator_fly_too(ideal: gs.Scenario) -> None:
    D = np.asarray(ideal.vehicle.D_B)
    inverse = np.linalg.pinv(D)

    class Passthrough:
        def step(self, y: gs.Measurement, last: gs.Allocation) -> gs.Estimate:
            return gs.Estimate.healthy(y)

    class Allocate:
        def step(self, demand: gs.Demand, x: gs.Estimate, det: gs.Detection) -> np.ndarray:
            return np.clip(inverse @ demand.tau_B, -0.2, 0.2)

    ours = ideal.replace(observer=Passthrough(), allocator=Allocate()).run()
    # numpy's pseudo-inverse and ours differ by rounding; the closed loop does not amplify it
    np.testing.assert_allclose(ours["omega_BN_B"], ideal.run()["omega_BN_B"], rtol=0, atol=1e-12)


def test_a_component_that_returns_the_wrong_size_is_named(ideal: gs.Scenario) -> None:
    class Wrong:
        def step(self, *_: object) -> np.ndarray:
            return np.zeros(2)

    with pytest.raises(ValueError, match=r"controller Wrong\.step returned 2 numbers; 3 belong there"):
        ideal.replace(controller=Wrong()).run()


def test_non_finite_output_is_caught_by_the_guard(ideal: gs.Scenario) -> None:
    class Broken:
        def step(self, x: gs.Estimate, *_: object) -> np.ndarray:
            return np.full(3, np.nan) if x.tick == 50 else np.zeros(3)

    flown = ideal.replace(controller=Broken()).run(channels=["allocation.u"])
    assert flown.completed
    assert np.isfinite(flown["allocation.u"]).all()


def test_a_python_component_is_offered_by_protocol() -> None:
    from gyrostat import protocols

    assert isinstance(MrpFeedback(1.0, 1.0), protocols.Controller)
    assert not isinstance(object(), protocols.Controller)
