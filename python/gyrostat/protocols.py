# SPDX-License-Identifier: MIT
"""What a Python object must offer to fly in the loop in place of a catalogue component.

Each role of the stack needs ``step``; beside it a reference has ``at``, a sensor ``measure``, a fault ``apply``, an
actuator ``deliver``, a disturbance ``torque_B``. Optional are ``setup(setup)``, called exactly once, before the run,
with vehicle and period; ``telemetry()``, a dictionary of numbers and vectors that are recorded (`Telemetry`);
``start``, called at tick 0, when no interval has passed, with the arguments of ``step`` but ``last``; ``skip(y, last)``
(observers), called instead of ``step`` for an interval that teaches nothing: rate or wheel momentum was not measured at
one of its ends (``y.rate_valid``, ``y.momentum_valid``), or the state jumped; ``shift_rate(step)`` (observers), called
before ``step`` where a navigator says that its rate has moved without motion (``y.rate_step``); and ``reset``
(allocators). Every run flies a copy of the object (`copy.deepcopy`); `Result.components` holds the one that flew.
The signals carry the names of the C++ contract: ``x.q_NB``, ``x.omega_BN_B``, ``ref.q_NR``, ``last.u``. An exception
ends the run and reaches the caller unchanged, with a note of where and when. A Python step costs microseconds where a
compiled one costs nanoseconds.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from gyrostat._core import Allocation, Demand, Detection, Estimate, Measurement, Reference


@runtime_checkable
class Navigator(Protocol):
    """Sensors as they are -> what ideal ones would show: attitude, rate without bias, validity."""

    def step(self, y: Measurement, /) -> Measurement:
        """Every sample, also those with nothing valid in them. Change what is given and return it."""


@runtime_checkable
class Observer(Protocol):
    """Measurement -> estimate. Start from ``Estimate.healthy(y)`` and set what is estimated."""

    def step(self, y: Measurement, last: Allocation, /) -> Estimate:
        """Every sample after the first: `last` was issued over the interval just ended."""


@runtime_checkable
class Detector(Protocol):
    """Estimate -> what changed or failed."""

    def step(self, x: Estimate, last: Allocation, /) -> Detection:
        """Every sample after the first."""


@runtime_checkable
class Controller(Protocol):
    """Estimate and reference -> demanded torque, N m, body frame."""

    def step(self, x: Estimate, det: Detection, ref: Reference, last: Allocation, /) -> NDArray[np.float64] | Demand:
        """Every sample after the first."""


@runtime_checkable
class Allocator(Protocol):
    """Demanded torque -> commands, N m, one an actuator."""

    def step(self, demand: Demand, x: Estimate, det: Detection, /) -> NDArray[np.float64] | Allocation:
        """Every sample."""


@runtime_checkable
class ReferencePath(Protocol):
    """What the vehicle should do, as a function of time."""

    def at(self, t: float, /) -> NDArray[np.float64] | tuple[NDArray[np.float64], ...]:
        """Every sample, in order: ``q_NR``, or ``(q_NR, omega_RN_R, omegadot_RN_R)``; without, both are zero."""


@runtime_checkable
class Sensor(Protocol):
    """What the sensors show -> what it shows beside or instead of it; ideal sensors show the truth."""

    def measure(self, y: Measurement, /) -> Measurement:
        """Every sample, after the sensors of the catalogue. Change what is given and return it."""


@runtime_checkable
class Fault(Protocol):
    """What happens to the commands on their way to the actuators, whose limits come after."""

    def apply(self, t: float, u: NDArray[np.float64], /) -> NDArray[np.float64]:
        """Every sample: the command issued at `t` -> the one that arrives, held until the next sample."""


@runtime_checkable
class Drive(Protocol):
    """The law of an actuator: what it gives along its axis of what it is commanded.

    Beside the native ones, as ``Scenario(drives={2: MyWheel()})``. Flight knows axis and limits from the vehicle, as of
    any other; with a ``wheel_inertia`` what is given is taken from a wheel, and momentum limit and friction of truth
    act on it.
    """

    def deliver(
        self, t: float, u: float, h_w: float, omega_BN_B: NDArray[np.float64], /
    ) -> float | NDArray[np.float64] | list[tuple[float, float]]:
        """Every sample: N m (A m^2 of a magnetorquer) from `t` on, held until the next one, before faults act on it.

        Or rows ``(after, value)``: `value` is given from ``t + after`` on. They begin at 0, go on in order of time, and
        end before the period is over.

        Parameters
        ----------
        t
            Time of the sample, s.
        u
            The command that arrives, inside the true limits where these act on commands.
        h_w
            Momentum in the wheel, N m s; 0 where it is none.
        omega_BN_B
            (3,) body rate, rad/s.
        """


@runtime_checkable
class Telemetry(Protocol):
    """What any of them may have beside: inner signals that are recorded as ``controller.name``, ``drive2.name``, ..."""

    def telemetry(self) -> Mapping[str, float | NDArray[np.float64]]:
        """Numbers and vectors by name: always the same names, and sizes.

        Asked once after ``setup``, for names and sizes, and then at every recorded sample.
        """


@runtime_checkable
class Disturbance(Protocol):
    """A torque on the body, N m in body axes."""

    def torque_B(self, t: float, q_NB: NDArray[np.float64], omega_BN_B: NDArray[np.float64], /) -> NDArray[np.float64]:
        """Every sample: the torque that is held until the next one."""
