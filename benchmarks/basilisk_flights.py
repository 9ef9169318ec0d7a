# SPDX-License-Identifier: MIT
"""Flights of Basilisk's own Monte Carlo facility: its plain closed loop, FTC-4RW, 200 s at 100 Hz, drawn initial rates.

``python benchmarks/basilisk_flights.py [FLIGHTS] [PROCESSES]`` prints CPU seconds a flight, and wall-clock seconds, as
JSON. ``benchmarks/campaign.py --basilisk`` calls it beside flights of its own. Needs `bsk`.
"""

from __future__ import annotations

import json
import resource
import sys
import tempfile
import time
from typing import Any

import peers
from Basilisk.utilities import macros
from Basilisk.utilities.MonteCarlo.Controller import Controller
from Basilisk.utilities.MonteCarlo.Dispersions import NormalVectorCartDispersion


def create() -> Any:
    """A simulation before its initialisation; the dispersion finds the body in it."""
    return peers.basilisk_simulation()


def execute(sim: Any) -> None:
    """One flight."""
    sim.InitializeSimulation()
    sim.ConfigureStopTime(macros.sec2nano(peers.DURATION))
    sim.ExecuteSimulation()


def main() -> None:
    """Fly and time."""
    flights = int(sys.argv[1]) if len(sys.argv) > 1 else 16
    processes = int(sys.argv[2]) if len(sys.argv) > 2 else 2
    controller = Controller()
    controller.setSimulationFunction(create)
    controller.setExecutionFunction(execute)
    controller.setExecutionCount(flights)
    controller.setThreadCount(processes)
    controller.setShouldDisperseSeeds(True)
    controller.setVerbose(False)
    controller.addDispersion(NormalVectorCartDispersion("body.hub.omega_BN_BInit", 0.0, 0.01))
    with tempfile.TemporaryDirectory() as folder:
        controller.setArchiveDir(folder + "/flights")
        started, before = time.monotonic(), _cpu()
        failed = controller.executeSimulations()
        wall, used = time.monotonic() - started, _cpu() - before
    if failed:
        raise SystemExit(f"failed: {failed}")
    print(json.dumps({"flights": flights, "cpu": used / flights, "wall": wall / flights}))


def _cpu() -> float:
    return sum(
        r.ru_utime + r.ru_stime for r in map(resource.getrusage, (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN))
    )


if __name__ == "__main__":
    main()
