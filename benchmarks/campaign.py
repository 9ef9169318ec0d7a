# SPDX-License-Identifier: MIT
"""CPU time of the flights of a campaign, into a folder, against the bare loop and against Basilisk's.

The case: 200 s at 100 Hz, Runge-Kutta, four wheels, two faults, gyro and attitude noise, finite-time observer, integral
sliding mode, pseudo-inverse, four measures. Taken in turns, five times each: `Experiment`, the campaign, both on one
thread and on two, and, where it is built (``cmake --build --preset bench -t bench_experiment``), the bare C++ loop.
Where `bsk` is installed, its own Monte Carlo facility flies its plain closed loop in the same run, in two processes and
in one. Then the highest memory of processes that fly up to 10^5 short flights. ``python benchmarks/campaign.py [RUNS]``
"""

from __future__ import annotations

import json
import resource
import subprocess
import sys
import tempfile
from collections.abc import Callable
from functools import partial
from importlib.util import find_spec
from pathlib import Path
from statistics import median
from time import perf_counter

import gyrostat as gs
from gyrostat.campaign import dist

BENCH = Path(__file__).parents[1] / "build" / "bench" / "benchmarks" / "bench_experiment"
ROUNDS = 5


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


def bare() -> float:
    """CPU seconds of a flight of the C++ loop around the same objects, without metrics."""
    command = [str(BENCH), "--benchmark_filter=^bare/campaign$", "--benchmark_format=json"]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    return 1e-6 * float(json.loads(done.stdout)["benchmarks"][0]["cpu_time"])


def main() -> None:
    runs = int(sys.argv[1]) if len(sys.argv) > 1 else 400
    campaign, share = case(), -(-runs // ROUNDS)
    cell = campaign.cells[""]
    values = campaign.drawn(campaign.points(0, share)).values
    _into_a_folder(campaign, 1, 1)  # loads PyArrow
    ways: dict[str, Callable[[], float]] = {}
    for jobs in (1, 2):
        ways[f"experiment, {jobs} threads"] = _timed(partial(cell.experiment.fly, values, threads=jobs), share)
        ways[f"campaign, {jobs} threads"] = _timed(partial(_into_a_folder, campaign, share, jobs), share)
    if BENCH.exists():
        ways["bare loop"] = bare
    used: dict[str, list[float]] = {name: [] for name in ways}
    for _ in range(ROUNDS):
        for name, fly in ways.items():
            used[name].append(fly())
    one = median(used["campaign, 1 threads"])
    print("CPU of a flight                  ms   of the campaign's")
    for name, seconds in used.items():
        print(f"{name:24} {1000 * median(seconds):11.2f} {median(seconds) / one:10.3f}", flush=True)
    by_clock = [median(_elapsed(campaign, share, jobs) for _ in range(ROUNDS)) for jobs in (1, 2)]
    print(f"by the clock, where two cores are free: {share / by_clock[0]:.0f} and {share / by_clock[1]:.0f} flights/s "
          f"on one and two threads, {by_clock[0] / by_clock[1]:.2f} times", flush=True)  # fmt: skip
    if find_spec("Basilisk") is None:
        print("Basilisk: not installed", file=sys.stderr)
    else:
        for processes in (2, 1):
            theirs = basilisk(processes)
            print(f"Basilisk, {processes} processes {1000 * theirs:16.2f} {theirs / one:10.1f}", flush=True)
    with tempfile.TemporaryDirectory() as folder:
        for count in (1_000, 10_000, 100_000):
            print(
                f"highest memory, {count:7d} runs: {memory(count, str(Path(folder) / str(count))):6.0f} MB", flush=True
            )


def _timed(fly: Callable[[], object], flights: int) -> Callable[[], float]:
    """CPU seconds of one of so many flights."""

    def timed() -> float:
        before = _cpu()
        fly()
        return (_cpu() - before) / flights

    return timed


def _into_a_folder(campaign: gs.Campaign, runs: int, jobs: int) -> None:
    with tempfile.TemporaryDirectory() as folder:
        campaign.run(runs, out=Path(folder) / "flown", jobs=jobs, chunk=min(runs, 500))


def _elapsed(campaign: gs.Campaign, runs: int, jobs: int) -> float:
    """Seconds by the clock."""
    start = perf_counter()
    _into_a_folder(campaign, runs, jobs)
    return perf_counter() - start


def _cpu() -> float:
    usage = resource.getrusage(resource.RUSAGE_SELF)
    return usage.ru_utime + usage.ru_stime


if __name__ == "__main__":
    main()
