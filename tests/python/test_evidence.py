# SPDX-License-Identifier: MIT
"""The detector `evidence` in flight: what it says of each fault, and when; no flight is lost through it."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest

import gyrostat as gs
from gyrostat import detection

CLASSES = ("healthy", "gain", "additive", "stuck", "intermittent", "unclear")
CHANNELS = ("error.angle", *(f"detection.{k}" for k in ("class", "changed", "failed", "gain", "bias")))


def scenario(**changes: Any) -> gs.Scenario:
    """Four wheels at 10 Hz from rest at 45 deg, a constant and a slow torque, noisy gyro and attitude."""
    slow = gs.waveforms.Sine(amplitude=1e-3, omega=0.05)
    blocks: dict[str, Any] = {
        "vehicle": gs.vehicle.ftc_4rw(),
        "duration": 200.0,
        "dt": 0.1,
        "seed": 1,
        "initial": {"q_NB": (math.cos(math.pi / 8), math.sin(math.pi / 8), 0.0, 0.0)},
        "observer": "learning_effectiveness",
        "detector": "evidence",
        "controller": "integral_sliding_mode",
        "allocator": "lexicographic",
        "disturbances": [
            gs.disturbances.Constant(torque_B=(2e-3, -1e-3, 1.5e-3)),
            gs.disturbances.Periodic(torque_B=(slow, slow, slow)),
        ],
        "sensors": [gs.sensors.Gyro(noise=1e-5), gs.sensors.Attitude(noise=2e-5)],
        "integrator": "rk4",
    }
    return gs.Scenario(**(blocks | changes))


@dataclass(frozen=True)
class Told:
    """What the detector said of one flight."""

    result: gs.Result

    def declared(self, actuator: int) -> float:
        """Instant of the first declaration, s; infinite without one."""
        return self._first((self.result["detection.changed"].astype(int) >> actuator & 1) > 0)

    def classed(self, actuator: int, name: str) -> float:
        """First instant at which it is of this class, s."""
        return self._first(self.result["detection.class"][:, actuator] == CLASSES.index(name))

    def _first(self, is_so: np.ndarray[Any, Any]) -> float:
        return float(self.result.t[np.argmax(is_so)]) if is_so.any() else math.inf

    def ever(self, channel: str) -> set[int]:
        """Actuators that were ever in a mask."""
        bits = int(np.bitwise_or.reduce(self.result[channel].astype(int)))
        return {i for i in range(16) if bits >> i & 1}

    @property
    def rms(self) -> float:
        """Of the pointing error over the last fifth, deg."""
        tail = self.result["error.angle"][-len(self.result) // 5 :]
        return float(np.degrees(np.sqrt(np.mean(tail**2))))


def told(**changes: Any) -> Told:
    return Told(scenario(**changes).run(channels=list(CHANNELS)))


OBSERVERS = ("learning_effectiveness", "finite_time_disturbance", "passthrough")


@pytest.mark.parametrize("observer", OBSERVERS)
def test_a_stuck_wheel_is_declared_and_classed(observer: str) -> None:
    flight = told(observer=observer, faults=[gs.faults.Stuck(actuator=2, t_on=50.0, torque=-0.07)])
    assert flight.ever("detection.changed") == {2}
    assert flight.declared(2) <= 51.5
    assert flight.classed(2, "stuck") <= 54.0
    assert flight.result["detection.bias"][-1, 2] == pytest.approx(-0.07, abs=1e-3)
    assert flight.ever("detection.failed") <= {2}
    assert flight.rms < 0.1


@pytest.mark.parametrize("observer", OBSERVERS)
def test_a_weak_wheel_is_classed_with_its_gain(observer: str) -> None:
    flight = told(observer=observer, faults=[gs.faults.LossOfEffectiveness(actuator=1, t_on=4.0, remaining=0.3)])
    assert flight.ever("detection.changed") == {1}
    assert flight.classed(1, "gain") <= 8.0
    assert flight.result["detection.gain"][-1, 1] == pytest.approx(0.3, abs=0.01)
    assert not flight.ever("detection.failed")


@pytest.mark.parametrize("observer", OBSERVERS)
def test_a_biased_wheel_is_additive_and_never_dropped(observer: str) -> None:
    flight = told(observer=observer, faults=[gs.faults.Bias(actuator=0, t_on=60.0, torque=0.04)])
    assert flight.ever("detection.changed") == {0}
    assert flight.classed(0, "additive") <= 61.5
    assert flight.result["detection.bias"][-1, 0] == pytest.approx(0.04, abs=1e-3)
    assert not flight.ever("detection.failed")


def test_a_bias_is_found_beside_a_dead_wheel() -> None:
    faults = [gs.faults.Dead(actuator=3, t_on=5.0), gs.faults.Bias(actuator=0, t_on=60.0, torque=0.02)]
    flight = told(faults=faults)
    assert flight.ever("detection.changed") == {0, 3}
    assert flight.classed(0, "additive") <= 61.5
    assert 0 not in flight.ever("detection.failed")


def test_a_wheel_that_comes_and_goes_is_declared_alone() -> None:
    fault = gs.faults.Intermittent(actuator=1, t_on=30.0, period=16.0, duty=0.5, remaining=0.0, torque=0.03)
    flight = told(faults=[fault])
    assert flight.declared(1) <= 31.5
    assert flight.ever("detection.changed") == {1}
    assert flight.classed(1, "intermittent") < 200.0


def test_a_late_gyro_and_a_wrong_inertia_do_not_matter() -> None:
    flight = told(
        truth={"dJ_B": (0.3 * np.array(gs.vehicle.ftc_4rw().J_B)).tolist()},
        sensors=[gs.sensors.Gyro(noise=1e-4, delay=1), gs.sensors.Attitude(noise=3e-4)],
        faults=[gs.faults.Bias(actuator=3, t_on=20.0, torque=-0.05)],
    )
    assert flight.ever("detection.changed") == {3}
    assert flight.classed(3, "additive") <= 21.5


@pytest.mark.parametrize(("dt", "duration"), [(0.1, 40.0), (0.01, 40.0), (0.001, 25.0)])
def test_delay_and_class_do_not_depend_on_the_period(dt: float, duration: float) -> None:
    faults = [
        gs.faults.Bias(actuator=0, t_on=15.0, torque=0.04),
        gs.faults.LossOfEffectiveness(actuator=1, t_on=4.0, remaining=0.3),
        gs.faults.Stuck(actuator=2, t_on=20.0, torque=-0.02),
    ]
    flight = told(dt=dt, duration=duration, observer="finite_time_disturbance", faults=faults)
    assert flight.ever("detection.changed") == {0, 1, 2}
    assert flight.declared(0) <= 16.5
    assert flight.declared(1) <= 6.0
    assert flight.declared(2) <= 22.0
    assert [CLASSES[int(k)] for k in flight.result["detection.class"][-1, :2]] == ["additive", "gain"]


@pytest.mark.parametrize("dt", [0.1, 0.01])
def test_no_alarm_without_a_fault(dt: float) -> None:
    coarse = gs.sensors.Tachometer(noise=1e-3, quantisation=5.2e-3, delay=1)
    for sensors in ([], [gs.sensors.Gyro(noise=1e-4)], [coarse]):
        flight = told(dt=dt, duration=600.0, sensors=sensors)
        assert not flight.ever("detection.changed"), sensors


def test_a_momentum_limit_that_flight_knows_is_no_fault() -> None:
    push = [gs.disturbances.Constant(torque_B=(0.03, 0.0, 0.0))]  # fills the wheels of 2 N m s within 200 s
    for where, alarms in (("vehicle", False), ("truth", True)):
        full = scenario(disturbances=push).replace(**{f"{where}.momentum_max": 2.0})
        flight = Told(full.run(channels=[*CHANNELS, "truth.h_w"]))
        assert np.abs(flight.result["truth.h_w"]).max() == pytest.approx(2.0)
        assert bool(flight.ever("detection.changed")) == alarms


def test_dropouts_of_the_tachometers_are_no_fault() -> None:
    flight = told(sensors=[gs.sensors.MomentumDropout(t_on=5.0, t_off=60.0)])
    assert not flight.ever("detection.changed")


def random_faults(rng: np.random.Generator) -> list[Any]:
    """One or two of any kind on different wheels, up to what three healthy wheels can hold."""
    faults = []
    for actuator in rng.permutation(4)[: rng.integers(1, 3)]:
        at: dict[str, Any] = {"actuator": int(actuator), "t_on": float(rng.uniform(5.0, 40.0))}
        kind = rng.integers(6)
        torque = float(rng.uniform(-0.06, 0.06))
        faults.append(
            gs.faults.LossOfEffectiveness(remaining=float(rng.uniform(0.1, 0.8)), **at) if kind == 0
            else gs.faults.Bias(torque=torque, **at) if kind == 1
            else gs.faults.Stuck(torque=torque, **at) if kind == 2
            else gs.faults.Dead(**at) if kind == 3
            else gs.faults.Drift(rate=torque / 60.0, **at) if kind == 4
            else gs.faults.Intermittent(period=12.0, duty=0.5, remaining=0.2, torque=torque, **at)
        )  # fmt: skip
    return faults


@pytest.mark.parametrize("observer", ["learning_effectiveness", "finite_time_disturbance"])
def test_no_flight_is_lost_through_the_detector(observer: str) -> None:
    rng = np.random.default_rng(15)
    lost = []
    for number in range(50):
        faults, seed = random_faults(rng), int(rng.integers(1000))
        without, beside = (
            told(detector=d, observer=observer, seed=seed, duration=120.0, faults=faults) for d in ("none", "evidence")
        )
        assert beside.ever("detection.changed") <= {f.params["actuator"] for f in faults}, number
        if without.rms < 0.1 <= beside.rms:
            lost.append((number, without.rms, beside.rms, faults))
    assert not lost


def test_threshold_does_not_take_away_what_is_needed() -> None:
    stuck = gs.Scenario.load("wheel2_degraded").replace(
        faults=[gs.faults.Stuck(actuator=2, t_on=20.0, torque=-0.07)],
        observer="finite_time_disturbance",
        detector="threshold",
        controller="integral_sliding_mode",
    )
    flight = Told(stuck.run(channels=list(CHANNELS)))
    assert flight.ever("detection.failed") <= {2}
    assert flight.rms < 0.1


def test_events_name_actuator_and_class() -> None:
    flight = told(faults=[gs.faults.Bias(actuator=0, t_on=60.0, torque=0.04, t_off=90.0)])
    events = [(e.name, e.what) for e in flight.result.events if e.name.startswith("detector.")]
    assert events[0] == ("detector.event", "actuator 0 additive")
    assert events[-1] == ("detector.recovered", "actuator 0 healthy")
    ((at, mask),) = detection.declarations(flight.result)
    assert at == pytest.approx(60.8)
    assert mask == 1


def test_a_python_detector_says_classes_gains_and_biases() -> None:
    class Says:
        def setup(self, setup: gs.Setup) -> None:
            self.det = gs.Detection.none(setup.vehicle)

        def step(self, x: gs.Estimate, last: gs.Allocation) -> gs.Detection:
            assert x.momentum_valid
            self.det.classes = ["healthy", "stuck"]
            self.det.gain = [1.0, 0.0, 1.0, 1.0]
            self.det.bias = [0.0, 0.02, 0.0, 0.0]
            return self.det

    result = scenario(detector=Says(), duration=1.0).run(channels=list(CHANNELS))
    np.testing.assert_array_equal(result["detection.class"][-1], [0, 3, 0, 0])
    np.testing.assert_array_equal(result["detection.gain"][-1], [1, 0, 1, 1])
    np.testing.assert_array_equal(result["detection.bias"][-1], [0, 0.02, 0, 0])
    det = gs.Detection.none(_setup_of().vehicle)
    with pytest.raises(ValueError, match="no class of faults 'broken'; there are: healthy, gain"):
        det.classes = ["broken"]


def _setup_of() -> gs.Setup:
    """The setup that a component of this scenario gets."""
    kept: list[gs.Setup] = []

    class Keeps:
        def setup(self, setup: gs.Setup) -> None:
            kept.append(setup)

        def step(self, x: gs.Estimate, last: gs.Allocation) -> gs.Detection:
            return gs.Detection.none(kept[0].vehicle)

    scenario(detector=Keeps(), duration=0.1).run(channels=["error.angle"])
    return kept[0]


def test_what_was_dropped_is_taken_back_where_another_fault_makes_it_needed() -> None:
    # wheel 0 rests in its dead zone and is dropped; then wheel 1 locks: two of four wheels do not turn a body
    scenario = gs.Campaign.load("faulty_ftc_hard").scenario(240, "joint/integral")
    result = scenario.run(channels=["detection.failed", "error.angle"])
    failed = result["detection.failed"].astype(int)
    assert max(int(mask).bit_count() for mask in np.unique(failed)) <= 1
    assert np.rad2deg(result["error.angle"][result.t > 0.8 * result.t[-1]].max()) < 1.0


def test_panels_that_bend_are_taken_for_torquers_and_never_for_wheels() -> None:
    # healthy slews with two modes of a tenth of the inertia: a limit of what rates can tell, which the page states
    rng = np.random.default_rng(5)
    named = {"wheels": 0, "torquers": 0}
    vehicle = gs.vehicle.ftc_4rw()
    for _ in range(20):
        panels = gs.Flexible(delta=0.8 * rng.normal(size=(2, 3)), omega=(0.8, 2.0))
        for kind, inertia in (("wheels", 0.05), ("torquers", None)):
            flown = gs.Scenario(
                vehicle=vehicle.model_copy(update={"wheel_inertia": inertia}),
                flexible=panels,
                **gs.recommended(),
                initial={"mrp": (0.1, 0.2, -0.3)},
                duration=60.0,
                dt=0.1,
                integrator="rk4",
            ).run(channels=["detection.event"])
            named[kind] += int(flown["detection.event"][-1] > 0)
    assert named["wheels"] == 0
    assert named["torquers"] > 0, "the page says so"
