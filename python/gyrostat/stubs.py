# SPDX-License-Identifier: MIT
"""Writes the type stubs of the modules made from the catalogue: ``python -m gyrostat.stubs [--check]``.

`gyrostat.faults`, `gyrostat.waveforms` and the like are built at run time; editors and type checkers read these stubs.
"""

from __future__ import annotations

import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from gyrostat import _core
from gyrostat.components import class_name, describe_parameter

MODULES = {
    "disturbances": "disturbance",
    "faults": "fault",
    "integrators": "integrator",
    "references": "reference",
    "sensors": "sensor",
    "waveforms": "waveform",
}
"""Module of the package -> family of the catalogue."""

_types = {
    "number": "float",
    "integer": "int",
    "switch": "bool",
    "text": "str",
    "vector3": "float | Vector",
    "matrix3": "float | Vector | Matrix",
    "columns3": "Matrix",
    "quaternion": "Vector",
    "per_actuator": "float | Vector",
    "mask": "Sequence[int]",
    "numbers": "Vector",
    "rows": "Matrix",
    "waveform": "float | Component",
    "waveforms": "Sequence[float | Component]",
    "waveforms3": "Sequence[float | Component]",
}


def stub(module: str) -> str:
    """The stub of one module."""
    family = MODULES[module]
    functions = [_function(_core.describe(family, name)) for name in _core.catalogue()[family]]
    text = "\n\n".join(functions)
    lines = ["# SPDX-License-Identifier: MIT", "# Generated from the catalogue by gyrostat.stubs."]
    if "Sequence[" in text:
        lines.append("from collections.abc import Sequence")
    if "Literal[" in text:
        lines.append("from typing import Literal")
    used = [name for name in ("Component", "Matrix", "Vector") if name in text]
    return "\n".join([*lines, "", f"from gyrostat.components import {', '.join(used)}", "", text]) + "\n"


def _function(info: Mapping[str, Any]) -> str:
    required = [p for p in info["params"] if p["required"]]
    optional = [p for p in info["params"] if not p["required"]]
    parameters = [f"    {p['name']}: {_type(p)}," for p in required]
    parameters += [f"    {p['name']}: {_type(p)} | None = ...," for p in optional]
    head = f"def {class_name(info['name'])}("
    summary = f'    """The {info["family"]} \'{info["name"]}\'.'
    if not parameters:
        return f'{head}) -> Component:\n{summary}"""'
    lines = [head, "    *,", *parameters, ") -> Component:", summary, "", "    Parameters", "    ----------"]
    for param in required + optional:
        lines += [f"    {param['name']}", f"        {describe_parameter(param)}"]
    return "\n".join([*lines, '    """'])


def _type(param: Mapping[str, Any]) -> str:
    if param["kind"] == "choice":
        return f"Literal[{', '.join(repr(o) for o in param['options'])}]".replace("'", '"')
    return _types[param["kind"]]


def main() -> None:
    """Write the stubs, or with ``--check`` say which are out of date (exit status 1)."""
    folder = Path(__file__).parent
    stale = [m for m in MODULES if not (path := folder / f"{m}.pyi").exists() or path.read_text() != stub(m)]
    if "--check" not in sys.argv[1:]:
        for module in stale:
            (folder / f"{module}.pyi").write_text(stub(module))
    elif stale:
        sys.exit(f"out of date: {', '.join(f'{m}.pyi' for m in stale)}; run python -m gyrostat.stubs")


if __name__ == "__main__":
    main()
