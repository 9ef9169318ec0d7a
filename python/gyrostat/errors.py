# SPDX-License-Identifier: MIT
"""Errors that a user can act on: one line that names the file, the key, the value and what is allowed."""

from __future__ import annotations

import difflib
from collections.abc import Iterable, Iterator
from contextlib import contextmanager

from gyrostat.text import one_line


class InputError(ValueError):
    """Something the user wrote cannot be used. The text is one complete line, whatever went into it."""

    def __init__(self, text: str) -> None:
        super().__init__(one_line(text))


class FileError(InputError, OSError):
    """A file or folder that cannot be read or written: also an ``OSError``."""


@contextmanager
def input_errors(source: str = "") -> Iterator[None]:
    """Turn a ``ValueError`` of the enclosed checks into an `InputError`, saying where it came from.

    Parameters
    ----------
    source
        File or block that was being read; put in front of the message.
    """
    try:
        yield
    except ValueError as error:
        raise InputError(f"{source}: {error}" if source else str(error)) from None


def suggestion(word: str, names: Iterable[str]) -> str:
    """Ending of a message about an unknown name: the nearest known one, or all of them."""
    known = sorted(names)
    near = difflib.get_close_matches(word, known, n=1)
    return f", did you mean '{near[0]}'?" if near else f"; there are: {', '.join(known)}"
