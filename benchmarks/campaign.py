# SPDX-License-Identifier: MIT
"""Flights of a campaign a second, into a folder, against the same flights of `Experiment` and against Basilisk's.

The case: 200 s at 100 Hz, Runge-Kutta, four wheels, two faults, gyro and attitude noise, finite-time observer, integral
sliding mode, pseudo-inverse, four measures. Where `bsk` is installed, its own Monte Carlo facility flies its plain
closed loop in the same run, in two processes and in one. Then the highest memory of processes that fly up to 10^5
short flights. ``python benchmarks/campaign.py [RUNS]``
"""

from __future__ import annotations

import json
import resource
import subprocess
import sys
import tempfile
import time
from importlib.util import find_spec
from pathlib import Path

import gyrostat as gs
from gyrostat.campaign import dist


def case() -> gs.Campaign:
    wheel = {"dist": "choice", "of": [0, 1, 2, 3]}
    return gs.Campaign(
        "wheel2_degraded",
        set={
            "duration": 200.0,
            "integrator": "rk4",
            "faults": [],
            "sensors": [{"type": "gyro", "noise": 1e-6}, {"type": "attitude", "noise": 1e-5}],
        },
        vary={"initial.omega_BN_B": dist.normal(0.0, 0.01, each=3), "truth.dJ_B": dist.inertia(0.05)},
        faults=[
            {
                "name": name,
                "actuator": wheel,
                "t_on": {"dist": "uniform", "low": 5.0, "high": 100.0},
                "kind": [{"type": "loss_of_effectiveness", "remaining": {"dist": "uniform", "low": 0.2, "high": 0.8}}],
            }
            for name in ("first", "second")
        ],
        measure={
            "settling": {"metric": "settling_time", "signal": "error.angle", "band": 1.7e-3, "after": "last_fault"},
            "final": {"metric": "window_max", "signal": "error.angle", "last": 5.0},
            "peak": {"metric": "window_max", "signal": "error.angle", "t0": "last_fault"},
            "energy": {"metric": "energy", "signal": "allocation.u"},
        },
        success={"final": {"below": 1.7e-3, "scale": "log"}},
    )


def memory(runs: int, folder: str) -> float:
    """Highest of a process of its own that flies short flights, MB."""
    code = (
        "import resource, gyrostat as gs\n"
        "c = gs.Campaign('wheel2_degraded', set={'duration': 10.0, 'dt': 0.1, 'integrator': 'rk4', 'faults': []},\n"
        "                vary={'initial.omega_BN_B': {'dist': 'normal', 'mean': 0.0, 'std': 0.01, 'each': 3}})\n"
        f"c.run({runs}, out={folder!r})\n"
        "print(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024)"
    )
    return float(subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout)


def basilisk(processes: int) -> float:
    """CPU seconds of a flight of its Monte Carlo facility."""
    command = [sys.executable, str(Path(__file__).with_name("basilisk_flights.py")), "16", str(processes)]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    return float(json.loads(done.stdout.splitlines()[-1])["cpu"])


def main() -> None:
    runs = int(sys.argv[1]) if len(sys.argv) > 1 else 400
    campaign = case()
    cell = campaign.cells[""]
    values = campaign.drawn(campaign.points(0, runs)).values
    _into_a_folder(campaign, 1, 1)  # loads PyArrow
    print("flights of the case                       a second   CPU ms a flight")
    used = 0.0
    for jobs in (1, 2):
        for name, fly in (
            ("experiment", lambda jobs: cell.experiment.fly(values, threads=jobs)),
            ("campaign, into a folder", lambda jobs: _into_a_folder(campaign, runs, jobs)),
        ):
            cpu, started = _cpu(), time.monotonic()
            fly(jobs)
            passed, used = time.monotonic() - started, (_cpu() - cpu) / runs
            print(f"{name:26} {jobs} threads {runs / passed:12.0f} {1000 * used:17.1f}")
    if find_spec("Basilisk") is None:
        print("Basilisk: not installed", file=sys.stderr)
    else:
        for processes in (2, 1):
            theirs = basilisk(processes)
            print(f"Basilisk, plain loop, {processes} processes {1000 * theirs:25.1f}, {theirs / used:.0f} times that")
    with tempfile.TemporaryDirectory() as folder:
        for count in (1_000, 10_000, 100_000):
            print(
                f"highest memory, {count:7d} runs: {memory(count, str(Path(folder) / str(count))):6.0f} MB", flush=True
            )


def _into_a_folder(campaign: gs.Campaign, runs: int, jobs: int) -> None:
    with tempfile.TemporaryDirectory() as folder:
        campaign.run(runs, out=Path(folder) / "flown", jobs=jobs, chunk=min(runs, 500))


def _cpu() -> float:
    usage = resource.getrusage(resource.RUSAGE_SELF)
    return usage.ru_utime + usage.ru_stime


if __name__ == "__main__":
    main()
