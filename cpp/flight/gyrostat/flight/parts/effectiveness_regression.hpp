// SPDX-License-Identifier: MIT
/// @file  Which change of the actuators' effectiveness explains a torque: regularised least norm.
///
///   de = Phi' (Phi Phi' + reg^2 I)^-1 tau,   Phi = D diag(u), columns of actuators that say nothing are zero
///
/// Three torques for n unknowns: with more than three informative columns the answer is the smallest one, not the true one.
/// Page: docs/components/adaptive_iterative_learning.md
#pragma once
#include <Eigen/LU>

#include "gyrostat/core/signals.hpp"

namespace gyrostat {

/// Actuators whose torque |D_i u_i| reaches `gate` (N m): what they deliver can be told from what disturbs.
template <class S>
Mask excited(const Mat3N<S>& D_B, const VecN<S>& u, S gate) noexcept {
  Mask out;
  for (int i = 0; i < static_cast<int>(D_B.cols()); ++i) {
    const Vec3<S> column = D_B.col(i) * u[i];
    out.set(i, column.norm() >= gate);
  }
  return out;
}

/// Projector onto the torques that no actuator of `known` can make, whatever it does.
template <class S>
Mat3<S> beyond(const Mat3N<S>& D_B, Mask known) noexcept {
  Mat3<S> P = Mat3<S>::Identity();
  for (int i = 0; i < static_cast<int>(D_B.cols()); ++i) {
    if (!known.test(i)) continue;
    const Vec3<S> axis = P * D_B.col(i);
    if (axis.squaredNorm() > S(1e-4) * D_B.col(i).squaredNorm()) P -= axis * axis.transpose() / axis.squaredNorm();
  }
  return P;
}

/// Zero for actuators outside `informative`. `regularisation` (N m) > 0 keeps it bounded when the columns are parallel.
template <class S>
VecN<S> explaining_change(const Mat3N<S>& D_B, const VecN<S>& u, Mask informative, S regularisation,
                          const Vec3<S>& tau_B) noexcept {
  Mat3<S> gram = regularisation * regularisation * Mat3<S>::Identity();
  for (int i = 0; i < static_cast<int>(D_B.cols()); ++i) {
    if (!informative.test(i)) continue;
    const Vec3<S> column = D_B.col(i) * u[i];
    gram += column * column.transpose();
  }
  const Mat3<S> inverse = gram.inverse();
  const Vec3<S> weight = inverse * tau_B;
  VecN<S> change = VecN<S>::Zero(D_B.cols());
  for (int i = 0; i < static_cast<int>(D_B.cols()); ++i)
    if (informative.test(i)) change[i] = D_B.col(i).dot(weight) * u[i];
  return change;
}

}  // namespace gyrostat
