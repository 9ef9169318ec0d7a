// SPDX-License-Identifier: MIT
/// @file  One implicit Euler step of the second-order homogeneous observer: its scalar equation and root.
///
///   z + c1 sig^a1(z) + c2 sig^a2(z) = r,   a2 = 2 a1 - 1,   1/2 < a1 < 1,   c1, c2 > 0
///
/// Source: error dynamics of Li et al. 2018, eq. (7)-(9), discretised implicitly so that there is no chatter.
#pragma once
#include <algorithm>
#include <cmath>
#include <limits>

namespace gyrostat {

/// x^(k/2) for a fixed exponent: by products and one square root when k is a small whole number, which exponents such as
/// a1 = 3/5, 2/3, 3/4 lead to, else by pow.
template <class S>
class HalfPower {
 public:
  explicit HalfPower(S exponent) noexcept : exponent_(exponent) {
    const S twice = S(2) * exponent, whole = std::round(twice);
    if (whole <= S(16) && std::abs(twice - whole) <= S(64) * std::numeric_limits<S>::epsilon() * twice) {
      halves_ = static_cast<int>(whole);
      exponent_ = whole / S(2);
    }
  }

  S exponent() const noexcept { return exponent_; }

  /// x >= 0
  S operator()(S x) const noexcept {
    if (halves_ == 0) return std::pow(x, exponent_);
    S out = (halves_ & 1) != 0 ? std::sqrt(x) : S(1);
    for (int i = 1; i < halves_; i += 2) out *= x;
    return out;
  }

 private:
  S exponent_;
  int halves_ = 0;  ///< 0: not a small whole number
};

/// The root of the equation above for fixed c1, c2, a1; any r.
template <class S>
class ImplicitRoot {
 public:
  /// z with its powers, which the solve has at hand. They stay exact where z itself underflows.
  struct Root {
    S z = S(0);
    S sig_a1 = S(0);  ///< sig^a1(z)
    S sig_a2 = S(0);  ///< sig^a2(z)
    int iterations = 0;
  };

  /// 1/2 < a1 < 1, c1 > 0, c2 > 0
  ImplicitRoot(S c1, S c2, S a1) noexcept : c1_(c1), c2_(c2), to_w_((S(1) - a1) / (S(2) * a1 - S(1))) {
    const S w_linear = std::min(c2 / c1, std::sqrt(c2)), w_power = std::max(c1, std::sqrt(c2));
    r_linear_ = c2 * std::pow(w_linear, S(1) / to_w_.exponent());
    r_power_ = w_power * w_power * std::pow(w_power, S(1) / to_w_.exponent());
  }

  Root operator()(S r) const noexcept {
    const S magnitude = std::abs(r);
    Root root;
    if (magnitude == S(0)) return root;
    // With y = |z|^a2 and w = y^((1 - a2) / (2 a2)): |z| = y w^2, |z|^a1 = y w, and f(y) = y (w^2 + c1 w + c2) - |r| is
    // convex and increasing, so that Newton from an upper bound descends monotonically.
    S y = upper_bound(magnitude), w = to_w_(y);
    for (root.iterations = 0; root.iterations < 60; ++root.iterations) {
      const S excess = value(y, w) - magnitude;
      const S step = excess / slope(w);
      if (!(step > S(2) * std::numeric_limits<S>::epsilon() * y)) break;
      y -= step;
      w = to_w_(y);
    }
    root.sig_a2 = std::copysign(y, r);
    root.sig_a1 = root.sig_a2 * w;
    root.z = root.sig_a1 * w;
    return root;
  }

 private:
  S value(S y, S w) const noexcept { return y * ((w + c1_) * w + c2_); }

  /// d value / dy, with dw/dy = e w / y.
  S slope(S w) const noexcept {
    const S e = to_w_.exponent();
    return ((S(1) + S(2) * e) * w + (S(1) + e) * c1_) * w + c2_;
  }

  /// y if the largest of the three terms stood alone: too large, and the sum of the terms there is below 3 |r|.
  S upper_bound(S r) const noexcept {
    const S e = to_w_.exponent();
    if (r <= r_linear_) return r / c2_;
    return r >= r_power_ ? std::pow(r, S(1) / (S(1) + S(2) * e)) : std::pow(r / c1_, S(1) / (S(1) + e));
  }

  S c1_, c2_;
  HalfPower<S> to_w_;
  S r_linear_, r_power_;
};

}  // namespace gyrostat
