# SPDX-License-Identifier: MIT
"""`joint_kalman` in closed loop: faults that others saturate on or leave an offset behind, against stated errors.

FTC-4RW at 10 Hz turns by 45 deg under a disturbance and noisy sensors, then holds.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import gyrostat as gs
from gyrostat import faults

E_MIN = 0.05
CHANNELS = ["error.angle", "truth.lumped_mean_B", "estimate.*", "allocation.u", "allocation.saturated"]


def flight(*what: Any, inertia: float = 1.0, gyro: Any = None, attitude: float = 2e-5, **changes: Any) -> gs.Scenario:
    """200 s with the faults `what`; the body has `inertia` times what flight knows."""
    vehicle = gs.vehicle.ftc_4rw()
    slow = gs.waveforms.Sine(amplitude=1e-3, omega=0.05)
    base = gs.Scenario(
        vehicle=vehicle,
        truth=gs.vehicle.Truth(dJ_B=(inertia - 1.0) * np.asarray(vehicle.J_B)),
        initial=gs.Initial(euler=(np.pi / 4, 0.0, 0.0)),
        observer="joint_kalman",
        controller="integral_sliding_mode",
        allocator="lexicographic",
        faults=what,
        disturbances=[
            gs.disturbances.Constant(torque_B=(2e-3, -1e-3, 1.5e-3)),
            gs.disturbances.Periodic(torque_B=[slow] * 3),
        ],
        sensors=[gyro or gs.sensors.Gyro(noise=1e-5), gs.sensors.Attitude(noise=attitude)],
        integrator="rk4",
        duration=200.0,
        dt=0.1,
        seed=1,
    )
    return base.replace(**changes)


def late_rms(flown: gs.Result) -> float:
    """Pointing error over the last fifth, rms, deg."""
    return float(np.degrees(np.sqrt(np.mean(flown["error.angle"][flown.t >= 160.0] ** 2))))


def lumped_error(flown: gs.Result) -> float:
    """What flight thinks acts beside the command, against what did: rms, share of the largest command."""
    D = np.asarray(gs.vehicle.ftc_4rw().D_B)
    lost = (flown["estimate.effectiveness"][1:] - 1.0) * flown["allocation.u"][:-1]
    off = lost @ D.T + flown["estimate.d_B"][1:] - flown["truth.lumped_mean_B"][1:]
    return float(np.sqrt(np.mean(np.sum(off**2, axis=1))) / 0.2)


def saturated(flown: gs.Result) -> float:
    return float(np.mean(flown["allocation.saturated"] != 0))


def test_a_stuck_wheel_is_taken_out_without_saturation() -> None:
    """The three others hold the attitude; the lumped observer asks the stuck one for what it cannot give."""
    scenario = flight(faults.Stuck(actuator=2, t_on=50.0, torque=-0.07))
    flown = scenario.run(channels=CHANNELS)
    assert late_rms(flown) <= 0.0015
    assert saturated(flown) == 0.0
    assert flown["estimate.effectiveness"][-1, 2] == E_MIN
    assert lumped_error(flown) <= 0.02
    lumped = scenario.replace(observer="finite_time_disturbance").run(channels=CHANNELS)
    assert saturated(lumped) > 0.5


def test_a_light_body_from_rates_alone_leaves_no_offset() -> None:
    """e = 1.05 is issued as 1, and the law has no integral: without the rest in d_B it would stand at 0.1 deg."""
    flown = flight(
        faults.LossOfEffectiveness(actuator=2, t_on=40.0, remaining=0.4),
        inertia=0.9,
        observer=gs.observer("joint_kalman", use_momentum=False),
        controller="predefined_time",
    ).run(channels=CHANNELS)
    assert late_rms(flown) <= 0.0015
    assert not np.isfinite(flown["estimate.effectiveness_bound"]).any()


def test_a_weak_wheel_is_known_to_three_hundredths() -> None:
    flown = flight(faults.LossOfEffectiveness(actuator=1, t_on=4.0, remaining=0.3)).run(channels=CHANNELS)
    assert flown["estimate.effectiveness"][-1] == pytest.approx([1.0, 0.3, 1.0, 1.0], abs=0.03)
    assert flown["estimate.effectiveness"][flown.t >= 8.0, 1] == pytest.approx(0.3, abs=0.1)
    assert late_rms(flown) <= 0.0015


def test_the_torque_that_a_wheel_adds_is_no_loss() -> None:
    flown = flight(faults.Bias(actuator=0, t_on=60.0, torque=0.04)).run(channels=[*CHANNELS, "observer.bias"])
    assert flown["estimate.effectiveness"][-1] == pytest.approx(np.ones(4), abs=0.03)
    assert flown["observer.bias"][flown.t >= 62.0, 0] == pytest.approx(0.04, abs=0.004)
    assert late_rms(flown) <= 0.0015


def test_two_faults_of_two_wheels_are_two() -> None:
    flown = flight(faults.Dead(actuator=3, t_on=5.0), faults.Bias(actuator=0, t_on=60.0, torque=0.02)).run(
        channels=CHANNELS
    )
    assert flown["estimate.effectiveness"][-1, 3] == E_MIN
    assert flown["estimate.effectiveness"][-1, :3] == pytest.approx(np.ones(3), abs=0.03)
    assert late_rms(flown) <= 0.0015


def test_a_wheel_that_comes_and_goes() -> None:
    coming = faults.Intermittent(actuator=1, t_on=30.0, period=16.0, duty=0.5, remaining=0.0, torque=0.03)
    scenario = flight(coming)
    flown = scenario.run(channels=CHANNELS)
    assert late_rms(flown) <= 0.007
    assert late_rms(scenario.replace(observer="finite_time_disturbance").run(channels=CHANNELS)) > 0.010
    assert np.delete(flown["estimate.effectiveness"][-1], 1) == pytest.approx(np.ones(3), abs=0.03)


def test_a_heavy_body_and_a_late_noisy_gyro() -> None:
    scenario = flight(
        faults.Bias(actuator=3, t_on=20.0, torque=-0.05),
        inertia=1.3,
        gyro=gs.sensors.Gyro(noise=1e-4, delay=1),
        attitude=3e-4,
    )
    flown = scenario.run(channels=CHANNELS)
    assert lumped_error(flown) <= 0.035
    assert late_rms(flown) <= 0.010
    assert lumped_error(scenario.replace(observer="finite_time_disturbance").run(channels=CHANNELS)) > 0.10


@pytest.mark.parametrize("dt", [0.1, 0.01])
def test_the_bound_holds_and_nothing_opens_on_a_healthy_flight(dt: float) -> None:
    flown = flight(dt=dt).run(channels=[*CHANNELS, "observer.openings"])
    bound = flown["estimate.effectiveness_bound"] * flown["estimate.effectiveness"]
    finite = np.isfinite(bound)
    assert finite[flown.t >= 2.0].mean() > 0.9
    assert (np.abs(flown["estimate.effectiveness"] - 1.0) <= bound)[finite].all()
    assert flown["observer.openings"][-1] == 0


def test_the_bound_holds_through_faults() -> None:
    """Over all wheels and samples; the second after a fault, in which nobody can know, included."""
    flown = flight(
        faults.LossOfEffectiveness(actuator=1, t_on=20.0, remaining=0.5),
        faults.Dead(actuator=3, t_on=70.0),
        duration=120.0,
    ).run(channels=[*CHANNELS, "truth.effectiveness"])
    bound = flown["estimate.effectiveness_bound"] * flown["estimate.effectiveness"]
    finite = np.isfinite(bound)
    inside = np.abs(flown["estimate.effectiveness"] - flown["truth.effectiveness"]) <= bound
    assert finite.mean() > 0.8
    assert inside[finite].mean() > 0.97


@pytest.mark.parametrize(("controller", "dt"), [("integral_sliding_mode", 0.5), ("mixed_learning_sliding_mode", 0.1)])
def test_an_actuator_that_comes_back_needs_a_limit(controller: str, dt: float) -> None:
    """Three torquers, one of which is gone for half of the time: with a limit it points, without one it spins up."""
    axes = np.eye(3)
    fault = faults.Intermittent(actuator=1, t_on=40.0 * dt, period=80.0 * dt, duty=0.5)
    fastest = []
    for limit in ({"u_max": 0.2}, {}):
        flown = gs.Scenario(
            vehicle=gs.Vehicle(J_B=(20.0, 17.0, 15.0), D_B=axes, **limit),
            observer="joint_kalman",
            controller=controller,
            allocator="lexicographic",
            faults=[fault],
            initial={"mrp": (0.1, 0.2, -0.3), "omega_BN_B": (0.01, -0.02, 0.03)},
            duration=400.0 * dt,
            dt=dt,
            integrator="rk4",
        ).run(channels=["truth.omega_BN_B"])
        fastest.append(float(np.linalg.norm(flown["truth.omega_BN_B"], axis=1).max()))
    assert fastest[0] < 0.1
    assert fastest[1] > 1.0, "the page says so"


def test_a_tachometer_that_is_late_is_told_and_costs_nothing() -> None:
    """Its delay is a data sheet's number; a filter that takes it for the present calls healthy wheels weak."""
    fault = faults.LossOfEffectiveness(actuator=1, t_on=2.0, remaining=0.4)

    def flown(delay: int, **observer: Any) -> gs.Result:
        sensors = [gs.sensors.Gyro(noise=1e-5), gs.sensors.Attitude(noise=2e-5), gs.sensors.Tachometer(delay=delay)]
        stack = {"observer": {"type": "joint_kalman"} | observer, "detector": {"type": "evidence", "drop": False}}
        scenario = flight(fault, sensors=sensors, **stack)
        return scenario.run(channels=[*CHANNELS, "truth.effectiveness", "detection.class", "detection.changed"])

    on_time = flown(0)
    for delay in (1, 3):
        late = flown(delay)
        assert late_rms(late) < 1.1 * late_rms(on_time)
        e, half = late["estimate.effectiveness"], late["estimate.effectiveness_bound"]
        assert np.mean((np.abs(e - late["truth.effectiveness"]) <= half * e)[1:]) > 0.95
        classes = late["detection.class"]
        assert list(np.flatnonzero(classes.any(axis=0))) == [1], "the wheel that failed and no other"
        assert classes[late.t >= 8.0][0, 1] == 1, "a loss"
    assert late_rms(flown(1, momentum_delay=0)) > 5.0 * late_rms(on_time)
    assert late_rms(flown(1, momentum_delay=0, momentum_timing=1.0)) < 1.1 * late_rms(on_time)


def test_the_delay_of_a_tachometer_is_shown_and_bounded() -> None:
    sensors = [gs.sensors.Tachometer(delay=4)]
    shown = flight(sensors=sensors, detector="evidence").resolve()
    assert shown["observer"]["momentum_delay"] == 4
    assert shown["detector"]["momentum_delay"] == 4
    said = flight(sensors=sensors, observer={"type": "joint_kalman", "momentum_delay": 2}).resolve()
    assert said["observer"]["momentum_delay"] == 2
    with pytest.raises(gs.InputError, match=r"momentum_delay.*32"):
        flight(sensors=[gs.sensors.Tachometer(delay=40)]).run()
