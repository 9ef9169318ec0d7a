# SPDX-License-Identifier: MIT
"""What bending costs: a sample of `flexible_4` against one of the same vehicle without its four modes, under rk4.

``python benchmarks/flexible.py`` prints microseconds of CPU a sample, the best of several flights of 40 000 samples
taken in turn, and how often cvode was restarted over the commands and faults of the shipped flight.
"""

from __future__ import annotations

import time

import gyrostat as gs

SAMPLES, REPEATS = 40_000, 9


def once(scenario: gs.Scenario) -> float:
    """Microseconds a sample."""
    begins = time.process_time()
    scenario.run(channels=["error.angle"], every=1000)
    return 1e6 * (time.process_time() - begins) / SAMPLES


def main() -> None:
    """Fly and print."""
    shipped = gs.Scenario.load("flexible_4")
    print(f"{'steps a sample':16}{'flexible':>10}{'rigid':>10}{'ratio':>8}")
    for substeps in (1, 2, 4):
        bends = shipped.replace(
            duration=SAMPLES * shipped.dt, faults=[], integrator={"type": "rk4", "substeps": substeps}
        )
        rigid = bends.replace(flexible=None)
        pairs = [(once(bends), once(rigid)) for _ in range(REPEATS)]
        with_modes, without = (min(each) for each in zip(*pairs, strict=True))
        print(f"{substeps:<16}{with_modes:10.2f}{without:10.2f}{with_modes / without:8.2f}")
    restarts = shipped.replace(integrator="cvode").run(channels=["error.angle"]).statistics["restarts"]
    commands, faults = round(shipped.duration / shipped.dt), len(shipped.faults)
    print(f"cvode over {commands} commands and {faults} faults: {restarts - 1} restarts")


if __name__ == "__main__":
    main()
