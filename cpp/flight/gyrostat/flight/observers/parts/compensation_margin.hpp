// SPDX-License-Identifier: MIT
/// @file  How much effectiveness a loop needs that feeds an observer's estimate of the lumped torque back to faulty actuators.
///
/// The lumped torque contains D (E - I) u, and u contains the estimate: a loop of its own. About one axis, with
/// effectiveness m, observer slopes l1, l2 and a sliding correction of slope r, its characteristic polynomial is
///
///   x^3 + m (r + l1) x^2 + m (l1 r + l2) x + m l2 r
///
/// For the homogeneous observer the secant slopes at every amplitude have l2 / l1^2 = lambda2 / lambda1^2.
/// The threshold is linear; it explains measured limit cycles of the loop of Li et al. 2018, but is no proof.
#pragma once
#include <cmath>

namespace gyrostat {

/// Hurwitz: all three roots in the left half-plane. m, l1, l2, r > 0.
template <class S>
bool compensation_is_stable(S m, S r, S l1, S l2) noexcept {
  return m * (r + l1) * (l1 * r + l2) > l2 * r;
}

/// Effectiveness above which the loop is stable whatever r: k / (1 + sqrt k)^2 with k = lambda2 / lambda1^2. The worst r is
/// sqrt(l2).
template <class S>
S critical_effectiveness(S lambda1, S lambda2) noexcept {
  const S root = std::sqrt(lambda2) / lambda1;
  return root * root / ((S(1) + root) * (S(1) + root));
}

}  // namespace gyrostat
