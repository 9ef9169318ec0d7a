# SPDX-License-Identifier: MIT
"""gyrostat: fault-tolerant spacecraft attitude control.

Describe a closed loop (`Scenario`), fly it (`Scenario.run`), look at what happened (`Result`). Components are named in
a catalogue (``gyrostat list``); SI units and radians everywhere, quaternions scalar first, actuators counted from 0.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

from gyrostat._core import Allocation, Demand, Detection, Estimate, Measurement, Reference, Setup, __version__
from gyrostat.components import Component, allocator, controller, detector, integrator, observer, reference
from gyrostat.errors import InputError
from gyrostat.results import Event, Result
from gyrostat.scenario import Record, Scenario, Shadow
from gyrostat.vehicle import Initial, Truth, Vehicle

if TYPE_CHECKING:
    from gyrostat import (
        attitude,
        design,
        disturbances,
        faults,
        integrators,
        metrics,
        papers,
        plots,
        references,
        sensors,
        vehicle,
        waveforms,
    )

__all__ = [
    "Allocation",
    "Component",
    "Demand",
    "Detection",
    "Estimate",
    "Event",
    "Initial",
    "InputError",
    "Measurement",
    "Record",
    "Reference",
    "Result",
    "Scenario",
    "Setup",
    "Shadow",
    "Truth",
    "Vehicle",
    "__version__",
    "allocator",
    "attitude",
    "controller",
    "design",
    "detector",
    "disturbances",
    "faults",
    "integrator",
    "integrators",
    "metrics",
    "observer",
    "papers",
    "plots",
    "reference",
    "references",
    "sensors",
    "vehicle",
    "waveforms",
]


def __getattr__(name: str) -> Any:
    """Sub-modules load when they are first used."""
    if name in __all__:
        return import_module(f"gyrostat.{name}")
    raise AttributeError(f"module 'gyrostat' has no attribute '{name}'")


def __dir__() -> list[str]:
    return __all__
