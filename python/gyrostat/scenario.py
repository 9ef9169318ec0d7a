# SPDX-License-Identifier: MIT
"""Scenarios: a frozen, validated, hashable description of one closed loop. TOML and Python say the same things."""

from __future__ import annotations

import copy
import operator
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import numpy as np
from numpy.typing import NDArray
from pydantic import PlainValidator, ValidationInfo, model_validator

from gyrostat import _core, protocols, toml
from gyrostat.components import Component, checked_text, freeze, thaw
from gyrostat.errors import InputError, input_errors, suggestion
from gyrostat.memory import available_memory
from gyrostat.model import Model
from gyrostat.text import shown
from gyrostat.vehicle import (
    ControlMomentGyros,
    Desaturation,
    Flexible,
    Initial,
    Orbit,
    Thrusters,
    Truth,
    Vehicle,
    all_actuators,
    standing,
)

if TYPE_CHECKING:
    from gyrostat.results import Result

Channels = Sequence[str]

_shipped = Path(__file__).parent


def _component(value: Any, info: ValidationInfo) -> Any:
    """A component from a `Component`, a table with a type, or a name."""
    if value is None or isinstance(value, Component):
        return value
    if isinstance(value, str):
        return Component(checked_text(value))
    if isinstance(value, Mapping):
        return freeze(value)
    if isinstance(value, bool | int | float | list | tuple):
        raise InputError(f"{shown(value)} is a {type(value).__name__}; a component belongs here")
    call = _calls.get(str(info.field_name))
    if call is not None and callable(getattr(value, call, None)):
        if isinstance(value, type):
            raise InputError(f"{value.__name__} is a class; an object of it belongs here: {value.__name__}(...)")
        return value
    family = str(info.field_name).removesuffix("s")
    shaped = " with waveforms (gyrostat.waveforms) in them" if family in ("fault", "disturbance") else ""
    lacks = "" if call is None else f" without {call}(...)"
    raise InputError(
        f"{_class_of(value).__name__} is a Python object{lacks}; for '{family}' there are: "
        f"{', '.join(_core.catalogue()[family])}{shaped}"
    )


def _role(value: Any, info: ValidationInfo) -> Any:
    """A component, or any Python object that can step."""
    if callable(getattr(value, "step", None)) and not isinstance(value, type):
        return value
    if value is None or isinstance(value, Component | str | Mapping):
        return _component(value, info)
    name = _class_of(value).__name__
    if isinstance(value, type):
        raise InputError(f"{name} is a class; an object of it belongs here: {name}(...)")
    raise InputError(
        f"{shown(value)} is a {name} without step(...); a name, a component or an object with step belongs here"
    )


def _path(value: Any, info: ValidationInfo) -> Any:
    """A reference of the catalogue, or any Python object that says where it is at a time."""
    if value is None or isinstance(value, Component | str | Mapping):
        return _component(value, info)
    name = _class_of(value).__name__
    if isinstance(value, type):
        raise InputError(f"{name} is a class; an object of it belongs here: {name}(...)")
    if callable(getattr(value, "at", None)):
        return value
    raise InputError(
        f"{name} is a Python object without at(t); for 'reference' there are: "
        f"{', '.join(_core.catalogue()['reference'])}"
    )


def _class_of(value: Any) -> type:
    return value if isinstance(value, type) else type(value)


def _components(value: Any, info: ValidationInfo) -> tuple[Component, ...]:
    if not isinstance(value, list | tuple):
        raise InputError(f"{shown(value)} must be a list of components")
    return tuple(_component(v, info) for v in value)


def _drives(value: Any) -> tuple[tuple[int, Any], ...]:
    """Objects by the actuator whose law they are."""
    if not isinstance(value, Mapping | tuple):
        raise InputError(f"{shown(value)} is no table of objects by actuator; write {{2: {_class_of(value).__name__}}}")
    drives: dict[int, Any] = {}
    for key, drive in value.items() if isinstance(value, Mapping) else value:
        actuator = int(key) if isinstance(key, str) and key.isascii() and key.isdecimal() else key
        if not isinstance(actuator, int | np.integer) or isinstance(actuator, bool) or actuator < 0:
            raise InputError(f"{shown(key)} is no actuator; a column of D_B belongs here, counted from 0")
        if isinstance(drive, type):
            raise InputError(f"{drive.__name__} is a class; an object of it belongs here: {drive.__name__}(...)")
        if not callable(getattr(drive, "deliver", None)):
            raise InputError(
                f"actuator {actuator}: {shown(drive)} is a {type(drive).__name__} without deliver(...); "
                "an object that says what the actuator gives belongs here"
            )
        other = next((i for i, known in drives.items() if known is drive and i != actuator), None)
        if other is not None:
            raise InputError(
                f"actuators {other} and {actuator} are one object of {type(drive).__name__}; each needs its own"
            )
        drives[int(actuator)] = drive
    return tuple(sorted(drives.items(), key=operator.itemgetter(0)))


def _names(value: Any) -> tuple[str, ...] | None:
    """Names of channels: a list, never a single text, which is a list of letters to Python."""
    if value is None:
        return None
    if isinstance(value, str) or not isinstance(value, Iterable):
        example = value if isinstance(value, str) else "truth.*"
        raise InputError(f"{shown(value)} is no list of names; write ['{example}']")
    names = tuple(value)
    for name in names:
        if not isinstance(name, str):
            raise InputError(f"{shown(name)} is no text; the name of a channel belongs here")
    return tuple(map(checked_text, names))


def _every(value: Any) -> int:
    """Every how many samples are recorded."""
    try:
        number = operator.index(value)
    except TypeError:
        number = 0
    if not 1 <= number <= 10**9 or isinstance(value, bool):
        raise InputError(f"{shown(value)} is no whole number from 1 to 1000000000")
    return number


_One = Annotated[Component | str | None, PlainValidator(_component)]
_Sensors = Annotated[Sequence[Component | protocols.Sensor], PlainValidator(_components)]
_Faults = Annotated[Sequence[Component | protocols.Fault], PlainValidator(_components)]
_Disturbances = Annotated[Sequence[Component | protocols.Disturbance], PlainValidator(_components)]
_Drives = Annotated[Mapping[int, protocols.Drive] | Sequence[tuple[int, protocols.Drive]], PlainValidator(_drives)]
_Navigator = Annotated[Component | protocols.Navigator | str | None, PlainValidator(_role)]
_Observer = Annotated[Component | protocols.Observer | str | None, PlainValidator(_role)]
_Detector = Annotated[Component | protocols.Detector | str | None, PlainValidator(_role)]
_Controller = Annotated[Component | protocols.Controller | str | None, PlainValidator(_role)]
_Allocator = Annotated[Component | protocols.Allocator | str | None, PlainValidator(_role)]

_Reference = Annotated[Component | protocols.ReferencePath | str | None, PlainValidator(_path)]

_calls = {"sensors": "measure", "faults": "apply", "disturbances": "torque_B"}
"""Lists that may hold Python objects, and the function that such an object has."""

_roles = ("navigator", "observer", "detector", "controller", "allocator", "reference")


class Shadow(Model):
    """An observer and detector that run beside the first pair on the same signals, without closing the loop."""

    observer: _One = None
    detector: _One = None


class Record(Model):
    """What a run keeps: names of channels (the usual ones when absent), and every how many samples."""

    channels: Annotated[Sequence[str] | None, PlainValidator(_names)] = None
    every: Annotated[int, PlainValidator(_every)] = 1


class Scenario(Model):
    """One closed loop: vehicle, what really flies, the flight stack, faults, and for how long.

    Everything is checked when the scenario is built, so that a typing error does not wait for a run.

    Parameters
    ----------
    duration, dt
        Simulated time and period of the flight stack, s. The duration must be a whole number of periods.
    vehicle
        The nominal vehicle: all that flight knows.
    truth, initial
        What really flies where it differs, and the state at t = 0.
    orbit
        Where it flies: field, sun and shadow, and the gravity gradient on it.
    desaturation
        What flight does about momentum, with magnetorquers.
    flexible
        Appendages of the true vehicle that bend.
    cmg
        Control moment gyros, behind the actuators of the vehicle.
    thrusters
        On/off thrusters, the last of the actuators.
    navigator, observer, detector, controller, allocator
        Components of the flight stack, or Python objects with a ``step`` (see `gyrostat.protocols`).
    reference, integrator
        The attitude to follow and the integrator of the truth.
    faults, disturbances, sensors
        What acts on the truth; see the modules of these names.
    drives
        Actuators that are Python objects, by their column of ``D_B``: what they give of a command
        (`gyrostat.protocols.Drive`). Axis, limits and whether it is a wheel stay the vehicle's.
    shadows
        Further (observer, detector) pairs on the same signals.
    seed, run_number
        Of all noise: flights of the same seed and other numbers have noise of their own.
    noise_versions
        Of the noise of each second: other versions, other noise; 0 is the run's own.
    allow_unstable
        Run settings whose check says unstable (a published study's own unstable cases).
    record
        What a run keeps by default.

    Raises
    ------
    InputError
        A ``ValueError`` of one line: the key, the value and what is allowed, or the nearest name.

    Examples
    --------
    >>> import gyrostat as gs
    >>> scenario = gs.Scenario(
    ...     vehicle=gs.vehicle.ftc_4rw(),
    ...     controller=gs.controller("mrp_feedback"),
    ...     faults=[gs.faults.LossOfEffectiveness(actuator=2, t_on=20.0, remaining=0.4)],
    ...     duration=60.0,
    ...     dt=0.01,
    ... )
    >>> scenario.run()["truth.omega_BN_B"].shape
    (6001, 3)
    """

    name: str = ""
    description: str = ""
    duration: float
    dt: float
    seed: int = 0
    run_number: int = 0
    noise_versions: Sequence[float] = ()
    allow_unstable: bool = False
    vehicle: Vehicle
    truth: Truth | None = None
    orbit: Orbit | None = None
    desaturation: Desaturation | None = None
    flexible: Flexible | None = None
    cmg: ControlMomentGyros | None = None
    thrusters: Thrusters | None = None
    initial: Initial | None = None
    navigator: _Navigator = None
    observer: _Observer = None
    detector: _Detector = None
    controller: _Controller = None
    allocator: _Allocator = None
    reference: _Reference = None
    integrator: _One = None
    faults: _Faults = ()
    disturbances: _Disturbances = ()
    sensors: _Sensors = ()
    drives: _Drives = ()
    shadows: Sequence[Shadow] = ()
    record: Record | None = None

    @model_validator(mode="before")
    @classmethod
    def _plain(cls, data: Any) -> Any:
        """Lists to tuples where the models want tuples; tables need texts as keys to become models."""
        if isinstance(data, dict):
            if isinstance(data.get("shadows"), list):
                data = {**data, "shadows": tuple(data["shadows"])}
            if "actuators" in data:
                raise InputError("unknown key 'actuators'; Python objects are 'drives', {column of D_B: object}")
            shadows = data.get("shadows")
            tables = [value for key, value in data.items() if key != "drives"]
            for table in (*tables, *(shadows if isinstance(shadows, tuple) else ())):
                if isinstance(table, dict) and not all(isinstance(key, str) for key in table):
                    raise InputError(f"{shown(table)}: the keys of a table are texts")
        return data

    @model_validator(mode="after")
    def _checked(self) -> Scenario:
        self.check()
        return self

    @classmethod
    def load(cls, name: str | Path) -> Scenario:
        """A scenario of a file, or a shipped one by name (``wheel2_degraded``, ``li2018/table1``).

        Raises
        ------
        InputError
            No such file or name, or a file that does not hold a valid scenario.
        """
        return cls.from_toml(find(name))

    @classmethod
    def from_toml(cls, path: str | Path) -> Scenario:
        """Read a TOML file; messages name the file."""
        tables = toml.read(Path(path))
        with input_errors(str(path)):
            return cls.from_dict(tables)

    @classmethod
    def from_dict(cls, tables: Mapping[str, Any]) -> Scenario:
        """From the tables of a TOML file, or of `to_dict`."""
        given: Any = tables
        if not isinstance(given, Mapping) or not all(isinstance(key, str) for key in given):
            raise InputError(f"{shown(tables)} is no table of a scenario: a dictionary with texts as keys")
        return cls(**tables)

    def to_dict(self) -> dict[str, Any]:
        """Plain tables; a Python component stands as it is."""
        tables: dict[str, Any] = {}
        for key in type(self).model_fields:
            value = getattr(self, key)
            if value is None or value in ((), "") or value is False or (key == "run_number" and value == 0):
                continue
            tables[key] = dict(value) if key == "drives" else _table(value)
        return tables

    def to_toml(self, path: str | Path | None = None) -> str:
        """The text of a TOML file, also written to `path` if given.

        Raises
        ------
        InputError
            A Python component has no text.
        """
        for role in self.python_components():
            raise InputError(f"{role} is a Python object; a TOML file can only hold components of the catalogue")
        text = toml.write(self.to_dict())
        if path is not None:
            from gyrostat.files import write_text

            write_text(Path(path), text)
        return text

    def replace(self, /, **changes: Any) -> Scenario:
        """A copy with other values. Dotted keys reach inside: ``replace(**{"observer.lambda1": 2.0})``.

        A list is entered by position (``faults.0.remaining``).
        """
        tables = self.to_dict()
        for key, value in changes.items():
            _set(tables, key, value)
        return type(self).from_dict(tables)

    @property
    def actuators(self) -> int:
        """Number of actuators: the vehicle's, its control moment gyros and its thrusters."""
        gyros = 0 if self.cmg is None else self.cmg.count
        return self.vehicle.actuators + gyros + (0 if self.thrusters is None else self.thrusters.torque.size)

    @property
    def axes_B(self) -> NDArray[np.float64]:
        """(3, n) axes of the actuators as flight knows them, of control moment gyros those of the start."""
        return np.asarray(all_actuators(self.to_dict())["D_B"], dtype=float)

    def standing(self) -> Scenario:
        """The scenario with gimbals that do not turn (`gyrostat.vehicle.standing`); itself without gyros."""
        return self if self.cmg is None else type(self).from_dict(standing(self.to_dict()))

    def check(self) -> list[dict[str, Any]]:
        """Build everything without running; one row a component check, with the number and the limit it was held to.

        Raises
        ------
        InputError
            Something that cannot be built.
        """
        with input_errors():
            return self.compiled.check(self.python_components())

    def remarks(self) -> list[str]:
        """What is allowed and yet looks like a mistake, one line each; nothing is refused for it.

        A run may be shorter than a fault is late (a look at the first seconds, a recording), so that a fault that never
        begins is said and not refused.
        """
        onsets = [
            (f"faults[{i}] '{f.type}'", f.params.get("t_on", 0.0))
            for i, f in enumerate(self.faults)
            if isinstance(f, Component)
        ]
        late = [
            f"{fault} never begins: t_on = {t_on:g} s, and the run ends at {self.duration:g} s"
            for fault, t_on in onsets
            if t_on >= self.duration
        ]
        return [*late, *self._unheard()]

    def _unheard(self) -> Iterator[str]:
        """A gyro that is slower than the stack, behind an observer that learns from differences of two rates."""
        observer, hears = self.observer, "joint_kalman"
        if not isinstance(observer, Component) or observer.type == hears:
            return
        if not _core.describe("observer", observer.type)["traits"]["estimates"]:
            return
        for i, sensor in enumerate(self.sensors):
            every = sensor.params.get("every", 1) if isinstance(sensor, Component) and sensor.type == "gyro" else 1
            if every > 1:
                yield (
                    f"sensors[{i}] 'gyro' has a rate every {every} samples, and observer '{observer.type}' learns from "
                    f"two in a row: it learns nothing; dt = {every * self.dt:g} s is the gyro's, or take {hears}"
                )

    def resolve(self) -> dict[str, Any]:
        """The scenario with every default filled in, as plain tables."""
        return self.compiled.resolve()

    def channel_names(self) -> list[dict[str, Any]]:
        """Every channel a run can record: name, size, unit and meaning."""
        return self.compiled.channel_names(copies(self.python_components()))

    def run(
        self,
        *,
        channels: Channels | None = None,
        every: int | None = None,
        progress: Callable[[float], None] | None = None,
    ) -> Result:
        """Fly it. The loop runs without Python's global lock: threads run scenarios in parallel.

        A Python component flies as a copy of its own (`copy.deepcopy`), so that runs do not touch each other, nor the
        scenario: the same numbers come out however often and wherever it is flown. `Result.components` holds what flew.

        Parameters
        ----------
        channels
            Names to record instead of the scenario's own choice (``estimate.*`` for a group); fewer are faster and
            smaller.
        every
            Record every so many samples, instead of the scenario's own choice.
        progress
            Called now and then with the finished fraction, 0 to 1. What it raises ends the run and reaches the caller.

        Returns
        -------
        Result
            Also of a run that ended early (see `Result.status`): what happened up to there.

        Raises
        ------
        InputError
            A channel that does not exist, a record that needs more memory than there is, or a Python component that
            cannot be copied.
        """
        from gyrostat.results import Result

        components = copies(self.python_components())
        with input_errors("channels"):
            chosen = None if channels is None else list(_names(channels) or ())
        with input_errors("every"):
            fewer = 0 if every is None else _every(every)
        if progress is not None and not callable(progress):
            raise InputError(f"progress: {shown(progress)} cannot be called")
        room = available_memory()
        if components:  # what a Python component raises reaches the caller as it is
            raw = self.compiled.simulate(components, chosen, fewer, progress, room)
        else:
            with input_errors():
                raw = self.compiled.simulate(components, chosen, fewer, progress, room)
        return Result.from_core(self, raw, components)

    def __getitem__(self, key: str) -> Any:
        """A value by the dotted key that `replace` takes, defaults filled in: ``scenario["observer.lambda1"]``.

        Raises
        ------
        KeyError
            There is no such key; the message has the nearest one.
        """
        values = self._values
        if key not in values:
            raise KeyError(f"no key '{key}'{suggestion(str(key), values)}")
        return values[key]

    def _ipython_key_completions_(self) -> list[str]:
        return list(self._values)

    def _repr_html_(self) -> str:
        from gyrostat import notebook

        return notebook.scenario(self)

    @cached_property
    def _values(self) -> dict[str, Any]:
        """Every value by its dotted key: tables, and what is in them."""
        return dict(_leaves("", self.resolve()))

    def python_components(self) -> dict[str, object]:
        """The roles that Python objects play, with the objects.

        Of sensors, faults and disturbances a list of those, of drives a dictionary by actuator.
        """
        found = {role: getattr(self, role) for role in _roles}
        alone = {r: c for r, c in found.items() if c is not None and not isinstance(c, Component)}
        listed = {k: [c for c in getattr(self, k) if not isinstance(c, Component)] for k in _calls}
        driven = {"drives": dict(self.drives)} if self.drives else {}
        return alone | {k: objects for k, objects in listed.items() if objects} | driven

    def tables(self) -> dict[str, Any]:
        """As `to_dict`, for the host: a Python component stands as ``type = "python"``, or not in its list or table."""
        tables = self.to_dict()
        for role in self.python_components():
            if role == "drives":
                del tables[role]
            elif role in _calls:
                tables[role] = [_table(c) for c in getattr(self, role) if isinstance(c, Component)]
            else:
                tables[role] = {"type": "python"}
        return tables

    @cached_property
    def compiled(self) -> _core.Compiled:
        """The scenario as the host has read and cross-checked it, once."""
        with input_errors():
            return _core.Compiled(self.tables())


def with_objects(tables: Mapping[str, Any], components: Mapping[str, Any]) -> dict[str, Any]:
    """`Scenario.tables` with `Scenario.python_components` in their places; in a list they come last."""
    merged = {k: [*tables.get(k, ()), *c] if k in _calls else c for k, c in components.items()}
    return {**tables, **merged}


def copies(components: dict[str, object]) -> dict[str, object]:
    """Copies for one run. They are taken together: what two components share, their copies share too."""
    try:
        return copy.deepcopy(components)
    except Exception as error:
        role, culprit = next(((r, c) for r, c in components.items() if not _can_be_copied(c)), ("", components))
        raise InputError(
            f"{role} {type(culprit).__name__} cannot be copied ({' '.join(str(error).split())}); a run flies its own "
            "copy of a Python component: take out what has no copy, or give the class a __deepcopy__"
        ) from None


def _can_be_copied(component: object) -> bool:
    try:
        copy.deepcopy(component)
    except Exception:
        return False
    return True


def _leaves(prefix: str, value: Any) -> Iterator[tuple[str, Any]]:
    """A table, or a list of tables, by keys; each with what is in it."""
    if prefix:
        yield prefix, value
    tables = isinstance(value, list) and all(isinstance(v, Mapping) for v in value)
    within = dict(enumerate(value)) if tables else value if isinstance(value, Mapping) else {}
    for key, inner in within.items():
        yield from _leaves(f"{prefix}.{key}" if prefix else str(key), inner)


def find(name: str | Path) -> Path:
    """The file of a scenario: a path, or the name of a shipped one, also where a folder has that name."""
    if not isinstance(name, str | Path):
        raise InputError(f"{shown(name)} is no text and no path; the name or the file of a scenario belongs here")
    path = Path(name)
    known = shipped()
    with suppress(OSError):  # too long for a file, say: then it is no file
        if path.suffix == ".toml" or (path.exists() and not (path.is_dir() and str(name) in known)):
            return path
    if str(name) in known:
        return known[str(name)]
    raise InputError(f"no scenario '{name}'{suggestion(str(name), known)}")


def shipped() -> dict[str, Path]:
    """Scenarios that come with the package, by name; those of a paper as ``<paper>/<case>``."""
    own = {p.stem: p for p in sorted((_shipped / "scenarios").glob("*.toml"))}
    papers = {f"{p.parts[-3]}/{p.stem}": p for p in sorted((_shipped / "papers").glob("*/scenarios/*.toml"))}
    return own | papers


def _table(value: Any) -> Any:
    """Plain form of a field of a scenario."""
    blocks = Vehicle | Truth | Orbit | Desaturation | Flexible | ControlMomentGyros | Thrusters | Initial
    if isinstance(value, Component | blocks):
        return value.to_dict()
    if isinstance(value, Model):
        return {k: _table(v) for k, v in value if v is not None}
    if isinstance(value, tuple):
        return [_table(v) for v in value]
    return thaw(value)


def _set(tables: dict[str, Any], key: str, value: Any) -> None:
    """Set a dotted key in place. A name where a component stands becomes that component."""
    *path, last = key.split(".")
    target: Any = tables
    for depth, part in enumerate(path):
        if isinstance(target, list):
            target = target[_position(target, part, ".".join(path[: depth + 1]))]
        elif isinstance(target, dict):
            if isinstance(target.get(part), Component | str):  # a component by its name alone
                target[part] = _table(Component(target[part]) if isinstance(target[part], str) else target[part])
            target = target.setdefault(part, {})
        if not isinstance(target, dict | list):
            raise InputError(f"'{key}': '{'.'.join(path[: depth + 1])}' = {shown(target)} has no keys")
    if isinstance(target, list):
        target[_position(target, last, key)] = value
    else:
        target[last] = value


def _position(entries: list[Any], part: str, key: str) -> int:
    if part.isascii() and part.isdecimal() and len(part) < 10 and int(part) < len(entries):
        return int(part)
    allowed = f"0 to {len(entries) - 1}" if entries else "no entry: the list is empty"
    raise InputError(f"'{key}': '{part}' is no position in the list; allowed: {allowed}")


__all__ = ["Record", "Scenario", "Shadow", "find", "shipped"]
