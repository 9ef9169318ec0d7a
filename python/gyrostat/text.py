# SPDX-License-Identifier: MIT
"""Text of a user's on its way into a line that we write: a message, a comment of exported code, a label."""

from __future__ import annotations

import re
import reprlib
from typing import Any

LONGEST = 1000
"""Characters of a message; what is longer loses its middle."""

_break = re.compile(r"[^\S ]+")


def printable(text: str) -> str:
    """One line without anything that acts on what shows it: a line break is a space, a control character ``{U+0007}``.

    So are invisible ones: those that turn the direction of writing, lone surrogates, what no standard assigns.
    """
    line = _break.sub(" ", unescaped(text))
    return line if line.isprintable() else "".join(c if c.isprintable() else f"{{U+{ord(c):04X}}}" for c in line)


def unescaped(text: str) -> str:
    """What was meant by a text of the system (an argument, a name of a file) whose locale does not know its letters."""
    try:
        return text.encode("utf-8", "surrogateescape").decode("utf-8")
    except UnicodeError:
        return text


def one_line(text: str) -> str:
    """As `printable`, and no longer than a reader wants."""
    line = printable(text)
    half = LONGEST // 2
    return line if len(line) <= LONGEST else f"{line[:half]} ... {line[-half:]}"


def number(value: float | str | None) -> str:
    """A number with three digits; a dash when there is none, a text as it is."""
    if value is None:
        return "–"
    return value if isinstance(value, str) else f"{value:.3g}"


class _Short(reprlib.Repr):
    def __init__(self) -> None:
        super().__init__()
        self.maxstring = self.maxother = 80
        self.maxdict = self.maxlist = self.maxtuple = 8
        self.maxlevel = 4

    def repr_int(self, x: int, level: int) -> str:
        del level
        return str(x) if x.bit_length() < 200 else f"an integer of {int(x.bit_length() * 0.30103) + 1} digits"


_short = _Short()


def shown(value: Any) -> str:
    """A value as a message shows it: short, in one line, whatever it is."""
    return printable(_short.repr(value))


__all__ = ["LONGEST", "number", "one_line", "printable", "shown", "unescaped"]
