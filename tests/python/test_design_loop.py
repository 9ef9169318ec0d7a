# SPDX-License-Identifier: MIT
"""Limits of the loop that an estimate closes: measured on the compiled stack, against eigenvalues written out here."""

from __future__ import annotations

import itertools
import json
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import numpy as np
import pytest
from commands import gyrostat
from numpy.typing import NDArray

import gyrostat as gs
from gyrostat import _core, design
from gyrostat.design import sampled_loop
from gyrostat.design.mixed_learning_tool import flight_inertia

J, DT = 12.0, 0.1  # kg m^2 about every axis, s
K, P = 0.9, 4.2  # N m, N m s: 0.14 rad/s, damped at 0.64

Loop = Callable[[float], NDArray[np.float64]]


# One axis of a loop that is linear for small errors. Its state is angle, rate, then the observer's.


def transition(step: Callable[[NDArray[np.float64], float], NDArray[np.float64]], size: int) -> Loop:
    """The matrix of a linear step of `size` states, for an effectiveness."""
    return lambda m: np.column_stack([step(unit, m) for unit in np.eye(size)])


def body(angle: float, rate: float, u: float, m: float) -> tuple[float, float]:
    """A held command moves a free axis."""
    return angle + DT * rate + 0.5 * DT**2 * m * u / J, rate + DT * m * u / J


def law_alone() -> Loop:
    def step(x: NDArray[np.float64], m: float) -> NDArray[np.float64]:
        return np.array(body(*x, -K / 4 * x[0] - P * x[1], m))

    return transition(step, 2)


def mixed_learning(b: float, damping: float) -> tuple[dict[str, Any], Loop]:
    """Bandwidth b, rad/s, and K1 / (b J)."""
    K1, K2, past, now, keep = damping * b * J, b * b * DT * J, 0.1, 0.9, 0.999

    def step(x: NDArray[np.float64], m: float) -> NDArray[np.float64]:
        angle, rate, predicted, carried = x
        error = rate - predicted
        learnt = carried + now * K2 * error
        u = -K / 4 * angle - P * rate - learnt
        predicted += DT / J * (u + learnt + K1 * error)
        return np.array([*body(angle, rate, u, m), predicted, keep * learnt + past * K2 * error])

    plain = {"type": "mixed_learning_disturbance", "K1": (K1 * np.eye(3)).tolist(), "K2": (K2 * np.eye(3)).tolist()}
    return plain | {"sigma1": past, "sigma2": now, "theta2": keep}, transition(step, 4)


def learning_disturbance(M: float, k1: float, k2: float, k3: float) -> tuple[dict[str, Any], Loop]:
    """Rates in 1/s; the interval is one period."""
    a = np.exp(-M * DT)
    gain = (1 - a) / M

    def step(x: NDArray[np.float64], m: float) -> NDArray[np.float64]:
        angle, rate, e, f = x
        u = -K / 4 * angle - P * rate - J * f
        after = body(angle, rate, u, m)
        e_next = a * e + gain * ((after[1] - rate) / DT - u / J - f)
        return np.array([*after, e_next, k1 * f + k2 * e_next + k3 * e])

    plain = {"type": "learning_disturbance", "M": M, "k1": k1, "k2": k2, "k3": k3, "interval": DT}
    return plain, transition(step, 4)


def finite_time(lambda1: float, lambda2: float) -> tuple[dict[str, Any], Loop]:
    """The implicit step where its powers are one but for a ten thousandth."""

    def step(x: NDArray[np.float64], m: float) -> NDArray[np.float64]:
        angle, rate, z, eta = x
        u = -K / 4 * angle - P * rate - J * (lambda1 * z + eta)
        after = body(angle, rate, u, m)
        z_next = (after[1] - rate + z - DT * (u / J + eta)) / (1 + DT * lambda1 + DT**2 * lambda2)
        return np.array([*after, z_next, eta + DT * lambda2 * z_next])

    return {"type": "finite_time_disturbance", "alpha1": 0.9999, "lambda1": lambda1, "lambda2": lambda2}, transition(
        step, 4
    )


def limits(loop: Loop) -> tuple[float, float]:
    """Effectiveness around 1 with all eigenvalues inside the unit circle, as far as `loop_margin` looks."""

    def unstable(m: float) -> bool:
        return bool(np.abs(np.linalg.eigvals(loop(m))).max() > 1)

    down = np.geomspace(1.0, sampled_loop.WEAKEST, 400)
    up = np.geomspace(1.0, sampled_loop.STRONGEST, 400)
    ends = [next((m for m in way if unstable(m)), way[-1]) for way in (down, up)]
    return float(ends[0]), float(ends[1])


def flown(observer: Any = None, **changes: Any) -> gs.Scenario:
    return gs.Scenario(
        vehicle=gs.Vehicle(J_B=(J, J, J), D_B=np.eye(3).tolist()),
        observer=observer,
        controller=gs.controller("mrp_feedback", K=K, P=P),
        allow_unstable=True,
        duration=10.0,
        dt=DT,
        **changes,
    )


CASES = {
    "law alone": (None, law_alone()),
    "mixed learning, slow": mixed_learning(b=0.15, damping=1.0),
    "mixed learning, hardly damped": mixed_learning(b=0.2, damping=0.5),
    "mixed learning, fast": mixed_learning(b=8.0, damping=0.9),
    "finite time, hardly damped": finite_time(lambda1=0.2, lambda2=0.12),
    "finite time, default": finite_time(lambda1=1.0, lambda2=0.6),
    "finite time, nearly dead beat": finite_time(lambda1=200.0, lambda2=100.0),
    "learning disturbance, hardly damped": learning_disturbance(M=0.1, k1=0.98, k2=0.3, k3=0.1),
    "learning disturbance, default": learning_disturbance(M=4.0, k1=0.98, k2=1.5, k3=0.5),
    "learning disturbance, nearly dead beat": learning_disturbance(M=20.0, k1=0.5, k2=14.0, k3=2.0),
}


@pytest.mark.parametrize("case", CASES)
def test_the_limits_are_those_of_the_eigenvalues(case: str) -> None:
    observer, loop = CASES[case]
    margin = design.loop_margin(flown(observer))
    # The search ends at a tenth; an error that falls by less than 3 % in a third of a trial counts as one that stays.
    assert (margin.lowest, margin.highest) == pytest.approx(limits(loop), rel=0.13)


def test_the_cases_above_have_limits_below_and_above() -> None:
    lowest, highest = zip(*(limits(loop) for _, loop in CASES.values()), strict=True)
    assert sum(low > 3 * sampled_loop.WEAKEST for low in lowest) >= 4
    assert sum(high < 0.8 * sampled_loop.STRONGEST for high in highest) >= 2


class DeadBeat:
    """All that the last interval's command does not explain; one axis is u[k] = law - (m - 1) u[k-1]."""

    def setup(self, setup: gs.Setup) -> None:
        self.J_over_dt = np.asarray(setup.vehicle.J_B) / setup.dt

    def start(self, y: gs.Measurement) -> gs.Estimate:
        self.rate = np.array(y.omega_BN_B)
        return gs.Estimate.healthy(y)

    def step(self, y: gs.Measurement, last: gs.Allocation) -> gs.Estimate:
        x = gs.Estimate.healthy(y)
        x.d_B = self.J_over_dt @ (y.omega_BN_B - self.rate) - last.u
        self.rate = np.array(y.omega_BN_B)
        return x


def test_a_dead_beat_observer_in_python_bears_up_to_twice_its_torque() -> None:
    scenario = flown(DeadBeat())
    assert sampled_loop.closes_a_loop(scenario)
    for m, settles in ((0.2, True), (1.8, True), (2.2, False)):
        assert sampled_loop.trial(scenario, m, 0.02).settles is settles, m


def test_the_limit_is_the_closed_form_of_the_compensation_where_that_holds() -> None:
    # One axis, continuous, a correction of slope r on the rate alone; r = sqrt(l2) is the worst.
    observer = {"type": "finite_time_disturbance", "alpha1": 0.9999, "lambda1": 1.0, "lambda2": 1.0}
    loop = flown(observer).replace(dt=0.01, **{"controller.P": J, "controller.K": 4e-2 * J})
    assert design.loop_margin(loop).lowest == pytest.approx(design.critical_effectiveness(1.0, 1.0), rel=0.15)


def test_a_delay_of_the_gyro_takes_from_the_margin() -> None:
    observer = mixed_learning(b=0.3, damping=2.0)[0]
    prompt = design.loop_margin(flown(observer))
    late = design.loop_margin(flown(observer, sensors=[gs.sensors.Gyro(noise=1e-3, delay=20)]))
    assert late.highest < 0.5 * prompt.highest


# Wheel 0 dead, wheel 2 at 38.8 %: 15 % is left of some torque. At 10 Hz, with the bandwidth b = 0.3 rad/s and K1 = b J,
# mixed learning and the law swing up to 4 deg.
FAULTS = [
    gs.faults.Dead(actuator=0, t_on=50.0),
    gs.faults.LossOfEffectiveness(actuator=2, t_on=50.0, remaining=0.388),
]


def degraded(observer: Any) -> gs.Scenario:
    base = gs.Scenario.load("wheel2_degraded")
    return base.replace(dt=0.1, duration=400.0, observer=observer, allocator="lexicographic", faults=FAULTS)


def test_check_fails_where_the_faults_leave_a_loop_that_swings() -> None:
    inertia = flight_inertia(degraded("mixed_learning_disturbance"))
    gains = {"K1": (0.3 * inertia).tolist(), "K2": (0.3**2 * 0.1 * inertia).tolist(), "sigma1": 0.1, "theta2": 0.999}
    swinging = degraded(gs.observer("mixed_learning_disturbance", **gains))
    assert swinging.run(channels=["error.angle"])["error.angle"][-100:].max() > np.deg2rad(2.0)
    (verdict,) = [f for f in sampled_loop.findings(swinging) if f.name == "faults"]
    assert verdict.ok is False
    assert "0, 1, 0.388, 1" in verdict.text
    healthy = sampled_loop.findings(swinging.replace(faults=[]))
    assert [f.ok for f in healthy if f.name == "effectiveness"] == [True]
    asked = sampled_loop.findings(swinging.replace(faults=[]), (0.15, 1.0))
    assert [f.ok for f in asked if f.name == "effectiveness"] == [False]


def test_the_defaults_fly_that_fault() -> None:
    for observer in ("finite_time_disturbance", "learning_disturbance", "mixed_learning_disturbance"):
        scenario = degraded(observer)
        assert all(f.ok is not False for f in sampled_loop.findings(scenario)), observer
        assert scenario.run(channels=["error.angle"])["error.angle"][-100:].max() < np.deg2rad(1e-3), observer


def regulating() -> list[str]:
    names = _core.catalogue()["controller"]
    return [c for c in names if _core.describe("controller", c)["traits"]["regulates"]]


def estimating(name: str) -> list[str]:
    names = _core.catalogue()["observer"]
    return [o for o in names if name in _core.describe("observer", o)["traits"]["estimates"]]


TINY = gs.Vehicle(J_B=(2e-3, 1.7e-3, 1.5e-3), D_B=gs.vehicle.ftc_4rw().D_B, u_max=2e-5)
LONG = gs.Vehicle(J_B=(8e3, 9e3, 3e3), D_B=np.hstack([np.eye(3)] * 2).tolist(), u_max=1.0)

# One of four wheels dead leaves a quarter of some torque; 1.5 is an inertia that is a third smaller.
SAMPLED = {
    "2 Hz": (gs.vehicle.ftc_4rw(), 0.5, (0.25, 1.0, 1.5), regulating()),
    "5 Hz, long": (LONG, 0.2, (0.3, 1.5), regulating()),
    "10 Hz, tiny": (TINY, 0.1, (0.2, 1.5), regulating()),
    "1 kHz": (gs.vehicle.ftc_4rw(), 1e-3, (0.25,), ["integral_sliding_mode"]),
}


@pytest.mark.parametrize(("vehicle", "dt", "effectiveness", "laws"), SAMPLED.values(), ids=SAMPLED)
def test_default_loops_bear_weakened_and_strengthened_actuators(
    vehicle: gs.Vehicle, dt: float, effectiveness: tuple[float, ...], laws: list[str]
) -> None:
    base = gs.Scenario(vehicle=vehicle, duration=10.0, dt=dt, allow_unstable=False)

    def unstable(stack: tuple[str, str]) -> list[float]:
        scenario = base.replace(observer=stack[0], controller=stack[1])
        return [m for m in effectiveness if not sampled_loop.settles(scenario, m)]

    stacks = list(itertools.product(estimating("d_B"), laws))
    stacks += [(observer, laws[0]) for observer in estimating("effectiveness")[: len(laws)]]
    with ThreadPoolExecutor() as pool:  # the loop runs without the GIL
        found = dict(zip(stacks, pool.map(unstable, stacks), strict=True))
    assert not {stack: m for stack, m in found.items() if m}


def test_only_loops_with_an_estimate_are_looked_at(scenario: gs.Scenario) -> None:
    assert sampled_loop.findings(scenario) == []
    assert sampled_loop.findings(scenario.replace(observer="mixed_learning_disturbance", controller="open_loop")) == []


def test_check_prints_the_limits() -> None:
    done = gyrostat("check", "wheel2_degraded", "--set", "dt=0.1", "--json")
    (row,) = [
        f for f in json.loads(done.stdout)["design"] if (f["where"], f["name"]) == ("sampled loop", "effectiveness")
    ]
    assert row["ok"] is True
    assert row["limit"] < 0.25 < row["value"] == pytest.approx(0.55, rel=1e-6)  # what 40 % of one wheel leaves
