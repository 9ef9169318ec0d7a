# SPDX-License-Identifier: MIT
"""Same scenario, same seed: the same bits, whoever flies it and whoever watches."""

from __future__ import annotations

import hashlib
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import gyrostat as gs

CHANNELS = ["truth.q_NB", "truth.omega_BN_B", "allocation.u"]


def fingerprint(result: gs.Result) -> str:
    digest = hashlib.sha256()
    for name in CHANNELS:
        digest.update(result[name].tobytes())
    return digest.hexdigest()


def test_twice_gives_the_same_bits(scenario: gs.Scenario) -> None:
    assert fingerprint(scenario.run()) == fingerprint(scenario.run())


def test_the_seed_matters(scenario: gs.Scenario) -> None:
    assert fingerprint(scenario.run()) != fingerprint(scenario.replace(seed=8).run())


def test_another_process_gives_the_same_bits(scenario: gs.Scenario, tmp_path: Path) -> None:
    scenario.to_toml(tmp_path / "same.toml")
    program = (
        "import sys; sys.path.insert(0, sys.argv[2]); import gyrostat as gs; from test_determinism import fingerprint;"
        "print(fingerprint(gs.Scenario.from_toml(sys.argv[1]).run()))"
    )
    command = [sys.executable, "-c", program, str(tmp_path / "same.toml"), str(Path(__file__).parent)]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    assert done.stdout.strip() == fingerprint(scenario.run())


def test_what_is_recorded_does_not_change_the_run(scenario: gs.Scenario) -> None:
    everything = scenario.run(channels=[c["name"] for c in scenario.channel_names()])
    assert fingerprint(everything) == fingerprint(scenario.run(channels=CHANNELS))
    sparse = scenario.run(channels=CHANNELS, every=100)
    for name in CHANNELS:
        assert sparse[name].tobytes() == everything[name][::100].tobytes()


def test_shadows_do_not_change_the_run(scenario: gs.Scenario) -> None:
    watched = scenario.replace(shadows=[{"observer": "finite_time_disturbance"}, {"observer": "passthrough"}])
    assert fingerprint(watched.run(channels=CHANNELS)) == fingerprint(scenario.run(channels=CHANNELS))


def test_threads_do_not_change_the_runs(scenario: gs.Scenario) -> None:
    seeds = range(6)
    alone = [fingerprint(scenario.replace(seed=s).run()) for s in seeds]
    with ThreadPoolExecutor(4) as pool:
        together = list(pool.map(lambda s: fingerprint(scenario.replace(seed=s).run()), seeds))
    assert together == alone
