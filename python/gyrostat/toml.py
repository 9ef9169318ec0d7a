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
from gyrostat.files import file_errors

MAX_BYTES = 4 * 2**20
"""Of a file. A table of a hundred thousand points fits; reading it takes seconds."""
MAX_DEPTH = 64
"""Brackets inside brackets, parts of a dotted key, and lists and tables inside each other in a scenario."""

_opaque = re.compile(  # brackets and dots mean nothing in strings and comments, closed or not
    r'"""(?:[^"\\]++|\\.|"(?!""))*+(?:"{3,5})?|"(?:[^"\\\n]++|\\.)*+"?|'
    r"'''(?:[^']++|'(?!''))*+(?:'{3,5})?|'[^'\n]*+'?|#[^\n]*+",
    re.DOTALL,
)
_bracket = re.compile(r"[\[\]{}]")
_dotted = re.compile(r"(?<![\w-])[\w-]++(?:[ \t]*+\.[ \t]*+[\w-]++)++")


def read(path: Path) -> dict[str, Any]:
    """The tables of a file.

    Raises
    ------
    InputError
        Unreadable, too large, truncated or malformed: with the file and the line.
    """
    with file_errors(path, "cannot be read"), path.open("rb") as file:
        data = file.read(MAX_BYTES + 1)
    if len(data) > MAX_BYTES:
        raise InputError(f"{path}: is larger than {MAX_BYTES // 2**20} MiB, the most that is read")
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise InputError(f"{path}: byte {error.start} is not UTF-8 text") from None
    try:
        return _tables(text)
    except _BeyondLimitError as error:
        raise InputError(f"{path}: {error}") from None
    except tomllib.TOMLDecodeError as error:
        raise InputError(f"{path}: {_located(str(error), text)}") from None


def value(text: str) -> Any:
    """A value as TOML reads it; a bare word is a text, so that ``--set observer.method=implicit`` needs no quotes.

    Raises
    ------
    InputError
        Deeper than a file may be.
    """
    try:
        tables = _tables(f"value = {text}")
    except _BeyondLimitError as error:
        raise InputError(f"{text[:40]} ...: {error}") from None
    except tomllib.TOMLDecodeError:
        return text
    return tables["value"] if len(tables) == 1 else text


class _BeyondLimitError(Exception):
    """What is TOML, but more of it than we read."""


def _tables(text: str) -> dict[str, Any]:
    """Parsed within the limits; the parser itself recurses, and takes the square of a key's parts."""
    plain = _opaque.sub(lambda found: "_" + "\n" * found[0].count("\n"), text)
    depth = 0
    for found in _bracket.finditer(plain):
        depth += 1 if found[0] in "[{" else -1
        if depth > MAX_DEPTH:
            raise _BeyondLimitError(f"{_line(plain, found)}: more than {MAX_DEPTH} brackets inside each other")
    for found in _dotted.finditer(plain):
        if found[0].count(".") >= MAX_DEPTH:
            raise _BeyondLimitError(f"{_line(plain, found)}: a key of more than {MAX_DEPTH} parts")
    try:
        return tomllib.loads(text)
    except tomllib.TOMLDecodeError:
        raise
    except ValueError:  # int() takes the square of the digits, and refuses thousands of them
        raise _BeyondLimitError("a number of thousands of digits") from None


def _line(text: str, at: re.Match[str]) -> str:
    return f"line {text.count(chr(10), 0, at.start()) + 1}"


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
