# SPDX-License-Identifier: MIT
"""Results: arrays by name, read-only; metrics against plain numpy; saved and read back."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays

import gyrostat as gs
from gyrostat import _core, metrics


def test_arrays_are_time_first_and_read_only(result: gs.Result) -> None:
    assert result.t.shape == (3001,)
    np.testing.assert_array_equal(result.t, np.arange(3001) * 0.01)
    assert result["truth.omega_BN_B"].shape == (3001, 3)
    assert result["error.angle"].shape == (3001,)
    for x in (result.t, result["truth.omega_BN_B"]):
        assert x.dtype == np.float64
        with pytest.raises(ValueError, match="read-only"):
            x[0] = 1.0


def test_a_short_name_means_the_truth_first(result: gs.Result) -> None:
    assert result.full_name("omega_BN_B") == "truth.omega_BN_B"
    assert result.full_name("u") == "allocation.u"
    assert "omega_BN_B" in result
    assert "omega" not in result


def test_the_initial_state_is_the_first_row(result: gs.Result) -> None:
    np.testing.assert_array_equal(result["truth.omega_BN_B"][0], (0.01, -0.02, 0.03))
    sigma = np.array((0.1, 0.2, -0.3))
    np.testing.assert_allclose(result["error.angle"][0], 4.0 * math.atan(np.linalg.norm(sigma)), rtol=1e-14)


def test_the_fault_shows_in_the_true_effectiveness(result: gs.Result) -> None:
    e = result["truth.effectiveness"]
    # one-sided: the sample at t = 5 s still shows the interval that ended there
    assert e[500, 2] == 1.0
    assert e[501, 2] == 0.4
    assert np.all(e[:, [0, 1, 3]] == 1.0)


def test_commands_stay_inside_the_limits(result: gs.Result) -> None:
    assert np.abs(result["allocation.u"]).max() <= 0.2


def test_fewer_channels_and_samples_can_be_recorded(scenario: gs.Scenario) -> None:
    few = scenario.run(channels=["truth.mrp", "error.*"], every=7)
    assert set(few) == {"truth.mrp", "error.angle", "error.euler", "error.euler_rates", "error.mrp", "error.omega_BR_B"}
    assert few.t[1] == pytest.approx(0.07)
    assert few.t[-1] == 30.0, "the last sample is always kept"


def test_a_saved_result_reads_back_whole(result: gs.Result, tmp_path: Path) -> None:
    path = result.save(tmp_path / "run.npz")
    again = gs.Result.load(path)
    assert again.scenario == result.scenario
    assert (again.status, again.cause, again.end_time) == (result.status, result.cause, result.end_time)
    assert again.events == result.events
    assert again.unit("omega_BN_B") == "rad/s"
    assert set(again) == set(result)
    for name in result:
        np.testing.assert_array_equal(again[name], result[name])
    with np.load(path) as plain:
        np.testing.assert_array_equal(plain["truth.omega_BN_B"], result["omega_BN_B"])
    assert [p.name for p in tmp_path.iterdir()] == ["run.npz"]


def test_channels_share_labelled_dimensions(result: gs.Result) -> None:
    data = result.to_xarray()
    assert dict(data.sizes) == {"time": 3001, "axis": 3, "quaternion": 4, "actuator": 4}
    assert list(data["axis"].to_numpy()) == ["x", "y", "z"]
    assert list(data["quaternion"].to_numpy()) == ["w", "x", "y", "z"]
    assert list(data["actuator"].to_numpy()) == [0, 1, 2, 3]
    assert data["time"].attrs["unit"] == "s"
    np.testing.assert_array_equal(data["time"], result.t)
    lost = data["truth.delivered"] - data["allocation.u"]
    np.testing.assert_array_equal(lost, result["truth.delivered"] - result["allocation.u"])
    assert data["truth.q_NB"].dims == ("time", "quaternion"), "four wheels are not the four numbers of a quaternion"
    y = data["truth.omega_BN_B"].sel(axis="y", time=5.0)
    assert float(y) == result["omega_BN_B"][500, 1]


def test_every_channel_that_can_be_recorded_has_its_dimension(scenario: gs.Scenario) -> None:
    axes = np.array([[1, 0, 0, 0.6, 0.8], [0, 1, 0, 0.8, 0], [0, 0, 1, 0, 0.6]])  # five: no other size
    for observer, controller in (
        ("adaptive_iterative_learning", "sliding_mode"),
        ("mixed_learning_disturbance", "mrp_feedback"),
    ):
        flown = scenario.replace(
            vehicle=gs.Vehicle(J_B=(3.0, 3.0, 3.0), D_B=axes.tolist(), u_max=1.0).to_dict(),
            observer=observer,
            controller=controller,
            allocator="lexicographic",
            detector="threshold",
            duration=0.1,
        )
        data = flown.run(channels=[c["name"] for c in flown.channel_names()]).to_xarray()
        sizes = {"time": 11, "axis": 3, "quaternion": 4, "actuator": 5}
        own = {"observer.gains_i": 3} if observer == "adaptive_iterative_learning" else {}
        assert dict(data.sizes) == sizes | own


def test_a_data_frame_of_everything_is_of_a_size_to_work_with(scenario: gs.Scenario) -> None:
    data = scenario.replace(duration=1.0).run().to_xarray()
    frame = data.to_dataframe()
    assert len(frame) == 101 * 3 * 4 * 4
    assert np.isfinite(frame.to_numpy()).all()
    only = data["truth.omega_BN_B"].to_dataframe()
    assert len(only) == 101 * 3


def test_a_result_read_back_has_the_same_labels(result: gs.Result, tmp_path: Path) -> None:
    again = gs.Result.load(result.save(tmp_path / "run.npz"))
    assert again.to_xarray().equals(result.to_xarray())


def test_xarray_carries_units(result: gs.Result) -> None:
    data = result.to_xarray()
    assert data["truth.omega_BN_B"].attrs["unit"] == "rad/s"
    assert data.sizes["time"] == 3001
    np.testing.assert_array_equal(data["error.angle"].to_numpy(), result["error.angle"])


def test_the_overview_draws_and_saves_its_data(result: gs.Result, tmp_path: Path) -> None:
    picture = result.plot().save(tmp_path / "overview.png")
    assert picture.read_bytes().startswith(b"\x89PNG")
    with np.load(tmp_path / "overview.npz") as data:
        np.testing.assert_array_equal(data["command"], result["allocation.u"])
        np.testing.assert_array_equal(data["t"], result.t)


# Metrics against plain numpy: the C++ is the implementation, this is the oracle.
_signals = arrays.arrays(
    np.float64,
    st.tuples(st.integers(2, 40), st.integers(1, 4)),
    elements=st.floats(-1e3, 1e3, allow_subnormal=False),
)
ROUNDING = 1e-12  # relative; sums of at most 160 terms in another order


@given(_signals, st.floats(0.01, 1e3), st.integers(0, 20))
def test_settling_time_is_counted_to_the_first_instant_of_the_quiet_tail(
    x: np.ndarray, band: float, first: int
) -> None:
    t = np.arange(len(x)) * 0.5
    after = 0.5 * first
    quiet = [k for k in range(first, len(x)) if np.abs(x[k:]).max() < band]
    expected = t[quiet[0]] - after if quiet else math.nan
    np.testing.assert_equal(metrics.settling_time(t, x, band, after), expected)


@given(_signals)
def test_window_metrics_agree_with_numpy(x: np.ndarray) -> None:
    t = np.arange(len(x)) * 0.25
    t0, t1 = t[len(t) // 3], t[-1]
    w = x[(t >= t0) & (t <= t1)]
    assert metrics.window_max(t, x, t0, t1) == np.abs(w).max()
    assert metrics.window_lowest(t, x, t0, t1) == w.min()
    assert metrics.window_highest(t, x, t0, t1) == w.max()
    expected = np.linalg.norm(w, axis=1).max()
    assert metrics.window_norm(t, x, t0, t1) == pytest.approx(expected, rel=ROUNDING)
    expected = np.sqrt((w**2).sum(axis=1).mean())
    assert metrics.window_rms(t, x, t0, t1) == pytest.approx(expected, rel=ROUNDING)


@given(_signals)
def test_energy_and_variation_agree_with_numpy(u: np.ndarray) -> None:
    t = np.arange(len(u)) * 0.25
    expected = ((u[:-1] ** 2).sum(axis=1) * 0.25).sum()
    assert metrics.energy(t, u) == pytest.approx(expected, rel=ROUNDING, abs=1e-300)
    expected = np.abs(np.diff(u, axis=0)).sum() / (t[-1] - t[0])
    assert metrics.total_variation(t, u, t[0], t[-1]) == pytest.approx(expected, rel=ROUNDING, abs=1e-300)


@settings(max_examples=50)
@given(_signals, st.floats(0.1, 1e3))
def test_level_metrics_agree_with_numpy(x: np.ndarray, level: float) -> None:
    t = np.arange(len(x)) * 0.25
    reached = np.abs(x).max(axis=1) >= level
    # a sample within rounding of the level may count either way
    close = np.isclose(np.abs(x).max(axis=1), level, rtol=1e-8)
    if not close.any():
        assert metrics.fraction_at_least(t, x, level, t[0], t[-1]) == pytest.approx(reached.mean(), rel=ROUNDING)
        expected = t[reached][0] if reached.any() else math.nan
        np.testing.assert_equal(metrics.first_reach(t, x, level), expected)


def test_run_metrics_count_from_the_last_fault(result: gs.Result) -> None:
    assert result.metrics.last_fault == 5.0
    band = 1.1 * float(result["error.angle"][-500:].max())  # holds for the last 5 s at least
    bad = np.flatnonzero(result["error.angle"] >= band)
    assert result.metrics.settling(band) == pytest.approx(result.t[bad[-1] + 1] - 5.0, rel=1e-12)
    u = result["allocation.u"]
    assert result.metrics.saturated_fraction == np.mean((np.abs(u) >= 0.2 * (1 - 1e-9)).any(axis=1))


@pytest.mark.parametrize("allocator", [*_core.catalogue()["allocator"], "python"])
def test_saturated_means_the_same_in_metric_channel_and_command(scenario: gs.Scenario, allocator: str) -> None:
    """Wheels, and nozzles that only push: a closed one stands at its limit of zero, and is not saturated."""
    axes = np.array([[1, -1, 1, -1, 0, 0], [1, 1, -1, -1, 0, 0], [1, -1, -1, 1, 0, 0]]) / 2.0
    nozzles = gs.Vehicle(J_B=(10.0, 12.0, 9.0), D_B=np.hstack([axes[:, :4], -axes[:, :4]]), u_min=0.0, u_max=0.2)
    for vehicle in (gs.vehicle.ftc_4rw(), nozzles):
        n = len(vehicle.D_B[0])
        lower, upper = (0.0 if vehicle is nozzles else -0.2), 0.2
        python = _Inverse(np.linalg.pinv(np.asarray(vehicle.D_B)), lower, upper)
        flown = scenario.replace(
            vehicle=vehicle.to_dict(),
            allocator=python if allocator == "python" else allocator,
            initial={"mrp": (0.1, 0.2, -0.3), "omega_BN_B": (0.1, -0.2, 0.15)},
            faults=[],
            sensors=[],
            duration=20.0,
        ).run()
        u, mask = flown["allocation.u"], flown["allocation.saturated"].astype(int)
        named = (mask[:, None] >> np.arange(n)) & 1 == 1
        np.testing.assert_array_equal(named, (u != 0.0) & ((u == lower) | (u == upper)))
        assert flown.metrics.saturated_fraction == np.mean(named.any(axis=1))
        assert 0.0 < flown.metrics.saturated_fraction < 0.9, "limits are met, and left"


class _Inverse:
    """An allocator of the user's: it says nothing of limits, the guard sees to them."""

    def __init__(self, inverse: np.ndarray, lower: float, upper: float) -> None:
        self.inverse, self.lower, self.upper = inverse, lower, upper

    def step(self, demand: gs.Demand, x: gs.Estimate, det: gs.Detection) -> np.ndarray:
        return np.clip(self.inverse @ demand.tau_B, self.lower, self.upper)


def test_a_fault_that_the_run_never_saw_does_not_count(scenario: gs.Scenario) -> None:
    healthy = scenario.replace(faults=[], disturbances=[], integrator="rk4", duration=200.0)
    late = gs.faults.Dead(actuator=1, t_on=1000.0)
    for faults, onset in (([], 0.0), ([late], 0.0), ([scenario.faults[0], late], 5.0)):
        run = healthy.replace(faults=faults).run(channels=["error.angle"])
        assert run.metrics.last_fault == onset
        bad = np.flatnonzero(run["error.angle"] >= metrics.DEFAULT_BAND)
        assert run.metrics.settling_time == run.t[bad[-1] + 1] - onset
        assert run.metrics.settling_time == metrics.settling_time(
            run.t, run["error.angle"], metrics.DEFAULT_BAND, onset
        )


def test_claims_and_python_measure_under_the_same_names() -> None:
    from gyrostat.papers.measures import METRICS

    shared = {"settling_time", "energy", "first_reach", "fraction_at_least", "total_variation"}
    shared |= {name for name in metrics.__all__ if name.startswith("window_")}
    assert shared <= set(metrics.__all__)
    assert shared <= set(METRICS)
    assert not {name for name in METRICS if name.startswith("window_")} - set(metrics.__all__)


def test_a_metric_without_its_channel_says_which(scenario: gs.Scenario) -> None:
    bare = scenario.replace(duration=1.0).run(channels=["truth.mrp"])
    with pytest.raises(KeyError, match=r"allocation\.u"):
        _ = bare.metrics.energy
    assert bare.metrics.to_dict()["energy"] is None
