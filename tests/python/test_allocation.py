# SPDX-License-Identifier: MIT
"""Allocation on arrays: optimality proven from the returned numbers, shapes, the attainable set against samples."""

from __future__ import annotations

import json
import runpy
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import linprog
from scipy.spatial import ConvexHull
from typer.testing import CliRunner

import gyrostat as gs
from gyrostat import allocation
from gyrostat.cli import app
from gyrostat.design import attainable_after_faults, torque_findings

ROOT = Path(__file__).parents[2]
PYRAMID = np.array([[1, 1, -1, -1], [1, -1, -1, 1], [1, 1, 1, 1]]) / np.sqrt(3.0)
MODES = ("lexicographic", "lexicographic_scaled", "weighted_least_squares", "robust_socp")


def problem(seed: int, rows: int, n: int) -> dict[str, Any]:
    """Half of the demands can be had; some actuators are dead. As posed: weak axes are not dropped."""
    rng = np.random.default_rng(seed)
    D = rng.normal(size=(rows, n))
    D /= np.linalg.norm(D, axis=0)
    e = np.where(rng.random(n) < 0.1, 0.0, rng.uniform(0.2, 1.0, n))
    up, lo = rng.uniform(0.1, 0.3, n), -rng.uniform(0.1, 0.3, n)
    inside = D @ (e * rng.uniform(lo, up))
    return {
        "D": D,
        "demand": inside * rng.choice([0.5, 1.0, 2.0, 4.0]),
        "up": up,
        "lo": lo,
        "effectiveness": e,
        "preferred": rng.uniform(-0.1, 0.1, n) * rng.integers(0, 2),
        "effort_weight": np.exp(rng.uniform(-1, 1, n)),
        "bound": rng.uniform(0, 0.3, n),
        "rank_tolerance": 0.0,
    }


problems = st.builds(problem, st.integers(0, 2**32 - 1), st.just(3), st.integers(3, 16)) | st.builds(
    problem, st.integers(0, 2**32 - 1), st.just(6), st.integers(6, 16)
)


def exact(values: Any) -> Any:
    """Rational numbers: what is computed with them has no rounding."""
    return np.vectorize(Fraction, otypes=[object])(np.asarray(values, float))


def box_minimum(p: dict[str, Any], slope: Any) -> Fraction:
    """sum of min over the box of weight/2 (u - preferred)^2 + slope u, without rounding."""
    w, mid = exact(p["effort_weight"]), exact(p["preferred"])
    u = np.minimum(np.maximum(mid - slope / w, exact(p["lo"])), exact(p["up"]))
    return Fraction(sum(w / 2 * (u - mid) ** 2 + slope * u))


def axes(p: dict[str, Any]) -> Any:
    return exact(p["D"]) * exact(p["effectiveness"])


def effort(p: dict[str, Any], u: Any) -> Fraction:
    return Fraction(sum(exact(p["effort_weight"]) / 2 * (exact(u) - exact(p["preferred"])) ** 2))


@settings(max_examples=150)
@given(problems)
def test_weighted_least_squares_is_within_its_proof(p: dict[str, Any]) -> None:
    s = allocation.solve(**p, mode="weighted_least_squares", residual_weight=1e4)
    A, u, y, gamma = axes(p), exact(s.command), exact(s.multiplier), Fraction(float(s.residual_weight))
    r = exact(p["demand"]) - A @ u
    primal = effort(p, s.command) + gamma / 2 * (r @ r)
    dual = y @ exact(p["demand"]) - (y @ y) / (2 * gamma) + box_minimum(p, -(A.T @ y))
    assert primal - dual >= 0  # exact arithmetic: the bound is a bound without any tolerance
    assert float(primal - dual) <= 1e-12 * float(primal)
    assert s.primal == pytest.approx(float(primal), rel=1e-11)


@settings(max_examples=150)
@given(problems)
def test_no_torque_in_reach_is_closer_than_the_lexicographic_one(p: dict[str, Any]) -> None:
    s = allocation.solve(**p)
    A = p["D"] * p["effectiveness"]
    r = p["demand"] - A @ s.command
    scale = np.abs(A).sum() * 0.3 + np.abs(p["demand"]).max()
    np.testing.assert_allclose(s.residual, r, atol=1e-14 * scale)
    if s.status == "optimal":
        assert np.linalg.norm(r) <= 1e-10 * scale
        return
    v = s.infeasibility_direction if s.infeasibility_direction.any() else r
    v = v / np.linalg.norm(v)
    support = np.maximum(v @ A * p["up"], v @ A * p["lo"]).sum()
    assert np.linalg.norm(r) - max(v @ p["demand"] - support, 0) <= 1e-10 * scale


@settings(max_examples=100)
@given(problems)
def test_effort_is_least_for_what_is_delivered(p: dict[str, Any]) -> None:
    s = allocation.solve(**p)
    A, u, y = axes(p), exact(s.command), exact(s.multiplier)
    bound = y @ (A @ u) + box_minimum(p, -(A.T @ y))
    size = float(effort(p, p["up"]) + effort(p, p["lo"]))
    assert effort(p, s.command) - bound >= 0
    assert float(effort(p, s.command) - bound) <= 1e-10 * size


@settings(max_examples=100)
@given(problems, st.floats(1.0, 5.0))
def test_robust_objective_is_within_its_proof(p: dict[str, Any], log_weight: float) -> None:
    h = 10**log_weight
    s = allocation.solve(**p, mode="robust_socp", residual_weight=h)
    A = p["D"] * p["effectiveness"]
    s_max = np.linalg.norm(p["D"] * (p["effectiveness"] > 0), 2)  # what cannot act adds no error
    g = p["bound"] * p["effectiveness"]
    worst = np.linalg.norm(p["demand"] - A @ s.command) + s_max * np.linalg.norm(g * s.command)
    assert s.worst_case == pytest.approx(worst, rel=1e-10)
    primal = float(effort(p, s.command)) + h / 2 * worst**2
    z = -s.multiplier / h
    sigma = s_max**2 * g * s.command / s.theta if s.theta > 0 else 0 * g
    kappa2 = z @ z + max(0.0, (sigma @ sigma) / s_max**2 - z @ z)
    dual = -h * (z @ p["demand"] + kappa2 / 2) + float(box_minimum(p, exact(h * (A.T @ z + g * sigma))))
    assert -1e-10 * primal <= primal - dual <= 1e-8 * primal


@settings(max_examples=100)
@given(problems)
def test_scaled_share_is_what_a_linear_program_finds(p: dict[str, Any]) -> None:
    s = allocation.solve(**p, mode="lexicographic_scaled")
    A = p["D"] * p["effectiveness"]
    n = A.shape[1]
    scale = np.abs(A).sum() * 0.3 + np.abs(p["demand"]).max()
    np.testing.assert_allclose(s.achieved, s.scale * p["demand"], atol=1e-9 * scale)
    lp = linprog(
        np.append(np.zeros(n), -1.0),
        A_eq=np.column_stack([A, -p["demand"]]),
        b_eq=np.zeros(len(A)),
        bounds=[*zip(p["lo"], p["up"], strict=True), (0.0, 1.0)],
    )
    if lp.status == 0:  # a rank-deficient program may fail there
        assert float(s.scale) == pytest.approx(lp.x[-1], abs=1e-6)  # the simplex's own tolerance


@settings(max_examples=60)
@given(problems, st.sampled_from(MODES), st.data())
def test_commands_stay_in_the_box_whatever_the_input(
    p: dict[str, Any], mode: allocation.Mode, data: st.DataObject
) -> None:
    wild = st.floats(allow_nan=True, allow_infinity=True)
    for key in ("demand", "preferred", "effectiveness", "effort_weight", "bound"):
        if data.draw(st.booleans(), label=key):
            p[key] = p[key].copy()
            p[key][data.draw(st.integers(0, len(p[key]) - 1))] = data.draw(wild)
    s = allocation.solve(**p, mode=mode)
    assert np.all((p["lo"] <= s.command) & (s.command <= p["up"]))


@pytest.mark.parametrize("mode", MODES)
def test_a_batch_is_its_problems_one_by_one(mode: allocation.Mode) -> None:
    rng = np.random.default_rng(1)
    demand, e = rng.normal(size=(5, 1, 3)) * 0.2, rng.uniform(0.3, 1, (7, 4))
    batch = allocation.solve(PYRAMID, demand, 0.2, effectiveness=e, bound=0.1, mode=mode)
    assert batch.command.shape == (5, 7, 4)
    assert batch.status.shape == batch.gap.shape == (5, 7)
    for i in range(5):
        for k in range(7):
            one = allocation.solve(PYRAMID, demand[i, 0], 0.2, effectiveness=e[k], bound=0.1, mode=mode)
            np.testing.assert_array_equal(one.command, batch.command[i, k])


def test_one_geometry_each() -> None:
    turned = np.stack([PYRAMID, PYRAMID[::-1]])
    s = allocation.solve(turned, [0.1, 0.05, 0.02], 0.2)
    np.testing.assert_allclose(s.achieved, [[0.1, 0.05, 0.02]] * 2, atol=1e-15)
    assert not np.allclose(s.command[0], s.command[1])


@pytest.mark.parametrize("mode", MODES)
def test_a_warm_series_ends_where_cold_starts_do_in_fewer_steps(mode: allocation.Mode) -> None:
    demand = 0.3 * np.sin(np.linspace(0, 6, 300))[:, None] * [1.0, 0.7, -0.4]
    args: dict[str, Any] = {"effectiveness": [1, 0.4, 0.8, 1], "bound": 0.1, "mode": mode}
    cold, warm = (allocation.solve(PYRAMID, demand, 0.2, warm=w, **args) for w in (False, True))
    np.testing.assert_allclose(warm.command, cold.command, atol=1e-6)
    assert warm.newton.sum() <= cold.newton.sum()


def test_first_row_has_priority() -> None:
    s = allocation.solve(PYRAMID, [0.6, 0.6, 0.3], 0.2, priority=[1, 1, 0])
    assert s.achieved[2] == pytest.approx(0.3, abs=1e-12)


def test_what_cannot_be_a_problem_is_reported_not_raised() -> None:
    demand = np.full((3, 3), 0.1)
    demand[1, 0] = np.nan
    s = allocation.solve(PYRAMID, demand, 0.2, warm=True)
    assert list(s.status) == ["optimal", "bad_input", "optimal"]
    np.testing.assert_array_equal(s.command[1], s.command[0])  # the previous one


@pytest.mark.parametrize("warm", [False, True])
@pytest.mark.parametrize("rows", [3, 6])
@pytest.mark.parametrize("mode", MODES)
@pytest.mark.parametrize("bad", [np.nan, np.inf])
def test_a_bad_geometry_is_one_bad_problem(mode: allocation.Mode, rows: int, warm: bool, bad: float) -> None:
    rng = np.random.default_rng(8)
    D = rng.normal(size=(4, rows, 8))
    demand = np.einsum("krn,n->kr", D, np.full(8, 0.02))
    D[1, 2, 3] = D[3, 0, 0] = bad
    s = allocation.solve(D, demand, 0.2, bound=0.1, mode=mode, warm=warm)
    assert [str(x) for x in s.status[[1, 3]]] == ["bad_input"] * 2
    assert "bad_input" not in s.status[[0, 2]]
    np.testing.assert_array_equal(s.command[1], s.command[0] if warm else 0.0)  # the previous one, or zero
    alone = allocation.solve(D[0], demand[0], 0.2, bound=0.1, mode=mode)
    np.testing.assert_array_equal(s.command[0], alone.command)
    if not warm:
        again = allocation.solve(D[2], demand[2], 0.2, bound=0.1, mode=mode)
        np.testing.assert_array_equal(s.command[2], again.command)


def test_a_bad_geometry_for_all_is_reported_for_all() -> None:
    s = allocation.solve(np.full((3, 4), np.nan), np.zeros((5, 3)), 0.2)
    assert set(s.status) == {"bad_input"}
    assert not s.command.any()


@pytest.mark.parametrize("worst_case", ["bound", "exact"])
def test_actuators_that_cannot_act_add_no_uncertainty_however_they_are_off(worst_case: allocation.WorstCase) -> None:
    rng = np.random.default_rng(12)
    for _ in range(50):
        D, demand, bound = rng.normal(size=(3, 6)), rng.normal(size=3) * 0.3, rng.uniform(0.05, 0.3, 6)
        off = np.arange(6) == rng.integers(6)
        common: dict[str, Any] = {
            "bound": bound,
            "mode": "robust_socp",
            "worst_case": worst_case,
            "residual_weight": 1e3,
        }
        closed = allocation.solve(D, demand, np.where(off, 0.0, 0.2), **common)
        dead = allocation.solve(D, demand, 0.2, effectiveness=np.where(off, 0.0, 1.0), **common)
        failing = allocation.solve(D, demand, 0.2, effectiveness=np.where(off, 1e-4, 1.0), **common)
        absent = allocation.solve(D * ~off, demand, 0.2, **common)
        for s in (closed, dead, failing):
            np.testing.assert_allclose(s.command, absent.command, rtol=0, atol=1e-9)
            assert s.worst_case == pytest.approx(absent.worst_case, rel=1e-9)


@pytest.mark.parametrize("mode", MODES)
def test_the_demand_along_a_weak_axis_is_ignored_and_the_rank_says_so(mode: allocation.Mode) -> None:
    weak = np.array([[1, -1, 1, -1], [1, 1, -1, -1], [1, -1, -1, 1]]) / 2 * np.array([[1], [1], [2e-3]])
    demand = np.array([[0.05, -0.03, 0.0], [0.05, -0.03, 0.02]])
    s = allocation.solve(weak, demand, 0.2, mode=mode)
    np.testing.assert_array_equal(s.rank, 2)
    np.testing.assert_allclose(s.command[1], s.command[0], rtol=0, atol=1e-9)
    assert s.status[1] == "optimal_reduced"
    np.testing.assert_allclose(s.residual[1], demand[1] - weak @ s.command[1], rtol=0, atol=1e-15)
    assert s.residual[1][2] == pytest.approx(0.02, abs=1e-6)
    served = allocation.solve(weak, [0.0, 0.0, 1e-4], 0.2, mode="lexicographic", rank_tolerance=1e-3)
    assert (served.rank, served.status) == (3, "optimal")


def test_the_attainable_set_has_the_axes_that_allocators_serve() -> None:
    weak = PYRAMID * np.array([[1], [1], [5e-3]])
    reach = allocation.attainable_set(weak, 0.2)
    assert reach.in_every_direction == pytest.approx(0.0, abs=1e-15)
    assert reach.radius([0, 0, 1]) == pytest.approx(0.0, abs=1e-15)
    whole = allocation.attainable_set(weak, 0.2, rank_tolerance=1e-3)
    assert whole.in_every_direction == pytest.approx(2e-3 / np.sqrt(0.75), rel=1e-2)  # 4 x 0.2 x 5e-3 / sqrt 3
    assert reach.radius([1, 0, 0]) == pytest.approx(whole.radius([1, 0, 0]), rel=1e-12)
    rng = np.random.default_rng(2)
    for _ in range(20):  # what the set says, every mode delivers
        n = int(rng.integers(3, 9))
        D = rng.normal(size=(3, n)) * np.array([[1], [1], [10 ** rng.uniform(-4, -1)]])
        v = allocation.served_axes(D) @ rng.normal(size=3)
        edge = allocation.attainable_set(D, 0.2).radius(v)
        s = allocation.solve(D, 0.999 * edge * v / np.linalg.norm(v), 0.2)
        assert s.status == "optimal"


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"demand": [1.0, 2.0]}, "rows"),
        ({"up": [0.2, 0.2]}, "up"),
        ({"effectiveness": np.ones(5)}, "effectiveness"),
        ({"mode": "fastest"}, "mode 'fastest'"),
        ({"worst_case": "none"}, "worst_case 'none'"),
        ({"priority": [0, 1]}, "priority"),
        ({"row_weight": [1.0, -1.0, 1.0]}, "row_weight"),
    ],
)
def test_shapes_and_names_are_checked(change: dict[str, Any], message: str) -> None:
    args: dict[str, Any] = {"D": PYRAMID, "demand": [0.1, 0.0, 0.0], "up": 0.2} | change
    with pytest.raises(ValueError, match=message):
        allocation.solve(**args)


def test_radius_of_the_attainable_set_is_where_the_lexicographic_command_stops() -> None:
    rng = np.random.default_rng(4)
    for _ in range(20):
        n = int(rng.integers(3, 9))
        D, up, lo = rng.normal(size=(3, n)), rng.uniform(0.1, 0.3, n), -rng.uniform(0.1, 0.3, n)
        reach = allocation.attainable_set(D, up, lo)
        directions = rng.normal(size=(50, 3))
        directions /= np.linalg.norm(directions, axis=1, keepdims=True)
        radius = reach.radius(directions)[:, None]
        inside = allocation.solve(D, 0.999 * radius * directions, up, lo)
        beyond = allocation.solve(D, 1.001 * radius * directions, up, lo)
        assert set(inside.status) == {"optimal"}
        assert set(beyond.status) == {"optimal_reduced"}
        assert reach.contains(0.999 * radius * directions).all()
        assert not reach.contains(1.001 * radius * directions).any()


def test_attainable_set_is_the_hull_of_the_extreme_commands() -> None:
    rng = np.random.default_rng(5)
    for n in (3, 4, 6):
        D, up, lo, e = (
            rng.normal(size=(3, n)),
            rng.uniform(0.1, 0.3, n),
            -rng.uniform(0.0, 0.3, n),
            rng.uniform(0.2, 1, n),
        )
        corners = np.stack(np.meshgrid(*zip(lo, up, strict=True), indexing="ij"), -1).reshape(-1, n) @ (D * e).T
        hull = ConvexHull(corners)
        reach = allocation.attainable_set(D, up, lo, e)
        assert reach.volume == pytest.approx(hull.volume, rel=1e-12)
        expected = corners[hull.vertices]
        assert reach.vertices().shape == expected.shape
        distance = np.linalg.norm(reach.vertices()[:, None] - expected, axis=-1).min(axis=0)
        assert distance.max() < 1e-14
        v = rng.normal(size=(10, 3))
        np.testing.assert_allclose(reach.support(v), (v @ corners.T).max(axis=1), rtol=1e-12)


def test_faces_of_the_pyramid_are_its_twelve_parallelograms() -> None:
    reach = allocation.attainable_set(PYRAMID, 0.2)
    faces = reach.faces()
    assert len(faces) == 12  # a rhombic dodecahedron
    assert {len(f) for f in faces} == {4}
    assert len(reach.vertices()) == 14
    for face, normal in zip(faces, reach.normals, strict=True):
        assert np.cross(face[1] - face[0], face[2] - face[1]) @ normal > 0  # counter-clockwise from outside
    # largest sphere inside: faces lie at 2 u_max |g_i . n| with n along (1, 1, 0)
    assert reach.in_every_direction == pytest.approx(0.4 * np.sqrt(2 / 3), rel=1e-12)


def test_cube_of_three_axes_with_doubled_ones_has_six_faces() -> None:
    reach = allocation.attainable_set(np.hstack([np.eye(3), np.eye(3)]), 0.1)
    assert len(reach.faces()) == 6
    assert reach.volume == pytest.approx(0.4**3)
    assert reach.in_every_direction == pytest.approx(0.2)


@pytest.mark.parametrize(
    ("axes_left", "corners", "along", "across"), [([0, 1], 4, [1, 1, 0], [0, 0, 1]), ([2], 2, [0, 0, 1], [1, 0, 0])]
)
def test_flat_sets_reach_only_along_themselves(
    axes_left: list[int], corners: int, along: list[float], across: list[float]
) -> None:
    e = np.isin(range(3), axes_left).astype(float)
    reach = allocation.attainable_set(np.eye(3), 0.1, effectiveness=e)
    assert reach.volume == 0
    assert reach.in_every_direction == pytest.approx(0, abs=1e-15)
    assert reach.radius(across) == pytest.approx(0, abs=1e-15)
    assert reach.radius(along) == pytest.approx(0.1 * np.linalg.norm(along))
    assert len(reach.vertices()) == corners


def test_nothing_left_is_a_point() -> None:
    reach = allocation.attainable_set(PYRAMID, 0.2, effectiveness=0.0)
    assert reach.volume == 0
    assert reach.radius([1, 0, 0]) == 0
    assert reach.vertices().shape == (1, 3)


def test_radius_is_nan_where_the_ray_misses() -> None:
    reach = allocation.attainable_set(np.eye(3), up=0.3, lo=0.1)
    assert np.isnan(reach.radius([1, 0, 0]))
    assert reach.radius([1, 1, 1]) == pytest.approx(0.3 * np.sqrt(3))
    assert reach.in_every_direction < 0


@pytest.mark.parametrize(
    "change",
    [{"D": np.eye(2)}, {"up": np.inf}, {"up": -1.0}, {"up": 0.1, "lo": 0.2}],
    ids=["rows", "infinite", "negative", "order"],
)
def test_attainable_sets_need_three_rows_and_finite_limits(change: dict[str, Any]) -> None:
    with pytest.raises(ValueError, match=r"actuators|finite"):
        allocation.attainable_set(**{"D": np.eye(3), "up": 0.1, **change})


def test_a_scenario_says_what_its_faults_leave() -> None:
    scenario = gs.Scenario.load("wheel2_degraded")
    sets = attainable_after_faults(scenario)
    assert sets is not None
    healthy, left = sets
    expected = allocation.attainable_set(PYRAMID, 0.2, effectiveness=[1, 1, 0.4, 1])
    assert healthy.in_every_direction == pytest.approx(0.4 * np.sqrt(2 / 3), rel=1e-12)
    assert left.in_every_direction == pytest.approx(expected.in_every_direction, rel=1e-12)


def test_check_says_what_the_faults_leave() -> None:
    printed = CliRunner().invoke(app, ["check", "wheel2_degraded"])
    assert printed.exit_code == 0
    assert "after the faults 0.229 N m in every direction, healthy 0.327 N m" in printed.output
    printed = CliRunner().invoke(app, ["check", "wheel2_degraded", "--json"])
    (found,) = (f for f in json.loads(printed.output)["design"] if f["where"] == "torque")
    assert found["ok"]
    assert found["value"] == pytest.approx(0.2286, abs=1e-4)


def test_check_says_whether_a_demand_is_within_reach() -> None:
    """0.28 N m across the weak wheel: beyond its 0.229 N m left, inside the healthy 0.327 N m."""
    direction = attainable_after_faults(gs.Scenario.load("wheel2_degraded"))[1]  # type: ignore[index]
    worst = direction.normals[np.argmin(direction.heights)]
    for size, code in ((0.22, 0), (0.28, 1)):
        numbers = [f"{x:.17g}" for x in size * worst]
        printed = CliRunner().invoke(app, ["check", "wheel2_degraded", "--torque", *numbers])
        assert printed.exit_code == code, printed.output
        assert "after the faults 0.229 N m, healthy" in printed.output


def test_a_scenario_is_infeasible_when_its_faults_leave_a_plane() -> None:
    dead = [gs.faults.Dead(actuator=i, t_on=5.0) for i in (0, 1)]
    (found,) = torque_findings(gs.Scenario.load("wheel2_degraded").replace(faults=dead))
    assert found.ok is False
    assert found.value == pytest.approx(0.0, abs=1e-12)


def test_the_worst_moment_of_a_slow_fade_is_found() -> None:
    """A dip to 20 % of 30 ms within a fade of 60 s: one state in two thousand."""
    dip = 35.005
    fade = gs.waveforms.Table(
        times=[0.0, dip, dip + 1e-3, dip + 0.03, dip + 0.031, 60.0], values=[1.0, 0.6, 0.2, 0.2, 0.6, 0.5]
    )
    scenario = gs.Scenario.load("wheel2_degraded").replace(
        duration=60.0, faults=[gs.faults.LossOfEffectiveness(actuator=2, t_on=0.0, remaining=fade)]
    )
    sets = attainable_after_faults(scenario)
    assert sets is not None
    expected = allocation.attainable_set(PYRAMID, 0.2, effectiveness=[1, 1, 0.2, 1])
    assert sets[1].in_every_direction == pytest.approx(expected.in_every_direction, rel=1e-9)


def test_flown_scenarios_say_when_their_demand_is_out_of_reach() -> None:
    scenario = gs.Scenario.load("wheel2_degraded").replace(duration=60.0, initial={})
    calm, flown = (torque_findings(s, fly=True)[-1] for s in (scenario, scenario.replace(**{"vehicle.u_max": 0.002})))
    assert calm.value == 0.0
    assert flown.value is not None
    # Independent: the torque is missed exactly where the closest one differs from the demand.
    run = scenario.replace(**{"vehicle.u_max": 0.002}).run()
    closest = allocation.solve(
        PYRAMID, run["demand.tau_B"], up=0.002, effectiveness=run["truth.effectiveness"], effectiveness_min=0.0
    )
    # Both hold it to 1e-9 N m, one across the nearest face, one to the nearest torque: they may differ at the edge.
    assert flown.value == pytest.approx(np.mean(closest.residual_norm > 1e-9), abs=1e-3)
    assert 0.0 < flown.value < 1.0


def test_the_figure_shows_what_the_modes_do() -> None:
    script = ROOT / "docs" / "figures" / "allocation_edge.py"
    drawn = runpy.run_path(str(script))["draw"]().data
    with np.load(script.with_suffix(".npz")) as saved:
        for signal, values in drawn.items():
            np.testing.assert_allclose(saved[signal], values, rtol=0, atol=1e-9, err_msg=signal)


def nearly_coplanar(third: float, allocator: str) -> gs.Scenario:
    """Wheels whose third axis is `third` of the others, an error about every axis, 10 Hz."""
    return gs.Scenario(
        vehicle=gs.vehicle.Vehicle(
            J_B=np.diag([20.0, 17.0, 15.0]).tolist(),
            D_B=(np.array([[1, -1, 1, -1], [1, 1, -1, -1], [1, -1, -1, 1]]) / 2 * [[1], [1], [third]]).tolist(),
            u_max=0.2,
        ),
        initial=gs.Initial(mrp=(0.05, -0.04, 0.02)),
        allocator=gs.allocator(allocator),
        integrator="rk4",
        duration=120.0,
        dt=0.1,
    )


@pytest.mark.parametrize("allocator", ["pseudo_inverse", *MODES])
def test_no_allocator_works_at_its_limits_for_an_axis_that_it_hardly_moves(allocator: str) -> None:
    channels = ["allocation.u", "allocation.status", "truth.mrp"]
    flown = nearly_coplanar(2e-3, allocator).run(channels=channels)
    late = flown.t > 60.0
    assert np.abs(flown["allocation.u"][late]).max() < 1e-3  # of 0.2 N m: the two axes that are served are at rest
    assert np.all(flown["allocation.status"][late].astype(int) & 64)
    assert np.abs(flown["truth.mrp"][late, :2]).max() < 2e-3
    served = nearly_coplanar(0.1, allocator).run(channels=channels)
    assert not np.any(served["allocation.status"].astype(int) & 64)
    assert np.abs(served["truth.mrp"][-1]).max() < 1e-3


def test_check_says_that_an_axis_is_too_weak_to_be_served() -> None:
    (found,) = torque_findings(nearly_coplanar(5e-3, "lexicographic"))
    assert found.ok is False
    assert found.value == pytest.approx(0.0, abs=1e-12)
    assert "below rank_tolerance = 0.01 of the strongest and not served" in found.text
    (served,) = torque_findings(nearly_coplanar(5e-3, "lexicographic").replace(**{"allocator.rank_tolerance": 1e-3}))
    assert served.ok
    assert served.value == pytest.approx(4 * 0.2 * 5e-3 / 2, rel=1e-2)


def test_stuck_actuators_move_the_set() -> None:
    scenario = gs.Scenario.load("wheel2_degraded").replace(faults=[gs.faults.Stuck(actuator=1, t_on=5.0, torque=0.1)])
    sets = attainable_after_faults(scenario)
    assert sets is not None
    np.testing.assert_allclose(sets[1].centre, 0.1 * PYRAMID[:, 1], atol=1e-15)


def test_without_limits_there_is_no_set() -> None:
    scenario = gs.Scenario.load("wheel2_degraded").replace(**{"vehicle.u_max": float("inf")})
    assert attainable_after_faults(scenario) is None
