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
from gyrostat import metrics


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


def test_xarray_carries_units(result: gs.Result) -> None:
    data = result.to_xarray()
    assert data["truth.omega_BN_B"].attrs["unit"] == "rad/s"
    assert data.sizes["t"] == 3001
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


@given(_signals, st.floats(0.01, 1e3))
def test_settling_time_is_the_first_instant_of_the_quiet_tail(x: np.ndarray, band: float) -> None:
    t = np.arange(len(x)) * 0.5
    quiet = [k for k in range(len(x)) if np.abs(x[k:]).max() < band]
    expected = t[quiet[0]] if quiet else math.nan
    np.testing.assert_equal(metrics.settling_time(t, x, band), expected)


@given(_signals)
def test_window_metrics_agree_with_numpy(x: np.ndarray) -> None:
    t = np.arange(len(x)) * 0.25
    t0, t1 = t[len(t) // 3], t[-1]
    w = x[(t >= t0) & (t <= t1)]
    assert metrics.window_max(t, x, t0, t1) == np.abs(w).max()
    assert metrics.window_min(t, x, t0, t1) == w.min()
    assert metrics.window_upper(t, x, t0, t1) == w.max()
    expected = np.linalg.norm(w, axis=1).max()
    assert metrics.window_max_norm(t, x, t0, t1) == pytest.approx(expected, rel=ROUNDING)
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


def test_a_metric_without_its_channel_says_which(scenario: gs.Scenario) -> None:
    bare = scenario.replace(duration=1.0).run(channels=["truth.mrp"])
    with pytest.raises(KeyError, match=r"allocation\.u"):
        _ = bare.metrics.energy
    assert bare.metrics.to_dict()["energy"] is None
