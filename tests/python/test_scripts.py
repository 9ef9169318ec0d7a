# SPDX-License-Identifier: MIT
"""What the set-up says to somebody whose machine lacks something."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

import pytest

from gyrostat import _core

SCRIPTS = Path(__file__).parents[2] / "scripts"


def run(folder: Path, *command: str, user: int | None = None, **environment: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        command,
        user=user,
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


def test_an_administrator_is_asked_once_for_all_of_it() -> None:
    """On a Debian without any of the packages, as a user without sudo."""
    with tempfile.TemporaryDirectory() as name:  # where nobody may look, unlike the folders of a test
        folder, tools = Path(name), Path(name) / "bin"
        folder.chmod(0o755)
        tools.mkdir()
        for script in ("find_python", "debian_packages"):
            shutil.copy(SCRIPTS / script, folder)
        for tool in ("bash", "grep", "find", "env"):
            (tools / tool).symlink_to(f"/usr/bin/{tool}")
        (tools / "dpkg-query").write_text("#!/usr/bin/bash\nexit 1\n")
        (tools / "dpkg-query").chmod(0o755)
        user = 65534 if os.geteuid() == 0 else None  # nobody, in place of root
        found = run(folder, str(folder / "find_python"), "--packages", user=user, PATH=str(tools), PYTHON="")
        wanted = found.stdout.split()
        assert wanted in ([], ["python3", "python3-venv", "python3-dev"])
        packages = [*wanted, "g++", "cmake"]
        call = [str(folder / "debian_packages"), *packages, "--", "chromium"]
        done = run(folder, *call, user=user, PATH=str(tools))
    assert done.returncode == 1
    assert done.stderr.count("apt-get install") == 1
    assert done.stderr.rstrip().endswith("g++ cmake chromium")


def test_what_flies_under_the_sanitizers_fits_the_module(tmp_path: Path) -> None:
    """`make asan-python` compiles for minutes before it calls the program."""
    program = SCRIPTS.parent / "tests" / "sanitized" / "bindings.py"
    done = run(tmp_path, sys.executable, str(program), str(Path(_core.__file__).parent))
    assert done.returncode == 0, done.stderr
    assert done.stdout == "bindings under the sanitizers: nothing to report\n"
