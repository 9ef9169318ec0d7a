# SPDX-License-Identifier: MIT
"""Target ``c``: three C functions over the stack, in memory of the caller, with a build file and a self-test in C."""

from __future__ import annotations

from pathlib import Path

from gyrostat.export.cpp import names, write_header
from gyrostat.export.folder import filled
from gyrostat.export.model import FlightCode
from gyrostat.export.recording import write_recording


def write(code: FlightCode, folder: Path) -> None:
    """The C header, the C++ behind it, build file, self-test, recorded rows and the library's headers."""
    write_header(code, folder, namespace=f"{code.name}_flight")
    write_recording(code, folder)
    for template, target in (
        ("c/flight.h", f"{code.name}.h"),
        ("c/flight.cpp", f"{code.name}.cpp"),
        ("c/self_test.c", "self_test.c"),
        ("c/CMakeLists.txt", "CMakeLists.txt"),
        ("c/README.md", "README.md"),
    ):
        (folder / target).write_text(filled(template, names(code)), encoding="utf-8")
