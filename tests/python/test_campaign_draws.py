# SPDX-License-Identifier: MIT
"""Random inputs of campaigns: the words, what is made of them, and that no input touches another."""

from __future__ import annotations

from hashlib import blake2b

import numpy as np
import pytest
from scipy import stats

import gyrostat as gs
from gyrostat import _core
from gyrostat.campaign import dist, torque_left
from gyrostat.campaign.distributions import BY_NAME, Inertia, distribution
from gyrostat.campaign.streams import NETS, Stream, Streams, name_hash, uniform, words

N = 100_000
BASE = {"duration": 1.0, "dt": 0.1, "integrator": "rk4", "faults": []}
MEASURE = {"final": {"metric": "final", "signal": "error.angle"}}


def campaign(**changes) -> gs.Campaign:
    return gs.Campaign(**{"base": "wheel2_degraded", "set": BASE, "measure": MEASURE, "seed": 7, **changes})


def philox(key: tuple[int, int], counter: tuple[int, int, int, int]) -> np.ndarray:
    """Four words of numpy's generator, which counts up before it draws."""
    number = sum(word << (64 * i) for i, word in enumerate(counter)) - 1
    before = np.array([number >> (64 * i) & (2**64 - 1) for i in range(4)], dtype=np.uint64)
    return np.random.Philox(counter=before, key=np.array(key, dtype=np.uint64)).random_raw(4)


def test_words_are_those_of_the_example() -> None:
    expected = [0x97E8FF95E512BF1D, 0xCC0500335DBB28D1, 0x5AAAB592B05B9C92, 0xC8E2F92A2FE552CA]
    assert name_hash("initial.mrp") == 0x4BB90EE972C2688A
    assert words(7, 1234, 1235, [Stream("initial.mrp", 4)])[0].tolist() == expected


def test_every_word_is_numpys_philox_with_this_key_and_counter() -> None:
    rng = np.random.default_rng(1)
    for _ in range(40):
        seed, run = (int(x) for x in rng.integers(0, 2**63, 2))
        run >>= 20
        domain, part = (int(x) for x in rng.integers(0, 5, 2))
        names = [f"name {x}" for x in rng.integers(0, 10**9, 3)]
        counts = [int(x) for x in rng.integers(1, 11, 3)]
        streams = [Stream(n, c) for n, c in zip(names, counts, strict=True)]
        made = words(seed, run, run + 2, streams, domain=domain, part=part)
        assert made.shape == (2, sum(counts))
        for row in range(2):
            expected: list[int] = []
            for name, count in zip(names, counts, strict=True):
                h = int.from_bytes(blake2b(name.encode(), digest_size=8).digest(), "little")
                blocks = [philox((seed, run + row), (j, h, part, domain)) for j in range(-(-count // 4))]
                expected += np.concatenate(blocks)[:count].tolist()
            assert made[row].tolist() == expected


def test_bad_requests_for_words_are_refused() -> None:
    with pytest.raises(ValueError, match="last lies before first"):
        _core.words(1, 2, 1, [1], [1])
    with pytest.raises(ValueError, match="differ in length"):
        _core.words(1, 0, 1, [1], [1, 2])
    with pytest.raises(ValueError, match="more words"):
        _core.words(1, 0, 2**40, [1], [1])


def test_uniform_numbers_stay_off_both_ends() -> None:
    u = uniform(np.array([0, 2**64 - 1, 2**63], dtype=np.uint64))
    assert u.tolist() == [2.0**-53, 1.0 - 2.0**-53, 0.5 + 2.0**-53]


SAMPLES = {
    "normal": (dist.normal(2.0, 0.5), stats.norm(2.0, 0.5)),
    "truncnormal": (dist.truncnormal(0.0, 1.0, -1.0, 2.5), stats.truncnorm(-1.0, 2.5)),
    "truncnormal far up": (dist.truncnormal(0.0, 1.0, 12.0, 13.0), stats.truncnorm(12.0, 13.0)),
    "truncnormal far down": (dist.truncnormal(0.0, 1.0, -14.0, -12.0), stats.truncnorm(-14.0, -12.0)),
    "lognormal": (dist.lognormal(-1.0, 0.7), stats.lognorm(0.7, scale=np.exp(-1.0))),
    "uniform": (dist.uniform(-3.0, 1.0), stats.uniform(-3.0, 4.0)),
    "loguniform": (dist.loguniform(1e-6, 1e-2), stats.loguniform(1e-6, 1e-2)),
    "exponential": (dist.exponential(0.3), stats.expon(scale=0.3)),
    "beta": (dist.beta(2.0, 3.0, low=-1.0, high=1.0), stats.beta(2.0, 3.0, loc=-1.0, scale=2.0)),
    "triangular": (dist.triangular(1.0, 1.5, 4.0), stats.triang(0.5 / 3.0, loc=1.0, scale=3.0)),
}


@pytest.mark.parametrize("name", SAMPLES)
def test_marginals_are_what_they_are_called(name: str) -> None:
    """Kolmogorov and Smirnov, against scipy's distribution functions, at 10^5 runs."""
    made, oracle = SAMPLES[name]
    x = campaign(vary={"observer.lambda1": made}).draws(0, N)["observer.lambda1"]
    assert stats.kstest(x, oracle.cdf).pvalue > 1e-4
    assert len(np.unique(x)) > 0.99 * N  # and not the ends


def test_counts_and_choices_have_their_shares() -> None:
    drawn = campaign(
        vary={
            "observer.lambda1": dist.choice([1.0, 5.0, 2.0], [0.2, 0.5, 0.3]),
            "observer.lambda2": dist.poisson(0.4, most=3),
            "controller.zeta1": dist.mixture([(0.9, 0.2), (0.1, dist.uniform(0.1, 0.2))]),
        }
    ).draws(0, N)
    counts = [np.count_nonzero(drawn["observer.lambda1"] == x) for x in (1.0, 5.0, 2.0)]
    assert stats.chisquare(counts, [0.2 * N, 0.5 * N, 0.3 * N]).pvalue > 1e-4
    counts = [np.count_nonzero(drawn["observer.lambda2"] == k) for k in range(4)]
    shares = [*stats.poisson(0.4).pmf(range(3)), stats.poisson(0.4).sf(2)]
    assert stats.chisquare(counts, np.array(shares) * N).pvalue > 1e-4
    mixed = drawn["controller.zeta1"]
    assert stats.binomtest(int(np.count_nonzero(mixed == 0.2)), N, 0.9).pvalue > 1e-4
    assert stats.kstest(mixed[mixed != 0.2], stats.uniform(0.1, 0.1).cdf).pvalue > 1e-4


def test_a_table_is_its_quantiles() -> None:
    x = campaign(vary={"observer.lambda1": dist.table([1.0, 2.0, 6.0], [0.0, 0.25, 1.0])}).draws(0, N)
    cdf = lambda v: np.interp(v, [1.0, 2.0, 6.0], [0.0, 0.25, 1.0])  # noqa: E731
    assert stats.kstest(x["observer.lambda1"], cdf).pvalue > 1e-4


@pytest.mark.parametrize("angle", [None, dist.uniform(0.1, 1.2)])
def test_attitudes(angle) -> None:
    """Uniform on SO(3): the angle has density (1 - cos) / pi; axes are uniform on the sphere in both cases."""
    drawn = campaign(vary={"initial.q_NB": dist.attitude(angle)}).draws(0, N)
    q = np.column_stack([drawn[f"initial.q_NB.{i}"] for i in range(4)])
    assert np.allclose(np.linalg.norm(q, axis=1), 1.0, atol=1e-14)
    q *= np.where(q[:, :1] < 0.0, -1.0, 1.0)
    phi = 2.0 * np.arccos(np.clip(q[:, 0], -1.0, 1.0))
    oracle = stats.uniform(0.1, 1.1).cdf if angle is not None else lambda a: (a - np.sin(a)) / np.pi
    assert stats.kstest(phi, oracle).pvalue > 1e-4
    axis = q[:, 1:] / np.linalg.norm(q[:, 1:], axis=1)[:, None]
    for i in range(3):
        assert stats.kstest(axis[:, i], stats.uniform(-1.0, 2.0).cdf).pvalue > 1e-4


@pytest.mark.parametrize("angle", [None, dist.uniform(0.0, 1.0), dist.uniform(3.2, 5.0)])
def test_attitudes_are_the_same_in_every_chart(angle) -> None:
    """MRP are the short ones, unless an angle says otherwise."""
    by = {key: campaign(vary={f"initial.{key}": dist.attitude(angle)}) for key in ("q_NB", "mrp")}
    u = by["q_NB"].points(0, 50)
    q, mrp = by["q_NB"].drawn(u).values, by["mrp"].drawn(u).values
    if angle is None:
        q *= np.where(q[:, :1] < 0.0, -1.0, 1.0)
    assert np.allclose(mrp, q[:, 1:] / (1.0 + q[:, :1]), atol=1e-13)


@pytest.mark.parametrize("spread", [0.05, 0.5])
def test_inertias_belong_to_bodies(spread: float) -> None:
    """Principal moments, by an eigenvalue solver, obey the triangle inequality; their middle is the nominal one."""
    J = np.array([[20.0, 0.0, 0.9], [0.0, 17.0, 0.0], [0.9, 0.0, 15.0]])
    drawn = (
        campaign(vary={"truth.dJ_B": dist.inertia(spread)})
        .drawn(campaign(vary={"truth.dJ_B": dist.inertia(spread)}).points(0, N))
        .values.reshape(N, 3, 3)
        + J
    )
    assert np.array_equal(drawn, drawn.transpose(0, 2, 1))
    moments = np.linalg.eigvalsh(drawn)
    assert np.all(moments[:, 0] > 0.0)
    assert np.all(moments[:, 0] + moments[:, 1] > moments[:, 2])
    if spread == 0.05:
        assert np.allclose(np.mean(drawn, axis=0), J, atol=0.02 * 20.0)
        assert 0.03 < np.std(drawn[:, 0, 0]) / 20.0 < 0.045
    assert np.allclose(Inertia(spread=0.0).draw_about(np.full((1, 6), 0.3), J)[0], J, atol=1e-13)


def test_correlations_are_those_of_normal_scores() -> None:
    keys = ["truth.viscous_friction.0", "truth.viscous_friction.2", "truth.coulomb_friction.1"]
    R = np.array([[1.0, 0.7, -0.3], [0.7, 1.0, 0.2], [-0.3, 0.2, 1.0]])
    vary = {
        "truth.viscous_friction": dist.loguniform(1e-6, 1e-4, each=4),
        "truth.coulomb_friction": dist.beta(2.0, 3.0, each=4),
    }
    drawn = campaign(vary=vary, correlated=[{"keys": keys, "matrix": R.tolist()}]).draws(0, N)
    scores = np.column_stack([stats.norm.ppf(stats.rankdata(drawn[key]) / (N + 1)) for key in keys])
    assert np.allclose(np.corrcoef(scores.T), R, atol=0.01)
    assert stats.kstest(drawn[keys[0]], stats.loguniform(1e-6, 1e-4).cdf).pvalue > 1e-4
    assert stats.kstest(drawn[keys[2]], stats.beta(2.0, 3.0).cdf).pvalue > 1e-4
    alone = campaign(vary=vary).draws(0, 100)
    for key in set(alone) - set(keys):
        assert np.array_equal(alone[key], drawn[key][:100])


FAULT = {
    "name": "wheel",
    "probability": 0.3,
    "actuator": {"dist": "choice", "of": [0, 1, 2, 3]},
    "t_on": {"dist": "uniform", "low": 0.1, "high": 0.9},
    "kind": [
        {"weight": 0.6, "type": "loss_of_effectiveness", "remaining": {"dist": "beta", "a": 2.0, "b": 3.0}},
        {"weight": 0.3, "type": "lock"},
        {"weight": 0.1, "type": "stuck", "torque": {"dist": "uniform", "low": -0.1, "high": 0.1}},
    ],
}
BUS = {
    "name": "bus",
    "probability": 0.05,
    "actuators": [0, 1],
    "t_on": {"dist": "uniform", "low": 0.1, "high": 0.9},
    "delay": {"dist": "exponential", "mean": 0.5},
    "kind": [{"type": "dead"}],
}


def test_faults_happen_as_often_as_they_should() -> None:
    drawn = campaign(faults=[FAULT]).draws(0, N)
    kind = drawn["fault.wheel.0.kind"]
    counts = [np.count_nonzero(kind == k) for k in ("none", "loss_of_effectiveness", "lock", "stuck")]
    assert stats.chisquare(counts, N * np.array([0.7, 0.18, 0.09, 0.03])).pvalue > 1e-4
    happens = kind != "none"
    assert np.all(drawn["fault.wheel.0.t_on"][~happens] == np.inf)
    assert np.all(drawn["fault.wheel.0.actuator"][~happens] == -1)
    who = drawn["fault.wheel.0.actuator"][happens]
    assert stats.chisquare([np.count_nonzero(who == i) for i in range(4)]).pvalue > 1e-4
    weak = kind == "loss_of_effectiveness"
    remaining = drawn["fault.wheel.0.loss_of_effectiveness.remaining"]
    assert np.array_equal(np.isnan(remaining), ~weak)
    assert stats.kstest(remaining[weak], stats.beta(2.0, 3.0).cdf).pvalue > 1e-4


def test_counted_faults_of_distinct_actuators() -> None:
    """Each pair of four is as likely; a count is the number of occurrences."""
    fault = {k: v for k, v in FAULT.items() if k != "probability"} | {
        "count": {"dist": "poisson", "mean": 0.8, "most": 3},
        "distinct": True,
        "kind": [{"type": "lock"}],
    }
    drawn = campaign(faults=[fault]).draws(0, N)
    happens = np.column_stack([drawn[f"fault.wheel.{k}.kind"] != "none" for k in range(3)])
    assert np.all(happens[:, :-1] >= happens[:, 1:])
    shares = [*stats.poisson(0.8).pmf(range(3)), stats.poisson(0.8).sf(2)]
    assert stats.chisquare(np.bincount(happens.sum(axis=1)), np.array(shares) * N).pvalue > 1e-4
    who = np.column_stack([drawn[f"fault.wheel.{k}.actuator"] for k in range(3)])
    two = who[happens[:, 1]][:, :2]
    pairs = two[:, 0] * 4 + two[:, 1]
    counts = np.bincount(pairs, minlength=16).reshape(4, 4)
    assert np.all(np.diag(counts) == 0)
    assert stats.chisquare(counts[~np.eye(4, dtype=bool)]).pvalue > 1e-4


def test_a_common_cause_strikes_all_of_its_actuators_at_once() -> None:
    made = campaign(faults=[BUS])
    drawn = made.draws(0, 2000)
    (run, *_) = np.flatnonzero(drawn["fault.bus.0.kind"] == "dead")
    faults = made.scenario(int(run)).to_dict()["faults"]
    assert [f["actuator"] for f in faults] == [0, 1]
    for i, fault in enumerate(faults):
        assert fault["type"] == "dead"
        assert fault["t_on"] == drawn["fault.bus.0.t_on"][run] + drawn[f"fault.bus.0.delay.{i}"][run]
    assert faults[0]["t_on"] != faults[1]["t_on"]


VARY = {
    "initial.omega_BN_B": dist.normal(0.0, 0.01, each=3),
    "initial.q_NB": dist.attitude(dist.uniform(0.1, 1.2)),
    "truth.dJ_B": dist.inertia(0.05),
    "truth.viscous_friction": dist.loguniform(1e-6, 1e-4, each=4),
    "disturbances.0.torque_B": dist.truncnormal(0.0, 1e-3, -3e-3, 3e-3, each=3),
    "vehicle.u_max": dist.mixture([(0.9, 0.2), (0.1, dist.uniform(0.1, 0.2))]),
}


def equal(a: np.ndarray, b: np.ndarray) -> bool:
    return bool(np.all((a == b) | ((a != a) & (b != b))))  # noqa: PLR0124


def test_a_run_drawn_alone_is_drawn_as_among_others() -> None:
    made = campaign(vary=VARY, faults=[FAULT, BUS])
    many = made.draws(0, 1500)
    for i in [0, 1, 2, 3, 499, 777, 1499]:
        for name, x in made.draws(i, i + 1).items():
            assert equal(x, many[name][i : i + 1]), name
    for name, x in made.draws(501, 1011).items():
        assert equal(x, many[name][501:1011]), name


def test_another_input_changes_no_other_column() -> None:
    vary = dict(VARY)
    few = campaign(vary={k: vary[k] for k in ("truth.dJ_B", "initial.omega_BN_B")}, faults=[FAULT]).draws(0, 300)
    turned = dict(reversed(vary.items()))
    many = campaign(vary=turned | {"observer.lambda1": dist.uniform(1.0, 2.0)}, faults=[BUS, FAULT]).draws(0, 300)
    assert set(few) < set(many)
    for name, x in few.items():
        assert equal(x, many[name]), name


def test_seeds_draw_otherwise() -> None:
    a, b = (campaign(vary=VARY, seed=s).draws(0, 200)["initial.omega_BN_B.0"] for s in (1, 2))
    assert not np.any(a == b)


def test_every_stratum_of_a_latin_hypercube_is_hit_once() -> None:
    made = campaign(vary=VARY, sampling="lhs", replicates=3, points=64)
    u = made.points(0, 192)
    for r in range(3):
        strata = np.sort(np.floor(u[64 * r : 64 * (r + 1)] * 64.0), axis=0)
        assert np.array_equal(strata, np.repeat(np.arange(64.0)[:, None], made.dimension, axis=1))
    assert np.array_equal(made.points(60, 70), u[60:70])
    order = words(7, 1, 2, [Stream("initial.omega_BN_B", 64)], domain=NETS, part=2)[0]
    column = made.inputs.index("initial.omega_BN_B[2]")
    assert np.array_equal(np.floor(u[64:128, column] * 64.0), np.argsort(order, kind="stable"))


def test_nets_of_sobol_fill_every_box() -> None:
    """The first two dimensions of a scrambled net of 2^6 points: one in each box of 8 x 8."""
    made = campaign(vary=VARY, sampling="sobol", replicates=2, points=64)
    u = made.points(0, 128)
    assert np.array_equal(made.points(50, 90), u[50:90])
    assert np.all((u > 0.0) & (u < 1.0))
    assert not np.array_equal(u[:64], u[64:])
    for r in range(2):
        boxes = np.floor(u[64 * r : 64 * (r + 1), :2] * 8.0) @ [8.0, 1.0]
        assert np.array_equal(np.sort(boxes), np.arange(64.0))


def test_two_streams_of_one_name_are_refused() -> None:
    with pytest.raises(gs.InputError, match="two inputs are called 'a'"):
        Streams((Stream("a", 1), Stream("a", 2)))


@pytest.mark.parametrize("name", sorted(BY_NAME))
def test_every_distribution_reads_what_it_writes(name: str) -> None:
    examples = {
        "normal": dist.normal(0.0, 1.0, each=2),
        "truncnormal": dist.truncnormal(0.0, 1.0, -1.0, 1.0),
        "lognormal": dist.lognormal(0.0, 1.0),
        "uniform": dist.uniform(0.0, 1.0),
        "loguniform": dist.loguniform(1.0, 2.0),
        "exponential": dist.exponential(1.0),
        "beta": dist.beta(2.0, 3.0, high=2.0),
        "triangular": dist.triangular(0.0, 0.5, 1.0),
        "choice": dist.choice([1.0, 2.0], [0.5, 0.5]),
        "poisson": dist.poisson(1.0, most=2),
        "table": dist.table([1.0, 2.0]),
        "mixture": dist.mixture([(0.5, 1.0), (0.5, dist.normal(0.0, 1.0))]),
        "attitude": dist.attitude(dist.uniform(0.0, 1.0)),
        "inertia": dist.inertia(0.1),
    }
    made = examples[name]
    again = distribution(made.table())
    assert again.table() == made.table()
    u = np.random.default_rng(3).uniform(size=(20, made.words))
    if name != "inertia":
        assert np.array_equal(again.draw(u), made.draw(u))


def test_the_torque_left_is_the_least_over_all_directions() -> None:
    """Against the support of the commands that are left, over many directions; and where nothing happens."""
    kinds = [
        {"weight": 0.25, "type": "loss_of_effectiveness", "remaining": {"dist": "uniform", "low": 0.0, "high": 0.8}},
        {"weight": 0.25, "type": "stuck", "torque": {"dist": "uniform", "low": -0.08, "high": 0.08}},
        {"weight": 0.25, "type": "bias", "torque": 0.05},
        {"weight": 0.25, "type": "hard_over", "sign": -1},
    ]
    fault = {"name": "a-b", "probability": 0.8, "actuator": 2, "t_on": 1.0, "kind": kinds}
    pair = {"name": "pair", "probability": 0.2, "actuators": [0, 1], "t_on": 1.0, "kind": [{"type": "dead"}]}
    campaign = gs.Campaign("wheel2_degraded", set={"faults": []}, faults=[fault, pair])
    D = np.array(campaign.base.vehicle.D_B)
    v = np.random.default_rng(1).standard_normal((40_000, 3))
    v /= np.linalg.norm(v, axis=1)[:, None]
    left = torque_left(campaign, 0, 60)
    columns = campaign.draws(0, 60)
    for run in range(60):
        gain, bias = np.ones(4), np.zeros(4)
        kind = columns["fault.a-b.0.kind"][run]
        if kind == "loss_of_effectiveness":
            gain[2] = columns["fault.a-b.0.loss_of_effectiveness.remaining"][run]
        elif kind != "none":
            gain[2] = kind == "bias"
            stuck = columns["fault.a-b.0.stuck.torque"][run]
            bias[2] = {"stuck": stuck, "bias": 0.05, "hard_over": -0.2}[str(kind)]
        if columns["fault.pair.0.kind"][run] == "dead":
            gain[:2] = 0.0
        reach = np.abs(v @ D) @ (gain * 0.2) + v @ D @ bias
        if np.linalg.matrix_rank(D * gain) < 3:
            assert left[run] <= 1e-12
        else:
            assert left[run] - 1e-9 <= reach.min() / 0.2 <= left[run] + 0.02
    healthy = columns["fault.a-b.0.kind"] == "none"
    assert np.ptp(left[healthy & (columns["fault.pair.0.kind"] == "none")]) == 0.0
