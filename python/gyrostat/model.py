# SPDX-License-Identifier: MIT
"""Base of the frozen models: structure is checked here, the meaning of a leaf by the C++ description."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Any, TypeVar

from pydantic import BaseModel, ConfigDict, PlainValidator, ValidationError

from gyrostat.components import freeze, thaw
from gyrostat.errors import InputError, suggestion
from gyrostat.text import shown


def freeze_or_none(value: Any) -> Any:
    """As `freeze`; None stays None: not written."""
    return None if value is None else freeze(value)


T = TypeVar("T")
Leaf = Annotated[T, PlainValidator(freeze_or_none)]
"""A value that is only frozen here and checked in C++; the argument is what type checkers accept."""


class Model(BaseModel):
    """Frozen, hashable, strict; errors are one line."""

    model_config = ConfigDict(frozen=True, extra="forbid", strict=True, arbitrary_types_allowed=True)

    if not TYPE_CHECKING:  # type checkers see the keyword arguments of the fields

        def __init__(self, /, **data):
            try:
                super().__init__(**data)
            except ValidationError as error:
                raise InputError(one_line(type(self), error)) from None


class Block(Model):
    """A table of leaves: what is None was not written."""

    def to_dict(self) -> dict[str, Any]:
        """The keys that were written, as plain numbers, texts and lists."""
        return {k: thaw(v) for k, v in self if v is not None}


def one_line(model: type[BaseModel], error: ValidationError) -> str:
    """The first problem of a validation: key, value and what is allowed."""
    first = error.errors()[0]
    path = "".join(f"[{part}]" if isinstance(part, int) else f".{part}" for part in first["loc"]).lstrip(".")
    if first["type"] == "extra_forbidden":
        return f"unknown key '{path}'{suggestion(path, model.model_fields)}"
    if first["type"] == "missing":
        return f"{path} is missing"
    if first["type"] == "value_error":  # raised by a validator of ours: the text is complete
        text = str(first["ctx"]["error"])
        return f"{path}: {text}" if path else text
    return f"{path} = {shown(first['input'])}: {first['msg'][0].lower()}{first['msg'][1:]}"
