# SPDX-License-Identifier: MIT
"""Components written in Python fly in the same loop as compiled ones."""

from __future__ import annotations

import re
import threading
from collections.abc import Callable
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


class KnowsTheBias:
    """A navigator that learns the bias of its gyro at tick 500, and says so."""

    bias = np.array([2e-3, -2e-3, 2e-3])

    def step(self, y: gs.Measurement) -> gs.Measurement:
        if y.tick >= 500:
            y.omega_BN_B = y.omega_BN_B - self.bias
        if y.tick == 500:
            y.rate_step = -self.bias
        return y


class Shifted:
    """An observer that differentiates the rate, unless it is told that there was no motion."""

    def __init__(self) -> None:
        self.shifts: list[np.ndarray] = []
        self.jumps: list[float] = []
        self.before = np.zeros(3)

    def shift_rate(self, step: np.ndarray) -> None:
        self.shifts.append(step)
        self.before = self.before + step

    def step(self, y: gs.Measurement, last: gs.Allocation) -> gs.Estimate:
        self.jumps.append(float(np.linalg.norm(y.omega_BN_B - self.before)))
        self.before = y.omega_BN_B
        return gs.Estimate.healthy(y)


def test_a_python_navigator_stands_before_the_observer(ideal: gs.Scenario) -> None:
    biased = ideal.replace(sensors=[gs.sensors.Gyro(bias=KnowsTheBias.bias)], duration=90.0, observer=Shifted())
    biased = biased.replace(faults=[], disturbances=[])
    plain = biased.replace(observer=None).run()
    flown = biased.replace(navigator=KnowsTheBias()).run()
    error = [np.rad2deg(result["error.angle"][-1]) for result in (plain, flown)]
    assert error[0] > 0.5, "a bias is an offset that no observer sees"
    assert error[1] < 0.01
    observer = flown.components["observer"]
    np.testing.assert_allclose(observer.shifts, [-KnowsTheBias.bias], rtol=0, atol=0)
    assert max(observer.jumps[2:]) < 1e-3, "knowledge is no motion"


def test_a_navigator_that_returns_something_else_is_told_so(ideal: gs.Scenario) -> None:
    class Forgetful:
        def step(self, y: gs.Measurement) -> None: ...

    with pytest.raises(ValueError, match=r"^navigator Forgetful\.step returned nothing \(None\); a Measurement"):
        ideal.replace(navigator=Forgetful()).run()  # type: ignore[arg-type]


class Watching:
    """An observer that notes what it is called for, and which parts were measured."""

    def __init__(self) -> None:
        self.calls: list[tuple[int, str, tuple[bool, bool, bool]]] = []
        self.rates: list[np.ndarray] = []

    def note(self, y: gs.Measurement, call: str) -> gs.Estimate:
        self.calls.append((y.tick, call, (y.attitude_valid, y.rate_valid, y.momentum_valid)))
        self.rates.append(y.omega_BN_B)
        return gs.Estimate.healthy(y)

    def start(self, y: gs.Measurement) -> gs.Estimate:
        return self.note(y, "start")

    def step(self, y: gs.Measurement, last: gs.Allocation) -> gs.Estimate:
        return self.note(y, "step")


class Skipping(Watching):
    def skip(self, y: gs.Measurement, last: gs.Allocation) -> gs.Estimate:
        return self.note(y, "skip")


@pytest.mark.parametrize("observer", [Watching(), Skipping()], ids=["step", "skip"])
def test_an_observer_sees_what_was_not_measured_and_may_skip_it(ideal: gs.Scenario, observer: Watching) -> None:
    sensors = [
        gs.sensors.RateDropout(t_on=0.2, t_off=0.3),
        gs.sensors.AttitudeDropout(t_on=0.4, t_off=0.5),
        gs.sensors.MomentumDropout(t_on=0.6, t_off=0.7),
    ]
    result = ideal.replace(observer=observer, sensors=sensors, duration=1.0).run(channels=["truth.omega_BN_B"])
    flown = result.components["observer"]
    ticks = range(101)
    assert [c[0] for c in flown.calls] == list(ticks)
    windows = (range(40, 50), range(20, 30), range(60, 70))
    assert [c[2] for c in flown.calls] == [tuple(k not in window for window in windows) for k in ticks]
    # an interval teaches nothing when the rate or the wheels were not measured at one of its ends
    blind = {*range(20, 31), *range(60, 71)} if isinstance(observer, Skipping) else set()
    assert [c[1] for c in flown.calls] == ["start", *("skip" if k in blind else "step" for k in ticks[1:])]
    # and what was not measured is carried on: within what the nominal model leaves, not held
    error = np.abs(np.array(flown.rates) - result["truth.omega_BN_B"]).max(axis=1)
    held = np.abs(result["truth.omega_BN_B"][29] - result["truth.omega_BN_B"][19]).max()
    assert error[29] < 0.1 * held


def of_observer(change: Callable[[gs.Estimate], object]) -> dict[str, Any]:
    class Mine:
        def step(self, y: gs.Measurement, last: gs.Allocation) -> object:
            return change(gs.Estimate.healthy(y))

    return {"observer": Mine()}


def of_detector(change: Callable[[gs.Detection], object]) -> dict[str, Any]:
    class Mine:
        def setup(self, setup: gs.Setup) -> None:
            self.vehicle = setup.vehicle

        def step(self, x: gs.Estimate, last: gs.Allocation) -> object:
            return change(gs.Detection.none(self.vehicle))

    return {"detector": Mine()}


def of(role: str, returned: Callable[[], object]) -> dict[str, Any]:
    class Mine:
        def step(self, *_: object) -> object:
            return returned()

    return {role: Mine()}


def with_values(signal: Any, **values: object) -> Any:
    for name, value in values.items():
        setattr(signal, name, value)
    return signal


@pytest.mark.parametrize(
    ("parts", "said"),
    [
        (
            of_observer(lambda x: with_values(x, h_w=[])),
            "observer Mine.step returned 0 numbers as h_w; 4 belong",
        ),
        (
            of_observer(lambda x: with_values(x, effectiveness=np.ones(5))),
            "observer Mine.step returned 5 numbers as effectiveness; 4 belong there, one an actuator",
        ),
        (
            of_observer(lambda x: with_values(x, effectiveness_bound=1.0)),
            "observer Mine.step returned 1 numbers as effectiveness_bound; 4 belong there, one an actuator",
        ),
        (of_observer(lambda x: with_values(x, omega_BN_B=[1, 2])), "omega_BN_B was given 2 numbers; 3 belong there"),
        (of_observer(lambda x: with_values(x, q_NB=np.eye(3))), "q_NB was given 9 numbers; 4 belong there"),
        (of_observer(lambda x: with_values(x, d_B="none")), "d_B was given a str; 3 numbers belong there"),
        (of_observer(lambda x: with_values(x, d_B=None)), "d_B was given nothing (None); 3 numbers belong there"),
        (of_observer(lambda x: with_values(x, h_w=np.ones(17))), "h_w was given 17 numbers; at most 16 belong there"),
        (of("observer", lambda: 3), "observer Mine.step returned a int; an Estimate (Estimate.healthy(y) makes one)"),
        (of_detector(lambda d: with_values(d, u_probe=[1, 2])), "detector Mine.step returned 2 numbers as u_probe; 4 "),
        (
            of_detector(lambda d: with_values(d, failed=[7])),
            "detector Mine.step returned actuator 7 as failed; the vehicle has 0 to 3",
        ),
        (of_detector(lambda d: with_values(d, enabled=[16])), "actuator 16 is not in 0 to 15"),
        (of("detector", lambda: None), "detector Mine.step returned nothing (None); a Detection"),
        (of("controller", lambda: np.zeros(2)), "controller Mine.step returned 2 numbers; 3 belong there"),
        (of("controller", lambda: "stop"), "controller Mine.step returned a str; 3 numbers belong there"),
        (of("controller", lambda: gs.Demand([1, 2])), "tau_B was given 2 numbers; 3 belong there"),
        (
            of("controller", lambda: gs.Demand([1, 2, 3], u_pref=[1])),
            "controller Mine.step returned 1 numbers as u_pref; 4 belong there, one an actuator, or none",
        ),
        (of("allocator", lambda: np.zeros(3)), "allocator Mine.step returned 3 numbers; 4 belong there"),
        (
            of("allocator", gs.Allocation),
            "allocator Mine.step returned 0 numbers as u; 4 belong there, one an actuator",
        ),
        (
            of("allocator", lambda: with_values(gs.Allocation(), u=np.zeros(4), saturated=[4])),
            "allocator Mine.step returned actuator 4 as saturated; the vehicle has 0 to 3",
        ),
    ],
)
def test_what_does_not_fit_is_one_line_with_what_belongs_there(
    ideal: gs.Scenario, parts: dict[str, Any], said: str
) -> None:
    with pytest.raises(ValueError, match=f"^{re.escape(said)}") as caught:
        ideal.replace(**parts, duration=0.1).run()
    assert "\n" not in str(caught.value)


def test_a_function_of_a_component_is_named_when_it_returns_the_wrong_size(ideal: gs.Scenario) -> None:
    class Starting(Skipping):
        def start(self, y: gs.Measurement) -> Any:
            return None

    class Lost(Skipping):
        def skip(self, y: gs.Measurement, last: gs.Allocation) -> Any:
            return None

    dropout = [gs.sensors.RateDropout(t_on=0.05, t_off=0.06)]
    for observer, said in ((Starting(), "start"), (Lost(), "skip")):
        with pytest.raises(ValueError, match=rf"^observer \w+\.{said} returned nothing \(None\); an Estimate"):
            ideal.replace(observer=observer, sensors=dropout, duration=0.1).run()


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
