// SPDX-License-Identifier: MIT
/// @file  The noise of a sensor, measured in flight: what a second difference holds beyond what the command explains.
///
///   y[k] - 2 y[k-1] + y[k-2] has six times the variance of y; what moves y steadily is not in it
///
/// The mean of the first samples, then a slow mean that no single one can lift far. Page: docs/components/joint_kalman.md
#pragma once
#include <algorithm>

namespace gyrostat {

template <class S>
class NoiseMeter {
 public:
  /// @param nominal  standard deviation before anything was measured; a fiftieth of it is the least that is believed
  explicit NoiseMeter(S nominal) noexcept : nominal_(nominal) { start(); }

  void start() noexcept {
    variance_ = nominal_ * nominal_;
    seen_ = 0;
  }

  /// @param square  of one second difference without the command's part: a sixth of it, or of the mean of several
  void take(S square) noexcept {
    constexpr int fresh = 30;  // samples
    if (seen_ < fresh) {
      variance_ += (square - variance_) / static_cast<S>(++seen_);
    } else {
      variance_ += S(0.01) * (std::min(square, S(9) * variance_) - variance_);
    }
    variance_ = std::max(variance_, S(4e-4) * nominal_ * nominal_);
  }

  S variance() const noexcept { return variance_; }

 private:
  S nominal_;
  S variance_ = S(0);
  int seen_ = 0;
};

}  // namespace gyrostat
