# SPDX-License-Identifier: MIT
"""Target ``cpp``: one header with the stack for any scalar, and its self-test."""

from __future__ import annotations

from pathlib import Path

from gyrostat import _core
from gyrostat.export.folder import copy_headers, filled
from gyrostat.export.model import FlightCode, Parameter, literal
from gyrostat.export.places import comment, markdown
from gyrostat.export.recording import write_recording

BASE_HEADERS = ["gyrostat/core/set_parameter.hpp", "gyrostat/flight/stack.hpp"]


def write(code: FlightCode, folder: Path) -> None:
    """Header, self-test, build file, recorded rows and the library's headers."""
    write_header(code, folder)
    write_recording(code, folder)
    values = names(code)
    for template, target in (
        ("cpp/self_test.cpp", "self_test.cpp"),
        ("cpp/CMakeLists.txt", "CMakeLists.txt"),
        ("cpp/README.md", "README.md"),
    ):
        (folder / target).write_text(filled(template, values), encoding="utf-8")


def write_header(code: FlightCode, folder: Path, namespace: str | None = None) -> None:
    """``<name>.hpp``, and what it includes in ``include/``."""
    values = names(code) | _parts(code) | {"namespace": namespace or code.name}
    (folder / f"{code.name}.hpp").write_text(filled("cpp/flight.hpp", values), encoding="utf-8")
    wanted = [*BASE_HEADERS, "gyrostat/flight/facade.hpp", *(c.header for c in code.components)]
    copy_headers(wanted, folder / "include", code.capacity)


def names(code: FlightCode) -> dict[str, object]:
    """What all templates speak of; text of the scenario's author only through `places`."""
    return {
        "name": code.name,
        "NAME": code.name.upper(),
        "title": comment(code.title or code.name),
        "heading": markdown(code.title or code.name),
        "version": _core.__version__,
        "scalar": code.scalar,
        "actuators": code.actuators,
        "dt": literal(code.dt),
        "duration": f"{(len(code.rows) - 1) * code.dt:g}",
        "samples": len(code.rows),
        "stack": ", ".join(c.name for c in code.components),
        "bytes": -(-code.bytes[code.scalar] * 3 // 2 // 64) * 64 + 128,
    }


def _parts(code: FlightCode) -> dict[str, object]:
    by_role = {c.role: c for c in code.components}
    return {
        "includes": "\n".join(f'#include "{h}"' for h in sorted([*BASE_HEADERS, *(c.header for c in code.components)])),
        "aliases": "\n".join(f"  using {role.capitalize()} = {c.cpp}<S>;" for role, c in by_role.items()),
        "vehicle": "\n".join(f"    {line}" for line in _vehicle(code)),
        "parameters": "\n".join(
            f"    take(set_parameter(p.{c.role}, {_setting(p)});{_comment(p)}"
            for c in code.components
            for p in c.params
        ),
        "allow_unstable": str(code.allow_unstable).lower(),
    }


def _setting(p: Parameter) -> str:
    return f'"{p.name}", ' + (", ".join(_number(x) for x in p.numbers) or "nullptr, 0") + ")"  # an empty mask


def _comment(p: Parameter) -> str:
    if p.kind == "choice":
        return f"  // {p.options[int(p.numbers[0])]}"
    return f"  // {p.unit}" if p.unit else ""


def _number(x: float) -> str:
    return literal(x).replace("INFINITY", "infinite")


def _vehicle(code: FlightCode) -> list[str]:
    v = code.vehicle
    n = code.actuators

    def filled_with(rows: list[list[float]]) -> str:
        return ",\n        ".join(", ".join(f"S({_number(x)})" for x in row) for row in rows)

    lines = [f"v.J_B << {filled_with(v['J_B'])};  // kg m^2, without the wheels' axial inertia"]
    lines += [f"v.D_B.resize(3, {n});", f"v.D_B << {filled_with(v['D_B'])};  // axes in columns"]
    for limit, unit in (("u_lo", "N m"), ("u_up", "N m"), ("u_rate", "N m/s"), ("h_max", "N m s")):
        lines += [f"v.{limit}.resize({n});", f"v.{limit} << {filled_with([v[limit]])};  // {unit}"]
    if v["u_quantum"]:
        for pulse, meaning in (
            ("u_quantum", "a tick of the valves"),
            ("u_dead", "least pulse"),
            ("u_gap", "least pause"),
        ):
            lines += [f"v.{pulse}.resize({n});", f"v.{pulse} << {filled_with([v[pulse]])};  // N m, {meaning}"]
    for mask in ("spare", "wheels"):
        lines += [f"v.{mask}.set({i});" for i in v[mask]]
    if v["orbit_rate"]:
        lines.append(f"v.orbit_rate = S({_number(v['orbit_rate'])});  // rad/s")
    return lines
