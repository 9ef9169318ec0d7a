// SPDX-License-Identifier: MIT
/// @file  Ideal torque actuators: torque along a fixed axis from outside.
#pragma once
#include "gyrostat/truth/effectors/effector.hpp"

namespace gyrostat::truth {

struct Torquer {
  static constexpr const char* name = "torquer";
  static constexpr int states = 0;
  static constexpr bool along_axis = true;
  static constexpr Storage storage = Storage::outer;

  int channel = -1;

  Mat3<double> inertia_B() const { return Mat3<double>::Zero(); }
};

}  // namespace gyrostat::truth
