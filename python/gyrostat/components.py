# SPDX-License-Identifier: MIT
"""Components by name: ``gyrostat.observer("finite_time_disturbance", lambda1=1.0)``.

A component here is data, a type and its parameters. What parameters exist, their defaults, units and ranges is known to
the C++ catalogue alone; every name and value is checked against it when the component is written down.
"""

from __future__ import annotations

import inspect
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from gyrostat import _core
from gyrostat.errors import InputError, input_errors
from gyrostat.old_names import current
from gyrostat.text import shown
from gyrostat.toml import MAX_DEPTH

Vector: TypeAlias = Sequence[float] | NDArray[np.float64]
"""Three numbers, or one an actuator."""
Matrix: TypeAlias = Sequence[Sequence[float]] | NDArray[np.float64]
"""Rows of numbers."""
UNBOUNDED = float(np.finfo(float).max)
"""The largest number; as a bound it says: any finite one."""


@dataclass(frozen=True, repr=False)
class Component:
    """One component of a scenario: its type and the parameters that differ from their defaults.

    Build it with `observer`, `controller`, ... or with the classes in `gyrostat.faults`, `gyrostat.waveforms`, ...; it
    is hashable, and equal to another one that says the same.
    """

    type: str
    items: tuple[tuple[str, Any], ...] = ()

    def __post_init__(self) -> None:
        object.__setattr__(self, "type", current(self.type))

    @classmethod
    def of(cls, name: str, params: Mapping[str, Any]) -> Component:
        """From the name of a type and a mapping of parameters; an absent value (None) counts as not written."""
        return _component(name, params, 0)

    @property
    def params(self) -> dict[str, Any]:
        """The parameters that were given."""
        return dict(self.items)

    def to_dict(self) -> dict[str, Any]:
        """``{"type": ..., parameter: value, ...}`` of plain numbers, texts, lists and dictionaries."""
        return {"type": self.type, **{k: thaw(v) for k, v in self.items}}

    def _repr_html_(self) -> str:
        from gyrostat import notebook

        return notebook.component(self)

    def __repr__(self) -> str:
        return f"Component({', '.join([repr(self.type), *(f'{k}={v!r}' for k, v in self.items)])})"


def freeze(value: Any) -> Any:
    """A hashable copy: lists and arrays become tuples, a table with a ``type`` a `Component`.

    Raises
    ------
    InputError
        Something that no file could say, or that is nested too deeply: a value that holds itself, for one.
    """
    return _frozen(value, 0)


def _frozen(value: Any, depth: int) -> Any:
    if depth > MAX_DEPTH:
        raise InputError(f"{shown(value)} lies more than {MAX_DEPTH} lists and tables deep, or holds itself")
    if isinstance(value, np.ndarray | np.generic):
        value = value.tolist()
    if isinstance(value, Mapping):
        if not isinstance(value.get("type"), str):
            raise InputError(f"{shown(dict(value))} needs a key 'type' with the name of a component")
        return _component(value["type"], {k: v for k, v in value.items() if k != "type"}, depth)
    if isinstance(value, list | tuple):
        return tuple(_frozen(v, depth + 1) for v in value)
    if isinstance(value, str):
        return checked_text(value)
    if isinstance(value, int) and not abs(value) <= UNBOUNDED:
        raise InputError(f"{shown(value)} is beyond the largest number, {UNBOUNDED:.2g}")
    if isinstance(value, bool | int | float | Component):
        return value
    if isinstance(value, type):
        raise InputError(f"{value.__name__} is a class; an object of it belongs here: {value.__name__}(...)")
    raise InputError(f"{shown(value)} is a {type(value).__name__}; a number, text, list or component belongs here")


def _component(name: str, params: Mapping[str, Any], depth: int) -> Component:
    if not all(isinstance(key, str) for key in (name, *params)):
        raise InputError(f"{shown(name)}, {shown(list(params))}: names of a component and its parameters are texts")
    items = [(checked_text(k), _frozen(v, depth + 1)) for k, v in params.items() if v is not None]
    return Component(checked_text(name), tuple(sorted(items, key=lambda item: item[0])))


def checked_text(text: str) -> str:
    """The text.

    Raises
    ------
    InputError
        It holds half of a surrogate pair and cannot be written as UTF-8.
    """
    try:
        text.encode()
    except UnicodeEncodeError as error:
        raise InputError(
            f"{shown(text)} is no text: character {error.start} is half of a pair, U+{ord(text[error.start]):04X}"
        ) from None
    return text


def thaw(value: Any) -> Any:
    """The plain form of a frozen value: tuples become lists, components dictionaries."""
    if isinstance(value, Component):
        return value.to_dict()
    if isinstance(value, tuple):
        return [thaw(v) for v in value]
    return value


def build(family: str, name: str, params: Mapping[str, Any]) -> Component:
    """A component of any family, checked against the catalogue.

    Raises
    ------
    InputError
        Unknown name or parameter (with the nearest one), wrong type, or a value outside its range.
    """
    with input_errors():
        component = Component.of(name, params)
        plain = component.to_dict()
        del plain["type"]
        _core.check_params(family, component.type, plain, f"{family} '{name}'")
    return component


def navigator(name: str, /, **params: Any) -> Component:
    """A navigator: sensors as they are -> what ideal ones would show."""
    return build("navigator", name, params)


def observer(name: str, /, **params: Any) -> Component:
    """An observer: measurement -> estimate. ``gyrostat list observer`` names them."""
    return build("observer", name, params)


def detector(name: str, /, **params: Any) -> Component:
    """A detector: estimate -> which actuators changed or failed."""
    return build("detector", name, params)


def controller(name: str, /, **params: Any) -> Component:
    """A controller: estimate and reference -> demanded torque."""
    return build("controller", name, params)


def allocator(name: str, /, **params: Any) -> Component:
    """An allocator: demanded torque -> one command an actuator."""
    return build("allocator", name, params)


def reference(name: str, /, **params: Any) -> Component:
    """A reference: the attitude to follow. Also as classes in `gyrostat.references`."""
    return build("reference", name, params)


def integrator(name: str, /, **params: Any) -> Component:
    """The integrator of the truth. Also as classes in `gyrostat.integrators`."""
    return build("integrator", name, params)


def constructors(family: str, module: str) -> dict[str, Callable[..., Component]]:
    """One function a member of a family, with its real signature and documentation, by CamelCase name.

    Used by `gyrostat.faults`, `gyrostat.waveforms` and the like: they hold no second copy of a default.
    """
    made = {}
    for name in _core.catalogue()[family]:
        function = _constructor(_core.describe(family, name), module)
        made[function.__name__] = function
    return made


def class_name(name: str) -> str:
    """``loss_of_effectiveness`` -> ``LossOfEffectiveness``."""
    return "".join(part.capitalize() for part in name.split("_"))


def describe_parameter(param: Mapping[str, Any]) -> str:
    """Meaning, unit, range and default in one line."""
    facts = [param["meaning"]]
    if param["unit"]:
        facts.append(param["unit"])
    if param["options"]:
        facts.append("one of " + ", ".join(param["options"]))
    elif range_text(param):
        facts.append(range_text(param))
    if param["default"] is not None:
        facts.append(f"default {param['default']}" + (" (scales with the vehicle)" if param["scales"] else ""))
    return "; ".join(facts)


def range_text(param: Mapping[str, Any]) -> str:
    """``[lo, hi]``, ``>= lo``, ``<= hi``, or "" for any number; `inf` in it means that infinity is allowed."""
    if param["kind"] in ("choice", "switch", "text"):
        return ""
    above, below = (abs(param[end]) < UNBOUNDED for end in ("lo", "hi"))
    if above and (below or param["hi"] == np.inf):
        return f"[{param['lo']:g}, {param['hi']:g}]"
    return f">= {param['lo']:g}" if above else f"<= {param['hi']:g}" if below else ""


def _constructor(info: Mapping[str, Any], module: str) -> Callable[..., Component]:
    def make(**params: Any) -> Component:
        return build(info["family"], info["name"], params)

    make.__name__ = make.__qualname__ = class_name(info["name"])
    make.__module__ = module
    lines = [f"The {info['family']} '{info['name']}'.", "", "Parameters", "----------"]
    for param in info["params"]:
        lines += [param["name"], "    " + describe_parameter(param)]
    make.__doc__ = "\n".join(lines)
    make.__signature__ = inspect.Signature(  # type: ignore[attr-defined]
        [
            inspect.Parameter(
                p["name"],
                inspect.Parameter.KEYWORD_ONLY,
                default=inspect.Parameter.empty if p["required"] else p["default"],
            )
            for p in info["params"]
        ],
        return_annotation=Component,
    )
    return make
