# SPDX-License-Identifier: MIT
"""Target ``fmu``: the stack as an FMI 2.0 co-simulation unit, compiled for this machine, with its sources inside."""

from __future__ import annotations

import math
import shutil
import uuid
import xml.etree.ElementTree as ET
import zipfile
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from gyrostat import _core
from gyrostat.components import UNBOUNDED
from gyrostat.export.compiler import FLAGS, compile_shared, find_compiler, find_eigen, fmi_platform
from gyrostat.export.cpp import names, write_header
from gyrostat.export.folder import copy_notices, filled
from gyrostat.export.model import FlightCode, Parameter, literal, suffixes
from gyrostat.export.places import xml
from gyrostat.export.recording import write_rows

_integers = {
    "reference.event",
    "allocation.saturated",
    "allocation.status",
    "detection.changed",
    "detection.failed",
    "detection.enabled",
    "detection.event",
    "detection.class",
}
_switches = {"measurement.attitude_valid", "measurement.rate_valid", "measurement.momentum_valid"}
_switches_off = {"measurement.field_valid", "measurement.sun_valid"}
_scalar_first = {"measurement.q_NB", "reference.q_NR", "estimate.q_NB"}


@dataclass(frozen=True)
class Variable:
    """One variable of ``modelDescription.xml``; its value reference is its position."""

    name: str
    kind: str
    """``Real``, ``Integer``, ``Boolean`` or ``Enumeration``."""
    causality: str
    start: float
    unit: str = ""
    description: str = ""
    lo: float = -UNBOUNDED
    hi: float = UNBOUNDED
    options: tuple[str, ...] = ()


def write(code: FlightCode, folder: Path) -> None:
    """``<name>.fmu``, the recorded rows and a page that says how to step it."""
    compiler, (platform, ending), _ = find_compiler(), fmi_platform(), find_eigen()
    write_rows(code, folder)
    values = names(code) | {"flags": " ".join(FLAGS)}
    (folder / "README.md").write_text(filled("fmu/README.md", values), encoding="utf-8")
    unit = folder / "unit"
    sources = unit / "sources"
    sources.mkdir(parents=True)
    variables = list(_variables(code))
    guid = _guid(code, variables)
    _write_sources(code, sources, variables, guid)
    _write_description(code, unit / "modelDescription.xml", variables, guid)
    library = unit / "binaries" / platform / (code.name + ending)
    library.parent.mkdir(parents=True)
    compile_shared(compiler, sources / "fmu.cpp", [sources, sources / "include"], library)
    copy_notices(unit / "documentation" / "licenses")
    _pack(unit, folder / f"{code.name}.fmu")
    shutil.rmtree(unit)


def _variables(code: FlightCode) -> Iterator[Variable]:
    """Parameters, then inputs, then outputs: the order that the sources know."""
    for component in code.components:
        for p in component.params:
            yield from _parameter_variables(component.role, p, code.actuators)
    facts = {c["name"]: c for c in code.scenario.channel_names()}
    for signal, width in code.columns.items():
        causality = "input" if signal in code.inputs else "output"
        kind = "Integer" if signal in _integers else "Boolean" if signal in _switches | _switches_off else "Real"
        for i, suffix in enumerate(suffixes((width,) if width > 1 else ())):
            start = 1.0 if signal in _switches or (signal in _scalar_first and i == 0) else 0.0
            yield Variable(signal + suffix, kind, causality, start, facts[signal]["unit"], facts[signal]["meaning"])


def _parameter_variables(role: str, p: Parameter, actuators: int) -> Iterator[Variable]:
    if p.kind == "mask":  # of any length up to that of the vehicle: a switch for each actuator
        for i in range(actuators):
            yield Variable(f"{role}.{p.name}[{i}]", "Boolean", "parameter", float(i in p.numbers), "", p.meaning)
        return
    kind = {"choice": "Enumeration", "switch": "Boolean", "integer": "Integer"}.get(p.kind, "Real")
    for name, value in zip(p.elements(), p.numbers, strict=True):
        yield Variable(f"{role}.{name}", kind, "parameter", value, p.unit, p.meaning, p.lo, p.hi, p.options)


def _write_sources(code: FlightCode, folder: Path, variables: list[Variable], guid: str) -> None:
    write_header(code, folder)
    parameters, first = [], 0
    for component in code.components:
        for p in component.params:
            is_mask = p.kind == "mask"
            count = code.actuators if is_mask else len(p.numbers)
            parameters.append(
                f'    {{Parameter::{component.role}, "{p.name}", {first}, {count}, {str(is_mask).lower()}}},'
            )
            first += count
    types = {"Real": "real", "Integer": "integer", "Enumeration": "integer", "Boolean": "boolean"}
    values = names(code) | {
        "guid": guid,
        "parameters": "\n".join(parameters or ['    {Parameter::observer, "", 0, 0, false},']),
        "parameter_count": len(parameters),
        "first_input": first,
        "first_output": first + sum(v.causality == "input" for v in variables),
        "variables": len(variables),
        "start": "\n".join(
            f"    {literal(v.start).replace('INFINITY', 'infinite')},  // {i} {v.name}" for i, v in enumerate(variables)
        ),
        "types": "\n".join(f"    Type::{types[v.kind]},  // {v.name}" for v in variables),
    }
    for template in ("fmi2.h", "fmu.cpp", "fmu_model.hpp"):
        (folder / template).write_text(filled(f"fmu/{template}", values), encoding="utf-8")


def _guid(code: FlightCode, variables: list[Variable]) -> str:
    """The same for the same unit: interface, values and version decide."""
    return (
        "{"
        + str(uuid.uuid5(uuid.NAMESPACE_OID, repr((_core.__version__, code.name, code.dt, code.vehicle, variables))))
        + "}"
    )


def _write_description(code: FlightCode, path: Path, variables: list[Variable], guid: str) -> None:
    root = ET.Element(
        "fmiModelDescription",
        fmiVersion="2.0",
        modelName=code.name,
        guid=guid,
        description=xml(code.scenario.description or f"Flight stack of {code.title or code.name}"),
        generationTool=f"gyrostat {_core.__version__}",
        variableNamingConvention="structured",
    )
    ET.SubElement(root, "CoSimulation", modelIdentifier=code.name, canNotUseMemoryManagementFunctions="true")
    units = ET.SubElement(root, "UnitDefinitions")
    for unit in sorted({v.unit for v in variables if v.unit and v.kind == "Real"}):
        ET.SubElement(units, "Unit", name=unit)
    choices = {v.name: v for v in variables if v.options}
    if choices:
        definitions = ET.SubElement(root, "TypeDefinitions")
        for v in choices.values():
            enumeration = ET.SubElement(ET.SubElement(definitions, "SimpleType", name=v.name), "Enumeration")
            for value, option in enumerate(v.options):
                ET.SubElement(enumeration, "Item", name=option, value=str(value))
    categories = ET.SubElement(root, "LogCategories")
    ET.SubElement(categories, "Category", name="logStatusError")
    last = (len(code.rows) - 1) * code.dt
    ET.SubElement(root, "DefaultExperiment", startTime="0", stopTime=repr(last), stepSize=repr(code.dt))
    listed = ET.SubElement(root, "ModelVariables")
    for reference, v in enumerate(variables):
        _describe(listed, reference, v)
    structure = ET.SubElement(root, "ModelStructure")
    for block in ("Outputs", "InitialUnknowns"):
        unknowns = ET.SubElement(structure, block)
        for index, v in enumerate(variables, start=1):
            if v.causality == "output":
                ET.SubElement(unknowns, "Unknown", index=str(index))
    ET.indent(root)
    ET.ElementTree(root).write(path, encoding="UTF-8", xml_declaration=True)


def _describe(listed: ET.Element, reference: int, v: Variable) -> None:
    variability = "fixed" if v.causality == "parameter" else "discrete"
    scalar = ET.SubElement(
        listed,
        "ScalarVariable",
        name=v.name,
        valueReference=str(reference),
        description=v.description,
        causality=v.causality,
        variability=variability,
    )
    element = ET.SubElement(scalar, v.kind)
    if v.options:
        element.set("declaredType", v.name)
    if v.kind == "Real" and v.unit:
        element.set("unit", v.unit)
    if v.causality == "parameter" and v.kind in ("Real", "Integer"):
        for key, bound in (("min", v.lo), ("max", v.hi)):
            if abs(bound) < UNBOUNDED:
                element.set(key, _number(bound, v.kind))
    if v.causality != "output":
        element.set("start", _number(v.start, v.kind))


def _number(x: float, kind: str) -> str:
    if kind == "Boolean":
        return "true" if x else "false"
    if kind != "Real":
        return str(int(x))
    return ("INF" if x > 0 else "-INF") if math.isinf(x) else repr(float(x))


def _pack(unit: Path, archive: Path) -> None:
    """The same bytes for the same files: sorted, without the time of day."""
    with zipfile.ZipFile(archive, "w", zipfile.ZIP_DEFLATED) as packed:
        for path in sorted(p for p in unit.rglob("*") if p.is_file()):
            entry = zipfile.ZipInfo(path.relative_to(unit).as_posix())
            entry.compress_type, entry.external_attr = zipfile.ZIP_DEFLATED, 0o644 << 16
            packed.writestr(entry, path.read_bytes())
