// SPDX-License-Identifier: MIT
/// @file  What on/off actuators make of a command: whole ticks of their valves, none below a shortest pulse or a shortest pause.
///
///     n = floor(u / u_quantum + 1/2),   u < u_dead -> 0,   u_up - u < u_gap -> u_up,   u = n u_quantum
///
/// The valves round in the same way, so that what flight believes of a command is what it does. Page: docs/thrusters.md
#pragma once
#include <algorithm>
#include <cmath>

#include "gyrostat/core/signals.hpp"

namespace gyrostat {

/// Whether any actuator of the vehicle is on/off.
template <class S>
bool any_pulses(const Vehicle<S>& vehicle) noexcept {
  return vehicle.u_quantum.size() != 0 && (vehicle.u_quantum.array() > S(0)).any();
}

/// A command inside the box, as the valves deliver it; of other actuators it stays what it is.
template <class S>
VecN<S> as_pulses(const Vehicle<S>& vehicle, VecN<S> u) noexcept {
  const auto of = [](const VecN<S>& v, Eigen::Index i) { return v.size() == 0 ? S(0) : v[i]; };
  for (Eigen::Index i = 0; i < u.size(); ++i) {
    const S q = vehicle.u_quantum[i], up = vehicle.u_up[i];
    if (!(q > S(0))) continue;
    const S pulse = q * std::floor(u[i] / q + S(0.5));
    if (pulse < of(vehicle.u_dead, i) - q / S(2)) {
      u[i] = S(0);
    } else if (up - pulse < std::max(of(vehicle.u_gap, i) - q / S(2), q / S(2))) {
      u[i] = up;
    } else {
      u[i] = pulse;
    }
  }
  return u;
}

}  // namespace gyrostat
