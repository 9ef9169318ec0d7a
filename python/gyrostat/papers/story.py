# SPDX-License-Identifier: MIT
"""What a study is told with: its story, and findings that surprise. Every number in them is a claim's.

``{id}`` in a text is the measured number of the claim of that identifier.
"""

from __future__ import annotations

import re
from collections.abc import Collection, Iterator
from typing import Annotated

from pydantic import Field

from gyrostat.errors import InputError, suggestion
from gyrostat.model import Model

_number = re.compile(r"\{([^{}]*)\}")


class Story(Model):
    """``[story]`` of a ``claims.toml``."""

    promised: str
    seen: str
    why: str


class Surprise(Model):
    """One of ``[[findings]]``, the most surprising one first."""

    title: str
    text: str
    claim: Annotated[str, Field(description="where to read on")]


def parts(text: str) -> Iterator[tuple[str, str]]:
    """A text cut at its numbers: what is said, and the claim whose number follows; the last one has none."""
    pieces = _number.split(text)
    yield from zip(pieces[::2], [*pieces[1::2], ""], strict=True)


def check(story: Story | None, surprises: Collection[Surprise], claims: Collection[str]) -> None:
    """Every claim that is named is there.

    Raises
    ------
    InputError
        One is not.
    """
    told = [] if story is None else [story.promised, story.seen, story.why]
    named = [claim for s in surprises for claim in (s.claim, *_named(s.text))]
    for claim in [*(c for text in told for c in _named(text)), *named]:
        if claim not in claims:
            raise InputError(f"story: no claim '{claim}'{suggestion(claim, claims)}")


def _named(text: str) -> list[str]:
    return _number.findall(text)


__all__ = ["Story", "Surprise", "check", "parts"]
