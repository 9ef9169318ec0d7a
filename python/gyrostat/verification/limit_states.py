# SPDX-License-Identifier: MIT
"""limit_states [--repeats N] [--write FILE.csv]: subset simulation on failures whose probabilities are known exactly.

Run as ``python -m gyrostat.verification.limit_states``. Printed for each limit state: mean of the estimates over the
truth, coefficient of variation of one replicate, how often the 95 % interval holds the truth, and flights a replicate;
``--write docs/figures/limit_states.csv`` renews the table of the documentation.
Exit status 1 when a mean is more than 5 % off or fewer than 90 % of the intervals hold. Takes some minutes on a core.
"""

from __future__ import annotations

import argparse
import csv
import math
import sys
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy import special

from gyrostat.files import replacing
from gyrostat.verification.rare import Margin, SubsetSimulation
from gyrostat.verification.words import Words, uniforms

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class LimitState:
    """A margin of known probability.

    Attributes
    ----------
    name
        As printed.
    inputs, blocks
        Of a point.
    margin
        Positive: lost.
    probability
        That it is.
    """

    name: str
    inputs: int
    margin: Margin
    probability: float
    blocks: int = 0


def linear(inputs: int, probability: float) -> LimitState:
    """A sum of the inputs beyond a threshold: a half-space."""
    beta = -float(special.ndtri(probability))

    def margin(z: Floats) -> Floats:
        return np.asarray(z.sum(axis=1) / math.sqrt(inputs) - beta)

    return LimitState(f"linear, d = {inputs}", inputs, margin, probability)


def series(above: float, below: float, inputs: int = 10) -> LimitState:
    """One input beyond either of two thresholds: two failure regions."""

    def margin(z: Floats) -> Floats:
        return np.asarray(np.maximum(z[:, 0] - above, -z[:, 0] - below))

    name = f"series z1 > {above:g} or z1 < {-below:g}"
    return LimitState(name, inputs, margin, float(special.ndtr(-above) + special.ndtr(-below)))


def wheel() -> LimitState:
    """One actuator of four fails, chosen by an input; only the last one matters before severity is extreme."""

    def margin(z: Floats) -> Floats:
        which = np.floor(4 * special.ndtr(z[:, 0]))
        return np.asarray((z[:, 1] + z[:, 2]) / math.sqrt(2) - np.where(which == 3, 3.0, 5.5))

    return LimitState("one wheel of four fails", 3, margin, float(special.ndtr(-3) + 3 * special.ndtr(-5.5)) / 4)


def plateau() -> LimitState:
    """Five of six inputs beyond 1: the margin has seven values."""
    p = float(special.ndtr(-1))

    def margin(z: Floats) -> Floats:
        return np.asarray((z > 1).sum(axis=1) - 4.5)

    return LimitState("plateau: 5 of 6 inputs beyond 1", 6, margin, 6 * p**5 * (1 - p) + p**6)


def noise(blocks: int, probability: float) -> LimitState:
    """A sum of blocks of noise, known by their versions alone, beyond a threshold."""
    beta = -float(special.ndtri(probability))

    def margin(z: Floats, versions: Words) -> Floats:
        del z
        return np.asarray(special.ndtri(uniforms(versions)).sum(axis=1) / math.sqrt(blocks) - beta)

    return LimitState(f"noise, {blocks} blocks", 0, margin, probability, blocks)


def limit_states() -> list[LimitState]:
    """Those of docs/verification.md."""
    linears = [linear(d, p) for p in (1e-3, 1e-5, 1e-7) for d in (10, 50)]
    return [*linears, series(3.5, 3.7), series(4.0, 4.0), wheel(), plateau()]


@dataclass(frozen=True)
class Score:
    """Of many runs on one limit state: see the module."""

    bias: float
    variation: float
    coverage: float
    flights: float
    unconverged: int


def score(state: LimitState, repeats: int, population: int = 500, replicates: int = 8) -> Score:
    """Fly a limit state `repeats` times, with seeds from 1.

    A run of which a replicate found nothing has no interval: it counts as one that does not hold the truth.
    """
    runs = [
        SubsetSimulation(state.inputs, state.blocks, seed, population, replicates=replicates).run(state.margin)
        for seed in range(1, repeats + 1)
    ]
    p = np.array([r.replicates if r.replicates.size else np.zeros(replicates) for r in runs])
    flights = [population * (len(r.levels) + 1) for r in runs]
    held = [r.interval[0] <= state.probability <= r.interval[1] for r in runs]
    bad = sum(r.status != "converged" for r in runs)
    return Score(
        float(p.mean()) / state.probability,
        float(p.std(ddof=1) / p.mean()),
        float(np.mean(held)),
        float(np.mean(flights)),
        bad,
    )


HEAD = ("limit state", "probability", "mean / probability", "cv of a replicate", "cover of the 95 % interval",
        "flights a replicate")  # fmt: skip


def main() -> int:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--repeats", type=int, default=200, help="runs of eight replicates for each limit state")
    parser.add_argument("--population", type=int, default=500, help="flights of a replicate at a level")
    parser.add_argument("--write", type=Path, metavar="FILE.csv", help="the table, as a file")
    given = parser.parse_args()
    rows: list[tuple[str, ...]] = [HEAD]
    print(f"{'limit state':34} {'p':>10} {'mean / p':>9} {'cv':>6} {'cover %':>8} {'flights':>8} {'not conv.':>10}")
    holds = True
    for state in [*limit_states(), noise(60, 1e-3), noise(60, 1e-5)]:
        s = score(state, given.repeats, given.population)
        print(
            f"{state.name:34} {state.probability:>10.4g} {s.bias:>9.3f} {s.variation:>6.2f} {100 * s.coverage:>8.1f}"
            f" {s.flights:>8.0f} {s.unconverged:>10}",
            flush=True,
        )
        rows.append(
            (state.name, f"{state.probability:.4g}", f"{s.bias:.3f}", f"{s.variation:.2f}", f"{100 * s.coverage:.1f} %",
             f"{s.flights:.0f}")
        )  # fmt: skip
        holds = holds and abs(s.bias - 1) <= 0.05 and s.coverage >= 0.9
    if given.write is not None:
        with replacing(given.write) as temporary, temporary.open("w", newline="") as file:
            csv.writer(file, lineterminator="\n").writerows(rows)
    return 0 if holds else 1


if __name__ == "__main__":
    sys.exit(main())
