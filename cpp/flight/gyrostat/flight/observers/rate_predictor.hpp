// SPDX-License-Identifier: MIT
/// @file  The body rate at the next sample, on the nominal model and under a held torque: what learning observers compare with.
///
///   J w' = -w x (J w + D h_w) + tau_B
///
/// One Runge-Kutta step of order four a period. Euler would leave the curvature of the gyroscopic torque in the prediction
/// error, where it looks like an actuator fault while the body turns fast.
#pragma once
#include <Eigen/LU>

#include "gyrostat/core/signals.hpp"

namespace gyrostat {

template <class S>
class RatePredictor {
 public:
  explicit RatePredictor(const Setup<S>& setup) noexcept
      : J_B_(setup.vehicle.J_B), J_inv_(setup.vehicle.J_B.inverse()), dt_(setup.dt) {}

  /// rad/s after one period.
  /// @param omega    rad/s, at its beginning
  /// @param torque_B N m, held
  /// @param h0_B     N m s, momentum of the wheels at its beginning
  /// @param h1_B     N m s, at its end; a line in between, which is exact for a held motor torque
  Vec3<S> operator()(const Vec3<S>& omega, const Vec3<S>& torque_B, const Vec3<S>& h0_B,
                     const Vec3<S>& h1_B) const noexcept {
    const Vec3<S> middle_B = S(0.5) * (h0_B + h1_B);
    const Vec3<S> k1 = rate(omega, torque_B, h0_B);
    const Vec3<S> k2 = rate(omega + dt_ / S(2) * k1, torque_B, middle_B);
    const Vec3<S> k3 = rate(omega + dt_ / S(2) * k2, torque_B, middle_B);
    const Vec3<S> k4 = rate(omega + dt_ * k3, torque_B, h1_B);
    return omega + dt_ / S(6) * (k1 + S(2) * k2 + S(2) * k3 + k4);
  }

 private:
  Vec3<S> rate(const Vec3<S>& omega, const Vec3<S>& torque_B, const Vec3<S>& h_B) const noexcept {
    return J_inv_ * (torque_B - omega.cross(J_B_ * omega + h_B));
  }

  Mat3<S> J_B_, J_inv_;
  S dt_;
};

}  // namespace gyrostat
