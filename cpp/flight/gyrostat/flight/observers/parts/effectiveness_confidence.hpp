// SPDX-License-Identifier: MIT
/// @file  How well an estimate of effectiveness is known: second moments of its error, propagated beside the estimate.
///
/// An actuator shows in the rates only as effectiveness times command, so one that is not commanded cannot be seen. The
/// error e~ of an update with gain K follows e~+ = (I - K V) e~ - K d, V = D diag(u), and its moments
///
///   P+ = (I - K V) P (I - K V)' + K R K' + growth,   P(0) = I
///
/// P = I is "anything between dead and healthy". Between updates P grows back to that within `memory`, so that an estimate
/// which is not renewed is forgotten to be known. A residual that P cannot explain (a fault) makes the actuators along its axis
/// unknown at once. Page: docs/components/learning_effectiveness.md
#pragma once
#include <algorithm>
#include <cmath>

#include "gyrostat/core/types.hpp"

namespace gyrostat {

template <class S>
class EffectivenessConfidence {
 public:
  /// @param actuators     how many
  /// @param torque_error  N m, bound of what actuators do not explain about an axis: disturbance, noise
  /// @param growth        of each variance, a sample
  EffectivenessConfidence(int actuators, S torque_error, S growth) noexcept
      : n_(actuators), torque_error_(torque_error), growth_(growth) {
    start();
  }

  void start() noexcept { P_.setIdentity(n_, n_); }

  /// One sample passed.
  void grow() noexcept {
    for (int i = 0; i < n_; ++i) P_(i, i) = std::min(P_(i, i) + growth_, S(1));
  }

  /// The residual `r_B` = V e~ + d, N m, before it is used: what is not explained makes unknown.
  void doubt(const Mat3N<S>& V, const Vec3<S>& r_B) noexcept {
    const Mat3N<S> VP = V.lazyProduct(P_);
    for (int axis = 0; axis < 3; ++axis) {
      const S spread = VP.row(axis).dot(V.row(axis)) + torque_error_ * torque_error_;
      if (r_B[axis] * r_B[axis] <= S(9) * spread) continue;
      const S largest = V.row(axis).cwiseAbs().maxCoeff();
      for (int i = 0; i < n_; ++i) {
        if (std::abs(V(axis, i)) > S(0.5) * largest) forget(i);
      }
    }
  }

  /// The estimate moved by K r_B. @param lasting  how much more a lasting torque error does than white noise: (2 - k) / k
  void learn(const Mat3N<S>& K_transposed, const Mat3N<S>& V, S lasting) noexcept {
    const Mat3N<S> VP = V.lazyProduct(P_);
    Mat3<S> spread = VP * V.transpose();
    spread.diagonal().array() += lasting * torque_error_ * torque_error_;
    for (int i = 0; i < n_; ++i) {
      const Vec3<S> K_i = K_transposed.col(i);
      const Vec3<S> VP_i = VP.col(i);
      const Vec3<S> spread_K_i = spread * K_i;
      for (int j = 0; j <= i; ++j) {
        const Vec3<S> K_j = K_transposed.col(j);
        const Vec3<S> VP_j = VP.col(j);
        P_(i, j) += K_j.dot(spread_K_i) - K_i.dot(VP_j) - K_j.dot(VP_i);
        P_(j, i) = P_(i, j);
      }
    }
  }

  /// Half-width of effectiveness i, absolute: sqrt(2 P_ii) covers the rest of the initial ignorance and the torque error
  /// together, since a + b <= sqrt(2 (a^2 + b^2)).
  S half_width(int i) const noexcept { return std::sqrt(S(2) * std::max(P_(i, i), S(0))); }

  /// Information gathered about effectiveness i and not yet forgotten, in units of what was known at the start.
  S information(int i) const noexcept { return S(1) / std::max(P_(i, i), S(1e-12)) - S(1); }

 private:
  void forget(int i) noexcept {
    P_.row(i).setZero();
    P_.col(i).setZero();
    P_(i, i) = S(1);
  }

  using Moments = Eigen::Matrix<S, Eigen::Dynamic, Eigen::Dynamic, 0, max_actuators, max_actuators>;

  int n_;
  S torque_error_, growth_;
  Moments P_;
};

}  // namespace gyrostat
