// SPDX-License-Identifier: MIT
/// @file  How noisy a wheel's measured momentum is, read from the measurement itself.
///
/// With delivered = e u, second differences hold no motion but that of the command: h - 2 h1 + h2 + dt e (u - u1) is noise, of
/// six times its variance. e is fitted to the same numbers, so that a weak wheel does not read as a noisy one. A coarse
/// tachometer that jumps seldom shows no noise; its step is what all changes are multiples of, and two readings are off by one.
/// Page: docs/components/evidence.md
#pragma once
#include <algorithm>
#include <cmath>

namespace gyrostat {

template <class S>
class TachometerNoise {
 public:
  static constexpr int settling = 30;  ///< samples of a plain mean; after them one in a hundred is new

  TachometerNoise() noexcept = default;
  /// @param least  N m s, standard deviation that no measurement falls below
  /// @param moved  N m, change of the command that tells the effectiveness
  TachometerNoise(S least, S moved) noexcept : least_(least * least), prior_(moved * moved) {}

  /// The next sample has no past: a gap, a jump.
  void interrupt() noexcept { known_ = 0; }

  /// @param h  N m s, measured now
  /// @param u  N m, command of the interval just ended
  void sample(S h, S u, S dt) noexcept {
    if (known_ >= 1) reread_step(std::abs(h - h1_));
    if (known_ >= 2) {
      const S du = u - u1_, bend = h - S(2) * h1_ + h2_;
      seen_ = std::min(seen_ + 1, 100);
      const S share = S(1) / static_cast<S>(seen_);
      const S left = bend + dt * effectiveness() * du;
      told_ += share * (-bend / dt * du - told_);
      moved_ += share * (du * du - moved_);
      const S s = left * left / S(6);
      if (seen_ <= settling) {
        variance_ += share * (s - variance_);
      } else {
        variance_ += S(0.01) * (std::min(s, S(9) * variance()) - variance_);  // an outlier counts as three sigma
      }
      variance_ = std::max(variance_, least_);
    }
    known_ = std::min(known_ + 1, 2);
    h2_ = h1_;
    h1_ = h;
    u1_ = u;
  }

  bool settled() const noexcept { return seen_ >= settling; }

  /// (N m s)^2, of one sample.
  S variance() const noexcept { return std::max(variance_, of_step()); }

 private:
  S effectiveness() const noexcept {
    return std::clamp((told_ + prior_) / (moved_ + prior_), S(0), S(1));  // 1 until the command has moved
  }
  /// What all changes are multiples of; without steps it is soon next to nothing, for a remainder is half of it at most.
  void reread_step(S change) noexcept {
    if (step_ == S(0)) step_ = change;
    if (step_ == S(0)) return;
    const S left = std::abs(change - step_ * std::round(change / step_));
    if (left > S(1e-3) * step_) step_ = left;
  }
  /// What covers a difference of two readings that is off by a whole step.
  S of_step() const noexcept { return step_ * step_ / S(6); }

  S least_ = S(0), prior_ = S(1);
  S h1_ = S(0), h2_ = S(0), u1_ = S(0);
  S told_ = S(0), moved_ = S(0);
  S variance_ = S(0);
  S step_ = S(0);  ///< N m s, of the tachometer
  int known_ = 0, seen_ = 0;
};

}  // namespace gyrostat
