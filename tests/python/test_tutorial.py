# SPDX-License-Identifier: MIT
"""The tutorial from a requirement to a verdict: its commands print what it says, and it ends in the page."""

from __future__ import annotations

import re
import shlex
from pathlib import Path

from commands import gyrostat

PAGE = Path(__file__).parents[2] / "docs" / "verdict.md"
_number = re.compile(r"\d+(?:\.\d+)?(?:e[-+]\d+)?")


def steps() -> list[tuple[str, str]]:
    """Blocks of code in their order, with their language."""
    return re.findall(r"^```(\w+)\n(.*?)^```", PAGE.read_text(encoding="utf-8"), re.DOTALL | re.MULTILINE)


def same(told: str, said: str) -> bool:
    """Word by word; numbers to two digits, which another compiler leaves."""
    if _number.sub("#", told) != _number.sub("#", said):
        return False
    pairs = zip(_number.findall(told), _number.findall(said), strict=True)
    return all(abs(float(a) - float(b)) <= 0.02 * abs(float(b)) for a, b in pairs)


def test_the_tutorial_does_what_it_says(tmp_path: Path) -> None:
    printed = ""
    for language, text in steps():
        if language == "toml":
            name = re.match(r"# (\S+\.toml)\n", text)
            assert name is not None
            (tmp_path / name[1]).write_text(text)
        elif language == "sh":
            (line,) = text.strip().splitlines()
            command, _, remark = line.partition("#")
            wanted = re.search(r"exit status (\d)", remark)
            arguments = shlex.split(command)
            assert arguments[0] == "gyrostat"
            done = gyrostat(*arguments[1:], cwd=tmp_path)
            assert done.returncode == int(wanted[1] if wanted else 0), done.stderr
            printed = done.stdout
        else:
            assert language == "text"
            assert same(text, printed), printed
    page = (tmp_path / "flown" / "report.html").read_text()
    assert "<b>PASS</b> after 4000 runs" in page
    assert "PASS at run 3787" in page
