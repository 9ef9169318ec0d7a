// SPDX-License-Identifier: MIT
/// @file  Which of the two sets of modified Rodrigues parameters a law follows, with hysteresis.
///
/// sigma and its shadow -sigma / |sigma|^2 are one attitude. A law keeps its set until |sigma| exceeds `switch_at`; then it takes
/// the other, whose norm is 1 / switch_at. At 1 that is the short way always; above, noise at half a turn no longer makes the law
/// change its mind at every sample; infinite, it never switches and flies the long way where the initial state asks for it.
#pragma once
#include <cmath>
#include <limits>

#include "gyrostat/core/attitude.hpp"
#include "gyrostat/core/params.hpp"

namespace gyrostat {

/// The parameter that every MRP law has.
inline constexpr Field shadow_switch_field{"shadow_switch", "", 1, std::numeric_limits<double>::infinity(),
                                           "MRP norm at which the shadow set is taken; 1: short way, infinite: never"};

template <class S>
class MrpSwitching {
 public:
  explicit MrpSwitching(S switch_at) noexcept
      : follows_(!std::isfinite(switch_at)),
        w_switch_(follows_ ? S(-1) : (S(1) - switch_at * switch_at) / (S(1) + switch_at * switch_at)) {}

  /// At the next quaternion the choice is made anew: the short way, or the measured sign when it never switches.
  void start() noexcept { chosen_ = false; }

  /// The one of q and -q that the law follows; its MRP is vec / (1 + w).
  Quat<S> operator()(const Quat<S>& q) noexcept {
    if (!chosen_) {
      sign_ = !follows_ && q.w() < S(0) ? S(-1) : S(1);
      chosen_ = true;
    } else if (sign_ * q.w() < w_switch_) {
      sign_ = -sign_;
    }
    return Quat<S>(sign_ * q.w(), sign_ * q.x(), sign_ * q.y(), sign_ * q.z());
  }

 private:
  bool follows_;  ///< never switches
  S w_switch_;    ///< scalar part (1 - |sigma|^2) / (1 + |sigma|^2) at the limit
  S sign_ = S(1);
  bool chosen_ = false;
};

}  // namespace gyrostat
