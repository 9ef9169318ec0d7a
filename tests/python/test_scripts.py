# SPDX-License-Identifier: MIT
"""What the set-up says to somebody whose machine lacks something."""

from __future__ import annotations

import os
import subprocess
from pathlib import Path

import pytest

SCRIPTS = Path(__file__).parents[2] / "scripts"


def run(folder: Path, *command: str, **environment: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        command,
        cwd=folder,
        env={**os.environ, **environment},
        capture_output=True,
        text=True,
        check=False,
        timeout=60,
    )


@pytest.mark.parametrize(
    ("printed", "says"),
    [
        (
            "E: Failed to fetch http://mirror/pool/g++.deb  Connection failed",
            "not fetched: E: Failed to fetch http://mirror/pool/g++.deb",
        ),
        (
            "Failed to establish a new connection: name or service not known",
            "needs the network: run the same command again",
        ),
        (
            "cc1plus: error: writing: No space left on device",
            "ran out of disk: make room and run the same command again",
        ),
    ],
)
def test_a_failed_step_says_what_was_fetched_or_written(tmp_path: Path, printed: str, says: str) -> None:
    done = run(tmp_path, str(SCRIPTS / "step"), "part", "bash", "-c", f"echo '{printed}'; exit 7")
    assert done.returncode == 7
    assert says in done.stdout
    assert "build/log/part.log" in done.stdout


def test_a_step_that_failed_otherwise_guesses_nothing(tmp_path: Path) -> None:
    done = run(tmp_path, str(SCRIPTS / "step"), "part", "bash", "-c", "echo 'error: expected ;'; exit 1")
    assert "disk" not in done.stdout
    assert "network" not in done.stdout


def test_an_administrator_is_asked_once_for_all_of_it(tmp_path: Path) -> None:
    """On a Debian without any of the packages, as a user without sudo."""
    tools = tmp_path / "bin"
    tools.mkdir()
    for name in ("bash", "grep", "find", "env"):
        (tools / name).symlink_to(f"/usr/bin/{name}")
    (tools / "dpkg-query").write_text("#!/usr/bin/bash\nexit 1\n")
    (tools / "dpkg-query").chmod(0o755)
    found = run(tmp_path, str(SCRIPTS / "find_python"), "--packages", PATH=str(tools), PYTHON="")
    assert found.stdout.split() == [] or found.stdout.split() == ["python3", "python3-venv", "python3-dev"]
    if os.geteuid() == 0:
        pytest.skip("root installs instead")
    done = run(tmp_path, str(SCRIPTS / "debian_packages"), *found.stdout.split(), "g++", "cmake", PATH=str(tools))
    assert done.returncode == 1
    assert done.stderr.count("apt-get install") == 1
    assert done.stderr.rstrip().endswith("g++ cmake")
