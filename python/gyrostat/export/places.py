# SPDX-License-Identifier: MIT
"""Text of a scenario on its way into what is exported: one function a place, which leaves nothing that acts there."""

from __future__ import annotations

import re
from functools import cache
from pathlib import Path

from gyrostat.errors import InputError
from gyrostat.text import printable

LONGEST_NAME = 63
"""Characters of a name: as many as C99 tells apart in a file."""

_folder = Path(__file__).resolve().parent
_family = re.compile(
    r".*_t|(?:atomic|clock|cnd|memory_order|mtx|posix|pthread|sa|sched|sem|si|sigev|thrd|timer|tss)_.*"
    r"|f\d+x?(?:add|sub|mul|div|fma|sqrt)f\d+x?|(?:str|wcs)(?:to|from)f\d*x?"
)
"""Whole families of reserved names: types of POSIX, threads and clocks, arithmetic that rounds to narrower types."""
_variant = re.compile(r"(?:_unlocked|_l|_r|_np|f\d+x?|64|f|l)$")
"""What the C library hangs on a name: ``sinf``, ``strtod_l``, ``fopen64``."""
_no_code = re.compile(r'//[^\n]*|/\*.*?\*/|"(?:[^"\\\n]|\\.)*"|@\w+@', re.DOTALL)


def comment(text: str) -> str:
    """For a comment of C or C++, of either kind: nothing ends it, opens another or carries it into the next line."""
    line = re.sub(r"\?(?=\?)", "? ", printable(text).replace("\\", "{U+005C}"))  # ??/ is a backslash to C99
    return line.replace("*/", "* /").replace("/*", "/ *")


def markdown(text: str) -> str:
    """For a page: a span of code, in which nothing is a link, a tag or emphasis."""
    line = printable(text)
    fence = "`" * (1 + max(map(len, re.findall("`+", line)), default=0))
    space = " " if line[:1] in "` " or line[-1:] in "` " else ""
    return f"{fence}{space}{line}{space}{fence}"


def xml(text: str) -> str:
    """For an attribute of XML, which quotes marks itself but has no way to write a control character."""
    return printable(text)


def identifier(given: str) -> str:
    """The name of files, of a namespace, and of C types and functions.

    Raises
    ------
    InputError
        C, C++, their libraries, a compiler, the build or the exported code itself means something else by it.
    """
    shape = re.fullmatch(r"[a-z]\w*|[A-Z][a-z]\w*", given, re.ASCII)
    if not shape or "__" in given or given.endswith("_") or len(given) > LONGEST_NAME:
        raise InputError(
            f"name '{given}': letters, digits and single underscores belong here, a small letter first or second, "
            f"{LONGEST_NAME} at most"
        )
    if is_taken(given):
        raise InputError(
            f"name '{given}' means something else in C or C++, or to a build; '{identifier_of(given)}' would do"
        )
    return given


def identifier_of(title: str) -> str:
    """An identifier that resembles a title."""
    made = re.sub(r"[\W_]+", "_", title, flags=re.ASCII).strip("_").lower()[:48].strip("_")
    return next((n for n in (made, f"flight_{made}") if n[:1].isalpha() and n[-1] != "_" and not is_taken(n)), "flight")


def is_taken(name: str) -> bool:
    """Whether a name, or one that the exported code makes with it, is somebody else's."""
    words, suffixes = _reserved()
    return any(_is_reserved(name + suffix, words) for suffix in suffixes)


def _is_reserved(name: str, words: frozenset[str]) -> bool:
    if name in words or name.lower() in words or _family.fullmatch(name):
        return True
    root = _variant.sub("", name)
    return root != name and _is_reserved(root, words)


@cache
def _reserved() -> tuple[frozenset[str], tuple[str, ...]]:
    """Words of the list and of the templates, and what the templates hang on a name ("" for the name itself)."""
    from gyrostat.export.model import GIMBALS, INPUTS, OUTPUTS, SKY

    listed = (_folder / "reserved.txt").read_text(encoding="ascii")
    words = {word for line in listed.splitlines() if not line.startswith("#") for word in line.split()}
    words |= {signal.replace(".", "_") for signal in (*INPUTS, *GIMBALS, *SKY, *OUTPUTS)}
    suffixes = {""}
    for template in (_folder / "templates").rglob("*.in"):
        if template.suffixes[0] in (".h", ".hpp", ".c", ".cpp"):
            text = template.read_text(encoding="utf-8")
            words |= set(re.findall(r"\b[A-Za-z]\w*", _no_code.sub(" ", text)))
            suffixes |= set(re.findall(r"@name@(\w+)", text))
    return frozenset(words), tuple(sorted(suffixes))


__all__ = ["LONGEST_NAME", "comment", "identifier", "identifier_of", "is_taken", "markdown", "xml"]
