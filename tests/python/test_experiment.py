# SPDX-License-Identifier: MIT
"""Many flights of one scenario: each is the flight of a scenario of its own, whoever flies it and in which order."""

from __future__ import annotations

import itertools
import time
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import gyrostat as gs
from gyrostat import _core
from gyrostat.experiment import usual_measures

CHANNELS = ["error.angle", "allocation.u", "allocation.saturated"]


def turning(**changes: Any) -> gs.Scenario:
    """A slew of 8 s with noise, a fault and a disturbance that is a wave."""
    usual: dict[str, Any] = {
        "vehicle": gs.vehicle.ftc_4rw(),
        "initial": gs.Initial(mrp=(0.1, 0.2, -0.3), omega_BN_B=(0.01, -0.02, 0.03)),
        "controller": "mrp_feedback",
        "faults": [gs.faults.LossOfEffectiveness(actuator=2, t_on=3.0, remaining=0.4)],
        "disturbances": [gs.disturbances.Periodic(torque_B=[gs.waveforms.Sine(amplitude=1e-3), 0.0, 1e-3])],
        "sensors": [gs.sensors.Gyro(noise=1e-6)],
        "integrator": "rk4",
        "duration": 8.0,
        "dt": 0.1,
        "seed": 5,
    }
    return gs.Scenario(**(usual | changes))


def same(a: Any, b: Any) -> bool:
    return np.asarray(a).tobytes() == np.asarray(b).tobytes()


# Paths, and values that all of them allow.
NUMBERS: dict[str, tuple[float, float]] = {
    "initial.omega_BN_B": (-0.05, 0.05),
    "initial.mrp.1": (-0.5, 0.5),
    "initial.wheel_speed": (-50.0, 50.0),
    "truth.viscous_friction": (0.0, 1e-3),
    "truth.dJ_B.0.0": (-2.0, 2.0),
    "vehicle.u_max": (0.1, 0.3),
    "vehicle.J_B.1.1": (16.0, 18.0),
    "faults.0.remaining": (0.0, 1.0),
    "faults.0.t_on": (0.0, 9.0),
    "disturbances.0.torque_B.0.amplitude": (0.0, 1e-2),
    "disturbances.0.torque_B.2": (-1e-3, 1e-3),
    "sensors.0.noise": (0.0, 1e-4),
    "controller.K": (0.1, 0.3),
}


@settings(max_examples=40)
@given(st.data())
def test_a_flight_is_the_run_of_its_scenario(data: st.DataObject) -> None:
    vary = data.draw(st.lists(st.sampled_from(list(NUMBERS)), unique=True, max_size=5))
    experiment = gs.Experiment(turning(), vary=vary)
    starts = [next(path for path in vary if c == path or c.startswith(path + ".")) for c in experiment.columns]
    values = [[data.draw(st.floats(*NUMBERS[p])) for p in starts] for _ in range(3)]
    first = data.draw(st.integers(0, 2**30))
    flights = experiment.fly(np.reshape(values, (3, len(starts))), first=first, threads=2) if vary else None
    flights = flights or experiment.fly(runs=3, first=first)
    alone = experiment.scenario(values[1], first + 1)
    assert alone.run_number == first + 1
    metrics = alone.run(channels=CHANNELS).metrics
    for name in flights.metrics:
        assert same(flights[name][1], getattr(metrics, name)), name
    changed = turning().replace(**_whole(experiment.columns, values[1]), run_number=first + 1)
    assert same(changed.run(channels=CHANNELS).metrics.energy, flights["energy"][1])


def _whole(columns: tuple[str, ...], values: list[float]) -> dict[str, Any]:
    """What `Scenario.replace` takes: elements that a scenario does not name yet come as whole lists."""
    out: dict[str, Any] = {}
    for column, x in zip(columns, values, strict=True):
        if column.startswith("initial.omega"):
            out.setdefault("initial.omega_BN_B", [0.0, 0.0, 0.0])[int(column[-1])] = x
        elif column == "truth.dJ_B.0.0":
            out["truth.dJ_B"] = [x, 0.0, 0.0]
        elif column == "vehicle.J_B.1.1":
            J = [list(row) for row in turning().vehicle.J_B]  # type: ignore[union-attr]
            J[1][1] = x
            out["vehicle.J_B"] = J
        else:
            out[column] = x
    return out


def test_metrics_are_those_of_a_result_with_every_stack() -> None:
    names = _core.catalogue()
    stacks = [(o, "mrp_feedback", "pseudo_inverse") for o in names["observer"]]
    stacks += [("passthrough", c, "pseudo_inverse") for c in names["controller"]]
    stacks += [("learning_effectiveness", "mrp_feedback", a) for a in names["allocator"]]
    for observer, controller, allocator in stacks:
        scenario = turning(observer=observer, controller=controller, allocator=allocator, allow_unstable=True)
        flights = gs.Experiment(scenario, vary=["faults.0.remaining"]).fly([0.9, 0.1], threads=2)
        for i, remaining in enumerate((0.9, 0.1)):
            run = scenario.replace(**{"faults.0.remaining": remaining}, run_number=i).run(channels=CHANNELS)
            for name in flights.metrics:
                assert same(flights[name][i], getattr(run.metrics, name)), (observer, controller, allocator, name)
            assert flights.status[i] == run.status
            assert flights.held_fraction[i] == run.metrics.held_fraction


def test_threads_order_and_company_change_no_bit() -> None:
    experiment = gs.Experiment(turning(), vary=["faults.0.remaining", "seed"])
    rng = np.random.default_rng(1)
    values = np.column_stack([rng.uniform(0.0, 1.0, 30), rng.integers(0, 1000, 30)])
    one, many = experiment.fly(values, first=100, threads=1), experiment.fly(values, first=100, threads=7)
    tail = experiment.fly(values[20:], first=120, threads=2)
    for name in one.metrics:
        assert same(one[name], many[name])
        assert same(one[name][20:], tail[name])
    other_noise = experiment.fly(values, first=0)
    assert not same(one["energy"], other_noise["energy"])


def test_the_number_of_a_flight_and_the_seed_key_its_noise() -> None:
    energies = [
        turning(seed=seed, run_number=run).run(channels=CHANNELS).metrics.energy
        for seed, run in [(5, 0), (5, 1), (6, 0)]
    ]
    assert len(set(energies)) == 3
    assert gs.Experiment(turning(), vary=["seed"]).fly([5, 6])["energy"].tolist()[0] == energies[0]


def test_every_metric_is_measured_as_on_the_recorded_series() -> None:
    scenario = turning(shadows=[{"observer": "finite_time_disturbance"}])
    window = {"t0": 2.0, "t1": 7.0}
    numbers: dict[str, dict[str, float]] = {
        "settling_time": {"band": 0.5},
        "recovery": {"band": 0.8, "after": 3.0, "until": 6.0},
        "energy": {},
        "final": {},
        "fraction_at_least": {"level": 0.05, **window},
        "first_reach": {"level": 1e-3, "after": 1.0},
        "window_max": window,
        "window_norm": window,
        "window_rms": window,
        "window_lowest": window,
        "window_highest": window,
        "total_variation": window,
    }
    signals = ["error.mrp", "truth.lumped_mean_B", "shadow0.estimate.d_B", "observer.rate_error"]
    scenario = scenario.replace(observer="learning_effectiveness")
    measures = {
        f"{metric} of {signal}": {"metric": metric, "signal": signal, **arguments}
        for (metric, arguments), signal in itertools.product(numbers.items(), signals)
    }
    measures["column"] = {"metric": "window_highest", "signal": "error.mrp", "column": 2}
    measures["end"] = {"metric": "window_max", "signal": "error.mrp", "last": 3.0}
    measures["fault"] = {"metric": "window_max", "signal": "error.mrp", "t0": "last_fault"}
    flights = gs.Experiment(scenario, measure=measures).fly(runs=2)
    result = scenario.replace(run_number=1).run(channels=signals)
    for (metric, arguments), signal in itertools.product(numbers.items(), signals):
        value = getattr(gs.metrics, metric)(result.t, result[signal], **arguments)
        assert same(flights[f"{metric} of {signal}"][1], value), (metric, signal)
    mrp = result["error.mrp"]
    assert flights["column"][1] == mrp[:, 2].max()
    assert flights["end"][1] == np.abs(mrp[result.t >= 5.0 - 1e-9]).max()
    assert flights["fault"][1] == np.abs(mrp[result.t >= 3.0 - 1e-9]).max()


def test_values_that_fit_no_vehicle_do_not_fly_and_stop_nothing() -> None:
    flights = gs.Experiment(turning(), vary=["vehicle.J_B.0.0"]).fly([20.0, 2000.0, -1.0, 21.0])
    assert flights.status.tolist() == ["completed", "refused", "refused", "completed"]
    assert set(flights.causes) == {1, 2}
    assert "triangle inequality" in flights.causes[1]
    assert np.isnan(flights["energy"][1])
    assert flights.completed.sum() == 2
    outside = gs.Experiment(turning(), vary=["faults.0.remaining"]).fly([0.5, 40.0, float("nan")])
    assert outside.status.tolist() == ["completed", "refused", "refused"]
    assert "per cent" in outside.causes[1]


def test_a_flight_that_ends_early_says_so() -> None:
    tumbling = turning(truth=gs.Truth(dJ_B=(-15.0, -12.0, -10.0)), controller=gs.controller("mrp_feedback"))
    flights = gs.Experiment(tumbling, vary=["initial.omega_BN_B"]).fly([[0, 0, 0.0], [900, 900, 900.0]])
    assert flights.status[0] == "completed"
    assert flights.end_time[0] == 8.0
    alone = gs.Experiment(tumbling, vary=["initial.omega_BN_B"]).scenario([900, 900, 900.0], 1).run()
    assert flights.status[1] == alone.status
    assert flights.end_time[1] == alone.end_time


class Law:
    """A law with a state of its own: a flight that started with another's would differ."""

    def __init__(self) -> None:
        self.steps = 0

    def step(self, x: gs.Estimate, det: Any, ref: Any, last: Any) -> Any:
        self.steps += 1
        return -0.5 * x.omega_BN_B * min(self.steps, 10)


def test_python_components_fly_as_copies() -> None:
    law = Law()
    scenario = turning(controller=law)
    flights = gs.Experiment(scenario, vary=["faults.0.remaining"]).fly([0.4, 0.4, 0.7], threads=4)
    assert law.steps == 0
    for i, remaining in enumerate((0.4, 0.4, 0.7)):
        run = scenario.replace(**{"faults.0.remaining": remaining}, run_number=i).run(channels=CHANNELS)
        assert same(run.metrics.energy, flights["energy"][i])

    class Broken(Law):
        def step(self, x: gs.Estimate, det: Any, ref: Any, last: Any) -> Any:
            raise RuntimeError("out of order")

    with pytest.raises(RuntimeError, match="out of order"):
        gs.Experiment(turning(controller=Broken())).fly(runs=3)


class InterruptedFlightsError(Exception):
    pass


def test_progress_is_told_and_can_stop_all() -> None:
    experiment = gs.Experiment(turning(duration=400.0, dt=0.01), vary=["seed"])
    seen: list[float] = []

    def stop(fraction: float) -> None:
        seen.append(fraction)
        if len(seen) == 2:
            raise InterruptedFlightsError

    started = time.monotonic()
    with pytest.raises(InterruptedFlightsError):
        experiment.fly(np.arange(2000), threads=2, progress=stop)
    assert len(seen) == 2
    assert all(0.0 <= f < 1.0 for f in seen)
    assert time.monotonic() - started < 20.0  # two thousand flights take minutes


BAD_PATHS = {
    "faults.0.remainin": "did you mean 'remaining'",
    "falts.0.remaining": "did you mean 'faults'",
    "controller.gain": "there are",
    "faults.3.remaining": "no position in a list of 1",
    "faults.x.remaining": "no position",
    "initial.mrp.5": "no position in a list of 3",
    "vehicle.coordinates": "only numbers differ",
    "controller.compensate": "only numbers differ",
    "dt": "the same in all flights",
    "duration": "the same in all flights",
    "faults": "the name of a parameter",
    "": "no number of a scenario",
    "truth.viscous_friction.0": "has no value",
    "disturbances.0.torque_B.0.amplitud": "did you mean 'amplitude'",
    "shadows.0.observer.x": "no position",
    "initial.mrp.0.1": "has no part",
}


@pytest.mark.parametrize("path", BAD_PATHS)
def test_a_path_that_is_no_number_is_refused_with_what_there_is(path: str) -> None:
    with pytest.raises(gs.InputError, match=BAD_PATHS[path]) as error:
        gs.Experiment(turning(), vary=[path])
    assert "\n" not in str(error.value)


BAD_MEASURES: dict[str, Any] = {
    "no metric 'settling'": {"metric": "settling", "signal": "error.angle"},
    "did you mean 'error.angle'": {"metric": "final", "signal": "error.angel"},
    "band is missing": {"metric": "settling_time", "signal": "error.angle"},
    "no parameter 'level'": {"metric": "final", "signal": "error.angle", "level": 1.0},
    "column = 3; error.mrp has 3": {"metric": "final", "signal": "error.mrp", "column": 3},
    "names several channels": {"metric": "final", "signal": "error.*"},
    "signal is missing": {"metric": "final"},
    "a table with metric and signal": 3,
    "is outside": {"metric": "window_max", "signal": "error.angle", "last": -1.0},
}


@pytest.mark.parametrize("words", BAD_MEASURES)
def test_a_measure_that_is_none_is_refused(words: str) -> None:
    with pytest.raises(gs.InputError, match=words):
        gs.Experiment(turning(), measure={"a": BAD_MEASURES[words]})


def test_values_of_another_shape_are_refused() -> None:
    experiment = gs.Experiment(turning(), vary=["initial.omega_BN_B"])
    for values in ([1.0, 2.0], [[1.0, 2.0]], "abc", [[1.0, 2.0, "x"]], np.zeros((2, 2, 3))):
        with pytest.raises(gs.InputError, match="values"):
            experiment.fly(values)
    for wrong in ({}, {"runs": 3}):
        with pytest.raises(gs.InputError, match="values are missing"):
            experiment.fly(**wrong)
    with pytest.raises(gs.InputError, match="how many flights"):
        gs.Experiment(turning()).fly()
    for wrong in ({"threads": 0}, {"first": -1}, {"threads": 1.5}, {"progress": 3}, {"runs": 4}):
        with pytest.raises(gs.InputError):
            experiment.fly(np.zeros((2, 3)), **wrong)  # type: ignore[arg-type]
    with pytest.raises(gs.InputError, match="one number a column"):
        experiment.scenario([1.0])
    with pytest.raises(gs.InputError, match="stands twice"):
        gs.Experiment(turning(), vary=["initial.mrp", "initial.mrp.1"])
    with pytest.raises(gs.InputError, match="a Scenario belongs here"):
        gs.Experiment("wheel2_degraded")  # type: ignore[arg-type]
    with pytest.raises(gs.InputError, match="no list of paths"):
        gs.Experiment(turning(), vary="seed")


def test_flights_are_a_table() -> None:
    flights = gs.Experiment(turning(), vary=["faults.0.remaining"]).fly([0.2, 0.6])
    table = flights.to_dataframe()
    assert list(table["faults.0.remaining"]) == [0.2, 0.6]
    assert list(table.columns[-len(usual_measures(8.0)) :]) == list(usual_measures(8.0))
    assert len(flights) == len(table) == 2
    assert "2 completed" in repr(flights)
