// SPDX-License-Identifier: MIT
/// @file  Dry friction at standstill: which wheels break loose, which stay.
///
/// A wheel whose speed relative to the body is zero turns with the body as long as dry friction r, up to its magnitude, can
/// keep it there. Its speed changes by
///
///     s' = -(u + r) / Js - g . w',   J w' = T + sum over these wheels of g (u + r)
///
/// with u the motor's torque on the body and T all other torques. Wanted are the r with which each wheel either keeps its
/// speed (s' = 0, |r| <= dry) or breaks loose against the full friction (r = dry sign(s')). Wheels that stay are added to
/// the body's inertia, so that no r has to be solved for. The matrix of s' in r is symmetric and definite: there is one
/// solution, and changing one wheel at a time, always the first that is wrong, ends at it (Murty 1974).
#pragma once
#include <array>

#include "gyrostat/core/types.hpp"

namespace gyrostat::truth {

/// A wheel at speed zero.
struct StandingWheel {
  int actuator = 0;
  Vec3<double> axis_B = Vec3<double>::Zero();
  double inertia = 0, drive = 0, dry = 0;  ///< kg m^2; N m on the body; N m
  int direction = 0;                       ///< of the speed it takes up; 0: it stays
};

struct Standstill {
  std::array<StandingWheel, max_actuators> wheels;
  int count = 0;

  void add(const StandingWheel& wheel) noexcept { wheels[static_cast<std::size_t>(count++)] = wheel; }
  /// Fills in the directions.
  /// @param J_B  without these wheels' axial inertia; `torque_B` on the body, without these wheels
  void settle(const Mat3<double>& J_B, const Vec3<double>& torque_B) noexcept;
};

}  // namespace gyrostat::truth
