# SPDX-License-Identifier: MIT
"""Control allocation on arrays: the solver that flies, for one problem or a batch, and the set of torques within reach.

What the modes mean and when to use which: docs/allocation.md.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import combinations
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from gyrostat import _core

__all__ = ["AttainableSet", "Solutions", "attainable_set", "served_axes", "solve"]

Floats = NDArray[np.float64]
Mode = Literal["lexicographic", "lexicographic_scaled", "weighted_least_squares", "robust_socp"]
WorstCase = Literal["bound", "exact", "paper_constant"]

_MODES = ("lexicographic", "lexicographic_scaled", "weighted_least_squares", "robust_socp")
_WORST_CASES = ("bound", "exact", "paper_constant")
DEFAULT_RANK_TOLERANCE: float = _core.default_rank_tolerance
_STATUSES = np.array(["optimal", "optimal_reduced", "cap_reached", "bad_input"])


@dataclass(frozen=True)
class Solutions:
    """Allocations, one for each problem of the batch. SI.

    Below, ``...`` are the leading axes of the problems, m the rows of torque, n the actuators.

    Attributes
    ----------
    command
        (..., n) N m, inside the box without exception.
    achieved, residual
        (..., m) N m: ``D diag(effectiveness) command``, and what is missing of the demand.
    residual_norm, residual_excess
        (...) length of the row-weighted residual, and (lexicographic modes) how far above a proven lower bound it is.
    worst_case
        (...) worst row-weighted residual under `bound`.
    multiplier, theta
        (..., m) and (...): the dual solution. With it anybody can check `primal`, `dual` and `gap`.
    primal, dual, gap
        (...) objective, its proven lower bound, and their difference from terms that are never negative.
    scale
        (...) delivered share of the demand (``lexicographic_scaled``).
    infeasibility_direction
        (..., m): v with ``v . demand > max v . D e u``, or zero.
    residual_weight
        (...) as used: beyond 1e8 times the effort weights it is capped.
    saturated
        (..., n) commands that sit on a limit, and are not at rest (zero).
    status
        (...) ``optimal``, ``optimal_reduced`` (the demand is not delivered in full), ``cap_reached`` (not proven to
        the bounds of docs/allocation.md, see `gap`) or ``bad_input`` (not a problem: the previous command of the
        batch clipped, or zero).
    warnings
        (...) bits: 1 effectiveness above 1 clamped, 2 weights capped, 4 demand clamped, 8 direction lost.
    rank
        (...) axes of torque that are served, of m; where some are dropped, the certificate is that of the problem on
        the others, while `achieved` and `residual` are those of all axes.
    newton, outer
        (...) Newton steps in all, and rounds around them.
    seconds
        (...) time of each solve.
    """

    command: Floats
    achieved: Floats
    residual: Floats
    residual_norm: Floats
    residual_excess: Floats
    worst_case: Floats
    multiplier: Floats
    theta: Floats
    primal: Floats
    dual: Floats
    gap: Floats
    scale: Floats
    infeasibility_direction: Floats
    residual_weight: Floats
    saturated: NDArray[np.bool_]
    status: NDArray[np.str_]
    warnings: NDArray[np.int32]
    rank: NDArray[np.int32]
    newton: NDArray[np.int32]
    outer: NDArray[np.int32]
    seconds: Floats


def solve(
    D: ArrayLike,
    demand: ArrayLike,
    up: ArrayLike,
    lo: ArrayLike | None = None,
    *,
    effectiveness: ArrayLike = 1.0,
    preferred: ArrayLike = 0.0,
    effort_weight: ArrayLike = 1.0,
    bound: ArrayLike = 0.0,
    row_weight: ArrayLike = 1.0,
    mode: Mode = "lexicographic",
    worst_case: WorstCase = "bound",
    residual_weight: float = 1e4,
    margin: float = 0.0,
    priority: Sequence[int] | None = None,
    effectiveness_min: float | None = None,
    rank_tolerance: float = DEFAULT_RANK_TOLERANCE,
    max_newton: int = 200,
    warm: bool = False,
) -> Solutions:
    """Distribute torques over actuators with limits. Arguments broadcast over their leading axes.

    Parameters
    ----------
    D
        (..., m, n) actuator axes in columns; m is 3 (torques) or 6 (torques and forces), n at most 16.
    demand
        (..., m) N m.
    up, lo
        (..., n) N m, limits of the command; `lo` is ``-up`` unless given; infinite: none.
    effectiveness
        (..., n) delivered / commanded. Below `effectiveness_min` an actuator counts as failed.
    preferred
        (..., n) N m, command that costs nothing.
    effort_weight
        (..., n) > 0.
    bound
        (..., n) relative half-width of the effectiveness, for `worst_case`.
    row_weight
        (m,) > 0, how much a missing unit of each row matters.
    mode
        See docs/allocation.md. ``lexicographic``: the closest torque, then least effort.
    residual_weight
        gamma of ``weighted_least_squares``, h of ``robust_socp``.
    margin
        N m, of ``worst_case="paper_constant"``.
    priority
        m integers; rows of a smaller number are served first (``lexicographic``).
    effectiveness_min
        Default 1e-3.
    rank_tolerance
        As of the allocators that fly: an axis of torque with a smaller singular value of ``D diag(effectiveness)``,
        relative to the largest, is dropped, and the demand along it ignored (`Solutions.rank`); 0 keeps every axis.
        Problems of three rows: the six of torques and forces have no common measure.
    max_newton
        Limit of all Newton steps of one problem together.
    warm
        Start each problem where the one before ended: the batch is a time series. Else every start is cold.

    Raises
    ------
    ValueError
        Shapes that do not fit, an unknown name, or row weights that are not positive. Other bad numbers are reported in
        `Solutions.status`, problem by problem.

    Examples
    --------
    >>> import numpy as np
    >>> D = np.array([[1, 1, -1, -1], [1, -1, -1, 1], [1, 1, 1, 1]]) / np.sqrt(3)
    >>> demands = np.linspace(0, 1, 50)[:, None] * [0.6, 0.3, 0.1]
    >>> solve(D, demands, up=0.2, effectiveness=[1, 0.4, 1, 1]).command.shape
    (50, 4)
    """
    if mode not in _MODES:
        raise ValueError(f"mode '{mode}' is none of {', '.join(_MODES)}")
    if worst_case not in _WORST_CASES:
        raise ValueError(f"worst_case '{worst_case}' is none of {', '.join(_WORST_CASES)}")
    axes, torque = np.asarray(D, float), np.asarray(demand, float)
    if axes.ndim < 2 or torque.ndim < 1 or torque.shape[-1] != axes.shape[-2]:
        raise ValueError(f"D {axes.shape} and demand {torque.shape} are not (..., rows, actuators) and (..., rows)")
    rows, n = axes.shape[-2:]
    upper = np.asarray(up, float)
    columns = {
        "effectiveness": np.asarray(effectiveness, float),
        "up": upper,
        "lo": -upper if lo is None else np.asarray(lo, float),
        "preferred": np.asarray(preferred, float),
        "effort_weight": np.asarray(effort_weight, float),
        "bound": np.asarray(bound, float),
    }
    for name, value in columns.items():
        if value.ndim > 0 and value.shape[-1] not in (1, n):
            raise ValueError(f"{name} {value.shape} is not (..., {n})")
    batch = np.broadcast_shapes(axes.shape[:-2], torque.shape[:-1], *(v.shape[:-1] for v in columns.values()))
    count = int(np.prod(batch, dtype=int))

    def flat(value: Floats, *tail: int) -> Floats:
        return np.ascontiguousarray(np.broadcast_to(value, (*batch, *tail)).reshape(count, *tail))

    raw: dict[str, Any] = _core.allocate(
        D=axes.reshape(1, rows, n) if axes.ndim == 2 or axes[..., 0, 0].size == 1 else flat(axes, rows, n),
        row_weight=np.broadcast_to(np.asarray(row_weight, float), (1, rows)),
        demand=flat(torque, rows),
        **{name: flat(value, n) for name, value in columns.items()},
        priority=np.zeros(rows, np.int32) if priority is None else np.asarray(priority, np.int32),
        mode=_MODES.index(mode),
        worst_case=_WORST_CASES.index(worst_case),
        residual_weight=residual_weight,
        margin=margin,
        effectiveness_min=-1.0 if effectiveness_min is None else effectiveness_min,
        rank_tolerance=rank_tolerance,
        max_newton=max_newton,
        warm=warm,
    )
    raw["status"] = _STATUSES[raw["status"]]
    return Solutions(**{name: value.reshape(batch + value.shape[1:]) for name, value in raw.items()})


@dataclass(frozen=True)
class AttainableSet:
    """All torques that commands inside their limits can produce: a zonotope in three dimensions.

    Attributes
    ----------
    centre
        (3,) N m.
    generators
        (3, n) N m: half of what each actuator can move the torque. The set is ``centre + generators @ [-1, 1]^n``.
    normals
        (f, 3) unit outward normals of its faces; a flat set has its plane from both sides.
    heights
        (f,) N m: the set is where ``normals @ (torque - centre) <= heights``.
    """

    centre: Floats
    generators: Floats
    normals: Floats
    heights: Floats

    @property
    def volume(self) -> float:
        """(N m)^3; zero for a flat set."""
        triples = combinations(range(self.generators.shape[1]), 3)
        return 8 * sum(abs(float(np.linalg.det(self.generators[:, t]))) for t in triples)

    @property
    def in_every_direction(self) -> float:
        """N m: the largest torque that can be had whatever its direction; negative if zero torque is out of reach."""
        return float(np.min(self.heights + self.normals @ self.centre))

    def support(self, direction: ArrayLike) -> Floats:
        """Largest component along `direction` (..., 3), which need not be a unit vector; (...)."""
        v = np.asarray(direction, float)
        return np.asarray(v @ self.centre + np.abs(v @ self.generators).sum(axis=-1))

    def contains(self, torque: ArrayLike, tolerance: float = 1e-12) -> NDArray[np.bool_]:
        """Whether torques (..., 3) can be had, up to `tolerance` (N m)."""
        off = np.asarray(torque, float) - self.centre
        return np.asarray(np.all(off @ self.normals.T <= self.heights + tolerance, axis=-1))

    def radius(self, direction: ArrayLike) -> Floats:
        """N m: the largest torque along `direction` (..., 3) from zero torque; nan if there is none. Exact.

        The ray is cut with every face; nothing is iterated.
        """
        v = np.asarray(direction, float)
        norm = np.linalg.norm(v, axis=-1, keepdims=True)
        unit = np.divide(v, norm, out=np.full_like(v, np.nan), where=norm > 0)
        size = np.abs(self.generators).sum() + np.abs(self.centre).sum()
        rate = unit @ self.normals.T  # (..., f)
        room = self.heights + self.normals @ self.centre
        with np.errstate(divide="ignore", invalid="ignore"):
            at = room / rate
        parallel = np.abs(rate) <= 1e-12
        leaves = np.where(~parallel & (rate > 0), at, np.inf).min(axis=-1)
        enters = np.where(~parallel & (rate < 0), at, -np.inf).max(axis=-1)
        outside = (parallel & (room < -1e-12 * size)).any(axis=-1)
        reached = ~outside & (leaves >= -1e-12 * size) & (leaves >= enters - 1e-12 * size)
        return np.asarray(np.where(reached, np.maximum(leaves, 0.0), np.nan))

    def moved(self, by: ArrayLike) -> AttainableSet:
        """The same set about another centre: what a torque (3,) that nobody commands makes of it."""
        return replace(self, centre=self.centre + np.asarray(by, float))

    def faces(self) -> list[Floats]:
        """The polygons of the surface: corners (k, 3) in order, seen from outside counter-clockwise.

        Where the set is flat, some are edges or points.
        """
        return [self._face(normal) for normal in self.normals]

    def vertices(self) -> Floats:
        """(k, 3) N m, the corners, each once."""
        corners = np.concatenate(self.faces()) if len(self.normals) else self.centre[None]
        size = np.abs(self.generators).sum()
        _, first = np.unique(np.round(corners / (1e-9 * size)), axis=0, return_index=True) if size > 0 else (None, [0])
        return np.asarray(corners[np.sort(first)])

    def _face(self, normal: Floats) -> Floats:
        reach = normal @ self.generators
        free = np.abs(reach) <= 1e-9 * np.abs(self.generators).max()
        middle = self.centre + self.generators @ np.where(free, 0.0, np.sign(reach))
        across = np.linalg.svd(normal[None])[2][1:]  # an orthonormal basis of the face's plane
        if np.dot(np.cross(across[0], across[1]), normal) < 0:
            across = across[::-1]
        edges = (across @ self.generators[:, free]).T
        edges = edges[np.linalg.norm(edges, axis=1) > 1e-12 * np.abs(self.generators).max()]
        edges *= np.where((edges[:, 1] < 0) | ((edges[:, 1] == 0) & (edges[:, 0] < 0)), -1.0, 1.0)[:, None]
        edges = edges[np.argsort(np.arctan2(edges[:, 1], edges[:, 0]))]
        if len(edges) == 0:
            return np.asarray(middle[None])
        half = -edges.sum(axis=0) + 2 * np.concatenate([np.zeros((1, 2)), np.cumsum(edges, axis=0)])
        ring = np.concatenate([half[:-1], -half[:-1]])
        return np.asarray(middle + ring @ across)


def attainable_set(
    D: ArrayLike,
    up: ArrayLike,
    lo: ArrayLike | None = None,
    effectiveness: ArrayLike = 1.0,
    *,
    rank_tolerance: float = DEFAULT_RANK_TOLERANCE,
) -> AttainableSet:
    """The torques within reach of commands ``lo <= u <= up``, along the axes that allocators serve.

    Parameters
    ----------
    D
        (3, n) actuator axes in columns.
    up, lo
        (n,) or number, N m, finite; `lo` is ``-up`` unless given.
    effectiveness
        (n,) or number, delivered / commanded.
    rank_tolerance
        As of the allocators: an axis of torque with a smaller singular value of ``D diag(effectiveness)``, relative to
        the largest, is dropped, and the set is flat; 0 keeps every axis.

    Raises
    ------
    ValueError
        Another shape, limits that are not finite or in the wrong order.
    """
    axes = np.asarray(D, float)
    if axes.ndim != 2 or axes.shape[0] != 3:
        raise ValueError(f"D {axes.shape} is not (3, actuators)")
    n = axes.shape[1]
    upper = np.broadcast_to(np.asarray(up, float), n)
    lower = -upper if lo is None else np.broadcast_to(np.asarray(lo, float), n)
    if not (np.all(np.isfinite(upper)) and np.all(np.isfinite(lower)) and np.all(lower <= upper)):
        raise ValueError("limits must be finite, lo <= up")
    A = axes * np.broadcast_to(np.asarray(effectiveness, float), n)
    A = served_axes(A, rank_tolerance) @ A
    generators = A * ((upper - lower) / 2)
    normals = _normals(generators)
    return AttainableSet(A @ ((upper + lower) / 2), generators, normals, np.abs(normals @ generators).sum(axis=1))


def served_axes(A: ArrayLike, rank_tolerance: float = DEFAULT_RANK_TOLERANCE) -> Floats:
    """Projector (3, 3) onto the axes of torque that allocators serve with the effective geometry `A` (3, n).

    An axis with a singular value of `A` below `rank_tolerance` times the largest may be nothing but misalignment: it is
    dropped.
    """
    axes = np.asarray(A, float)
    if axes.ndim != 2 or axes.shape[0] != 3:
        raise ValueError(f"A {axes.shape} is not (3, actuators)")
    if axes.shape[1] > 16:
        axes = np.asarray(np.linalg.qr(axes.T, mode="r")).T  # of the same singular values and axes
    return np.eye(3) if rank_tolerance <= 0.0 else np.asarray(_core.served_axes(axes, rank_tolerance))


def _normals(generators: Floats) -> Floats:
    """Unit normals of the faces: across every pair of generators, and, where the set is flat, its plane's."""
    size = np.linalg.norm(generators, axis=0).max(initial=0.0)
    used = generators[:, np.linalg.norm(generators, axis=0) > 1e-12 * size] if size > 0 else generators[:, :0]
    left, values, _ = np.linalg.svd(used, full_matrices=True) if used.size else (np.eye(3), np.zeros(0), None)
    rank = int(np.sum(values > 1e-12 * size))
    outside = left[:, rank:].T  # nothing moves along these
    if rank == 3:
        pairs = [np.cross(used[:, i], used[:, j]) for i, j in combinations(range(used.shape[1]), 2)]
    elif rank == 2:
        pairs = [np.cross(outside[0], used[:, i]) for i in range(used.shape[1])]
    else:
        pairs = [left[:, 0]] if rank == 1 else []
    found = np.array([p for p in [*pairs, *outside] if np.linalg.norm(p) > 1e-12 * size**2 or rank < 3]).reshape(-1, 3)
    found /= np.linalg.norm(found, axis=1, keepdims=True)
    both = np.concatenate([found, -found])
    _, first = np.unique(np.round(both, 9) + 0.0, axis=0, return_index=True)
    return np.asarray(both[np.sort(first)])
