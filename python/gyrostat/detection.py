# SPDX-License-Identifier: MIT
"""How well faults were detected and isolated, and which faults nobody could: metrics for every observer and detector.

A change of an actuator's true effectiveness is *detected* by the first declaration within a horizon after it; it
is *isolated* when this actuator alone is named, *ambiguous* when others are named too, *wrong* when it is not named. A
declaration that belongs to no change is a false alarm.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from gyrostat._core import catalogue
from gyrostat.components import Component
from gyrostat.results import Result
from gyrostat.scenario import Scenario

Array = NDArray[np.float64]
Answer = Literal["isolated", "ambiguous", "wrong", "missed"]

ANSWERS: tuple[Answer, ...] = ("isolated", "ambiguous", "wrong", "missed")


@dataclass(frozen=True)
class Change:
    """A jump of an actuator's true effectiveness and what became of it."""

    t: float
    """When it happened, s."""
    actuator: int
    size: float
    """New less old effectiveness."""
    answer: Answer
    delay: float | None
    """From the jump to the declaration, s; None when missed."""


@dataclass(frozen=True)
class DetectionReport:
    """Every change with its answer, and what was declared without one."""

    changes: tuple[Change, ...]
    false_alarms: tuple[float, ...]
    """Instants of declarations that belong to no change, s."""
    isolation: NDArray[np.int_]
    """Counts, shape (n, n + 2): row the actuator that changed; columns the actuator named alone, ambiguous, missed."""
    error: Array
    """Root mean square of the effectiveness less the truth, an actuator, shape (n,); with ``detector.effectiveness`` it
    counts what the detector maps of a torque estimate onto the actuators that push."""

    @property
    def missed(self) -> int:
        """Number of changes without a declaration."""
        return self.count("missed")

    def count(self, answer: Answer) -> int:
        """Number of changes with this answer."""
        return sum(c.answer == answer for c in self.changes)

    @property
    def delays(self) -> Array:
        """Of the detected changes, s."""
        return np.array([c.delay for c in self.changes if c.delay is not None])


def evaluate(
    changes: Sequence[tuple[float, int, float]],
    declarations: Sequence[tuple[float, int]],
    actuators: int,
    horizon: float = 4.0,
) -> tuple[tuple[Change, ...], tuple[float, ...], NDArray[np.int_]]:
    """Match declarations with changes.

    Parameters
    ----------
    changes
        (time s, actuator, size), in order of time.
    declarations
        (time s, bit mask of the actuators named), in order of time.
    actuators
        Number of actuators, n.
    horizon
        s; a declaration later than that after a change does not belong to it. Each belongs to the latest change that it
        names, else to the latest change that has no declaration yet; several changes at once may share one.

    Returns
    -------
    changes, false_alarms, isolation
        As in `DetectionReport`.
    """
    owner: dict[int, tuple[float, int]] = {}
    false: list[float] = []
    for t, mask in declarations:
        open_ = [k for k, c in enumerate(changes) if c[0] - 1e-9 <= t <= c[0] + horizon and k not in owner]
        named = [k for k in open_ if mask >> changes[k][1] & 1]
        if named:
            owner |= dict.fromkeys(named, (t, mask))
        elif open_:
            owner[open_[-1]] = (t, mask)
        else:
            false.append(t)
    isolation = np.zeros((actuators, actuators + 2), dtype=int)
    found: list[Change] = []
    for k, (t, actuator, size) in enumerate(changes):
        if k not in owner:
            isolation[actuator, -1] += 1
            found.append(Change(t, actuator, size, "missed", None))
            continue
        when, mask = owner[k]
        named = [j for j in range(actuators) if mask >> j & 1]
        answer: Answer = "wrong" if actuator not in named else "isolated" if len(named) == 1 else "ambiguous"
        isolation[actuator, named[0] if len(named) == 1 else actuators] += 1
        found.append(Change(t, actuator, size, answer, when - t))
    return tuple(found), tuple(false), isolation


def true_changes(result: Result, least: float) -> list[tuple[float, int, float]]:
    """Jumps of at least `least` from one recorded sample to the next, (time s, actuator, size).

    A sample shows the interval that ended there, so the jump is the start of that interval.
    """
    e = result["truth.effectiveness"][1:]
    jump = np.diff(e, axis=0)
    rows, columns = np.nonzero(np.abs(jump) >= least)
    return [(float(result.t[1 + k]), int(j), float(jump[k, j])) for k, j in zip(rows, columns, strict=True)]


def declarations(result: Result, role: str = "") -> list[tuple[float, int]]:
    """(time s, bit mask named) of each declaration of the loop's detector, or of a shadow's (``"shadow0"``).

    Needs ``detection.event``, or for the loop's own detector the events of the run, and of a `threshold` detector
    ``detector.declared``; without the latter the mask is what is new in ``detection.changed``. A recovery is none.
    """
    prefix = f"{role}." if role else ""
    if f"{prefix}detection.event" in result:
        rows = np.nonzero(np.diff(result[f"{prefix}detection.event"]) > 0)[0] + 1
        times = [float(t) for t in result.t[rows]]
    else:
        times = [e.t for e in result.events if e.name == f"{prefix}detector.event"]
        rows = np.minimum(np.searchsorted(result.t, np.array(times) - 1e-9), len(result) - 1)
    named = f"{prefix}detector.declared"
    if named in result:
        masks = result[named][rows].astype(int).tolist()
        return [(t, mask) for t, mask in zip(times, masks, strict=True) if mask]
    changed = result[f"{prefix}detection.changed"].astype(int)
    masks = []
    for k in rows:
        new, gone = int(changed[k] & ~changed[k - 1]), int(changed[k - 1] & ~changed[k])
        masks.append(new or (0 if gone else int(changed[k])))
    return [(t, mask) for t, mask in zip(times, masks, strict=True) if mask]


def detection_report(result: Result, role: str = "", *, least: float = 0.15, horizon: float = 4.0) -> DetectionReport:
    """Delay, misses, false alarms, isolation and estimation error of one observer and detector.

    Parameters
    ----------
    result
        Must hold ``truth.effectiveness``, the role's ``detector.effectiveness`` (or ``estimate.effectiveness``),
        ``detection.event`` and ``detector.declared`` (or ``detection.changed``), recorded at every sample.
    role
        "" for the pair that closes the loop, ``"shadow0"``, ... for those beside it.
    least
        Smallest jump of the effectiveness that ought to be found.
    horizon
        s, how long after a jump a declaration still belongs to it.
    """
    e = result["truth.effectiveness"]
    prefix = f"{role}." if role else ""
    mapped, own = f"{prefix}detector.effectiveness", f"{prefix}estimate.effectiveness"
    estimate = result[mapped if mapped in result else own]
    found, false, isolation = evaluate(true_changes(result, least), declarations(result, role), e.shape[1], horizon)
    error = np.sqrt(np.mean((estimate[1:] - e[1:]) ** 2, axis=0))
    return DetectionReport(found, false, isolation, error)


def compare(
    scenario: Scenario,
    observers: Mapping[str, Component | Mapping[str, Any] | str] | None = None,
    *,
    least: float = 0.15,
    horizon: float = 4.0,
) -> dict[str, DetectionReport]:
    """Hold observers against each other: all on the same measurements and commands, each with the scenario's detector.

    Parameters
    ----------
    scenario
        What is flown; its own observer closes the loop. Its detector must declare changes (`threshold`).
    observers
        By label; every observer of the catalogue with its default parameters when not given.
    least, horizon
        As in `detection_report`.

    Returns
    -------
    dict
        A report by label. An observer of one lumped torque is heard through the detector, which maps its ``d_B`` onto
        the actuators that push.
    """
    chosen = observers or {name: name for name in catalogue()["observer"]}
    detector = scenario.resolve()["detector"]
    roles = {label: f"shadow{k}" for k, label in enumerate(chosen)}
    wanted = ("detector.effectiveness", "detector.declared", "detection.event")
    beside = scenario.replace(
        shadows=[{"observer": observer, "detector": detector} for observer in chosen.values()], record=None
    )
    flown = beside.run(channels=["truth.effectiveness", *(f"{r}.{c}" for r in roles.values() for c in wanted)])
    return {label: detection_report(flown, role, least=least, horizon=horizon) for label, role in roles.items()}


@dataclass(frozen=True)
class Identifiability:
    """What torques can tell about the actuators' effectiveness, for a layout and a series of commands."""

    rank: int
    """Number of combinations of effectiveness that show."""
    hidden: Array
    """Orthonormal combinations that leave no trace, one a row, shape (k, n)."""
    silent: tuple[int, ...]
    """Actuators whose torque stays below the gate: nothing is known of them."""
    confused: tuple[tuple[int, int], ...]
    """Pairs whose traces are alike: a fault of one is explained by the other."""

    def __str__(self) -> str:
        parts = [f"{self.rank} of {self.hidden.shape[1]} effectiveness values show"]
        parts += [f"silent: actuators {', '.join(map(str, self.silent))}"] if self.silent else []
        parts += [f"not told apart: {', '.join(f'{i} and {j}' for i, j in self.confused)}"] if self.confused else []
        for row in self.hidden:
            if np.count_nonzero(np.abs(row) > 0.1) > 1:
                terms = " ".join(f"{x:+.2f} e{i}" for i, x in enumerate(row) if abs(x) > 0.1)
                parts.append(f"no trace of {terms}")
        return "; ".join(parts)


def identifiability(
    D_B: ArrayLike, commands: ArrayLike, *, gate: float = 0.0, tolerance: float = 1e-2
) -> Identifiability:
    """What is not identifiable: the null space of ``sum_k diag(u_k) D' D diag(u_k)``.

    Three torques a sample cannot tell four effectiveness values at one command; a series of commands that do not stay
    proportional can.

    Parameters
    ----------
    D_B
        Actuator axes, shape (3, n).
    commands
        One row a sample, N m, shape (k, n) or (n,).
    gate
        N m: entries below it are not used, as in the observers.
    tolerance
        Relative singular value that counts as zero, and distance of normalised traces that counts as the same.
    """
    D = np.asarray(D_B, dtype=float)
    u = np.atleast_2d(np.asarray(commands, dtype=float))
    torque = np.where(np.abs(u) * np.linalg.norm(D, axis=0) >= gate, u, 0.0)
    gram = (D.T @ D) * (torque.T @ torque)
    size = np.sqrt(np.diag(gram))
    silent = tuple(int(i) for i in np.nonzero(size <= tolerance * max(float(size.max()), 1e-300))[0])
    heard = [i for i in range(D.shape[1]) if i not in silent]
    scale = np.where(size > 0.0, size, 1.0)
    alike = gram / np.outer(scale, scale)
    values, vectors = np.linalg.eigh(alike)
    zero = values <= tolerance**2 * max(float(values.max()), 1e-300)
    confused = tuple((i, j) for i in heard for j in heard if i < j and 1.0 - abs(alike[i, j]) <= tolerance**2)
    hidden = vectors[:, zero].T / scale
    norms = np.linalg.norm(hidden, axis=1, keepdims=True)
    return Identifiability(int((~zero).sum()), hidden / np.where(norms > 0.0, norms, 1.0), silent, confused)


__all__ = [
    "ANSWERS",
    "Change",
    "DetectionReport",
    "Identifiability",
    "compare",
    "declarations",
    "detection_report",
    "evaluate",
    "identifiability",
    "true_changes",
]
