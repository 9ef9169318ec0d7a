// SPDX-License-Identifier: MIT
/// @file  The quintic that starts with given value, rate and acceleration and ends at rest at a chosen time.
///
///   p(t) = d0 + d1 t + d2 t^2/2 + sum over i = 0 ... 2 of t^(i+3) sum over j of a_ij d_j / T^(i+3-j),   0 <= t <= T
///   p(t) = 0 afterwards;   a = [ -10 -6 -3/2; 15 8 3/2; -6 -3 -1/2 ]
///
/// Source: Cao, Gong, Xue, Wen 2023, section 4; a_21 = -3 is printed with the wrong sign there.
#pragma once
#include <array>

#include "gyrostat/core/types.hpp"

namespace gyrostat {

/// Value, rate and acceleration, an axis each.
template <class S>
struct PathPoint {
  Vec3<S> p = Vec3<S>::Zero(), rate = Vec3<S>::Zero(), acceleration = Vec3<S>::Zero();
};

template <class S>
class PreassignedPath {
 public:
  /// At its end.
  PreassignedPath() noexcept { c_.fill(Vec3<S>::Zero()); }
  /// @param T  s, positive
  PreassignedPath(const PathPoint<S>& start, S T) noexcept : T_(T) {
    // In x = t / T the derivatives at the start are d0, T d1, T^2 d2, and no power of T is left.
    const Vec3<S> d0 = start.p, d1 = T * start.rate, d2 = T * T * start.acceleration;
    c_ = {d0,
          d1,
          S(0.5) * d2,
          S(-10) * d0 - S(6) * d1 - S(1.5) * d2,
          S(15) * d0 + S(8) * d1 + S(1.5) * d2,
          S(-6) * d0 - S(3) * d1 - S(0.5) * d2};
  }

  S end() const noexcept { return T_; }

  PathPoint<S> at(S t) const noexcept {
    if (!(t < T_)) return {};
    const S x = t / T_;
    PathPoint<S> out;
    out.p = c_[0] + x * (c_[1] + x * (c_[2] + x * (c_[3] + x * (c_[4] + x * c_[5]))));
    out.rate = (c_[1] + x * (S(2) * c_[2] + x * (S(3) * c_[3] + x * (S(4) * c_[4] + x * S(5) * c_[5])))) / T_;
    out.acceleration = (S(2) * c_[2] + x * (S(6) * c_[3] + x * (S(12) * c_[4] + x * S(20) * c_[5]))) / (T_ * T_);
    return out;
  }

 private:
  S T_ = S(0);
  std::array<Vec3<S>, 6> c_;
};

}  // namespace gyrostat
