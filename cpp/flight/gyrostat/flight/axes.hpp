// SPDX-License-Identifier: MIT
/// @file  Where the actuators of a vehicle point at a sample: the policy of a stack that fills `Measurement::axes`.
///
/// A policy is called with the vehicle and the measurement as the components get it, and returns its axes. It must give another
/// `revision` whenever it gives another `D_B`, or allocators keep what they have factored. Page: docs/architecture.md
#pragma once
#include <concepts>

#include "gyrostat/core/signals.hpp"

namespace gyrostat {

template <class G, class S>
concept Geometry = requires(G geometry, const Vehicle<S>& vehicle, const Measurement<S>& y) {
  { geometry(vehicle, y) } noexcept -> std::same_as<Axes<S>>;
};

/// Wheels and fixed thrusters: the axes of the vehicle, and nothing to do.
struct FixedAxes {};

}  // namespace gyrostat
