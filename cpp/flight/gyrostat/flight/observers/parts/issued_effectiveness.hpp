// SPDX-License-Identifier: MIT
/// @file  An estimate of effectiveness is issued inside its limits; what that leaves over is a torque all the same.
///
///   effectiveness = clamp(e, lo, hi),   d_B += D diag(e - effectiveness) u
///
/// A body lighter than known has e = 1.1: with 1 issued and the rest kept back, a law without an integral stands off its target.
/// Page: docs/components/learning_effectiveness.md
#pragma once
#include <algorithm>

#include "gyrostat/core/signals.hpp"

namespace gyrostat {

/// What observers of effectiveness believe at most, beyond what they issue: a body whose inertia is an eighth below nominal. Less
/// than detectors take for a change.
template <class S>
inline constexpr S effectiveness_headroom = S(0.15);

/// @param e  as believed   @param u  N m, of the interval just ended
template <class S>
void issue_effectiveness(Estimate<S>& x, const VecN<S>& e, S lo, S hi, const Mat3N<S>& D_B, const VecN<S>& u) noexcept {
  for (Eigen::Index i = 0; i < e.size(); ++i) {
    x.effectiveness[i] = std::clamp(e[i], lo, hi);
    x.d_B += D_B.col(i) * ((e[i] - x.effectiveness[i]) * u[i]);
  }
}

}  // namespace gyrostat
