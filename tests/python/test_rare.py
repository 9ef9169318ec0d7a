# SPDX-License-Identifier: MIT
"""Rare failures: words by counter, limit states of known probability, plateaus, and searches that were killed."""

from __future__ import annotations

import math
import signal
import subprocess
import sys
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from gyrostat.errors import InputError
from gyrostat.verification.journal import remembered
from gyrostat.verification.limit_states import LimitState, limit_states, linear, noise, score
from gyrostat.verification.rare import Rare, SubsetSimulation, cox_interval
from gyrostat.verification.words import philox, stream, uniforms

Floats = NDArray[np.float64]
words = st.integers(0, 2**64 - 1)


@given(st.lists(words, min_size=2, max_size=2), st.lists(words, min_size=4, max_size=4))
def test_words_are_those_of_numpys_generator_one_counter_on(key: list[int], counter: list[int]) -> None:
    number = sum(c << (64 * i) for i, c in enumerate(counter))
    before = [((number - 1) >> (64 * i)) % 2**64 for i in range(4)]
    generator = np.random.Philox(key=np.array(key, np.uint64), counter=np.array(before, np.uint64))
    ours = philox((key[0], key[1]), (counter[0], counter[1], counter[2], counter[3]))
    assert ours.tolist() == generator.random_raw(4).tolist()


def test_a_stream_has_the_words_of_its_counters_in_order() -> None:
    chains = np.arange(3, dtype=np.uint64)
    got = stream((7, 1), (chains, (2 << 32) + 5), 2, 10)
    assert got.shape == (3, 10)
    for chain in range(3):
        for j in range(10):
            assert got[chain, j] == philox((7, 1), (j // 4, chain, (2 << 32) + 5, 2))[j % 4]


def test_uniform_numbers_never_are_zero_or_one() -> None:
    ends = uniforms(np.array([0, 2**64 - 1], np.uint64))
    assert 0 < ends[0] < 1e-15
    assert 1 - 1e-15 < ends[1] < 1


@pytest.mark.parametrize("state", [*limit_states(), noise(60, 1e-3)], ids=lambda s: f"{s.name}, {s.probability:.0e}")
def test_limit_states_have_their_probability(state: LimitState) -> None:
    # 12 runs of 8 replicates: the mean's error is cv / sqrt(96), at most 6.5 %; four of those
    got = score(state, repeats=6, population=200)
    assert abs(got.bias - 1) <= 4 * got.variation / math.sqrt(6 * 8)
    assert got.coverage >= 4 / 6


@pytest.mark.parametrize("inputs", [1, 500])
def test_one_input_and_five_hundred_work(inputs: int) -> None:
    got = SubsetSimulation(inputs, seed=3, population=200).run(linear(inputs, 1e-4).margin)
    assert got.status == "converged"
    assert 0.5e-4 < got.probability < 2e-4
    assert got.interval[0] < got.probability < got.interval[1]


def test_a_constant_margin_stalls_at_once_and_bounds_from_independent_flights() -> None:
    got = SubsetSimulation(3).run(lambda z: np.full(len(z), -1.0))
    assert (got.status, got.flights, got.levels) == ("stalled", 500, ())
    assert got.bound == pytest.approx(1 - 0.05 ** (1 / 500))  # no failure among 500: (1 - p)^500 = 0.05
    assert math.isnan(got.probability)


def test_a_plateau_below_the_limit_stalls_when_nothing_lies_above_it() -> None:
    got = SubsetSimulation(2, seed=1).run(lambda z: np.minimum(z[:, 0], 1.0) - 3.0)
    assert got.status == "stalled"
    assert got.bound == pytest.approx(1 - 0.05 ** (1 / 500))
    assert got.interval == (0.0, got.bound)


def test_a_frequent_failure_needs_no_level() -> None:
    got = SubsetSimulation(1, seed=2).run(lambda z: z[:, 0])
    assert got.levels == ()
    assert got.flights == 9 * 500
    assert got.probability == pytest.approx(0.5, abs=4 * 0.5 / math.sqrt(8 * 500))
    # Clopper-Pearson of all first flights
    assert got.probability < got.bound < got.probability + 0.03


def test_replicates_that_find_nothing_are_not_converged() -> None:
    got = [SubsetSimulation(3, seed=seed, population=20).run(linear(3, 1e-4).margin) for seed in range(10)]
    empty = [r for r in got if r.status != "stalled" and not (r.replicates > 0).all()]
    assert len(empty) > 3  # two chains climb four levels
    assert all(r.status == "not converged" and math.isnan(r.interval[0]) for r in empty)
    wide = [r for r in got if r.variation > 1]
    assert all(r.status == "not converged" for r in wide)


def test_the_likeliest_lost_flights_come_first_and_are_lost() -> None:
    state = linear(10, 1e-4)
    got = SubsetSimulation(10, seed=1).run(state.margin)
    distances = [flight.distance for flight in got.lost]
    assert distances == sorted(distances)
    assert len({flight.z.tobytes() for flight in got.lost}) == 10
    z = np.array([flight.z for flight in got.lost])
    assert (state.margin(z) > 0).all()
    assert state.margin(z).tolist() == [flight.margin for flight in got.lost]
    assert distances[0] > 3.719  # the distance of the plane


def same(a: Rare, b: Rare) -> bool:
    return a.replicates.tobytes() == b.replicates.tobytes() and a.levels == b.levels and a.flights == b.flights


def test_threads_and_batches_do_not_change_a_bit() -> None:
    state = noise(7, 1e-3)
    plan = SubsetSimulation(2, 7, seed=5, population=100)

    def whole(z: Floats, versions: NDArray[np.uint64]) -> Floats:
        return state.margin(z, versions) + 0.1 * np.array([float(x[0]) for x in z])

    with ThreadPoolExecutor(2) as pool:

        def shared(z: Floats, versions: NDArray[np.uint64]) -> Floats:
            parts = pool.map(lambda i: whole(z[i : i + 7], versions[i : i + 7]), range(0, len(z), 7))
            return np.concatenate(list(parts))

        assert same(plan.run(whole), plan.run(shared))


def test_a_killed_search_goes_on_with_the_same_bits(tmp_path: Path) -> None:
    path, flown = tmp_path / "margins", tmp_path / "flown"
    program = f"""
import time, numpy as np
from pathlib import Path
from gyrostat.verification.journal import remembered
from gyrostat.verification.limit_states import linear
from gyrostat.verification.rare import SubsetSimulation
def margin(z):
    time.sleep(0.01)
    with open({str(flown)!r}, "a") as file: file.write(f"{{len(z)}}\\n")
    return linear(4, 1e-3).margin(z)
with remembered(margin, Path({str(path)!r}), "linear") as known:
    got = SubsetSimulation(4, seed=9, population=100).run(known)
print(got.replicates.tobytes().hex(), got.flights)
"""
    for batches in (3, 14):
        process = subprocess.Popen([sys.executable, "-c", program], stdout=subprocess.DEVNULL)
        while process.poll() is None and (not flown.exists() or flown.read_text().count("\n") < batches):
            time.sleep(0.002)
        process.send_signal(signal.SIGKILL)
        process.wait()
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    in_one_go = SubsetSimulation(4, seed=9, population=100).run(linear(4, 1e-3).margin)
    assert done.stdout.split() == [in_one_go.replicates.tobytes().hex(), str(in_one_go.flights)]
    flights = sum(map(int, flown.read_text().split()))
    assert in_one_go.flights <= flights <= in_one_go.flights + 2 * 800  # a batch may be flown again, one a kill


def test_a_torn_record_is_flown_again(tmp_path: Path) -> None:
    path, plan, state = tmp_path / "margins", SubsetSimulation(3, seed=1, population=50), linear(3, 1e-2)

    def fly() -> tuple[Rare, int]:
        flown = 0

        def margin(z: Floats) -> Floats:
            nonlocal flown
            flown += len(z)
            return state.margin(z)

        with remembered(margin, path, "linear") as known:
            return plan.run(known), flown

    first, flown = fly()
    assert flown == first.flights
    again, flown = fly()
    assert same(again, first)
    assert flown == 0
    whole = path.read_bytes()
    path.write_bytes(whole[:-5])
    again, flown = fly()
    assert same(again, first)
    assert flown in range(5, 8 * 5 + 1, 5)  # one move of the five chains of each replicate that is left
    assert path.read_bytes() == whole
    spoilt = bytearray(whole)
    spoilt[len(whole) // 2] ^= 1
    path.write_bytes(bytes(spoilt))
    again, flown = fly()
    assert same(again, first)
    assert 0 < flown < first.flights
    with pytest.raises(InputError, match="margins of another search"), remembered(state.margin, path, "other"):
        pass
    with (
        pytest.raises(InputError, match="batch 0 has other flights"),
        remembered(state.margin, path, "linear") as known,
    ):
        SubsetSimulation(3, seed=2, population=50).run(known)


def test_coxs_interval_holds_the_mean_of_lognormal_numbers() -> None:
    random = np.random.default_rng(4)
    held = [
        low <= math.exp(0.125) <= high
        for low, high in (cox_interval(np.exp(0.5 * random.standard_normal(8))) for _ in range(2000))
    ]
    assert 0.93 <= np.mean(held) <= 0.98


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"inputs": 0}, "at least one input or block"),
        ({"inputs": 2, "population": 505}, "population = 505: a multiple of 10 belongs here"),
        ({"inputs": 2, "share": 0.3}, "share = 0.3: one over a whole number"),
        ({"inputs": 2, "replicates": 1}, "replicates = 1: without two"),
        ({"inputs": 2, "seed": -1}, "seed = -1: a whole number from 0 to"),
        ({"inputs": 2, "seed": 2**64}, "seed = 18446744073709551616: a whole number"),
        ({"inputs": 2, "seed": 1.5}, r"seed = 1\.5: a whole number"),
    ],
)
def test_a_plan_that_cannot_be_flown_is_refused(arguments: dict[str, float], message: str) -> None:
    with pytest.raises(InputError, match=message):
        SubsetSimulation(**arguments)  # type: ignore[arg-type]


def test_a_margin_may_spoil_the_points_that_it_is_given() -> None:
    def spoiling(z: Floats) -> Floats:
        got = linear(3, 1e-2).margin(z)
        z[:] = 7.0
        return got

    plan = SubsetSimulation(3, seed=1, population=50)
    assert same(plan.run(spoiling), plan.run(linear(3, 1e-2).margin))


def test_a_margin_that_is_not_finite_is_refused() -> None:
    with pytest.raises(InputError, match="margin: nan of flight 3 of a batch; a finite number belongs here"):
        SubsetSimulation(1).run(lambda z: np.where(np.arange(len(z)) == 3, np.nan, -1.0))
    with pytest.raises(InputError, match=r"gave shape \(500, 1\)"):
        SubsetSimulation(1).run(lambda z: z)
