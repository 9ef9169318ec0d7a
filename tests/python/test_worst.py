# SPDX-License-Identifier: MIT
"""The smallest lost flight: its distance where that is known, its explanation, and sensitivities of known functions."""

from __future__ import annotations

import math
import sys

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy import special, stats

from gyrostat.errors import InputError
from gyrostat.verification.limit_states import linear
from gyrostat.verification.sensitivity import failure_histogram, first_order
from gyrostat.verification.worst import WorstCase, explanation, shrunk

Floats = NDArray[np.float64]


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_the_likeliest_failure_of_a_plane_is_its_foot_and_random_flights_find_none(seed: int) -> None:
    p = 1e-6
    beta = float(-special.ndtri(p))
    state = linear(10, p)
    got = WorstCase(10, budget=2000, seed=seed).run(state.margin)
    assert got.lost
    assert beta <= math.sqrt(got.size) <= 1.03 * beta
    assert got.margin > 0
    assert got.flights <= 2000
    assert got.first_lost >= 400  # none of the random fifth, and none of as many random flights:
    random = np.random.default_rng(seed).standard_normal((2000, 10))
    assert not (state.margin(random) > 0).any()


def test_the_nearer_of_two_failures_is_found() -> None:
    def margin(z: Floats) -> Floats:  # a broad one at 4, a narrow one at 2.5
        return np.maximum(z[:, 0] - 4.0, np.minimum(-z[:, 0] - 2.5, 0.5 - np.abs(z[:, 1] - 0.5)))

    sizes = [math.sqrt(WorstCase(4, budget=1500, seed=seed).run(margin).size) for seed in range(4)]
    assert max(sizes) < 1.05 * 2.5


def test_one_input_and_a_size_of_ones_own_work() -> None:
    got = WorstCase(1, budget=300).run(lambda z: z[:, 0] - 3.0)
    assert math.sqrt(got.size) == pytest.approx(3.0, rel=0.01)
    losses = WorstCase(3, budget=900, seed=1).run(
        lambda z: (special.ndtr(z) @ np.array([3.0, 1.0, 1.0])) - 2.5, lambda z: special.ndtr(z).sum(axis=1)
    )
    assert losses.size == pytest.approx(2.5 / 3, rel=0.02)  # all of it in the input that weighs most


def test_what_cannot_be_lost_is_said_to_be_so() -> None:
    got = WorstCase(3, budget=300).run(lambda z: -1.0 - (z * z).sum(axis=1))
    assert not got.lost
    assert got.first_lost == -1
    assert got.size == math.inf
    assert np.linalg.norm(got.z) < 0.5  # it came as near as it could


def test_the_same_seed_gives_the_same_flights() -> None:
    state = linear(5, 1e-4)
    first, second = (WorstCase(5, budget=400, seed=4).run(state.margin) for _ in range(2))
    assert first.z.tobytes() == second.z.tobytes()
    assert first.number == second.number


@given(st.lists(st.floats(-4, 4), min_size=4, max_size=4))
def test_what_is_left_of_a_flight_is_lost_and_needs_each_of_its_inputs(values: list[float]) -> None:
    def margin(z: Floats) -> Floats:
        return z[:, 0] + 2 * z[:, 1] - 3.0

    z = np.array(values)
    if margin(z[None, :])[0] <= 0:
        return
    left, flights = shrunk(margin, z)
    assert margin(left[None, :])[0] > 0
    assert (np.abs(left) <= np.abs(z)).all()
    assert left[2] == left[3] == 0
    assert flights <= 4 * 11
    for i in np.flatnonzero(left):
        nearer = left.copy()
        nearer[i] *= 0.99  # ten bisections: a thousandth of what it was
        if abs(left[i]) > 0.2 * abs(z[i]):
            assert margin(nearer[None, :])[0] <= 0


def test_an_explanation_names_what_is_needed() -> None:
    said = explanation(["wheel.remaining", "rate", "t_on", "q"], [0.31, 0.04, 12.0, 6e-17], [0.6, 0.0, 12.0, 3e-17])
    assert said == ["wheel.remaining below 0.31 (nominal 0.6)", "rate above 0.04 (nominal 0)"]


def test_a_search_that_cannot_be_made_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(InputError, match="budget = 20: ten batches at least"):
        WorstCase(10, budget=20)
    with pytest.raises(InputError, match="one finite number a flight"):
        WorstCase(2, budget=100).run(lambda z: np.full(len(z), np.nan))
    with pytest.raises(InputError, match="size: one number a flight belongs here, below 500000"):
        WorstCase(2, budget=100).run(lambda z: z[:, 0] + 9, lambda z: np.full(len(z), np.nan))
    with pytest.raises(InputError, match="seed = -1: a whole number"):
        WorstCase(2, seed=-1)
    monkeypatch.setitem(sys.modules, "cma", None)
    with pytest.raises(InputError, match=r"needs the package 'cma': pip install 'gyrostat\[tune\]'"):
        WorstCase(2, budget=100).run(lambda z: z[:, 0] - 9)


def test_indices_of_ishigamis_function_are_the_published_ones() -> None:
    u = np.random.default_rng(1).random((200_000, 3))
    x = math.pi * (2 * u - 1)
    y = np.sin(x[:, 0]) + 7 * np.sin(x[:, 1]) ** 2 + 0.1 * x[:, 2] ** 4 * np.sin(x[:, 0])
    # 32 bins hold sinc(pi / 16)^2 = 0.987 of the variance of two periods, which sin^2 has; sampling error 0.002
    assert first_order(u, y) == pytest.approx([0.3139, 0.987 * 0.4424, 0.0], abs=5e-3)


@settings(max_examples=20)
@given(st.lists(st.floats(-3, 3), min_size=3, max_size=6).filter(lambda c: sum(x * x for x in c) > 1))
def test_indices_of_a_sum_are_shares_of_its_squares(weights: list[float]) -> None:
    c = np.array(weights)
    u = np.random.default_rng(2).random((20_000, c.size))
    y = special.ndtri(u) @ c
    # 32 bins of a normal number hold 0.995 of its variance; sampling error 0.01
    assert first_order(u, y) == pytest.approx(c**2 / (c @ c), abs=0.03)


def test_the_bias_of_few_rows_is_removed() -> None:
    random = np.random.default_rng(3)
    indices = np.array([first_order(random.random((200, 4)), random.standard_normal(200)) for _ in range(100)])
    # the raw share would be 31 / 199 = 0.156
    assert abs(indices.mean()) < 0.01


def test_values_that_are_missing_are_left_out_and_too_few_rows_have_no_index() -> None:
    random = np.random.default_rng(4)
    u = random.random((5000, 2))
    y = np.where(random.random(5000) < 0.3, np.nan, u[:, 0])
    assert first_order(u, y) == pytest.approx([1, 0], abs=0.01)
    assert np.isnan(first_order(u[:40], y[:40])).all()
    with pytest.raises(InputError, match="do not fit"):
        first_order(u, y[:10])


def test_failures_lie_where_they_lie_and_bars_are_clopper_and_pearsons() -> None:
    random = np.random.default_rng(5)
    u = random.random((20_000, 2))
    got = failure_histogram(u, u[:, 0] > 0.9, bins=10)
    assert got.counts[0, :9].sum() == 0
    assert got.share[0, 9] == 1
    assert got.counts.sum(axis=1).tolist() == [int((u[:, 0] > 0.9).sum())] * 2
    total = int(got.counts[1].sum())
    exact = stats.binomtest(int(got.counts[1, 3]), total).proportion_ci(method="exact")
    assert (got.low[1, 3], got.high[1, 3]) == pytest.approx((exact.low, exact.high))
    assert (got.low[1] <= 0.1).all()
    assert (got.high[1] >= 0.1).all()
    assert np.isnan(failure_histogram(u, np.zeros(20_000)).share).all()
