# SPDX-License-Identifier: MIT
"""TOML in and out: reading says file and line of what is wrong, writing covers what scenarios hold."""

from __future__ import annotations

import json
import re
import tomllib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from gyrostat.errors import InputError


def read(path: Path) -> dict[str, Any]:
    """The tables of a file.

    Raises
    ------
    InputError
        Unreadable, truncated or malformed: with the file and the line.
    """
    try:
        text = path.read_text(encoding="utf-8")
    except OSError as error:
        raise InputError(f"{path}: cannot be read: {(error.strerror or str(error)).lower()}") from None
    except UnicodeDecodeError as error:
        raise InputError(f"{path}: byte {error.start} is not UTF-8 text") from None
    try:
        return tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise InputError(f"{path}: {_located(str(error), text)}") from None


def value(text: str) -> Any:
    """A value as TOML reads it; a bare word is a text, so that ``--set observer.method=implicit`` needs no quotes."""
    try:
        return tomllib.loads(f"value = {text}")["value"]
    except tomllib.TOMLDecodeError:
        return text


def write(tables: Mapping[str, Any]) -> str:
    """The text of a file: plain keys first, then one table or array of tables a key."""
    plain = {k: v for k, v in tables.items() if not _is_table(v)}
    lines = [f"{_key(k)} = {_inline(v)}" for k, v in plain.items()]
    for name, table in tables.items():
        if name in plain:
            continue
        header, parts = (f"[{_key(name)}]", [table]) if isinstance(table, Mapping) else (f"[[{_key(name)}]]", table)
        for part in parts:
            lines += ["", header, *(f"{_key(k)} = {_inline(v)}" for k, v in part.items())]
    return "\n".join(lines) + "\n"


def _is_table(value: Any) -> bool:
    return isinstance(value, Mapping) or (
        isinstance(value, list) and bool(value) and all(isinstance(v, Mapping) for v in value)
    )


def _key(name: str) -> str:
    return name if re.fullmatch(r"[A-Za-z0-9_-]+", name) else _text(name)


def _text(value: str) -> str:
    return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")


def _inline(value: Any) -> str:
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, str):
        return _text(value)
    if isinstance(value, Mapping):
        return "{" + ", ".join(f"{_key(k)} = {_inline(v)}" for k, v in value.items()) + "}"
    if isinstance(value, list | tuple):
        return "[" + ", ".join(_inline(v) for v in value) + "]"
    return repr(value)


def _located(message: str, text: str) -> str:
    """``Expected '=' (at line 3, column 5)`` -> ``line 3, column 5: expected '='``."""
    match = re.fullmatch(r"(.*) \(at (line \d+, column \d+|end of document)\)", message, re.DOTALL)
    what, where = match.groups() if match else (message, "end of document")
    if where == "end of document":
        where = f"line {text.count(chr(10)) + 1} (end of file)"
    return f"{where}: {what[0].lower()}{what[1:]}"
