// SPDX-License-Identifier: MIT
/// @file  Reaction wheels: momentum P along a fixed axis, exchanged with the body.
///
/// A wheel may have a momentum limit and dry friction: then it turns, stands in its bearing or is full, which is decided piece
/// by piece (rigid_plant_definitions.hpp). Dry friction is constant while it turns one way, and so part of the impulse.
#pragma once
#include <cmath>

#include "gyrostat/truth/effectors/effector.hpp"
#include "gyrostat/truth/waveform.hpp"

namespace gyrostat::truth {

struct Wheel {
  static constexpr const char* name = "wheel";
  static constexpr int states = 0;
  static constexpr bool along_axis = true;
  static constexpr Storage storage = Storage::inner;

  int channel = -1;
  Vec3<double> axis_B = Vec3<double>::Zero();
  double inertia = 0;               ///< kg m^2 about the axis
  double viscous = 0, coulomb = 0;  ///< N m s/rad; N m
  double momentum_max = infinity;   ///< N m s

  Mat3<double> inertia_B() const { return inertia * axis_B * axis_B.transpose(); }
  bool watched() const noexcept { return momentum_max < infinity || coulomb > 0; }
  /// N m s, that turns with the body when it stands in its bearing.
  double turned_momentum(const Vec3<double>& omega_BN_B) const noexcept { return inertia * axis_B.dot(omega_BN_B); }
  /// rad/s, relative to the body.
  double speed(double momentum, const Vec3<double>& omega_BN_B) const noexcept {
    return momentum / inertia - axis_B.dot(omega_BN_B);
  }
  /// rad/s, sum of the two parts of that.
  double speed_parts(double momentum, const Vec3<double>& omega_BN_B) const noexcept {
    return std::abs(momentum) / inertia + std::abs(axis_B.dot(omega_BN_B));
  }
};

/// A wheel whose bearing has friction. Its state: the momentum that viscous friction has taken, beside P.
struct FrictionWheel : Wheel {
  static constexpr const char* name = "friction_wheel";
  static constexpr int states = 1;

  // On the present piece:
  double counts = 1;  ///< 0 while it stands or is full: what friction takes is no part of its momentum
  double drag = 0;    ///< N m s/rad; 0 while it stands

  void start(const Scene&, double* y) const noexcept { y[0] = 0; }
  Vec3<double> momentum_B(const Scene&, double, const double* y) const noexcept { return counts * y[0] * axis_B; }
  void rates(const Scene& s, double P, const double* y, double* ydot) const noexcept {
    ydot[0] = -drag * speed(P + counts * y[0], s.omega_BN_B);
  }
};

}  // namespace gyrostat::truth
