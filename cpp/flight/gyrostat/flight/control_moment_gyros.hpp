// SPDX-License-Identifier: MIT
/// @file  Where control moment gyros point, from the angles of their gimbals: the geometry of a stack that has some.
///
///     column -t_i(del_i),   stored momentum sum h_i s_i(del_i) + D_wheels h_w
///
/// A command u_i (N m) turns gimbal i at u_i / h_i. The columns of other actuators stay where the vehicle has them.
/// Page: docs/cmg.md
#pragma once
#include <algorithm>
#include <cmath>

#include "gyrostat/flight/axes.hpp"

namespace gyrostat {

template <class S>
class ControlMomentGyros {
 public:
  ControlMomentGyros() noexcept = default;

  /// Adds the gyro that is actuator i.
  /// @param gimbal_axis_B, spin_axis_B  unit, perpendicular; the rotor's at gimbal angle zero
  /// @param rotor_momentum  N m s
  void add(int i, const Vec3<S>& gimbal_axis_B, const Vec3<S>& spin_axis_B, S rotor_momentum) noexcept {
    gyros_.set(i);
    const Eigen::Index n = std::max<Eigen::Index>(spin_B_.cols(), i + 1);
    spin_B_.conservativeResize(3, n);
    transverse_B_.conservativeResize(3, n);
    rotor_momentum_.conservativeResize(n);
    spin_B_.col(i) = spin_axis_B;
    transverse_B_.col(i) = gimbal_axis_B.cross(spin_axis_B);
    rotor_momentum_[i] = rotor_momentum;
  }
  bool any() const noexcept { return gyros_.any(); }
  const Mask& gyros() const noexcept { return gyros_; }

  /// At these angles (rad, one an actuator); `revision` is the caller's.
  Axes<S> at(const Vehicle<S>& vehicle, const VecN<S>& gimbal, const VecN<S>& h_w) const noexcept {
    Axes<S> axes;
    axes.D_B = vehicle.D_B;
    axes.h_B = torque<S>(vehicle.D_B, h_w);
    for (int i = 0; i < axes.D_B.cols(); ++i) {
      if (!gyros_.test(i)) continue;
      const S c = std::cos(gimbal[i]), s = std::sin(gimbal[i]);
      axes.D_B.col(i) = s * spin_B_.col(i) - c * transverse_B_.col(i);
      axes.h_B += rotor_momentum_[i] * (c * spin_B_.col(i) + s * transverse_B_.col(i));
    }
    return axes;
  }

  /// Angles that are not one an actuator, or not finite: the last that were; before the first, the vehicle's axes.
  Axes<S> operator()(const Vehicle<S>& vehicle, const Measurement<S>& y) noexcept {
    if (!any()) return {};
    const bool possible = y.gimbal.size() == vehicle.actuators() && y.gimbal.allFinite();
    if (possible && (gimbal_.size() == 0 || gimbal_ != y.gimbal)) {
      gimbal_ = y.gimbal;
      ++revision_;
    }
    if (gimbal_.size() == 0) return {};
    Axes<S> axes = at(vehicle, gimbal_, y.h_w);
    axes.revision = revision_;
    return axes;
  }

 private:
  Mask gyros_;
  Mat3N<S> spin_B_{3, 0}, transverse_B_{3, 0};
  VecN<S> rotor_momentum_;  ///< N m s
  VecN<S> gimbal_;          ///< rad, the last that could be
  std::uint32_t revision_ = 0;
};

}  // namespace gyrostat
