// SPDX-License-Identifier: MIT
/// @file  A Python object as a component. The loop runs without the GIL and takes it around the object's own step; an
///        exception raised there ends the run and reaches the caller unchanged.
///
/// An object has `step(...)` with the arguments of its role, and may have `setup(setup)`, called once before the run,
/// `start(...)`, called at the first sample instead of `step`, `skip(y, last)` (observers), called instead of `step` for an
/// interval that taught nothing, `shift_rate(step)` (observers), called before `step` when a navigator has moved the rate by
/// knowledge, and `reset()` (allocators). A reference has `at(t)`, a sensor `measure(y)`, a fault `apply(t, u)`, a drive
/// `deliver(t, u, h_w, omega_BN_B)`, a disturbance `torque_B(t, q_NB, omega_BN_B)`, called between integrations. Any of them may have
/// `telemetry()`: what it gives is recorded. An object flies one run: who flies several copies it (Scenario.run does).
/// Docs: docs/extending.md
#pragma once
#include <pybind11/pybind11.h>

#include "gyrostat/host/simulate.hpp"

namespace gyrostat::bindings {

/// What components are made for. To fly: `setup` is called, and then `telemetry`, which says what can be recorded; who only asks for
/// that hands in copies, as a run does. To look: neither is called.
enum class Use { fly, look };

/// Components for the roles of `objects` (navigator, observer, detector, controller, allocator, reference -> object; sensors, faults,
/// disturbances -> list of objects; drives -> objects by their actuators). Needs the GIL.
host::ExternalComponents python_components(const pybind11::dict& objects, Use use);

}  // namespace gyrostat::bindings
