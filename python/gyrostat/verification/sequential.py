# SPDX-License-Identifier: MIT
"""Verdicts and intervals that stay valid however often one looks.

A limit q on a failure probability is tested by two mixtures of likelihood ratios against q: one over all smaller
probabilities, one over all larger ones. Under a true probability on the other side each is a supermartingale, so that
by Ville's inequality it ever exceeds 1/alpha with probability alpha at most, at whatever run one stops: Robbins 1970,
Ann. Math. Statist. 41; Howard et al. 2021, Ann. Statist. 49. Page: docs/verification.md
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy import special

from gyrostat.errors import InputError
from gyrostat.verification.incomplete_beta import log_beta_ratio, log_betainc, log_betaincc

Outcome = Literal["PASS", "FAIL", "UNDECIDED"]
Floats = NDArray[np.float64]
Counts = NDArray[np.int64]

FIRST_LOOK = 64
"""Runs at the first look of `distribution_band`; each later one is at twice as many."""
_MOST = 2**62
"""Runs; no boundary lies beyond."""


def log_e_pass(runs: ArrayLike, failures: ArrayLike, limit: ArrayLike) -> Floats:
    """Log evidence that failures are rarer than the limit: the mixture over (0, limit).

    The density of the mixture is that of Jeffreys, p^-1/2 (1 - p)^-1/2, cut off at the limit.

    Parameters
    ----------
    runs, failures
        Whole numbers, ``0 <= failures <= runs``; arrays broadcast.
    limit
        Failure probability q, in (0, 1).
    """
    n, S, q = (np.asarray(v, float) for v in (runs, failures, limit))
    a, b = S + 0.5, n - S + 0.5
    truncation = np.log(special.betainc(0.5, 0.5, q)) + math.log(math.pi)
    return np.asarray(log_beta_ratio(a, b, q) + log_betainc(a, b, q) + 0.5 * (np.log(q) + np.log1p(-q)) - truncation)


def log_e_fail(runs: ArrayLike, failures: ArrayLike, limit: ArrayLike) -> Floats:
    """Log evidence that failures are more frequent than the limit: the mixture over (limit, 1), of density 1/p.

    Minus infinity without a failure. Parameters as of `log_e_pass`.
    """
    n, S, q = np.broadcast_arrays(*(np.asarray(v, float) for v in (runs, failures, limit)))
    a, b = np.maximum(S, 1.0), n - S + 1
    log = log_beta_ratio(a, b, q) + log_betaincc(a, b, q) + np.log1p(-q) - np.log(-np.log(q))
    return np.asarray(np.where(S >= 1, log, -np.inf))


def runs_to_pass(failures: ArrayLike, limit: float, alpha: float) -> Counts:
    """Runs n_pass(S) after which S failures, and no more of them, make a PASS.

    Parameters
    ----------
    failures
        S, shape (m,) or a number.
    limit
        Failure probability.
    alpha
        Probability of a false PASS.

    Returns
    -------
    ndarray
        Smallest numbers of runs, shape (m,); 2^62 if no number suffices.
    """
    S = np.atleast_1d(np.asarray(failures, np.int64))

    def passed(n: Counts) -> NDArray[np.bool_]:
        return log_e_pass(n, S, limit) >= -math.log(alpha)

    low = np.maximum(S - 1, -1)  # not yet
    return _first(passed, low, 8 + (S + 4 * np.sqrt(S + 4.0)) / limit)


def runs_to_fail(failures: ArrayLike, limit: float, beta: float) -> Counts:
    """Runs n_fail(S) up to which failure number S makes a FAIL; S - 1 if it never does so alone.

    Parameters as of `runs_to_pass`; `beta` is the probability of a false FAIL.
    """
    S = np.atleast_1d(np.asarray(failures, np.int64))

    def no_longer(n: Counts) -> NDArray[np.bool_]:
        return log_e_fail(n, S, limit) < -math.log(beta)

    return _first(no_longer, S - 1, 8 + S / limit) - 1


def _first(reached: Callable[[Counts], NDArray[np.bool_]], low: Counts, guess: Floats) -> Counts:
    """Smallest n above `low` for which a monotone test holds, by doubling and bisection; all at once."""
    low = low.astype(np.int64)
    high = np.minimum(guess, 2.0**61).astype(np.int64) + low + 1
    while not (there := reached(high) | (high >= _MOST)).all():
        low, high = np.where(there, low, high), np.where(there, high, np.where(high < _MOST // 2, 2 * high, _MOST))
    while (open_ := high - low > 1).any():
        middle = np.where(open_, low + (high - low) // 2, high)
        there = reached(middle)
        low, high = np.where(open_ & ~there, middle, low), np.where(open_ & there, middle, high)
    return high


@dataclass(frozen=True)
class Verdict:
    """What a sequential test says of a limit.

    Attributes
    ----------
    outcome
        PASS, FAIL or UNDECIDED.
    runs, failures
        At the first crossing, where the verdict was latched; all that were given when undecided.
    limit
        Failure probability that was tested.
    log_e_pass, log_e_fail
        Evidence there.
    interval
        Limits that neither test rejects there. Each end is valid at every run with its own level.
    """

    outcome: Outcome
    runs: int
    failures: int
    limit: float
    log_e_pass: float
    log_e_fail: float
    interval: tuple[float, float]


@dataclass(frozen=True)
class Needed:
    """Runs that a test will still take, as far as the flown ones tell.

    Attributes
    ----------
    low, median, high
        10 %, 50 % and 90 % of continuations drawn from the posterior; infinite: more than `most`.
    most
        Runs beyond which nothing was drawn.
    passing
        Share of continuations that end in PASS.
    """

    low: float
    median: float
    high: float
    most: int
    passing: float


@dataclass(frozen=True)
class SequentialTest:
    """Is the failure probability at most the limit? Looked at after every run, latched at the first crossing.

    Attributes
    ----------
    limit
        Failure probability q, in (0, 1).
    alpha
        Probability of a false PASS at most.
    beta
        Probability of a false FAIL at most.
    """

    limit: float
    alpha: float = 0.05
    beta: float = 0.05

    def __post_init__(self) -> None:
        for name in ("limit", "alpha", "beta"):
            value = getattr(self, name)
            if not 0 < value < 1:
                raise InputError(f"{name} = {value:g}: a probability between 0 and 1, ends excluded, belongs here")

    def decide(self, failures: ArrayLike, runs: int) -> Verdict:
        """The verdict after `runs` runs.

        It depends on the numbers of the failing runs alone: not on how the runs were divided or when one looked.

        Parameters
        ----------
        failures
            Numbers of the runs that failed, from 0, in order.
        runs
            Runs flown, the numbers 0 to ``runs - 1``.
        """
        return self._verdict(*self.crossing(failures, runs))

    def crossing(self, failures: ArrayLike, runs: int) -> tuple[Outcome, int, int]:
        """As `decide`: the outcome, and runs and failures at the first crossing."""
        numbers = _run_numbers(failures, runs)
        first, block = 0, 64
        while first <= numbers.size:
            S = np.arange(first, min(first + block, numbers.size + 1))
            first, block = first + block, min(2 * block, 65536)  # short campaigns end soon
            ends = np.append(numbers, runs)[S]  # runs before the next failure, or all
            passed = log_e_pass(ends, S, self.limit) >= -math.log(self.alpha)
            failed = log_e_fail(np.append(0, numbers + 1)[S], S, self.limit) >= -math.log(self.beta)
            if crossed := np.flatnonzero(passed | failed).tolist():
                at = int(S[crossed[0]])
                if failed[crossed[0]]:
                    return "FAIL", int(numbers[at - 1]) + 1, at
                return "PASS", int(runs_to_pass(at, self.limit, self.alpha)[0]), at
        return "UNDECIDED", runs, numbers.size

    def evidence(self, failures: ArrayLike, runs: int, points: int = 400) -> tuple[Counts, Floats, Floats]:
        """Evidence against runs, for a picture: runs, log evidence for PASS and for FAIL, shape (points,) at most."""
        at = np.unique(np.geomspace(1, max(runs, 1), points).astype(np.int64))
        S = np.searchsorted(np.asarray(failures, np.int64), at)
        return at, log_e_pass(at, S, self.limit), log_e_fail(at, S, self.limit)

    def interval(self, runs: int, failures: int) -> tuple[float, float]:
        """Limits that neither test rejects: their verdict after these runs would be UNDECIDED.

        The lower end misses a true probability with probability beta, the upper one with alpha, at whatever runs one
        looks; both together with alpha + beta at most.
        """
        return failure_interval(runs, failures, self.alpha, self.beta)

    def still_needed(self, runs: int, failures: int, *, most: int, draws: int = 200, seed: int = 0) -> Needed:
        """Runs still needed, with their spread.

        Failure probabilities are drawn from the posterior Beta(S + 1/2, n - S + 1/2), and each is continued at random
        to the first boundary.

        Parameters
        ----------
        runs, failures
            So far, undecided.
        most
            Further runs beyond which a continuation counts as more than that; so does one of 50 000 further failures.
        draws
            Continuations.
        seed
            Of the draws: the same numbers for the same input.
        """
        random = np.random.Generator(np.random.Philox(key=np.array([seed, runs], np.uint64)))
        p = random.beta(failures + 0.5, runs - failures + 0.5, draws)
        p = np.maximum(p, 1e-18)
        ended = np.full(draws, np.inf)
        passing = np.zeros(draws, bool)
        last = np.full(draws, runs, np.int64)  # runs up to and with the failure that came last
        going = np.arange(draws)
        S, block = failures, 32
        while going.size:
            counts = S + np.arange(block + 1)
            to_pass = runs_to_pass(counts, self.limit, self.alpha)
            to_fail = runs_to_fail(counts[1:], self.limit, self.beta)
            gaps = np.minimum(random.geometric(p[going, None], (going.size, block)), most + 1)
            at = last[going, None] + np.cumsum(gaps, axis=1)
            passed = at > to_pass[:-1]  # before this failure
            failed = at <= to_fail
            crossed = passed | failed
            first = np.argmax(crossed, axis=1)
            rows = np.arange(going.size)
            done = crossed[rows, first]
            end = np.where(passed[rows, first], to_pass[first], at[rows, first]) - runs
            within = done & (end <= most)
            ended[going[within]] = end[within]
            passing[going[within]] = passed[rows, first][within]
            last[going] = at[:, -1]
            going = going[~done & (at[:, -1] - runs <= most) & (S + block - failures < 50_000)]
            S, block = S + block, min(2 * block, 4096)
        low, median, high = np.quantile(ended, [0.1, 0.5, 0.9], method="inverted_cdf")
        return Needed(float(low), float(median), float(high), most, float(passing.mean()))

    def _verdict(self, outcome: Outcome, runs: int, failures: int) -> Verdict:
        return Verdict(
            outcome,
            runs,
            failures,
            self.limit,
            float(log_e_pass(runs, failures, self.limit)),
            float(log_e_fail(runs, failures, self.limit)),
            self.interval(runs, failures),
        )


def failure_interval(runs: int, failures: int, alpha: float = 0.05, beta: float = 0.05) -> tuple[float, float]:
    """Limits that neither one-sided test rejects, by bisection. See `SequentialTest.interval`.

    Raises
    ------
    InputError
        More failures than runs.
    """
    n, S = _counts(runs, failures)
    if n == 0:
        return 0.0, 1.0
    low, high = 0.0, 1.0
    if S > 0:
        low = _bisect(lambda q: float(log_e_fail(n, S, q)) >= -math.log(beta), inside=S / n, outside=0.0)
    if n > S:
        high = _bisect(lambda q: float(log_e_pass(n, S, q)) >= -math.log(alpha), inside=S / n, outside=1.0)
    return low, high


def rate_interval(runs: int, failures: int, alpha: float = 0.05) -> tuple[float, float]:
    """Two-sided interval of a rate without a limit, valid at every run (Robbins' beta-binomial mixture).

    Parameters
    ----------
    runs, failures
        Whole numbers, ``0 <= failures <= runs``.
    alpha
        Probability that the interval ever misses the true rate, at most.

    Raises
    ------
    InputError
        More failures than runs.
    """
    n, S = _counts(runs, failures)
    if n == 0:
        return 0.0, 1.0

    def rejected(p: float) -> bool:
        return float(_log_e_rate(n, S, p)) >= -math.log(alpha)

    low = _bisect(rejected, inside=S / n, outside=0.0) if S > 0 else 0.0
    high = _bisect(rejected, inside=S / n, outside=1.0) if n > S else 1.0
    return low, high


def _counts(runs: int, failures: int) -> tuple[int, int]:
    if not 0 <= failures <= runs:
        raise InputError(f"failures = {failures}: from 0 to runs = {runs} belongs here")
    return runs, failures


def _run_numbers(failures: ArrayLike, runs: int) -> Counts:
    numbers = np.asarray(failures)
    if runs < 0:
        raise InputError(f"runs = {runs}: 0 or more belongs here")
    if numbers.ndim != 1 or (numbers.size and numbers.dtype.kind not in "iu"):
        raise InputError("failures: numbers of the failing runs belong here, whole ones in a list")
    numbers = numbers.astype(np.int64)
    if numbers.size and (numbers[0] < 0 or numbers[-1] >= runs or (np.diff(numbers) <= 0).any()):
        raise InputError(f"failures: run numbers from 0 to {runs - 1} belong here, in order and each once")
    return numbers


def _log_e_rate(n: ArrayLike, S: ArrayLike, p: float) -> Floats:
    ratio = log_beta_ratio(np.asarray(S, float) + 0.5, np.asarray(n, float) - S + 0.5, p)
    return np.asarray(ratio + 0.5 * (math.log(p) + math.log1p(-p)) - math.log(math.pi))


def _bisect(rejected: Callable[[float], bool], *, inside: float, outside: float) -> float:
    """The end of the accepted side between an estimate that is accepted and an end, in log odds."""
    odds = [
        math.log(p / (1 - p)) if 0 < p < 1 else math.copysign(700 if p < 0.5 else 36, p - 0.5)
        for p in (inside, outside)
    ]
    good, bad = odds
    if not rejected(float(special.expit(bad))):
        return outside
    for _ in range(200):
        middle = 0.5 * (good + bad)
        if middle in (good, bad):
            break
        if rejected(float(special.expit(middle))):
            bad = middle
        else:
            good = middle
    return float(special.expit(good))


def exceedance_counts(runs: int, level: float, alpha: float = 0.05) -> tuple[int, int]:
    """Numbers of runs above the true quantile that the two-sided mixture does not reject.

    Parameters
    ----------
    runs
        n.
    level
        Of the quantile, tau: a run is above it with probability 1 - tau.
    alpha
        Probability of ever missing it, at most.

    Raises
    ------
    InputError
        A level that is not between 0 and 1.
    """
    if not 0 < level < 1:
        raise InputError(f"level = {level:g}: between 0 and 1, ends excluded, belongs here")
    if runs == 0:
        return 0, 0
    p, threshold = 1 - level, -math.log(alpha)
    centre = min(max(round(runs * p), 0), runs)
    below = _edge(lambda k: float(_log_e_rate(runs, k, p)) >= threshold, centre, 0)
    above = _edge(lambda k: float(_log_e_rate(runs, k, p)) >= threshold, centre, runs)
    return below, above


def _edge(rejected: Callable[[int], bool], inside: int, outside: int) -> int:
    if not rejected(outside):
        return outside
    good, bad = inside, outside
    while abs(good - bad) > 1:
        middle = (good + bad) // 2
        good, bad = (good, middle) if rejected(middle) else (middle, bad)
    return good


def quantile_interval(values: ArrayLike, level: float, alpha: float = 0.05) -> tuple[float, float]:
    """Interval of a quantile from order statistics, valid at every run and for any distribution.

    Parameters
    ----------
    values
        Of all runs, shape (n,); nan, no value, counts as larger than every number.
    level
        Of the quantile, in (0, 1).
    alpha
        Probability of ever missing it, at most.
    """
    ordered = np.sort(np.nan_to_num(np.asarray(values, float), nan=np.inf, posinf=np.inf, neginf=-np.inf))
    n = ordered.size
    fewest, most = exceedance_counts(n, level, alpha)
    low = -np.inf if most >= n else float(ordered[n - most - 1])
    high = np.inf if fewest <= 0 else float(ordered[n - fewest])
    return low, high


def distribution_band(runs: int, alpha: float = 0.05) -> tuple[int, float]:
    """Half-width of the band of a whole distribution function, of Dvoretzky, Kiefer, Wolfowitz and Massart.

    One looks at 64, 128, 256, ... runs and spends ``alpha / ((k + 1)(k + 2))`` at look k, so that the band holds at all
    looks together with probability 1 - alpha; between two looks the earlier band stands.

    Parameters
    ----------
    runs
        Flown.
    alpha
        Probability of ever missing the distribution, at most.

    Returns
    -------
    tuple of int and float
        How many first runs the band is about, and its half-width; 0 and 1 before the first look.
    """
    if runs < FIRST_LOOK:
        return 0, 1.0
    look = int(runs // FIRST_LOOK).bit_length() - 1
    n = FIRST_LOOK << look
    spent = alpha / ((look + 1) * (look + 2))
    return n, math.sqrt(math.log(2 / spent) / (2 * n))


def levels(confidence: float, requirements: int, *, familywise: bool = False) -> tuple[float, float]:
    """Levels alpha and beta of each of several requirements.

    "All PASS" needs no correction: every single false PASS has to happen. "Any FAIL" does, so beta is divided by
    their number; `familywise` divides alpha too, so that not even one false PASS comes more often than stated.
    """
    alpha = beta = 1 - confidence
    return alpha / requirements if familywise else alpha, beta / requirements


def together(outcomes: Sequence[Outcome]) -> Outcome:
    """The verdict on several requirements: FAIL if any fails, PASS if all pass."""
    if "FAIL" in outcomes:
        return "FAIL"
    return "PASS" if all(outcome == "PASS" for outcome in outcomes) else "UNDECIDED"


__all__ = [
    "Needed",
    "Outcome",
    "SequentialTest",
    "Verdict",
    "distribution_band",
    "exceedance_counts",
    "failure_interval",
    "levels",
    "log_e_fail",
    "log_e_pass",
    "quantile_interval",
    "rate_interval",
    "runs_to_fail",
    "runs_to_pass",
    "together",
]
