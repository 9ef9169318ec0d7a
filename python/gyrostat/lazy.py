# SPDX-License-Identifier: MIT
"""Names of a package that load when they are first used, so that the import itself costs nothing."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from importlib import import_module
from typing import Any


def loader(
    package: str, offered: Sequence[str], home_of: Mapping[str, str], held: dict[str, Any]
) -> Callable[[str], Any]:
    """``__getattr__`` of a package.

    Parameters
    ----------
    package
        Its full name.
    offered
        What it has: names, and modules of its own.
    home_of
        Of a name the module that has it; what is not in it is a module.
    held
        The ``globals()`` of the package, which keep what was loaded.
    """

    def load(name: str) -> Any:
        if name not in offered:
            raise AttributeError(f"module '{package}' has no attribute '{name}'")
        if name in home_of:
            value = getattr(import_module(f"{package}.{home_of[name]}"), name)
        else:
            value = import_module(f"{package}.{name}")
        held[name] = value
        return value

    return load
