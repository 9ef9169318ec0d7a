# SPDX-License-Identifier: MIT
"""JSON Schema of the scenario file, generated from the catalogue: editors complete and check TOML with it."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from gyrostat import _core
from gyrostat.scenario import Record, Scenario, Shadow

_number = {"type": "number"}
_numbers = {"type": "array", "items": _number}
_rows = {"type": "array", "items": _numbers}
_waveform = {"anyOf": [_number, {"$ref": "#/$defs/waveform"}]}
_kinds: dict[str, dict[str, Any]] = {
    "number": _number,
    "integer": {"type": "integer"},
    "switch": {"type": "boolean"},
    "text": {"type": "string"},
    "vector3": {"anyOf": [_number, {**_numbers, "minItems": 3, "maxItems": 3}]},
    "matrix3": {"anyOf": [_number, {**_numbers, "minItems": 3, "maxItems": 3}, _rows]},
    "columns3": {**_rows, "minItems": 3, "maxItems": 3},
    "quaternion": {**_numbers, "minItems": 4, "maxItems": 4},
    "per_actuator": {"anyOf": [_number, _numbers]},
    "mask": {"type": "array", "items": {"type": "integer", "minimum": 0}},
    "numbers": _numbers,
    "rows": _rows,
    "waveform": _waveform,
    "waveforms": {"type": "array", "items": _waveform},
    "waveforms3": {"type": "array", "items": _waveform, "minItems": 3, "maxItems": 3},
}
_lists = {"faults": "fault", "disturbances": "disturbance", "sensors": "sensor"}
_blocks = ("vehicle", "truth", "initial")


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


def _family(family: str) -> dict[str, Any]:
    return {"anyOf": [_table(_core.describe(family, name), typed=True) for name in _core.catalogue()[family]]}


def _table(info: Mapping[str, Any], *, typed: bool = False) -> dict[str, Any]:
    properties = {p["name"]: _parameter(p) for p in info["params"]}
    required = [p["name"] for p in info["params"] if p["required"]]
    if typed:
        properties = {"type": {"const": info["name"]}, **properties}
        required = ["type", *required]
    return _closed(properties, required)


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
