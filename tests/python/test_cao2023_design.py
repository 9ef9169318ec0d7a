# SPDX-License-Identifier: MIT
"""Design of the learning observer and of the preassigned time, by brute force; what ``gyrostat check`` says."""

from __future__ import annotations

import json
import subprocess
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from commands import gyrostat

import gyrostat as gs
from gyrostat import design, papers
from gyrostat.design import learning_disturbance, preassigned_time
from gyrostat.design.learning_disturbance import LearningGains, largest_stable_k3

GAINS = LearningGains(M=18.0, k1=0.98, k2=15.0, k3=5.0, Tc=0.01)


def case(name: str) -> gs.Scenario:
    return papers.load("cao2023").cases[name].scenario


def companion_radius(g: LearningGains, h: float, N: int) -> float:
    """The recursion written as a matrix over e and the N remembered pairs, by eigenvalues."""
    a = np.exp(-g.M * h)
    b = (1.0 - a) / g.M
    # state: e[k], then f[k-1] ... f[k-N], then e[k-1] ... e[k-N]
    A = np.zeros((2 * N + 1, 2 * N + 1))
    f = np.zeros(2 * N + 1)
    f[0], f[N], f[2 * N] = g.k2, g.k1, g.k3
    A[0] = -b * f
    A[0, 0] += a
    A[1], A[N + 1, 0] = f, 1.0
    for i in range(1, N):
        A[1 + i, i] = A[N + 1 + i, N + i] = 1.0
    return float(np.abs(np.linalg.eigvals(A)).max())


# ---- the observer ---------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("h", "Tc", "held", "radius"),
    [
        (0.001, 0.01, False, 0.99899),
        (0.0021, 0.021, False, 1.0001),
        (0.005, 0.05, False, 1.0031),
        (0.01, 0.1, False, 1.0083),
        (0.001, 0.002, False, 0.99496),
        (0.0021, 0.0042, False, 1.0005),
        (0.005, 0.01, False, 1.0152),
        (0.001, 0.01, True, 0.93),
        (0.001, 0.02, True, 0.88),
        (0.001, 0.05, True, 0.75),
    ],
)
def test_the_spectral_radius_is_that_of_the_companion_matrix(h: float, Tc: float, held: bool, radius: float) -> None:
    gains = replace(GAINS, Tc=Tc)
    found = gains.spectral_radius(h, held=held)
    assert found == pytest.approx(radius, abs=5e-3 if held else 1e-4)  # published with two digits, and with four
    assert found == pytest.approx(companion_radius(gains, Tc if held else h, 1 if held else round(Tc / h)), rel=1e-9)


def test_the_flight_code_and_the_design_agree_on_the_radius() -> None:
    """Schur-Cohn in flight, roots of the polynomial here."""
    for h, Tc, form in [(0.001, 0.01, "rolling"), (0.002, 0.05, "held"), (0.0005, 0.01, "rolling")]:
        scenario = case("T5").replace(dt=h, **{"observer.interval": Tc, "observer.form": form})
        row = next(r for r in scenario.check() if r["where"] == "observer")
        assert row["ok"]
    refused = next(r for r in case("T5").replace(dt=0.005).check() if r["where"] == "observer")
    assert refused["value"] == pytest.approx(GAINS.spectral_radius(0.005), abs=1e-8)


def test_the_largest_period_is_where_even_delays_lose_stability() -> None:
    limit = GAINS.largest_period()
    assert limit == pytest.approx(2.0e-3, abs=1e-6)
    for N in (2, 4, 10, 20):
        for factor, stable in ((0.999, True), (1.001, False)):
            h = factor * limit
            assert (replace(GAINS, Tc=N * h).spectral_radius(h) < 1.0) is stable
    assert replace(GAINS, k1=0.0, k2=10.0, k3=0.0).largest_period() == float("inf")


def test_the_exact_condition_agrees_with_brute_force_over_delays() -> None:
    """Sampled finely enough, a setting is stable for every delay tried if and only if the condition says so."""
    rng = np.random.default_rng(3)
    delays = np.geomspace(1e-2, 1.0, 15)
    seen = {True: 0, False: 0}
    while min(seen.values()) < 20:
        gains = LearningGains(rng.uniform(1, 30), rng.uniform(0.0, 0.7), rng.uniform(0, 20), rng.uniform(0, 80), 1.0)
        if abs(gains.delay_margin) < 0.25 * (gains.M + gains.k2):
            continue  # the decisive delay may lie outside those tried
        # The half-sample-rate mode belongs to sampling, not to the continuous law: stay five times below its limit.
        N = [max(20, int(np.ceil(5.0 * Tc / gains.largest_period()))) for Tc in delays]
        radius = [
            replace(gains, Tc=float(Tc)).spectral_radius(float(Tc) / n)
            for Tc, n in zip(delays, N, strict=True)
            if n < 100
        ]
        stable = gains.stable_for_every_delay
        assert (max(radius) < 1.0) is stable, gains
        seen[stable] += 1


def test_the_condition_is_where_the_characteristic_equation_meets_the_imaginary_axis() -> None:
    """(M + j w)(1 - k1 q) + k2 + k3 q = 0 with |q| = 1, by a search over w and the phase of q."""
    w = np.concatenate([[0.0], np.geomspace(1e-3, 1e3, 400)])[:, None]
    q = np.exp(-1j * np.linspace(0.0, 2.0 * np.pi, 2001))[None, :]
    for k1, k2, k3 in [(0.98, 15.0, 5.0), (0.98, 15.0, 50.0), (0.98, 15.0, 52.0), (0.5, 0.0, 26.0), (0.5, 0.0, 28.0)]:
        gains = replace(GAINS, k1=k1, k2=k2, k3=k3)
        residual = np.abs((18.0 + 1j * w) * (1.0 - k1 * q) + k2 + k3 * q).min()
        assert bool(residual > 0.2) is gains.stable_for_every_delay, (gains, residual)


def test_the_error_gain_is_that_of_the_loop() -> None:
    assert float(GAINS.error_gain(0.0)) == pytest.approx(0.01768, abs=1e-5)
    assert float(replace(GAINS, k3=0.0).error_gain(0.0)) == pytest.approx(0.02344, abs=1e-5)
    w = np.geomspace(0.1, 300.0, 50)
    q = np.exp(-1j * w * 0.01)
    learned = (15.0 + 5.0 * q) / (1.0 - 0.98 * q)  # fhat over e
    np.testing.assert_allclose(GAINS.error_gain(w), np.abs(1.0 - learned / (18.0 + 1j * w + learned)), rtol=1e-12)


def test_the_theorem_admits_next_to_nothing() -> None:
    """Largest k2 over all its free numbers, and what the estimate would then miss."""
    for k1, k2, left in [(0.98, 0.30, 0.51), (0.5, 3.1, 0.74)]:
        gains = replace(GAINS, k1=k1, k3=0.05)
        found = gains.theorem_largest_k2()
        assert found == pytest.approx(k2, abs=0.01)
        assert float(replace(gains, k2=found).error_gain(0.0)) == pytest.approx(left, abs=5e-3)
    assert np.isnan(GAINS.theorem_largest_k2()), "k3 = 5 is beyond any choice"
    assert (GAINS.theorem_gamma1, GAINS.theorem_gamma3) == (-208.0, -24.0)
    needed = next(M for M in range(1000, 20000, 100) if replace(GAINS, M=M, k3=0.05).theorem_largest_k2() >= 15.0)
    assert 5000 < needed < 8000, "k2 = 15 with k1 = 0.98 asks for M of several thousand"


def test_no_random_choice_of_its_free_numbers_beats_the_search() -> None:
    rng = np.random.default_rng(5)
    gains = replace(GAINS, k1=0.5, k3=0.05)
    r = np.exp(rng.uniform(np.log(1e-4), np.log(30.0), (200_000, 7)))
    psi = 1e-9
    A = 1.0 + psi + 0.5 / r[:, 6]
    gamma2 = 1.0 - A * (1.0 + r[:, 0] + r[:, 1] + r[:, 2]) * gains.k1**2
    gamma3 = 1.0 - A * (1.0 + 1.0 / r[:, 1] + 1.0 / r[:, 3] + r[:, 5]) * gains.k3**2
    squared = (gains.M - 1.0 - 0.5 * r[:, 6]) / (A * (1.0 + 1.0 / r[:, 0] + r[:, 3] + r[:, 4]))
    admitted = np.sqrt(squared[(gamma2 >= 0.0) & (gamma3 >= 0.0) & (squared > 0.0)])
    assert len(admitted) > 100
    found = gains.theorem_largest_k2()
    assert 0.8 * found < admitted.max() <= found * (1.0 + 1e-3)


def test_the_gain_region_ends_where_a_root_leaves_the_circle() -> None:
    k2 = np.array([1.0, 15.0, 30.0, 45.0])
    largest = largest_stable_k3(GAINS, 0.001, k2)
    assert np.isnan(largest[3]), "k2 alone is beyond 40 /s"
    for a, b in zip(k2[:3], largest[:3], strict=True):
        assert replace(GAINS, k2=float(a), k3=0.999 * float(b)).spectral_radius(0.001) < 1.0
        assert replace(GAINS, k2=float(a), k3=1.003 * float(b)).spectral_radius(0.001) > 1.0
    growth = GAINS.growth(0.001)
    assert growth == pytest.approx(2.0, abs=1e-2)  # k2 + k3 = 40 /s, where the half-sample-rate mode is lost
    assert GAINS.growth(0.005) < 1.0


# ---- the preassigned time -------------------------------------------------------------------------------------------


def test_the_coefficients_of_the_quintic_are_the_corrected_table() -> None:
    table = [[-10.0, -6.0, -1.5], [15.0, 8.0, 1.5], [-6.0, -3.0, -0.5]]
    np.testing.assert_allclose(preassigned_time.quintic_coefficients(), table, rtol=0, atol=1e-12)


def test_the_quintic_begins_as_told_and_ends_at_rest() -> None:
    rng = np.random.default_rng(11)
    for T in (2.0, 5.0, 10.0):
        d = rng.uniform(-1.0, 1.0, 3)
        before = preassigned_time.quintic([0.0, np.nextafter(T, 0.0)], T, *d)
        np.testing.assert_allclose(before[0], d, rtol=0, atol=1e-15)
        np.testing.assert_allclose(before[1], 0.0, rtol=0, atol=1e-12 * T * T)
        np.testing.assert_array_equal(preassigned_time.quintic([T, 2.0 * T], T, *d), np.zeros((2, 3)))


def test_the_printed_sign_of_a21_makes_the_path_jump_at_t() -> None:
    d1, T = 1.3, 5.0
    a = preassigned_time.quintic_coefficients()
    a[2, 1] = 3.0  # as printed
    assert d1 * T * (1.0 + a[:, 1].sum()) == pytest.approx(6.0 * T * d1)


def test_the_smallest_feasible_time_is_where_saturation_begins() -> None:
    scenario = case("limited")
    least = preassigned_time.smallest_feasible_time(scenario)
    assert least.time == pytest.approx(1.4508, rel=1e-3)
    assert least.saturating < least.time <= 1.001 * least.saturating
    for factor, saturated in ((1.05, False), (0.95, True)):
        flown = scenario.replace(**{"controller.T": factor * least.time}).run(channels=["allocation.saturated"])
        assert bool(flown["allocation.saturated"].any()) is saturated, factor
    # The cases of the study are those two.
    for name, factor in (("limited_feasible", 1.05), ("limited_infeasible", 0.95)):
        assert case(name).resolve()["controller"]["T"] == pytest.approx(factor * least.time, rel=1e-3)


def test_one_sided_nozzles_at_rest_are_not_taken_for_saturated() -> None:
    scenario = case("nozzles").replace(**{"vehicle.u_max": 8.0})
    # No slower than two signs and the pseudo-inverse: this allocator moves along null directions before it gives up.
    assert 1.0 < preassigned_time.smallest_feasible_time(scenario).time < 1.4508


def test_other_laws_and_unlimited_commands_are_left_alone() -> None:
    assert preassigned_time.findings(case("T5")) == []
    other = gs.Scenario.load("ftc_4rw")
    assert preassigned_time.findings(other) == []
    assert learning_disturbance.findings(other) == []
    assert learning_disturbance.figures(other) == {}
    with pytest.raises(gs.InputError, match="preassigned_time"):
        preassigned_time.smallest_feasible_time(other)
    with pytest.raises(gs.InputError, match="M = -1"):
        replace(GAINS, M=-1.0)
    with pytest.raises(gs.InputError, match="whole number"):
        GAINS.spectral_radius(0.003)
    with pytest.raises(gs.InputError, match="T = 0"):
        preassigned_time.quintic(0.0, 0.0, 1.0, 0.0, 0.0)


# ---- gyrostat check -------------------------------------------------------------------------------------------------


def found(done: subprocess.CompletedProcess[str]) -> dict[str, Any]:
    return {f["name"]: f for f in json.loads(done.stdout)["design"]}


def test_check_gives_every_condition_with_its_number_and_draws_the_figures(tmp_path: Path) -> None:
    done = gyrostat("check", "cao2023/printed", "--set", "vehicle.u_max=8", "--out", str(tmp_path), "--json")
    assert done.returncode == 0, done.stdout + done.stderr
    findings = found(done)
    assert findings["every delay"]["value"] == pytest.approx(20.36)
    assert findings["sampled"]["value"] == pytest.approx(0.99899, abs=1e-5)
    assert findings["gain region"]["value"] == pytest.approx(2.0, abs=1e-2)
    assert findings["error at rest"]["value"] == pytest.approx(0.01768, abs=1e-5)
    assert findings["published theorem"]["value"] == -208.0
    assert findings["feasible_time"]["limit"] == pytest.approx(1.4508, rel=1e-3)
    page = (tmp_path / "index.html").read_text()
    for name in ("response", "gain_region"):
        assert f'gyrostat.draw("{name}"' in page
        assert (tmp_path / f"{name}.png").stat().st_size > 10_000
        with np.load(tmp_path / f"{name}.npz") as data:
            assert len(data.files) > 3
    assert {name for draw in design.FIGURES for name in draw(case("T5"))} == {"response", "gain_region"}


def test_check_refuses_an_unstable_setting_with_its_number() -> None:
    done = gyrostat("check", "cao2023/printed", "--set", "dt=0.005")
    assert done.returncode == 1
    assert "unstable: spectral radius of the sampled recursion = 1.01524, must be < 1" in done.stdout
    assert "fails: spectral radius 1.01524" in done.stdout


def test_check_says_that_thrusters_of_one_sign_cannot_do_it() -> None:
    done = gyrostat("check", "cao2023/printed", "--set", "vehicle.u_min=[0, 0, 0, 0]")
    assert done.returncode == 1
    assert "no torque in some direction" in done.stdout


def test_check_says_that_a_time_is_too_short() -> None:
    settings = ("--set", "vehicle.u_max=8", "--set", "controller.T=1")
    done = gyrostat("check", "cao2023/printed", *settings)
    assert done.returncode == 1
    assert "smallest T without saturation from this initial state: 1.45 s" in done.stdout
