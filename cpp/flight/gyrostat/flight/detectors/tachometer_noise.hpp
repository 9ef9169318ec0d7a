// SPDX-License-Identifier: MIT
/// @file  How noisy a wheel's measured momentum is, read from the measurement itself.
///
/// With delivered = e u, second differences hold no motion but that of the command: h - 2 h1 + h2 + dt e (u - u1) is noise, of
/// six times its variance. e is fitted to the same numbers, so that a weak wheel does not read as a noisy one. A coarse
/// tachometer that jumps seldom shows no noise; the smallest change ever seen is then its step, q^2 / 12 its variance.
/// Page: docs/components/evidence.md
#pragma once
#include <algorithm>
#include <cmath>
#include <limits>

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
    if (known_ >= 1 && h != h1_) step_ = std::min(step_, std::abs(h - h1_));
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
        variance_ += S(0.01) * (std::min(s, S(9) * variance_) - variance_);  // an outlier counts as three sigma
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
  S variance() const noexcept {
    const S step = step_ < std::numeric_limits<S>::max() ? step_ : S(0);
    return std::max(variance_, step * step / S(12));
  }

 private:
  S effectiveness() const noexcept {
    return std::clamp((told_ + prior_) / (moved_ + prior_), S(0), S(1));  // 1 until the command has moved
  }

  S least_ = S(0), prior_ = S(1);
  S h1_ = S(0), h2_ = S(0), u1_ = S(0);
  S told_ = S(0), moved_ = S(0);
  S variance_ = S(0);
  S step_ = std::numeric_limits<S>::max();  ///< N m s, smallest change from one sample to the next
  int known_ = 0, seen_ = 0;
};

}  // namespace gyrostat
