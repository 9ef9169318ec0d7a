# SPDX-License-Identifier: MIT
"""JSON Schema of the scenario file, generated from the catalogue: editors complete and check TOML with it."""

from __future__ import annotations

import json
import math
import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from gyrostat import _core, toml
from gyrostat.errors import InputError
from gyrostat.files import file_errors, write_text
from gyrostat.scenario import Record, Scenario, Shadow

_number = {"type": "number"}
_numbers = {"type": "array", "items": _number}
_rows = {"type": "array", "items": _numbers}
_waveform = {"if": {"type": "object"}, "then": {"$ref": "#/$defs/waveform"}, "else": _number}
_three = {"minItems": 3, "maxItems": 3}
_one_or_more = {"type": ["number", "array"]}
_kinds: dict[str, dict[str, Any]] = {
    "number": _number,
    "integer": {"type": "integer"},
    "switch": {"type": "boolean"},
    "text": {"type": "string"},
    "vector3": {**_one_or_more, "items": _number, **_three},
    "matrix3": {**_one_or_more, "items": {**_one_or_more, "items": _number, **_three}, **_three},
    "columns3": {**_rows, **_three},
    "quaternion": {**_numbers, "minItems": 4, "maxItems": 4},
    "per_actuator": {**_one_or_more, "items": _number},
    "mask": {"type": "array", "items": {"type": "integer", "minimum": 0}},
    "numbers": _numbers,
    "rows": _rows,
    "waveform": _waveform,
    "waveforms": {"type": "array", "items": _waveform},
    "waveforms3": {"type": "array", "items": _waveform, **_three},
}
_lists = {"faults": "fault", "disturbances": "disturbance", "sensors": "sensor"}
_blocks = ("vehicle", "truth", "orbit", "desaturation", "flexible", "cmg", "thrusters", "initial")


def scenario_schema() -> dict[str, Any]:
    """The schema as a dictionary (draft 2020-12)."""
    run = {p["name"]: _parameter(p) for p in _core.describe("run", "run")["params"]}
    properties: dict[str, Any] = {"name": {"type": "string"}, "description": {"type": "string"}, **run}
    families = [f for f in _core.catalogue() if f not in (*_blocks, "run")]
    for key in Scenario.model_fields:
        if key in _blocks:
            properties[key] = _table(_core.describe(key, key))
        elif key in families or key in _lists:
            one = {"$ref": f"#/$defs/{_lists.get(key, key)}"}
            properties[key] = {"type": "array", "items": one} if key in _lists else one
    pair = {key: {"$ref": f"#/$defs/{key}"} for key in Shadow.model_fields}
    properties["shadows"] = {"type": "array", "items": _closed(pair)}
    channels = {"type": "array", "items": {"type": "string"}}
    properties["record"] = _closed(
        dict(zip(Record.model_fields, (channels, {"type": "integer", "minimum": 1}), strict=True))
    )
    return {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": "gyrostat scenario",
        **_closed(properties, [k for k, f in Scenario.model_fields.items() if f.is_required()]),
        "$defs": {family: _family(family) for family in families},
    }


def schema_text() -> str:
    """The schema as a file holds it."""
    return json.dumps(scenario_schema(), indent=2, default=str) + "\n"


SCHEMA_FILE = "gyrostat.schema.json"


def install_schema(file: Path) -> Path:
    """Write the schema beside a scenario file, and the line ``#:schema ./...`` into it, by which editors find it.

    Returns
    -------
    Path
        The schema.

    Raises
    ------
    InputError
        The file is none of ours (not read as TOML, nothing is written), or cannot be written.
    """
    if file.suffix != ".toml":
        raise InputError(f"{file}: a scenario's file ends in .toml")
    toml.read(file)
    with file_errors(file, "cannot be read"):
        text = file.read_text(encoding="utf-8")
    line = f"#:schema ./{SCHEMA_FILE}\n"
    rest = re.sub(r"^#:schema [^\n]*\n", "", text, flags=re.MULTILINE)
    target = file.parent / SCHEMA_FILE
    write_text(target, schema_text())
    if line + rest != text:
        write_text(file, line + rest)
    return target


def _family(family: str) -> dict[str, Any]:
    """A name alone, or a table whose ``type`` decides what else it may hold: a mistake is told of that type alone."""
    names = {"enum": _core.catalogue()[family]}
    members = [_core.describe(family, name) for name in names["enum"]]
    table = {
        "type": "object",
        "required": ["type"],
        "properties": {"type": names},
        "allOf": [
            {"if": {"properties": {"type": {"const": info["name"]}}, "required": ["type"]}, "then": _table(info)}
            for info in members
        ],
    }
    return table if family == "waveform" else {"if": {"type": "string"}, "then": names, "else": table}


def _table(info: Mapping[str, Any]) -> dict[str, Any]:
    properties = {p["name"]: _parameter(p) for p in info["params"]}
    if info["name"] != info["family"]:
        properties = {"type": {"const": info["name"]}, **properties}
    return _closed(properties, [p["name"] for p in info["params"] if p["required"]])


def _closed(properties: dict[str, Any], required: list[str] | None = None) -> dict[str, Any]:
    table: dict[str, Any] = {"type": "object", "properties": properties, "additionalProperties": False}
    return {**table, "required": required} if required else table


def _parameter(param: Mapping[str, Any]) -> dict[str, Any]:
    schema: dict[str, Any] = {"enum": param["options"]} if param["kind"] == "choice" else dict(_kinds[param["kind"]])
    unit = f" ({param['unit']})" if param["unit"] else ""
    schema["description"] = param["meaning"] + unit
    if param["kind"] in ("number", "integer"):
        schema |= {k: param[e] for k, e in (("minimum", "lo"), ("maximum", "hi")) if abs(param[e]) < math.inf}
    if param["default"] is not None and not param["scales"]:
        schema["default"] = param["default"]
    return schema
