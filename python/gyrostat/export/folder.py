# SPDX-License-Identifier: MIT
"""The folder of an export: appears complete, or not at all. What every target puts into it."""

from __future__ import annotations

import re
import shutil
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path

from gyrostat.errors import InputError
from gyrostat.files import file_errors, replacing_folder

_package = Path(__file__).resolve().parents[1]
_templates = Path(__file__).resolve().parent / "templates"
_include = re.compile(r'^#include "(gyrostat/[^"]+)"', re.MULTILINE)
_capacity = re.compile(r"inline constexpr int max_actuators = \d+;")
_namespace = re.compile(r"^(namespace gyrostat)\b(?!::inline)", re.MULTILINE)
_placeholder = re.compile(r"@(\w+)@")


@contextmanager
def new_folder(path: Path) -> Iterator[Path]:
    """A temporary folder beside `path` that takes its name when the block ends well, and vanishes when it does not.

    Raises
    ------
    InputError
        `path` is a file or a folder with something in it, or cannot be made.
    """
    with file_errors(f"--out {path}", "cannot be written"):
        if path.exists() and (not path.is_dir() or any(path.iterdir())):
            kind = "a folder that is not empty" if path.is_dir() else "a file"
            raise InputError(f"--out {path}: is {kind}; name a new or empty one")
    with replacing_folder(path) as temporary:
        yield temporary


def filled(template: str, values: Mapping[str, object]) -> str:
    """A file of `templates` with every ``@key@`` replaced; a key that is not known is a mistake of ours."""
    text = (_templates / f"{template}.in").read_text(encoding="utf-8")
    return _placeholder.sub(lambda match: str(values[match[1]]), text)


def copy_headers(wanted: list[str], into: Path, capacity: int) -> None:
    """Copy the wanted headers of the library with all that they include of it, and its licence.

    The copies are of a library for `capacity` actuators: its storage is inline. They are types of their own, so that
    code for several vehicles links into one program.
    """
    roots, licence, _ = _library()
    missing = list(wanted)
    seen: set[str] = set()
    while missing:
        name = missing.pop()
        if name in seen:
            continue
        seen.add(name)
        source = next((root / name for root in roots if (root / name).is_file()), None)
        if source is None:
            raise InputError(f"{name}: the header is not part of this installation of gyrostat")
        text = source.read_text(encoding="utf-8")
        target = into / name
        target.parent.mkdir(parents=True, exist_ok=True)
        target.write_text(_namespace.sub(rf"\1::inline actuators_{capacity}", _sized(text, capacity)), encoding="utf-8")
        missing += _include.findall(text)
    shutil.copyfile(licence, into / "gyrostat" / "LICENSE")


def _sized(text: str, capacity: int) -> str:
    return _capacity.sub(f"inline constexpr int max_actuators = {capacity};", text)


def copy_notices(into: Path) -> None:
    """Licences of what a compiled unit contains: ours, and Eigen's."""
    _, licence, eigen = _library()
    into.mkdir(parents=True)
    shutil.copyfile(licence, into / "gyrostat.txt")
    shutil.copyfile(eigen, into / "eigen.txt")


def has_header(name: str) -> bool:
    """Whether the library has a header of this name."""
    return any((root / name).is_file() for root in _library()[0])


def _library() -> tuple[list[Path], Path, Path]:
    """Include roots of core and flight, our licence and Eigen's: of the installed package, or of a checkout."""
    installed = _package / "include"
    if installed.is_dir():
        return [installed], installed / "gyrostat" / "LICENSE", installed / "licenses" / "eigen.txt"
    checkout = _package.parents[1]
    roots = [checkout / "cpp" / "core", checkout / "cpp" / "flight"]
    return roots, checkout / "LICENSE", checkout / "licenses" / "eigen.txt"
