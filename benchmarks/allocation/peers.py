# SPDX-License-Identifier: MIT
"""Control allocation: gyrostat against general solvers; one process, one core, problem by problem in turn.

Every solver gets the same problem before the next one is posed, three times in a row, of which the fastest counts: a
microsecond solver would else pay for the caches that Python emptied. Times are those that the solvers report: from data
to solution, with what changes when an effectiveness changes (factorisations) and without Python. Where a solver reports
none, its call is timed and the line says so. Objectives are compared at each solver's command, clipped to the box,
against gyrostat's, which carries a certificate. Absolute figures are those of one machine; the ratios travel.

With --native (a library of this folder: cmake --build --preset bench --target bench_allocation_native) the own solver
and DAQP's C function are timed by one clock without Python between them, and ratios are to these times.

    pip install . daqp quadprog piqp proxsuite osqp qoco ecos clarabel scs
    python benchmarks/allocation/peers.py [--count 2000] [--only 3x4,3x8] [--native LIBRARY] [--json]
"""

from __future__ import annotations

import argparse
import ctypes
import json
import os
import sys
import time
import warnings
from collections import defaultdict
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy import sparse

from gyrostat import allocation

warnings.filterwarnings("ignore")
GEOMETRIES = {"3x4": (3, 4), "3x6": (3, 6), "3x8": (3, 8), "3x16": (3, 16), "6x12": (6, 12)}
LIMIT, GAMMA = 0.25, 1e6
REPEATS = 3
PAPER = np.column_stack([np.eye(3), np.full(3, 1 / np.sqrt(3.0))])  # axes of Yang et al. 2023


@dataclass
class Problem:
    """min 1/2 u'u + weight/2 (worst or nominal residual)^2 in a box of +- LIMIT."""

    D: np.ndarray
    e: np.ndarray
    bound: np.ndarray
    demand: np.ndarray
    h: float  # weight of the robust problem

    @property
    def A(self) -> np.ndarray:
        """Effect of a command."""
        return self.D * self.e

    @property
    def active(self) -> np.ndarray:
        """Axes of the actuators that can act: the others deliver no error either."""
        return self.D * (self.e > 0)


def problems(rows: int, n: int, count: int) -> Iterator[Problem]:
    """Some 40 % of the demands can be had; the others are up to three times too large."""
    rng = np.random.default_rng(rows * 100 + n)
    for k in range(count):
        D = PAPER if (rows, n) == (3, 4) else rng.normal(size=(rows, n))
        D = D / np.linalg.norm(D, axis=0)
        e = np.where(rng.random(n) < 0.1, 0.0, rng.uniform(0.3, 1.0, n))
        edge = D @ (e * LIMIT * np.sign(rng.normal(size=rows) @ D))  # the attainable set's end in a random direction
        share = rng.uniform(0.1, 1.0) if rng.random() < 0.4 else rng.uniform(1.0, 3.0)
        yield Problem(D, e, rng.uniform(0, 0.3, n), share * edge, 10 ** (1 + 4 * (k % 100) / 100))


def wls_objective(p: Problem, u: np.ndarray) -> float:
    r = p.demand - p.A @ u
    return 0.5 * u @ u + 0.5 * GAMMA * (r @ r)


def robust_objective(p: Problem, u: np.ndarray) -> float:
    worst = np.linalg.norm(p.demand - p.A @ u) + np.linalg.norm(p.active, 2) * np.linalg.norm(p.bound * p.e * u)
    return 0.5 * u @ u + 0.5 * p.h * worst**2


Answer = tuple[np.ndarray | None, float]  # command (None: no solution), seconds


def own(mode: str, **settings: float) -> Callable[[Problem], Answer]:
    def run(p: Problem) -> Answer:
        weight = p.h if mode == "robust_socp" else GAMMA
        s = allocation.solve(
            p.D, p.demand, LIMIT, effectiveness=p.e, bound=p.bound, mode=mode, residual_weight=weight, **settings
        )
        own.newton[mode].append(int(s.newton))
        own.outer[mode].append(int(s.outer))
        own.gap[mode].append(float(s.gap / s.primal))
        return s.command, float(s.seconds)

    return run


own.newton, own.outer, own.gap = defaultdict(list), defaultdict(list), defaultdict(list)


def own_warm(p: Problem) -> Answer:
    """From the solution of a demand 2 % smaller."""
    both = np.stack([p.demand / 1.02, p.demand])
    s = allocation.solve(
        p.D, both, LIMIT, effectiveness=p.e, mode="weighted_least_squares", residual_weight=GAMMA, warm=True
    )
    return s.command[1], float(s.seconds[1])


def hessian(p: Problem) -> tuple[np.ndarray, np.ndarray]:
    return GAMMA * p.A.T @ p.A + np.eye(len(p.e)), -GAMMA * p.A.T @ p.demand


def daqp_peer() -> Callable[[Problem], Answer]:
    import daqp

    def run(p: Problem) -> Answer:
        H, f = hessian(p)
        n = len(f)
        x, _, flag, info = daqp.solve(
            H, f, np.zeros((0, n)), np.full(n, LIMIT), np.full(n, -LIMIT), np.zeros(n, np.intc)
        )
        return (np.asarray(x) if flag > 0 else None), info["setup_time"] + info["solve_time"]

    return run


def quadprog_peer() -> Callable[[Problem], Answer]:
    import quadprog

    def run(p: Problem) -> Answer:
        H, f = hessian(p)
        n = len(f)
        C, b = np.hstack([np.eye(n), -np.eye(n)]), np.full(2 * n, -LIMIT)
        start = time.perf_counter()
        x = quadprog.solve_qp(H, -f, C, b)[0]
        return x, time.perf_counter() - start

    return run


def piqp_peer() -> Callable[[Problem], Answer]:
    import piqp

    solvers: dict[int, piqp.DenseSolver] = {}

    def run(p: Problem) -> Answer:
        H, f = hessian(p)
        n = len(f)
        none, limit = np.zeros((0, n)), np.full(n, LIMIT)
        if n not in solvers:
            solvers[n] = piqp.DenseSolver()
            solvers[n].settings.compute_timings = True
            solvers[n].setup(H, f, none, np.zeros(0), none, None, None, -limit, limit)
            solvers[n].solve()
        s = solvers[n]
        s.update(P=H, c=f)
        status = s.solve()
        done = status == piqp.PIQP_SOLVED
        return (np.asarray(s.result.x) if done else None), s.result.info.update_time + s.result.info.solve_time

    return run


def proxqp_peer() -> Callable[[Problem], Answer]:
    from proxsuite import proxqp

    def run(p: Problem) -> Answer:
        H, f = hessian(p)
        n = len(f)
        qp = proxqp.dense.QP(n, 0, 0, True)
        qp.settings.compute_timings = True
        qp.settings.eps_abs = 1e-9
        limit = np.full(n, LIMIT)
        qp.init(H, f, None, None, None, None, None, -limit, limit)
        qp.solve()
        return np.asarray(qp.results.x), 1e-6 * qp.results.info.run_time

    return run


def osqp_peer() -> Callable[[Problem], Answer]:
    import osqp

    def run(p: Problem) -> Answer:
        H, f = hessian(p)
        n = len(f)
        s = osqp.OSQP()
        box, limit = sparse.eye(n, format="csc"), np.full(n, LIMIT)
        s.setup(sparse.csc_matrix(np.triu(H)), f, box, -limit, limit, verbose=False)
        r = s.solve(raise_error=False)
        return (np.asarray(r.x) if r.x is not None else None), r.info.run_time

    return run


class Cone:
    """The robust problem for conic solvers: x = (u, a, b, t), t >= a + s_max b, a >= |A u - demand|, b >= |G u|."""

    def __init__(self, p: Problem) -> None:
        rows, n = p.D.shape
        s_max = np.linalg.norm(p.active, 2)
        self.n = n + 3
        self.P = sparse.diags(np.r_[np.ones(n), 0.0, 0.0, p.h], format="csc")
        box = np.vstack([np.eye(n, n + 3), -np.eye(n, n + 3), np.r_[np.zeros(n), 1.0, s_max, -1.0]])
        residual = np.zeros((rows + 1, n + 3))
        residual[0, n] = -1.0
        residual[1:, :n] = -p.A
        spread = np.zeros((n + 1, n + 3))
        spread[0, n + 1] = -1.0
        spread[1:, :n] = -np.diag(p.bound * p.e)
        self.G = sparse.csc_matrix(np.vstack([box, residual, spread]))
        self.h = np.r_[np.full(2 * n, LIMIT), 0.0, 0.0, -p.demand, np.zeros(n + 1)]
        self.linear, self.cones = 2 * n + 1, [rows + 1, n + 1]


def qoco_peer() -> Callable[[Problem], Answer]:
    import qoco

    def run(p: Problem) -> Answer:
        c = Cone(p)
        s = qoco.QOCO()
        s.setup(
            c.n, len(c.h), 0, c.P, np.zeros(c.n), None, None, c.G, c.h, c.linear, 2, np.array(c.cones), verbose=False
        )
        r = s.solve()
        done = "SOLVED" in str(r.status)
        return (np.asarray(r.x)[: len(p.e)] if done else None), r.solve_time_sec

    return run


def clarabel_peer(tolerance: float = 1e-8) -> Callable[[Problem], Answer]:
    import clarabel

    def run(p: Problem) -> Answer:
        c = Cone(p)
        s = clarabel.DefaultSettings()
        s.verbose = False
        s.tol_gap_abs = s.tol_gap_rel = s.tol_feas = tolerance
        cones = [clarabel.NonnegativeConeT(c.linear), *(clarabel.SecondOrderConeT(k) for k in c.cones)]
        r = clarabel.DefaultSolver(sparse.triu(c.P, format="csc"), np.zeros(c.n), c.G, c.h, cones, s).solve()
        return (np.asarray(r.x)[: len(p.e)] if "Solved" in str(r.status) else None), r.solve_time

    return run


def scs_peer() -> Callable[[Problem], Answer]:
    import scs

    def run(p: Problem) -> Answer:
        c = Cone(p)
        s = scs.SCS(
            {"P": sparse.triu(c.P, format="csc"), "A": c.G, "b": c.h, "c": np.zeros(c.n)},
            {"l": c.linear, "q": c.cones},
            verbose=False,
            eps_abs=1e-6,
            eps_rel=1e-6,
        )
        r = s.solve()
        seconds = 1e-3 * (r["info"]["setup_time"] + r["info"]["solve_time"])
        return (np.asarray(r["x"])[: len(p.e)] if r["info"]["status_val"] in (1, 2) else None), seconds

    return run


def ecos_peer() -> Callable[[Problem], Answer]:
    """Its objective is linear: q >= 1/2 (u'u + h t^2) as one more cone."""
    import ecos

    def run(p: Problem) -> Answer:
        c = Cone(p)
        n = len(p.e)
        last = np.zeros((n + 3, c.n + 1))
        last[0, -1] = last[1, -1] = -1.0
        last[2 : n + 2, :n] = -np.sqrt(2.0) * np.eye(n)
        last[n + 2, n + 2] = -np.sqrt(2.0 * p.h)
        wider = sparse.hstack([c.G, sparse.csc_matrix((len(c.h), 1))])
        G = sparse.vstack([wider, sparse.csc_matrix(last)], format="csc")
        h = np.r_[c.h, 1.0, -1.0, np.zeros(n + 1)]
        r = ecos.solve(np.r_[np.zeros(c.n), 1.0], G, h, {"l": c.linear, "q": [*c.cones, n + 3], "e": 0}, verbose=False)
        timing = r["info"]["timing"]
        done = r["info"]["exitFlag"] in (0, 10)
        return (np.asarray(r["x"])[:n] if done else None), timing["tsetup"] + timing["tsolve"]

    return run


WLS = {
    "daqp": daqp_peer,
    "quadprog (call)": quadprog_peer,
    "piqp (update + solve)": piqp_peer,
    "proxqp": proxqp_peer,
    "osqp": osqp_peer,
}
ROBUST = {"qoco": qoco_peer, "ecos": ecos_peer, "clarabel": clarabel_peer, "scs": scs_peer}


def available(peers: dict[str, Callable[[], Callable[[Problem], Answer]]]) -> dict[str, Callable[[Problem], Answer]]:
    out = {}
    for name, make in peers.items():
        try:
            out[name] = make()
        except ImportError as missing:
            print(f"{name}: left out, {missing}", file=sys.stderr)
    return out


def measure(rows: int, n: int, count: int, reference: dict[str, float]) -> list[dict[str, float | str]]:
    """One line a solver; ratios are to the reference (us) of its problem, or to the first line."""
    own.newton.clear(), own.outer.clear(), own.gap.clear()
    groups = {
        "wls": (wls_objective, {"gyrostat": own("weighted_least_squares"), "gyrostat warm": own_warm} | available(WLS)),
        "lex": (None, {"gyrostat lexicographic": own("lexicographic"), "gyrostat scaled": own("lexicographic_scaled")}),
        "robust": (robust_objective, {"gyrostat robust": own("robust_socp")} | available(ROBUST)),
    }
    seconds: dict[str, list[float]] = defaultdict(list)
    excess: dict[str, list[float]] = defaultdict(list)
    failed: dict[str, int] = defaultdict(int)
    for p in problems(rows, n, count):
        for objective, peers in groups.values():
            best = None
            for name, run in peers.items():
                answers = [run(p) for _ in range(REPEATS)]
                u = answers[-1][0]
                seconds[name].append(min(taken for _, taken in answers))
                if u is None:
                    failed[name] += 1
                elif objective is not None:
                    value = objective(p, np.clip(u, -LIMIT, LIMIT))
                    best = value if best is None else best
                    excess[name].append(value / best - 1)
    out: list[dict[str, float | str]] = []
    for group, (_, peers) in groups.items():
        first = 1e-6 * reference[group] if group in reference else np.median(seconds[next(iter(peers))])
        for name in peers:
            t, x = np.array(seconds[name]), excess[name] or [np.nan]
            out.append(
                {
                    "problem": group,
                    "solver": name,
                    "median_us": 1e6 * float(np.median(t)),
                    "p99_us": 1e6 * float(np.quantile(t, 0.99)),
                    "ratio": float(np.median(t) / first),
                    "excess_median": float(np.median(x)),
                    "excess_p999": float(np.quantile(x, 0.999)),
                    "failed": failed[name],
                }
            )
    for mode in own.newton:
        gaps = own.gap[mode]
        out.append(
            {
                "problem": "counts",
                "solver": mode,
                "newton_max": max(own.newton[mode]),
                "newton_mean": float(np.mean(own.newton[mode])),
                "outer_max": max(own.outer[mode]),
                "gap_max": max(gaps),
                "gap_median": float(np.median(gaps)),
            }
        )
    return out


NATIVE = ("cold", "warm", "daqp call", "lexicographic", "scaled", "robust", "robust exact")


def native(library: Path, rows: int, n: int, count: int) -> list[dict[str, float | str]]:
    """The own solver and DAQP in C, one clock."""
    lib = ctypes.CDLL(str(library))
    lib.gyrostat_time_allocation.restype = ctypes.c_double
    try:
        import daqp

        address = ctypes.cast(ctypes.PyDLL(daqp.__file__).daqp_quadprog, ctypes.c_void_p)
    except (ImportError, AttributeError) as missing:
        print(f"daqp: left out, {missing}", file=sys.stderr)
        address = ctypes.c_void_p(None)
    posed = list(problems(rows, n, count))
    columns = [np.array([getattr(p, key) for p in posed], float) for key in ("D", "e", "bound", "demand", "h")]
    ns = np.zeros((count, len(NATIVE)))
    pointers = [c.ctypes.data_as(ctypes.c_void_p) for c in (*columns, ns)]
    difference = lib.gyrostat_time_allocation(rows, n, count, *pointers[:-1], address, pointers[-1])
    reference = float(np.median(ns[:, NATIVE.index("daqp call")])) or np.nan
    return [
        {
            "problem": "native",
            "solver": name,
            "median_us": float(np.median(t)) / 1e3,
            "p99_us": float(np.quantile(t, 0.99)) / 1e3,
            "ratio": float(np.median(t)) / reference,
            "excess_median": np.nan,
            "excess_p999": difference,
            "failed": 0,
        }
        for name, t in zip(NATIVE, ns.T, strict=True)
    ]


def print_lines(lines: list[dict[str, float | str]]) -> None:
    print(
        f"{'solver':24} {'median us':>10} {'p99 us':>10} {'ratio':>8} {'excess median':>14} {'p99.9':>9} {'failed':>7}"
    )
    for line in lines:
        if line["problem"] == "counts":
            print(
                f"  {line['solver']}: Newton steps mean {line['newton_mean']:.1f} max {line['newton_max']}, "
                f"rounds max {line['outer_max']}, certified relative gap median {line['gap_median']:.1e} "
                f"max {line['gap_max']:.1e}"
            )
            continue
        print(
            f"{line['solver']:24} {line['median_us']:10.2f} {line['p99_us']:10.2f} {line['ratio']:8.2f} "
            f"{line['excess_median']:14.1e} {line['excess_p999']:9.1e} {line['failed']:7d}"
        )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--count", type=int, default=2000, help="problems a geometry")
    parser.add_argument("--only", default=",".join(GEOMETRIES), help="geometries")
    parser.add_argument("--native", type=Path, help="bench_allocation_native, to time DAQP's C function too")
    parser.add_argument("--native-only", action="store_true", help="leave the Python peers out")
    parser.add_argument("--json", action="store_true")
    options = parser.parse_args()
    os.sched_setaffinity(0, {max(os.sched_getaffinity(0))})
    everything = {}
    for name in options.only.split(","):
        lines = native(options.native, *GEOMETRIES[name], options.count) if options.native else []
        own_us = {str(line["solver"]): float(line["median_us"]) for line in lines}
        groups = {"wls": "cold", "lex": "lexicographic", "robust": "robust"}
        reference = {group: own_us[line] for group, line in groups.items() if line in own_us}
        if not options.native_only:
            lines += measure(*GEOMETRIES[name], options.count, reference)
        everything[name] = lines
        if options.json:
            continue
        print(f"\n{name}, {options.count} problems")
        print_lines(lines)
    if options.json:
        print(json.dumps(everything, indent=1))


if __name__ == "__main__":
    main()
