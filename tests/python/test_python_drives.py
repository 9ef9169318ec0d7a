# SPDX-License-Identifier: MIT
"""Actuators that are Python objects: one that gives what it is commanded flies as the native one, to the bit."""

from __future__ import annotations

import itertools
import re
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import numpy as np
import pytest

import gyrostat as gs
from gyrostat.export import export

TRUTH = ["truth.q_NB", "truth.omega_BN_B", "truth.h_w", "truth.delivered", "truth.external_B", "allocation.u"]


class Ideal:
    """Gives what it is commanded."""

    def deliver(self, t: float, u: float, h_w: float, omega_BN_B: np.ndarray) -> Any:
        return u


class Lagging(Ideal):
    """Of first order: the mean over the interval of what it gives, which is exact for what it gives in all."""

    def __init__(self, time_constant: float) -> None:
        self.time_constant, self.now, self.calls = time_constant, 0.0, 0

    def setup(self, setup: gs.Setup) -> None:
        self.dt = setup.dt

    def deliver(self, t: float, u: float, h_w: float, omega_BN_B: np.ndarray) -> float:
        self.calls += 1
        left = (self.now - u) * np.exp(-self.dt / self.time_constant)
        mean = u + (self.now - u - left) * self.time_constant / self.dt
        self.now = u + left
        return float(mean)

    def telemetry(self) -> dict[str, Any]:
        return {"now": self.now, "pair": np.array([self.now, self.calls])}


class Pulsing(Ideal):
    """All or nothing, for as long into the interval as makes the mean."""

    def __init__(self, most: float) -> None:
        self.most = most

    def setup(self, setup: gs.Setup) -> None:
        self.dt = setup.dt

    def deliver(self, t: float, u: float, h_w: float, omega_BN_B: np.ndarray) -> Any:
        share = min(abs(u) / self.most, 1.0)
        if share in (0.0, 1.0):
            return np.sign(u) * self.most * share
        return [(0.0, np.sign(u) * self.most), (share * self.dt, 0.0)]


def scenario(**changes: Any) -> gs.Scenario:
    return gs.Scenario(
        **{
            "vehicle": gs.vehicle.ftc_4rw(),
            "controller": "mrp_feedback",
            "observer": "finite_time_disturbance",
            "reference": gs.reference("hold", euler=[0.2, -0.1, 0.3]),
            "duration": 10.0,
            "dt": 0.05,
            "integrator": "rk4",
            **changes,
        }
    )


def torquers(**changes: Any) -> gs.Scenario:
    wheels = gs.vehicle.ftc_4rw().to_dict()
    return scenario(vehicle={**wheels, "wheel_inertia": None}, **changes)


def tiny(**changes: Any) -> gs.Scenario:
    """A ten-thousandth of the size, wheels with friction and a momentum limit that they reach."""
    vehicle = gs.vehicle.ftc_4rw().to_dict()
    smaller = {key: (1e-4 * np.asarray(vehicle[key])).tolist() for key in ("J_B", "u_max", "wheel_inertia")}
    rough = {"viscous_friction": 1e-8, "coulomb_friction": 1e-7, "momentum_max": 4e-5}
    return scenario(vehicle={**vehicle, **smaller}, truth=rough, **changes)


def with_everything(**changes: Any) -> gs.Scenario:
    """Navigator, joint observer, desaturation, faults of what is driven (4: a magnetorquer) and of what is not."""
    faults = [
        gs.faults.LossOfEffectiveness(actuator=0, remaining=0.5, t_on=20.0),
        gs.faults.Lock(actuator=4, t_on=30.3),
        gs.faults.DeadZone(actuator=1, width=1e-4, t_on=10.0),
        gs.faults.Drift(actuator=3, rate=1e-6, t_on=40.0),
    ]
    base = gs.Scenario.load("cubesat_6u").replace(faults=faults, observer="joint_kalman", duration=100.0)
    return base.replace(**changes)


def on_gimbals(**changes: Any) -> gs.Scenario:
    return gs.Scenario.load("agile_cmg").replace(duration=20.0, **changes)


def that_bends(**changes: Any) -> gs.Scenario:
    return gs.Scenario.load("smallsat_flexible").replace(duration=40.0, **changes)


def beside_valves(**changes: Any) -> gs.Scenario:
    """Wheels in front of thrusters, one of which leaks."""
    leak = gs.faults.Leak(actuator=5, fraction=0.01, t_on=2.0)
    valves = {**gs.vehicle.twelve_thrusters()[1].to_dict(), "tick": 0.05 / 32}
    return scenario(thrusters=valves, faults=[leak], allocator="weighted_least_squares", **changes)


INTEGRATORS = pytest.mark.parametrize("integrator", ["rk4", "cvode", "auto"])


@INTEGRATORS
@pytest.mark.parametrize("of", [scenario, torquers, tiny, with_everything, on_gimbals, that_bends, beside_valves])
def test_an_ideal_one_is_the_native_one_to_the_bit(of: Any, integrator: str) -> None:
    native = of(integrator=integrator)
    without_valves = native.actuators - (0 if native.thrusters is None else native.thrusters.torque.size)
    driven = native.replace(drives={i: Ideal() for i in (0, 1, 3, 4) if i < without_valves})
    expected, flown = native.run(channels=TRUTH), driven.run(channels=TRUTH)
    assert expected.completed
    assert np.abs(expected["truth.delivered"]).max() > 0
    for channel in TRUTH:
        np.testing.assert_array_equal(flown[channel], expected[channel])


def test_it_flies_on_euler_angles_too() -> None:
    native = gs.Scenario.load("cao2023/printed").replace(duration=2.0)
    driven = native.replace(drives={0: Ideal()})
    names = ["truth.euler", "truth.delivered"]
    for channel in names:
        np.testing.assert_array_equal(driven.run(channels=names)[channel], native.run(channels=names)[channel])


@INTEGRATORS
def test_it_may_switch_inside_a_sample_and_the_times_are_exact(integrator: str) -> None:
    """About a principal axis the rate is the integral of what is given: of pulses as of their mean, at the samples."""

    class Commands:
        def step(self, x: gs.Estimate, *_: object) -> gs.Demand:
            return gs.Demand([0, 0, 0], u_pref=[0.3 * np.sin(0.7 * x.tick), 0, 0])

    axes = {"J_B": [20.0, 17.0, 15.0], "D_B": np.eye(3), "u_max": 1.0}
    flight = scenario(vehicle=axes, controller=Commands(), observer="passthrough", integrator=integrator)
    channels = ["truth.omega_BN_B", "allocation.u", "truth.delivered"]
    flown = flight.replace(drives={0: Pulsing(1.0)}).run(channels=channels)
    rate = np.concatenate([[0.0], np.cumsum(flown["allocation.u"][:-1, 0]) * 0.05 / 20.0])
    # rounding of 200 additions of up to 1e-3; cvode keeps momentum, which is a polynomial, as exactly
    np.testing.assert_allclose(flown["truth.omega_BN_B"][:, 0], rate, rtol=0, atol=1e-14)
    assert set(np.round(flown["truth.delivered"][:, 0], 12)) <= {0.0, 1.0, -1.0}, "the last of each interval"


def test_a_fault_acts_on_what_it_gives_and_a_limit_before_or_behind() -> None:
    """Twice the command, with half of it left: the command. Limits of the output end at what is allowed."""

    class Strong(Ideal):
        def deliver(self, t: float, u: float, h_w: float, omega_BN_B: np.ndarray) -> float:
            assert abs(u) <= 0.2
            return 2 * u

    half = [gs.faults.LossOfEffectiveness(actuator=1, remaining=0.5, t_on=0.0)]
    native = scenario(truth={"u_max": 0.2}).run(channels=TRUTH)
    flown = scenario(truth={"u_max": 0.2}, drives={1: Strong()}, faults=half).run(channels=TRUTH)
    np.testing.assert_array_equal(flown["truth.omega_BN_B"], native["truth.omega_BN_B"])
    limited = scenario(truth={"u_max": 0.05, "limit_on": "output"}, drives={1: Lagging(0.1)}).run(channels=TRUTH)
    assert np.abs(limited["truth.delivered"][:, 1]).max() == 0.05


def test_it_sees_its_own_momentum_and_the_body_rate() -> None:
    """A wheel that rubs, held over each sample: at first order it becomes the native one as the period goes to zero."""
    c, inertia = 2e-3, 0.05

    class Rubbing(Ideal):
        def __init__(self, axis_B: np.ndarray) -> None:
            self.axis_B = axis_B

        def deliver(self, t: float, u: float, h_w: float, omega_BN_B: np.ndarray) -> float:
            return float(u + c * (h_w / inertia - self.axis_B @ omega_BN_B))

    def rate(dt: float, **changes: Any) -> np.ndarray:
        wheels = {**gs.vehicle.ftc_4rw().to_dict(), "wheel_inertia": inertia}
        start = gs.Initial(wheel_speed=(50.0, -20.0, 30.0, 10.0), omega_BN_B=(0.02, 0.01, -0.01))
        flight = scenario(vehicle=wheels, initial=start, dt=dt, controller="open_loop", observer="passthrough")
        return np.asarray(flight.replace(**changes).run(channels=TRUTH)["truth.omega_BN_B"][-1])

    axes = np.asarray(gs.vehicle.ftc_4rw().D_B).T
    error = [
        np.abs(rate(dt, drives={i: Rubbing(axes[i]) for i in range(4)}) - rate(dt, truth={"viscous_friction": c})).max()
        for dt in (0.1, 0.05, 0.025)
    ]
    assert error[0] < 1e-3
    assert [1.9 < a / b < 2.1 for a, b in itertools.pairwise(error)] == [True, True]


def test_every_run_flies_a_copy_and_says_what_is_inside() -> None:
    lag = Lagging(0.3)
    flight = scenario(drives={2: lag, 0: Lagging(0.1)})
    first, again = flight.run(), flight.run()
    with ThreadPoolExecutor(2) as pool:
        results = list(pool.map(lambda _: flight.run(), range(4)))
    assert lag.calls == 0
    assert first.components["drives"][2].calls == 200
    for other in (again, *results):
        for channel in ("truth.delivered", "drive2.now"):
            np.testing.assert_array_equal(other[channel], first[channel])
    # what a sample records is what the interval before it left
    np.testing.assert_array_equal(first["drive2.pair"][:, 1], np.arange(201))
    assert first["drive2.now"][-1] == first.components["drives"][2].now
    assert np.abs(first["drive0.now"] - first["allocation.u"][:, 0]).max() > 0


def test_a_side_torque_comes_from_the_same_object_as_a_disturbance() -> None:
    class Skewed(Ideal):
        setups = 0

        def setup(self, setup: gs.Setup) -> None:
            self.setups += 1

        def deliver(self, t: float, u: float, h_w: float, omega_BN_B: np.ndarray) -> float:
            self.side = 0.1 * u
            return u

        def torque_B(self, t: float, q_NB: np.ndarray, omega_BN_B: np.ndarray) -> np.ndarray:
            return np.array([0.0, self.side, 0.0])

    skewed = Skewed()
    result = scenario(drives={1: skewed}, disturbances=[skewed]).run(channels=TRUTH)
    np.testing.assert_array_equal(result["truth.external_B"][1:, 1], 0.1 * result["allocation.u"][:-1, 1])
    assert result.components["drives"][1] is result.components["disturbances"][0]
    assert result.components["drives"][1].setups == 1


def test_campaigns_and_experiments_fly_it_on_one_thread() -> None:
    flight = scenario(
        drives={1: Lagging(0.2)}, faults=[gs.faults.LossOfEffectiveness(actuator=1, remaining=0.5)], duration=2.0
    )
    signals = {"last": "drive1.now", "e": "error.angle"}
    measure = {name: {"metric": "final", "signal": signal} for name, signal in signals.items()}
    experiment = gs.Experiment(flight, vary=["faults.0.remaining"], measure=measure)
    flown = experiment.fly([[0.5], [0.2]], threads=2)
    alone = experiment.scenario([0.2], 1).run()
    assert flown["last"][1] == alone["drive1.now"][-1]
    assert flown["e"][1] == alone["error.angle"][-1]


class Returning(Ideal):
    def __init__(self, out: Any, at: float = 0.3) -> None:
        self.out, self.at = out, at

    def deliver(self, t: float, u: float, h_w: float, omega_BN_B: np.ndarray) -> Any:
        return self.out if t >= self.at else u


WANTED = "a number, or rows (seconds from now, what it gives from then on) belong there"


@pytest.mark.parametrize(
    ("out", "said"),
    [
        (None, f"nothing (None); {WANTED}"),
        ("full", f"a str; {WANTED}"),
        ([1.0, 2.0, 3.0], f"3 numbers; {WANTED} at t = 0.3 s"),
        (np.zeros((2, 3)), f"6 numbers; {WANTED} at t = 0.3 s"),
        ([], f"0 numbers; {WANTED} at t = 0.3 s"),
        (np.nan, "a number that is not finite at t = 0.3 s"),
        (np.inf, "a number that is not finite at t = 0.3 s"),
        ([(0.0, 1.0), (0.01, np.nan)], "a number that is not finite at t = 0.3 s"),
        ([(0.01, 1.0)], "the time 0.01 s in row 0; rows begin at 0 and go on in order of time at t = 0.3 s"),
        ([(0.0, 1.0), (0.03, 0.0), (0.02, 1.0)], "the time 0.02 s in row 2; rows begin at 0 and go on in order"),
        ([(0.0, 1.0), (np.nan, 0.0)], "the time nan s in row 1; rows begin at 0 and go on in order of time"),
        ([(0.0, 1.0), (0.05, 0.0)], "the time 0.05 s in row 1, when the next command has come; less than 0.05 s"),
    ],
)
def test_what_it_gives_that_cannot_be_is_one_line_with_class_and_time(out: Any, said: str) -> None:
    with pytest.raises(ValueError, match=f"^drive1 Returning.deliver returned {re.escape(said)}") as caught:
        scenario(drives={1: Returning(out)}).run()
    assert "\n" not in str(caught.value)


def test_an_exception_reaches_the_caller_with_a_note() -> None:
    class TroubleError(Exception):
        pass

    problem = TroubleError("the bearing is gone")

    class Failing(Ideal):
        def deliver(self, t: float, u: float, h_w: float, omega_BN_B: np.ndarray) -> float:
            if t >= 0.5:
                raise problem
            return u

        def __deepcopy__(self, memo: object) -> Any:
            return self

    for integrator in ("rk4", "cvode"):
        with pytest.raises(TroubleError) as caught:
            scenario(drives={1: Failing()}, integrator=integrator).run()
        assert caught.value is problem
        assert problem.__notes__[-1] == "in drive1 Failing.deliver at t = 0.5 s"


@pytest.mark.parametrize(
    ("drives", "said"),
    [
        ({7: Ideal()}, "drives: actuator 7 is not there; the vehicle has 4 (0 to 3)"),
        ({-1: Ideal()}, "drives: -1 is no actuator; a column of D_B belongs here, counted from 0"),
        ({"one": Ideal()}, "drives: 'one' is no actuator"),
        ({True: Ideal()}, "drives: True is no actuator"),
        ({1: object()}, "drives: actuator 1: "),
        ({1: Ideal}, "drives: Ideal is a class; an object of it belongs here: Ideal(...)"),
        ([Ideal()], "drives: "),
        (dict.fromkeys((1, 3), Ideal()), "drives: actuators 1 and 3 are one object of Ideal; each needs its own"),
    ],
)
def test_what_cannot_drive_is_refused_when_it_is_written_down(drives: Any, said: str) -> None:
    with pytest.raises(ValueError, match=f"^{re.escape(said)}") as caught:
        scenario(drives=drives)
    assert "\n" not in str(caught.value)


def test_what_else_is_refused() -> None:
    with pytest.raises(ValueError, match=r"^unknown key 'actuators'; Python objects are 'drives'"):
        scenario(actuators={1: Ideal()})
    with pytest.raises(ValueError, match=r"^drives: actuator 4 is a thruster, whose valve says what it gives"):
        gs.Scenario.load("twelve_thrusters").replace(drives={4: Ideal()})
    with pytest.raises(ValueError, match=r"^drives is a Python object; a TOML file can only hold"):
        scenario(drives={1: Ideal()}).to_toml()

    with pytest.raises(ValueError, match=r"^drives: a Python object is there, which the exported scenario cannot say"):
        export(scenario(drives={1: Ideal()}), "cpp", "never")

    class Locked(Ideal):
        def __init__(self) -> None:
            import threading

            self.lock = threading.Lock()

    with pytest.raises(ValueError, match=r"^drives .* cannot be copied"):
        scenario(drives={1: Locked()}).run()


def test_a_scenario_with_one_is_hashable_and_says_what_flew() -> None:
    drive = Lagging(0.2)
    flight = scenario(drives={1: drive}, duration=1.0)
    assert hash(flight) == hash(scenario(drives={1: drive}, duration=1.0))
    assert flight.replace(duration=2.0).drives == ((1, drive),)
    other = Ideal()
    assert flight.replace(**{"drives.1": other, "drives.0": drive}).drives == ((0, drive), (1, other))
    assert flight.replace(drives={}).drives == ()
    assert flight.run().description["drives"] == {"1": {"type": "python", "class": "Lagging"}}
    assert isinstance(drive, gs.protocols.Drive)
