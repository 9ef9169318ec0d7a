// SPDX-License-Identifier: MIT
/// @file  A single-gimbal control moment gyro: a rotor of momentum h about s, turned about its gimbal axis g by an ideal servo.
///
///     del' = delivered / h0,   s(del) = s0 cos del + (g x s0) sin del,   momentum h s(del)
///
/// With P the impulse of its channel, del = del(0) - P / h0: the momentum is a known function of time, a command or a fault of
/// the gimbal is no jump. The torque on the body is h / h0 delivered along -(g x s(del)), and -h' along s while a rotor slows down.
/// Left out: inertia of gimbal and rotor about the gimbal axis, what J gains as the gimbal turns, the rotor's speed control.
/// Sources: Wie 2008, chapter 7; Kurokawa 1998. Page: docs/cmg.md
#pragma once
#include <vector>

#include "gyrostat/truth/effectors/effector.hpp"
#include "gyrostat/truth/faults/rotor_slow_down.hpp"

namespace gyrostat::truth {

struct ControlMomentGyro {
  static constexpr const char* name = "control_moment_gyro";
  static constexpr int states = 0;
  static constexpr bool along_axis = false;
  static constexpr Storage storage = Storage::inner;

  int channel = -1;
  Vec3<double> gimbal_axis_B = Vec3<double>::UnitZ();
  Vec3<double> spin_axis_B =
      Vec3<double>::UnitX();              ///< of the rotor at gimbal angle zero, perpendicular to the gimbal axis
  double rotor_momentum = 1;              ///< N m s, h0: what the rotor holds while it is healthy
  double angle = 0;                       ///< rad, at the start
  double angle_max = infinity;            ///< rad, of the stops on both sides
  std::vector<RotorSlowDown> slow_downs;  ///< over before or when the rotor is at rest

  Mat3<double> inertia_B() const { return Mat3<double>::Zero(); }
  /// rad
  double angle_at(double P) const noexcept { return angle - P / rotor_momentum; }
  Vec3<double> transverse_B() const noexcept { return gimbal_axis_B.cross(spin_axis_B); }
  Vec3<double> spin_B(double del) const noexcept {
    return std::cos(del) * spin_axis_B + std::sin(del) * transverse_B();
  }

  /// N m s, of the rotor.
  double momentum(double t) const noexcept;
  /// N m, its rate over the time that ends at t.
  double momentum_rate(double t) const noexcept;
  /// s, when these faults have brought it to rest; infinity: never.
  double rest_time(const std::vector<RotorSlowDown>& faults) const;

  Vec3<double> momentum_B(const Scene& s, double P, const double*) const noexcept {
    return momentum(s.t) * spin_B(angle_at(P));
  }
  Vec3<double> momentum_rate_B(const Scene& s, double P, double Pdot, const double*, const double*) const noexcept {
    const double del = angle_at(P), rate = -Pdot / rotor_momentum;
    const Vec3<double> across = std::cos(del) * transverse_B() - std::sin(del) * spin_axis_B;
    return momentum_rate(s.t) * spin_B(del) + momentum(s.t) * rate * across;
  }
  void rates(const Scene&, double, const double*, double*) const noexcept {}
  /// What is seen of it, in the place of its channel.
  void show(const Scene& s, double P, const double*, auto& state) const noexcept {
    state.gimbal[channel] = angle_at(P);
    state.rotor_momentum[channel] = momentum(s.t);
  }
};

}  // namespace gyrostat::truth
