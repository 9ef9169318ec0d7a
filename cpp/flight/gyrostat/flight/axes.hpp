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

/// Magnetorquers turn the vehicle across the field that was measured; all others stay where the vehicle has them.
template <class S>
struct MagneticAxes {
  Mat3N<S> dipole_B{3, 0};     ///< axes of the magnetorquers' dipoles, in their columns
  std::uint32_t revision = 0;  ///< of the axes given last

  Axes<S> operator()(const Vehicle<S>& vehicle, const Measurement<S>& y) noexcept {
    Axes<S> axes;
    if (!vehicle.magnetorquers.any()) return axes;
    axes.D_B = vehicle.D_B;
    for (int i = 0; i < vehicle.actuators(); ++i) {
      if (vehicle.magnetorquers.test(i)) axes.D_B.col(i) = Vec3<S>(dipole_B.col(i)).cross(y.field_B);
    }
    axes.h_B = torque<S>(vehicle.D_B, y.h_w);
    axes.revision = ++revision;
    return axes;
  }
};

}  // namespace gyrostat
