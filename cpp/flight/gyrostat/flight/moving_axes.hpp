// SPDX-License-Identifier: MIT
/// @file  Where the actuators of any vehicle point: control moment gyros by their gimbals, magnetorquers by the field, all others
///        where the vehicle has them. The geometry of the host's stacks, and of every exported one whose axes move.
///
/// Pages: docs/cmg.md, docs/orbit.md
#pragma once
#include "gyrostat/flight/control_moment_gyros.hpp"

namespace gyrostat {

template <class S>
struct MovingAxes {
  ControlMomentGyros<S> gyros;
  MagneticAxes<S> magnetic;

  Axes<S> operator()(const Vehicle<S>& vehicle, const Measurement<S>& y) noexcept {
    const Axes<S> turned = gyros(vehicle, y);
    if (!vehicle.magnetorquers.any()) return turned;
    Axes<S> out = magnetic(vehicle, y);
    if (!turned.move()) return out;
    for (int i = 0; i < vehicle.actuators(); ++i) {
      if (gyros.gyros().test(i)) out.D_B.col(i) = turned.D_B.col(i);
    }
    out.h_B = turned.h_B;
    return out;
  }
};

}  // namespace gyrostat
