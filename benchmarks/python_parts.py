# SPDX-License-Identifier: MIT
"""What a Python object costs a sample in each role, beside the compiled run: ``python benchmarks/python_parts.py``.

FTC-4RW at 100 Hz under rk4, nothing recorded; the objects do as little as they can. CPU time, least of some runs: what
else the machine does adds to it.
"""

from __future__ import annotations

import csv
import sys
import time
from types import SimpleNamespace
from typing import Any

import gyrostat as gs

SAMPLES, REPEATS = 20_000, 7


NOTHING = (0.0, 0.0, 0.0)


def part(**functions: Any) -> SimpleNamespace:
    """An object that has these functions."""
    return SimpleNamespace(**functions)


def drive(**functions: Any) -> SimpleNamespace:
    """An actuator that gives what it is commanded."""
    return part(deliver=lambda _t, u, _h, _w: u, **functions)


def cpu(changes: dict[str, Any], channels: list[str], every: int) -> float:
    """Microseconds a sample, the least of some runs."""
    base = gs.Scenario.load("ftc_4rw").replace(integrator="rk4", duration=SAMPLES * 0.01, faults=[], disturbances=[])
    scenario = base.replace(**changes)
    times = []
    for _ in range(REPEATS):
        start = time.process_time()
        scenario.run(channels=channels, every=every)
        times.append(time.process_time() - start)
    return 1e6 * min(times) / SAMPLES


def main() -> None:
    """One row a role."""
    pulses = part(deliver=lambda _t, u, _h, _w: [(0.0, 2.0 * u), (0.005, 0.0)])
    telling = drive(telemetry=lambda: {"a": 1.0, "b": 2.0})
    cases: dict[str, dict[str, Any]] = {
        "none": {},
        "controller": {"controller": part(step=lambda *_: NOTHING)},
        "observer": {"observer": part(step=lambda y, _: gs.Estimate.healthy(y))},
        "navigator": {"navigator": part(step=lambda y: y)},
        "reference": {"reference": part(at=lambda _: (1.0, 0.0, 0.0, 0.0))},
        "sensor": {"sensors": [part(measure=lambda y: y)]},
        "fault": {"faults": [part(apply=lambda _, u: u)]},
        "disturbance": {"disturbances": [part(torque_B=lambda *_: NOTHING)]},
        "actuator": {"drives": {0: drive()}},
        "four actuators": {"drives": {i: drive() for i in range(4)}},
        "actuator, two values an interval": {"drives": {0: pulses}},
        "actuator, two numbers recorded": {"drives": {0: telling}},
    }
    table = csv.writer(sys.stdout, lineterminator="\n")
    table.writerow(["Python object", "us a sample", "beside none"])
    compiled = 0.0
    for name, changes in cases.items():
        recorded = name.endswith("recorded")
        us = cpu(changes, ["drive0.*"] if recorded else ["error.angle"], 1 if recorded else SAMPLES)
        compiled = compiled or us
        table.writerow([name, f"{us:.2f}", f"{us / compiled:.1f}"])


if __name__ == "__main__":
    main()
