# SPDX-License-Identifier: MIT
"""Target ``cpp``: one header with the stack for any scalar, and its self-test."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from gyrostat import _core
from gyrostat.export.folder import copy_headers, filled
from gyrostat.export.model import SKY, FlightCode, Parameter, literal
from gyrostat.export.places import comment, markdown
from gyrostat.export.recording import write_recording

AXES_HEADER = "gyrostat/flight/moving_axes.hpp"
FACADE = "gyrostat/flight/facade.hpp"
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
    copy_headers(headers(code), folder / "include", code.capacity)


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
        **_sky(code),
        "stack": ", ".join(c.name for c in code.components),
        **_gimbals(code),
        "u_unit": _command_unit(code),
        "bytes": -(-code.bytes[code.scalar] * 3 // 2 // 64) * 64 + 128,
    }


_sky_signals = ("field_B", "field_N", "sun_B", "sun_N")
_sky_bits = ("field_valid", "sun_valid")


def _sky(code: FlightCode) -> dict[str, str]:
    """Of sun and field: members of a measurement in C and C++, and how a recorded row or an FMU's inputs fill them."""
    keys = ("sky_in_c", "sky_in_cpp", "sky_of_row", "sky_of_inputs")
    if not code.sees_the_sky:
        return dict.fromkeys(keys, "")
    in_c = f"""
  /* Sun (unit) and magnetic field (T), in body axes as measured and in N as an almanac and a model have them. A _valid
     that is 0: not measured at this sample. */
  {code.name}_real field_B[3], field_N[3], sun_B[3], sun_N[3];
  uint8_t field_valid, sun_valid;"""
    in_cpp = "\n  double field_B[3], field_N[3], sun_B[3], sun_N[3];\n  bool field_valid, sun_valid;"
    of_row = [f"take_recorded(d.row, measurement_{s}, y.{s}, 3);" for s in _sky_signals]
    of_row += [f"y.{bit} = d.row[measurement_{bit}] != 0.0;" for bit in _sky_bits]
    of_inputs = [
        f"y.{name} = in.one() != 0.0;" if name in _sky_bits else f"in(y.{name});"
        for name in (signal.split(".")[1] for signal in SKY)
    ]
    filled_in = (
        in_c,
        in_cpp,
        "".join(f"\n    {line}" for line in of_row),
        "".join(f"\n  {line}" for line in of_inputs),
    )
    return dict(zip(keys, filled_in, strict=True))


def _parts(code: FlightCode) -> dict[str, object]:
    by_role = {c.role: c for c in code.components}
    return {
        "includes": "\n".join(f'#include "{h}"' for h in sorted(headers(code)) if h != FACADE),
        "aliases": "\n".join(f"  using {role.capitalize()} = {c.cpp}<S>;" for role, c in by_role.items()),
        "vehicle": "\n".join(f"    {line}" for line in _vehicle(code)),
        "parameters": "\n".join(
            f"    take(set_parameter(p.{c.role}, {_setting(p)});{_comment(p)}"
            for c in code.components
            for p in c.params
        )
        + "".join(f"\n    {line}" for line in _axes(code)),
        "policies": _policies(code),
        "allow_unstable": str(code.allow_unstable).lower(),
    }


def headers(code: FlightCode) -> list[str]:
    """Of the library, what an export of it includes."""
    axes = [AXES_HEADER] if code.axes_move else []
    return [*BASE_HEADERS, FACADE, *axes, *(c.header for c in code.components)]


def _policies(code: FlightCode) -> str:
    """Of the stack, behind its navigator: where actuators point, and what takes the momentum off."""
    policies = ["gyrostat::MovingAxes<S>"] if code.axes_move else []
    policies += [c.role.capitalize() for c in code.components if c.role == "desaturation"]
    return "".join(f",\n                                      {policy}" for policy in policies)


def _gimbals(code: FlightCode) -> dict[str, str]:
    """What templates say of gimbals: nothing without them."""
    n = code.actuators
    said = {
        "gimbal_field": f"\n  {code.name}_real gimbal[{n}]; /* rad, each gimbal, 0 without; not finite: as before */",
        "gimbal_member": f", gimbal[{n}]",
        "take_gimbal": f"\n    take_recorded(d.row, measurement_gimbal, y.gimbal, {n});",
        "gimbal_of_inputs": "\n  in(y.gimbal);",
    }
    return said if code.gyros else dict.fromkeys(said, "")


def _command_unit(code: FlightCode, per: str = "") -> str:
    return f"N m{per}" + (f", of magnetorquers A m^2{per}" if code.vehicle["magnetorquers"] else "")


def _axes(code: FlightCode) -> list[str]:
    """Lines that say how the actuators turn."""

    def vector(v: Sequence[float]) -> str:
        return "{" + ", ".join(f"S({literal(x)})" for x in v) + "}"

    lines = [
        f"p.geometry.gyros.add({g['actuator']}, {vector(g['gimbal_axis_B'])},\n                         "
        f"{vector(g['spin_axis_B'])}, S({literal(g['rotor_momentum'])}));  // N m s"
        for g in code.gyros
    ]
    if code.vehicle["magnetorquers"]:
        lines.append(f"p.geometry.magnetic.dipole_B.resize(3, {code.actuators});")
        lines.append(f"p.geometry.magnetic.dipole_B << {_matrix(code.dipole_B)};  // magnetorquers in their columns")
    return lines


def _setting(p: Parameter) -> str:
    return f'"{p.name}", ' + (", ".join(_number(x) for x in p.numbers) or "nullptr, 0") + ")"  # an empty mask


def _comment(p: Parameter) -> str:
    if p.kind == "choice":
        return f"  // {p.options[int(p.numbers[0])]}"
    return f"  // {p.unit}" if p.unit else ""


def _number(x: float) -> str:
    return literal(x).replace("INFINITY", "infinite")


def _matrix(rows: Sequence[Sequence[float]]) -> str:
    return ",\n        ".join(", ".join(f"S({_number(x)})" for x in row) for row in rows)


def _vehicle(code: FlightCode) -> list[str]:
    v = code.vehicle
    n = code.actuators

    lines = [f"v.J_B << {_matrix(v['J_B'])};  // kg m^2, without the wheels' axial inertia"]
    lines += [f"v.D_B.resize(3, {n});", f"v.D_B << {_matrix(v['D_B'])};  // axes in columns"]
    u, u_dot = _command_unit(code), _command_unit(code, "/s")
    for limit, unit in (("u_lo", u), ("u_up", u), ("u_rate", u_dot), ("h_max", "N m s")):
        lines += [f"v.{limit}.resize({n});", f"v.{limit} << {_matrix([v[limit]])};  // {unit}"]
    if v["u_quantum"]:
        for pulse, meaning in (
            ("u_quantum", "a tick of the valves"),
            ("u_dead", "least pulse"),
            ("u_gap", "least pause"),
        ):
            lines += [f"v.{pulse}.resize({n});", f"v.{pulse} << {_matrix([v[pulse]])};  // N m, {meaning}"]
    for mask in ("spare", "wheels", "magnetorquers"):
        lines += [f"v.{mask}.set({i});" for i in v[mask]]
    if code.gyros:
        lines.append("v.moving_axes = true;  // D_B is where the gyros' axes start")
    if v["orbit_rate"]:
        lines.append(f"v.orbit_rate = S({_number(v['orbit_rate'])});  // rad/s")
    return lines
