# SPDX-License-Identifier: MIT
"""Tuning on a problem whose optimum is known: factors, effort that is held, flights that were not tuned on."""

from __future__ import annotations

import math

import numpy as np
import pytest
from numpy.typing import NDArray

from gyrostat.errors import InputError
from gyrostat.verification.tune import FlownSet, Tuner, graded_time, worst_tenth

Floats = NDArray[np.float64]
BEST = np.array([2.0, 0.5, 1.2])


def toy(factors: Floats, split: str, flights: int = 100) -> FlownSet | None:
    """A bowl in logarithms of factors under noise that is common to all factors; effort is the first factor."""
    random = np.random.default_rng(1 if split == "train" else 2)
    noise = random.standard_normal((flights, 3))
    if factors[1] > 4:
        return None
    away = np.log(factors / BEST)
    time = 20 + 30 * (away @ away) + 2 * noise[:, 0] + noise[:, 1:] @ away[:2]
    return FlownSet(time, energy=10 * float(factors[0]), variation=5.0)


def test_the_optimum_of_a_bowl_is_found_with_effort_free() -> None:
    got = Tuner(3, effort=math.inf, budget=400, seed=1).run(toy)
    assert got.evaluations <= 400
    best = toy(BEST, "train")
    assert best is not None
    assert worst_tenth(got.train.after) <= 1.05 * worst_tenth(best.time)
    assert got.factors == pytest.approx(BEST, rel=0.1)
    assert not got.overfit
    before, after = got.held_out.percentile(0.95)
    assert after < before
    assert got.held_out.interval[0] <= after - before <= got.held_out.interval[1]
    assert got.held_out.interval[1] < 0
    assert got.held_out.energy == pytest.approx(got.factors[0])


def test_effort_is_held_at_its_limit() -> None:
    got = Tuner(3, effort=1.4, budget=400, seed=1).run(toy)
    assert got.factors[0] == pytest.approx(1.4, rel=0.05)  # it would be 2
    assert got.factors[1:] == pytest.approx(BEST[1:], rel=0.15)
    assert got.train.energy <= 1.5


def test_the_trade_is_what_no_other_trial_beats() -> None:
    got = Tuner(3, effort=math.inf, budget=150, seed=2).run(toy)
    front = got.trade()
    assert [t.energy for t in front] == sorted(t.energy for t in front)
    for trial in front:
        assert not any(t.energy < trial.energy and t.worst_tenth < trial.worst_tenth for t in got.trials)


def test_one_parameter_and_refused_factors_work_and_seeds_repeat() -> None:
    def fly(factors: Floats, split: str) -> FlownSet | None:
        return None if factors[0] < 0.9 else toy(np.array([1.0, 1.0, factors[0]]), split)

    first, second = (Tuner(1, budget=60, seed=3).run(fly) for _ in range(2))
    assert first.factors.tobytes() == second.factors.tobytes()
    assert first.factors[0] == pytest.approx(1.2, rel=0.1)


def test_tuning_on_few_flights_is_said_to_overfit() -> None:
    def fly(factors: Floats, split: str) -> FlownSet:
        wanted = 2.0 if split == "train" else 0.5
        return FlownSet(10 + 20 * np.full(20, float(np.log(factors[0] / wanted)) ** 2), 1.0, 1.0)

    assert Tuner(1, budget=60).run(fly).overfit


def test_flights_that_do_not_settle_are_graded_by_their_error() -> None:
    time = graded_time(np.array([3.0, np.nan, np.nan, np.nan]), np.array([0.0, 0.02, 0.2, np.nan]), 0.002, 60.0)
    assert time[0] == 3.0
    assert time[1:3] == pytest.approx([60 + 20 * 2, 60 + 20 * 3])
    assert time[3] > time[2]


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"parameters": 0}, "parameters: at least one"),
        ({"parameters": 1, "effort": 0.5}, "effort = 0.5: at least 1"),
        ({"parameters": 1, "budget": 5}, "budget = 5: at least 10"),
    ],
)
def test_what_cannot_be_tuned_is_refused(arguments: dict[str, float], message: str) -> None:
    with pytest.raises(InputError, match=message):
        Tuner(**arguments)  # type: ignore[arg-type]


def test_published_values_that_cannot_be_flown_are_refused() -> None:
    with pytest.raises(InputError, match="published values are refused"):
        Tuner(2).run(lambda *_: None)
