// SPDX-License-Identifier: MIT
/// @file  The rate observer that observers of effectiveness share: the nominal model under the issued command and a correction.
///
///   J what' = -what x (J what + D h_w) + D diag(e) u + inj,   w~ = w - what
///
/// One Runge-Kutta step of order four a period. Euler would leave the curvature of the gyroscopic torque in the prediction
/// error, where it looks like an actuator fault while the body turns fast.
#pragma once
#include <Eigen/LU>

#include "gyrostat/core/signals.hpp"

namespace gyrostat {

/// Between two samples u, e and inj are held; the wheels' momentum is a line, which is exact for a held motor torque.
template <class S>
class RatePredictor {
 public:
  explicit RatePredictor(const Setup<S>& setup) noexcept : J_inv_(setup.vehicle.J_B.inverse()), dt_(setup.dt) {}

  /// First sample: the prediction begins at the measured rate.
  void start(const Vehicle<S>& vehicle, const Measurement<S>& y) noexcept {
    omega_hat_ = y.omega_BN_B;
    h_w_B_ = stored_B(vehicle, y);
    error_.setZero();
    injection_B_.setZero();
  }

  /// Over the interval just ended, with its estimated effectiveness and issued command. Returns w~, rad/s.
  const Vec3<S>& step(const Vehicle<S>& vehicle, const Measurement<S>& y, const VecN<S>& effectiveness,
                      const VecN<S>& u) noexcept {
    const Vec3<S> before_B = h_w_B_;
    h_w_B_ = stored_B(vehicle, y);
    const Vec3<S> torque_B = torque<S>(y.axes.of(vehicle.D_B), effectiveness.cwiseProduct(u)) + injection_B_;
    const Vec3<S> middle_B = S(0.5) * (before_B + h_w_B_);
    const Vec3<S> k1 = rate(vehicle.J_B, omega_hat_, torque_B, before_B);
    const Vec3<S> k2 = rate(vehicle.J_B, omega_hat_ + dt_ / S(2) * k1, torque_B, middle_B);
    const Vec3<S> k3 = rate(vehicle.J_B, omega_hat_ + dt_ / S(2) * k2, torque_B, middle_B);
    const Vec3<S> k4 = rate(vehicle.J_B, omega_hat_ + dt_ * k3, torque_B, h_w_B_);
    omega_hat_ += dt_ / S(6) * (k1 + S(2) * k2 + S(2) * k3 + k4);
    error_ = y.omega_BN_B - omega_hat_;
    return error_;
  }

  /// Over an interval that taught nothing: w~ stays, the prediction moves with the rate.
  void skip(const Vehicle<S>& vehicle, const Measurement<S>& y) noexcept {
    omega_hat_ = y.omega_BN_B - error_;
    h_w_B_ = stored_B(vehicle, y);
  }

  /// The measured rate has moved by `step`, rad/s, without motion.
  void shift_rate(const Vec3<S>& step) noexcept { omega_hat_ += step; }

  /// The correction of the next interval, N m.
  void correct(const Vec3<S>& injection_B) noexcept { injection_B_ = injection_B; }

  const Vec3<S>& error() const noexcept { return error_; }              ///< rad/s, w~
  const Vec3<S>& injection_B() const noexcept { return injection_B_; }  ///< N m, since the previous sample

 private:
  static Vec3<S> stored_B(const Vehicle<S>& vehicle, const Measurement<S>& y) noexcept {
    return y.axes.momentum_B(vehicle.D_B, y.h_w);
  }

  Vec3<S> rate(const Mat3<S>& J_B, const Vec3<S>& omega, const Vec3<S>& torque_B, const Vec3<S>& h_B) const noexcept {
    return J_inv_ * (torque_B - omega.cross(J_B * omega + h_B));
  }

  Mat3<S> J_inv_;
  S dt_;
  Vec3<S> omega_hat_ = Vec3<S>::Zero();  ///< rad/s
  Vec3<S> h_w_B_ = Vec3<S>::Zero();      ///< N m s, stored at the latest sample
  Vec3<S> error_ = Vec3<S>::Zero();
  Vec3<S> injection_B_ = Vec3<S>::Zero();
};

}  // namespace gyrostat
