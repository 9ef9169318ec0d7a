# SPDX-License-Identifier: MIT
"""The recorded rows beside exported code, and what reads them in C and C++."""

from __future__ import annotations

from pathlib import Path

from gyrostat.export.folder import filled
from gyrostat.export.model import FlightCode, suffixes

FLOAT_TOLERANCE = 1e-2
"""Of a float stack: root mean square relative to the signal's largest recorded value; rounding takes a tenth of it."""
FLOAT_ROWS = 100
"""Rows that this holds for: played back without a plant, rounding feeds on itself."""


def write_recording(code: FlightCode, folder: Path) -> None:
    """``recorded.csv`` (exact: every number reads back as the same double), ``recorded.h`` and the scenario."""
    write_rows(code, folder)
    offsets, first = [], 0
    for signal, width in code.columns.items():
        offsets.append(f"  {signal.replace('.', '_')} = {first},")
        first += width
    text = filled(
        "recorded.h",
        {"offsets": "\n".join(offsets), "columns": first, "float_rows": FLOAT_ROWS, "float_tolerance": FLOAT_TOLERANCE},
    )
    (folder / "recorded.h").write_text(text, encoding="utf-8")


def write_rows(code: FlightCode, folder: Path) -> None:
    """The rows and the scenario they come from."""
    header = ",".join(
        signal + suffix for signal, width in code.columns.items() for suffix in suffixes((width,) if width > 1 else ())
    )
    rows = [",".join([repr(x) if x % 1 else f"{x:.0f}" for x in row]) for row in code.rows.tolist()]
    (folder / "recorded.csv").write_text("\n".join([header, *rows, ""]), encoding="utf-8")
    code.scenario.to_toml(folder / "scenario.toml")
