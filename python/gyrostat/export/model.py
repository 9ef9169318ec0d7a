# SPDX-License-Identifier: MIT
"""What every target is written from: the flight half of a scenario, and recorded rows of its closed loop."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gyrostat.errors import InputError, input_errors
from gyrostat.export.folder import has_header
from gyrostat.export.places import identifier, identifier_of
from gyrostat.scenario import Scenario

SAMPLES = 3000
"""Rows of a recording unless the user says otherwise."""

INPUTS = (
    "measurement.q_NB",
    "measurement.omega_BN_B",
    "measurement.h_w",
    "measurement.attitude_valid",
    "measurement.rate_valid",
    "measurement.momentum_valid",
    "reference.q_NR",
    "reference.omega_RN_R",
    "reference.omegadot_RN_R",
    "reference.event",
)
GIMBALS = ("measurement.gimbal",)
"""Input of a stack that steers control moment gyros, beside the others."""
SKY = (
    "measurement.field_B",
    "measurement.field_N",
    "measurement.field_valid",
    "measurement.sun_B",
    "measurement.sun_N",
    "measurement.sun_valid",
)
"""Inputs more, of a stack that flies on an orbit."""

OUTPUTS = (
    "allocation.u",
    "allocation.achieved_B",
    "allocation.saturated",
    "allocation.status",
    "demand.tau_B",
    "estimate.q_NB",
    "estimate.omega_BN_B",
    "estimate.d_B",
    "estimate.effectiveness",
    "estimate.effectiveness_bound",
    "detection.changed",
    "detection.failed",
    "detection.enabled",
    "detection.event",
    "detection.class",
    "detection.gain",
    "detection.bias",
)
"""The signals on both sides of the stack, by the names of their channels."""

_folders = {
    "navigator": "navigators",
    "observer": "observers",
    "detector": "detectors",
    "controller": "controllers",
    "allocator": "allocators",
}
"""Of the headers of a role. The desaturation has none: it is the only one."""


@dataclass(frozen=True)
class Parameter:
    """One parameter as it is flown: what the catalogue says of it, and its value as a row of numbers."""

    name: str
    kind: str
    unit: str
    lo: float
    hi: float
    meaning: str
    options: tuple[str, ...]
    numbers: tuple[float, ...]
    shape: tuple[int, ...]
    """Of a vector or matrix; empty for a single number."""

    def elements(self) -> list[str]:
        """``["K3[0]", "K3[1]", "K3[2]"]``, or the name alone."""
        return [self.name + suffix for suffix in suffixes(self.shape)]


@dataclass(frozen=True)
class ComponentCode:
    """One flight component: its C++ class, header and parameters."""

    role: str
    name: str
    cpp: str
    header: str
    params: tuple[Parameter, ...]


@dataclass(frozen=True)
class FlightCode:
    """The flight stack of a scenario, ready to be written down."""

    name: str
    """A C identifier: of files, namespace and functions."""
    title: str
    scenario: Scenario
    scalar: str
    dt: float
    vehicle: Mapping[str, Any]
    components: tuple[ComponentCode, ...]
    gyros: tuple[Mapping[str, Any], ...]
    """Control moment gyros: actuator, gimbal_axis_B, spin_axis_B, rotor_momentum."""
    dipole_B: Sequence[Sequence[float]]
    """Axes of magnetorquers in their columns, as three rows; empty rows without any."""
    allow_unstable: bool
    capacity: int
    """Most actuators that the library is compiled for: its storage is inline."""
    bytes: Mapping[str, int]
    """At least the size of the stack for each scalar, with Eigen aligned to 16."""
    columns: Mapping[str, int]
    """Signal -> width, in the order of the rows."""
    rows: NDArray[np.float64]
    """The recorded closed loop, a row a sample from the first on."""

    @property
    def actuators(self) -> int:
        """How many the vehicle has."""
        return len(self.vehicle["u_up"])

    @property
    def inputs(self) -> tuple[str, ...]:
        """Signals that it takes, in the order of the rows."""
        return tuple(signal for signal in self.columns if signal not in OUTPUTS)

    @property
    def sees_the_sky(self) -> bool:
        """Whether sun and field are among its inputs."""
        return SKY[0] in self.columns

    @property
    def axes_move(self) -> bool:
        """Whether its actuators point elsewhere at every sample."""
        return bool(self.gyros or self.vehicle["magnetorquers"])

    def column(self, signal: str) -> NDArray[np.float64]:
        """The recorded rows of one signal, shape (samples, width)."""
        first = 0
        for name, width in self.columns.items():
            if name == signal:
                return self.rows[:, first : first + width]
            first += width
        raise KeyError(signal)


def flight_code(scenario: Scenario, *, scalar: str, samples: int, name: str | None) -> FlightCode:
    """Collect it, and fly the scenario for the rows.

    Raises
    ------
    InputError
        What only runs in the host: Python components, Euler-angle coordinates, shadows; or a name that is taken.
    """
    _refuse_host_only(scenario)
    name = identifier_of(scenario.name) if name is None else identifier(name)
    with input_errors():
        model = scenario.compiled.flight_model()
    if model["vehicle"]["coordinates"] != "body":
        raise InputError("vehicle: coordinates euler_angles cannot be exported; flight code takes body coordinates")
    components = tuple(_component(c) for c in model["components"])
    columns, rows = _recorded(scenario, samples)
    return FlightCode(
        name=name,
        title=scenario.name,
        scenario=scenario,
        scalar=scalar,
        dt=model["dt"],
        vehicle=model["vehicle"],
        components=components,
        gyros=tuple(model["gyros"]),
        dipole_B=model["dipole_B"],
        allow_unstable=model["allow_unstable"],
        capacity=model["capacity"],
        bytes=model["bytes"],
        columns=columns,
        rows=rows,
    )


def suffixes(shape: Sequence[int]) -> list[str]:
    """Of the elements of an array, row by row, counted from 0: ``[""]`` for a number, ``["[0,0]", "[0,1]", ...]``."""
    return [f"[{','.join(map(str, at))}]" if at else "" for at in np.ndindex(*shape)]


def _refuse_host_only(scenario: Scenario) -> None:
    for role in _folders:
        part = getattr(scenario, role)
        if part is not None and not hasattr(part, "to_dict"):
            raise InputError(
                f"{role}: {type(part).__name__} is a Python object; only components of the catalogue have C++"
            )
    for role in scenario.python_components():
        raise InputError(
            f"{role}: a Python object is there, which the exported scenario cannot say; the stack exports without it"
        )
    if scenario.shadows:
        raise InputError("shadows are not part of the flight stack: export without them (--set shadows=[])")


def _component(found: Mapping[str, Any]) -> ComponentCode:
    role, name = found["role"], found["name"]
    header = "/".join(["gyrostat/flight", *([_folders[role]] if role in _folders else []), f"{name}.hpp"])
    if (
        not found["cpp"].startswith("gyrostat::")
        or found["cpp"].startswith("gyrostat::host::")
        or not has_header(header)
    ):
        raise InputError(f"{role} '{name}' runs in the host alone and cannot be exported ({found['cpp']})")
    params = tuple(_parameter(role, p) for p in found["params"] if p["default"] is not None)
    return ComponentCode(role, name, found["cpp"], header, params)


def _parameter(role: str, found: Mapping[str, Any]) -> Parameter:
    value = found["default"]
    if found["kind"] == "choice":
        numbers: NDArray[np.float64] = np.array(float(found["options"].index(value)))
    else:
        try:
            numbers = np.array(value, dtype=float)
        except (TypeError, ValueError):
            raise InputError(f"{role}: {found['name']} is a {found['kind']}, which flight code does not have") from None
    facts = {key: found[key] for key in ("name", "kind", "unit", "lo", "hi", "meaning")}
    return Parameter(
        **facts, options=tuple(found["options"]), numbers=tuple(numbers.ravel().tolist()), shape=numbers.shape
    )


def _recorded(scenario: Scenario, samples: int) -> tuple[dict[str, int], NDArray[np.float64]]:
    """Width of each signal, and the rows of the first samples of the closed loop."""
    if samples < 0 or samples == 1:
        raise InputError(f"samples = {samples}: 2 or more belong here, or 0 for the whole run")
    intervals = round(scenario.duration / scenario.dt)
    if 0 < samples <= intervals:
        intervals = samples - 1
    flown = scenario.replace(record=None, duration=intervals * scenario.dt)
    gimbals = GIMBALS if scenario.cmg is not None else ()
    sky = SKY if scenario.orbit is not None else ()
    signals = (*INPUTS, *gimbals, *sky, *OUTPUTS)
    result = flown.run(channels=list(signals))
    blocks = {name: result.channels[name].reshape(len(result), -1) for name in signals}
    return {name: block.shape[1] for name, block in blocks.items()}, np.hstack(list(blocks.values()))


def literal(x: float) -> str:
    """A number as C and C++ read it, exactly."""
    if math.isinf(x):
        return "-INFINITY" if x < 0 else "INFINITY"
    return repr(float(x))
