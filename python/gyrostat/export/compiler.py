# SPDX-License-Identifier: MIT
"""The C++ compiler and Eigen of this machine, for targets that are compiled here."""

from __future__ import annotations

import os
import platform
import shlex
import shutil
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path

from gyrostat.errors import InputError

FLAGS = ("-std=c++20", "-O2", "-fPIC", "-fno-exceptions", "-fno-rtti", "-ffp-contract=off", "-fvisibility=hidden")
"""Of flight code; ``-ffp-contract=off``: the same bits with and without fused multiply-add."""


def find_compiler() -> list[str]:
    """``CXX``, or the first of c++, g++ and clang++ that is there.

    Raises
    ------
    InputError
        There is none.
    """
    given = shlex.split(os.environ.get("CXX", ""))
    for command in [given] if given else [["c++"], ["g++"], ["clang++"]]:
        if shutil.which(command[0]) is not None:
            return command
    if given:
        raise InputError(f"CXX = {' '.join(given)}: no such compiler; an FMU is compiled here")
    raise InputError("no C++ compiler found (c++, g++, clang++): an FMU is compiled here; install one or set CXX")


def find_eigen() -> Path:
    """The folder with ``Eigen/Core``: of ``EIGEN3_INCLUDE_DIR``, this Python environment or the system.

    Raises
    ------
    InputError
        It is in none of them.
    """
    given = os.environ.get("EIGEN3_INCLUDE_DIR")
    roots = [
        Path(sys.prefix) / "include",
        Path("/usr/local/include"),
        Path("/usr/include"),
        Path("/opt/homebrew/include"),
    ]
    for folder in [Path(given)] if given else [root / "eigen3" for root in roots]:
        if (folder / "Eigen" / "Core").is_file():
            return folder
    if given:
        raise InputError(f"EIGEN3_INCLUDE_DIR = {given}: holds no Eigen/Core")
    raise InputError("Eigen 3.4 not found: install it (Debian: libeigen3-dev) or set EIGEN3_INCLUDE_DIR")


def compile_shared(compiler: Sequence[str], source: Path, includes: Sequence[Path], library: Path) -> None:
    """Compile one file to a shared library.

    Raises
    ------
    InputError
        The compiler does not take it; its first error is named.
    """
    folders = [f"-I{folder}" for folder in includes]
    command = [*compiler, *FLAGS, "-isystem", str(find_eigen()), *folders, "-shared", str(source), "-o", str(library)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode != 0:
        lines = (done.stderr or done.stdout).strip().splitlines() or [f"exit status {done.returncode}"]
        first = next((line for line in lines if "error" in line), lines[0])
        raise InputError(f"{' '.join(compiler)} does not compile the FMU (C++20 is needed): {first.strip()}")


def fmi_platform() -> tuple[str, str]:
    """Folder of FMI 2.0 binaries for this machine, and the ending of its libraries.

    Raises
    ------
    InputError
        FMI 2.0 or this exporter has no name for it.
    """
    system, bits = platform.system(), 64 if sys.maxsize > 2**32 else 32
    known = {"Linux": ("linux", ".so"), "Darwin": ("darwin", ".dylib")}
    if system not in known or platform.machine() not in ("x86_64", "AMD64", "i686"):
        raise InputError(f"FMI 2.0 has no folder for {system} on {platform.machine()}; export the target c there")
    name, ending = known[system]
    return f"{name}{bits}", ending
