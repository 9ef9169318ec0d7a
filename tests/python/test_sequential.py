# SPDX-License-Identifier: MIT
"""Sequential verdicts: the formulas, exact error rates by dynamic programming, no dependence on when one looks."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import integrate, special, stats

from gyrostat.errors import InputError
from gyrostat.verification.incomplete_beta import log_betainc, log_betaincc
from gyrostat.verification.sequential import (
    SequentialTest,
    distribution_band,
    exceedance_counts,
    failure_interval,
    levels,
    log_e_fail,
    log_e_pass,
    quantile_interval,
    rate_interval,
    runs_to_fail,
    runs_to_pass,
    together,
)


def mixture(n: int, failures: int, q: float, *, passing: bool) -> float:
    """Log of the mixed likelihood ratio, integrated numerically over log odds."""

    def log_ratio(p: float) -> float:
        return failures * math.log(p / q) + (n - failures) * (math.log1p(-p) - math.log1p(-q))

    def density(p: float) -> float:  # in log odds, dp = p (1 - p) dx; not normalised
        return math.sqrt(p * (1 - p)) if passing else 1 - p

    ends = (-60.0, special.logit(q)) if passing else (special.logit(q), 30.0)
    grid = special.expit(np.linspace(*ends, 4001)[1:-1])
    peak = max(log_ratio(float(p)) for p in grid)
    peak_at = special.logit(float(grid[np.argmax([log_ratio(float(p)) for p in grid])]))

    def integral(f: object) -> float:
        assert callable(f)
        points = [peak_at] if ends[0] < peak_at < ends[1] else None
        return float(integrate.quad(lambda x: f(special.expit(x)), *ends, points=points, limit=2000, epsabs=0)[0])

    value = integral(lambda p: math.exp(log_ratio(p) - peak) * density(p))
    return peak + math.log(value / integral(density))


@pytest.mark.parametrize(
    ("evidence", "arguments", "value"),
    [
        (log_e_pass, (1000, 0, 0.003), 2.319472173234643),
        (log_e_pass, (5000, 3, 0.003), 6.043463447702374),
        (log_e_fail, (5000, 3, 0.003), -4.337484059418108),
        (log_e_fail, (2000, 30, 0.01), -0.1458552411366263),
    ],
)
def test_evidence_has_the_values_of_the_closed_form(
    evidence: object, arguments: tuple[float, ...], value: float
) -> None:
    assert callable(evidence)
    assert float(evidence(*arguments)) == pytest.approx(value, abs=1e-9)


@pytest.mark.parametrize(
    ("n", "failures", "q"), [(40, 3, 0.1), (1000, 4, 0.02), (1000, 60, 0.02), (20, 20, 0.9), (30, 0, 0.5)]
)
def test_evidence_is_the_integral_of_likelihood_ratios(n: int, failures: int, q: float) -> None:
    # 1e-6: of the quadrature, whose ends are cut off at odds of exp(-60) and exp(30)
    assert float(log_e_pass(n, failures, q)) == pytest.approx(mixture(n, failures, q, passing=True), abs=1e-6)
    if failures:
        assert float(log_e_fail(n, failures, q)) == pytest.approx(mixture(n, failures, q, passing=False), abs=1e-6)


def test_boundaries_are_those_of_the_closed_form() -> None:
    assert runs_to_pass(range(6), 1e-3, 0.05).tolist() == [3787, 6655, 8859, 10825, 12657, 14401]
    assert runs_to_fail(range(2, 7), 1e-3, 0.05).tolist() == [89, 266, 520, 833, 1192]


@given(st.integers(0, 10**9), st.floats(0, 1), st.floats(-9, -1e-4), st.booleans())
def test_evidence_is_finite_for_a_billion_runs_and_a_limit_of_a_billionth(
    n: int, share: float, log_q: float, few: bool
) -> None:
    failures = min(n, int(share * 100)) if few else int(share * n)
    q = 10.0**log_q
    assert math.isfinite(float(log_e_pass(n, failures, q)))
    assert math.isfinite(float(log_e_fail(n, failures, q))) == (failures > 0)


@pytest.mark.parametrize(("a", "b", "x"), [(3e5, 7e8, 1e-5), (40.5, 1e5, 1e-9), (1e6, 1e6, 0.4), (1e8, 1e9, 0.05)])
def test_far_tails_agree_with_the_leading_term_of_their_series(a: float, b: float, x: float) -> None:
    # I = x^a (1 - x)^b / (a B) F(a + b, 1; a + 1; x), whose terms fall as x (a + b) / (a + 1)
    terms, k = 1.0, 0
    total, term = 0.0, 1.0
    while term > 1e-17 * max(total, terms):
        total += term
        term *= (a + b + k) / (a + 1 + k) * x
        k += 1
    expected = a * math.log(x) + b * math.log1p(-x) - math.log(a) - float(special.betaln(a, b)) + math.log(total)
    # betaln of such arguments is right to 1e-15 of the terms it subtracts
    slack = 1e-13 * (a + b) * math.log(a + b) * 1e-2 + 1e-9
    assert float(log_betainc(a, b, x)) == pytest.approx(expected, abs=slack)
    assert float(log_betaincc(b, a, 1 - x)) == pytest.approx(expected, abs=slack + a * 2.3e-16 / x)  # 1 - x is rounded


def exact_rates(q: float, runs: int, most: int) -> tuple[float, float]:
    """False PASS and false FAIL at a true probability q, by dynamic programming over (n, S); formulas as printed."""
    S = np.arange(most, dtype=float)
    alive = np.zeros(most)
    alive[0] = 1.0
    passed = failed = 0.0
    threshold = math.log(20)
    norm = math.log(special.beta(0.5, 0.5) * special.betainc(0.5, 0.5, q))
    for n in range(1, runs + 1):
        alive = alive * (1 - q) + np.append(0.0, alive[:-1]) * q
        k = S[: min(most, n + 1)]
        k = k[alive[: k.size] > 0]
        binomial = -k * math.log(q) - (n - k) * math.log1p(-q)
        with np.errstate(divide="ignore", invalid="ignore"):
            e_pass = special.betaln(k + 0.5, n - k + 0.5) + np.log(special.betainc(k + 0.5, n - k + 0.5, q)) - norm
            e_fail = special.betaln(k, n - k + 1) + np.log(special.betaincc(k, n - k + 1, q)) - math.log(-math.log(q))
        index = k.astype(int)
        for_pass = index[e_pass + binomial >= threshold]
        for_fail = index[(e_fail + binomial >= threshold) & (k >= 1)]
        passed += alive[for_pass].sum()
        failed += alive[for_fail].sum()
        alive[for_pass] = alive[for_fail] = 0
    return 100 * passed, 100 * failed


@pytest.mark.parametrize(("q", "runs", "expected"), [(0.05, 6000, (4.537, 2.973)), (0.01, 10_000, (4.317, 2.893))])
def test_false_verdicts_come_less_often_than_stated_exactly(q: float, runs: int, expected: tuple[float, float]) -> None:
    # 1e-3 %: the last printed digit of the expected numbers
    assert exact_rates(q, runs, most=int(2.5 * q * runs) + 60) == pytest.approx(expected, abs=1e-3)


def by_hand(test: SequentialTest, failures: list[int], runs: int) -> tuple[str, int, int]:
    """The definition: evidence after every run."""
    failed = set(failures)
    S = 0
    for n in range(1, runs + 1):
        S += n - 1 in failed
        if float(log_e_fail(n, S, test.limit)) >= -math.log(test.beta):
            return "FAIL", n, S
        if float(log_e_pass(n, S, test.limit)) >= -math.log(test.alpha):
            return "PASS", n, S
    return "UNDECIDED", runs, S


@given(st.integers(0, 2**32), st.sampled_from([0.02, 0.1, 0.3, 0.8]), st.sampled_from([0.01, 0.05, 0.2, 0.9]))
def test_the_verdict_is_that_of_looking_after_every_run(seed: int, q: float, p: float) -> None:
    failures = np.flatnonzero(np.random.default_rng(seed).random(250) < p).tolist()
    test = SequentialTest(q, alpha=0.05, beta=0.02)
    assert test.crossing(failures, 250) == by_hand(test, failures, 250)


@given(st.integers(0, 2**32), st.lists(st.integers(1, 5000), max_size=8))
def test_the_verdict_does_not_depend_on_when_one_looked(seed: int, looks: list[int]) -> None:
    failures = np.flatnonzero(np.random.default_rng(seed).random(5000) < 0.012)
    test = SequentialTest(0.01)
    whole = test.crossing(failures, 5000)
    for n in [*sorted(looks), 5000]:
        part = test.crossing(failures[failures < n], n)
        if part[0] != "UNDECIDED":
            assert part == whole
            break
    else:
        assert whole[0] == "UNDECIDED"


@given(st.integers(1, 3000), st.floats(0, 1), st.floats(1e-4, 0.9))
def test_the_interval_holds_exactly_the_limits_that_are_not_rejected(n: int, share: float, q: float) -> None:
    failures = int(share * share * n)
    low, high = failure_interval(n, failures)
    rejected = float(log_e_pass(n, failures, q)) >= math.log(20) or float(log_e_fail(n, failures, q)) >= math.log(20)
    assert low <= failures / n <= high
    if not math.isclose(q, low, rel_tol=1e-9) and not math.isclose(q, high, rel_tol=1e-9):
        assert rejected == (not low <= q <= high)


@given(st.integers(1, 10**9), st.floats(0, 1), st.floats(-8, -0.3))
def test_the_rate_interval_is_the_set_of_the_formula(n: int, share: float, log_p: float) -> None:
    failures, p = int(share**4 * n), 10.0**log_p
    low, high = rate_interval(n, failures)
    assert low <= failures / n <= high
    if n <= 10**5 and not math.isclose(p, low, rel_tol=1e-6) and not math.isclose(p, high, rel_tol=1e-6):
        log_e = special.betaln(failures + 0.5, n - failures + 0.5) - math.log(math.pi)
        log_e += -failures * math.log(p) - (n - failures) * math.log1p(-p)
        assert (log_e < math.log(20)) == (low < p < high)


def test_more_failures_than_runs_are_no_interval() -> None:
    with pytest.raises(InputError, match="failures = 86: from 0 to runs = 82"):
        rate_interval(82, 86)


def test_passing_and_failing_campaigns_are_decided_in_time() -> None:
    random = np.random.default_rng(1)
    test = SequentialTest(0.01)
    for p, right in ((0.005, "PASS"), (0.02, "FAIL")):
        ends = [test.crossing(np.flatnonzero(random.random(20_000) < p), 20_000) for _ in range(200)]
        assert sum(outcome == right for outcome, _, _ in ends) >= 192  # 99 %: 192 or more with probability 0.999
        assert np.mean([n for _, n, _ in ends]) <= 25 / 0.01


def test_runs_still_needed_hold_what_then_happens_about_as_often_as_stated() -> None:
    random = np.random.default_rng(2)
    test = SequentialTest(0.01)
    held = asked = 0
    for p in (0.003, 0.02):
        for _ in range(20):
            flown = np.flatnonzero(random.random(60_000) < p)
            early = flown[flown < 400]
            if test.crossing(early, 400)[0] != "UNDECIDED":
                continue
            needed = test.still_needed(400, early.size, most=10**5, draws=50)
            _, n, _ = test.crossing(flown, 60_000)
            held += needed.low <= n - 400 <= needed.high
            asked += 1
    assert asked >= 20
    assert held >= 0.7 * asked  # nominal 80 % when p is drawn from the posterior; measured 91 % of 605


def test_counts_above_a_quantile_are_those_of_the_closed_form() -> None:
    counts = [exceedance_counts(n, 0.95) for n in (100, 1000, 10**4, 10**5)]
    assert counts == [(0, 13), (27, 77), (417, 588), (4711, 5294)]


def test_quantile_intervals_hold_the_quantile_at_all_looks_together() -> None:
    random = np.random.default_rng(3)
    truth = stats.expon.ppf(0.95)
    missed = 0
    for _ in range(300):
        flown = random.exponential(size=2000)
        ends = [quantile_interval(flown[:n], 0.95) for n in np.unique(np.geomspace(20, 2000, 20).astype(int))]
        missed += not all(low <= truth <= high for low, high in ends)
    assert missed <= 15  # 5 % of 300; measured 1.4 % in 10 000


def test_values_that_are_missing_lie_above_every_quantile() -> None:
    values = np.append(np.arange(200.0), np.full(20, np.nan))
    assert quantile_interval(values, 0.95)[1] == math.inf
    assert quantile_interval(values, 0.5)[0] >= 80


@given(st.lists(st.floats(-1e3, 1e3), min_size=1, max_size=300), st.floats(0.05, 0.95))
def test_ends_of_a_quantile_interval_leave_the_accepted_counts_above(values: list[float], level: float) -> None:
    low, high = quantile_interval(values, level)
    fewest, most = exceedance_counts(len(values), level)
    assert low <= high
    assert sum(v > low for v in values) <= most or low == -math.inf
    assert sum(v >= high for v in values) >= fewest


def test_the_band_spends_its_error_over_all_looks() -> None:
    spent = [2 * math.exp(-2 * n * half**2) for n, half in map(distribution_band, (64 << k for k in range(40)))]
    assert sum(spent) == pytest.approx(0.05 * 40 / 41)  # a telescoping sum
    assert distribution_band(63) == (0, 1.0)
    assert distribution_band(200) == distribution_band(128)


def test_only_failing_needs_a_correction_for_many_requirements() -> None:
    assert levels(0.95, 4) == pytest.approx((0.05, 0.0125))
    assert levels(0.95, 4, familywise=True) == pytest.approx((0.0125, 0.0125))
    assert together(["PASS", "UNDECIDED", "FAIL"]) == "FAIL"
    assert together(["PASS", "UNDECIDED"]) == "UNDECIDED"
    assert together(["PASS", "PASS"]) == "PASS"


def test_what_is_no_probability_or_no_run_is_refused() -> None:
    with pytest.raises(InputError, match="limit = 0: a probability"):
        SequentialTest(0.0)
    with pytest.raises(InputError, match="run numbers from 0 to 9 belong here"):
        SequentialTest(0.1).decide([10], 10)
    with pytest.raises(InputError, match="in order and each once"):
        SequentialTest(0.1).decide([3, 3], 10)
    for what in ([False, True], [0.5], [[1, 2]]):  # which runs failed, shares, columns
        with pytest.raises(InputError, match="numbers of the failing runs belong here"):
            SequentialTest(0.1).decide(what, 10)
    with pytest.raises(InputError, match="runs = -1: 0 or more"):
        SequentialTest(0.1).decide([], -1)
    with pytest.raises(InputError, match=r"level = 1\.5: between 0 and 1"):
        quantile_interval([1.0, 2.0], 1.5)


@pytest.mark.parametrize(("runs", "failures"), [(3, 4), (0, 1), (5, -1)])
def test_an_interval_of_what_is_no_count_is_refused(runs: int, failures: int) -> None:
    with pytest.raises(InputError, match=f"failures = {failures}: from 0 to runs = {runs} belongs here"):
        rate_interval(runs, failures)
    with pytest.raises(InputError, match=f"failures = {failures}: from 0 to runs = {runs} belongs here"):
        failure_interval(runs, failures)
