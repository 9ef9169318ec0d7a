// SPDX-License-Identifier: MIT
/// @file  Elementwise signs, powers and saturations of sliding-mode laws. sgn(0) = 0 everywhere.
#pragma once
#include <cmath>

#include "gyrostat/core/types.hpp"

namespace gyrostat {

template <class S>
S sgn(S x) noexcept {
  return static_cast<S>((x > S(0)) - (x < S(0)));
}

/// sign(x) |x|^a. At a = 0 this is sgn(x).
template <class S>
S sig(S x, S a) noexcept {
  return x == S(0) ? S(0) : std::copysign(std::pow(std::abs(x), a), x);
}

/// x clipped to [-1, 1].
template <class S>
S sat(S x) noexcept {
  return x > S(1) ? S(1) : (x < S(-1) ? S(-1) : x);
}

/// sig(x, a) inside [-1, 1], sgn(x) outside.
template <class S>
S sat_sig(S x, S a) noexcept {
  return std::abs(x) <= S(1) ? sig(x, a) : sgn(x);
}

/// Boundary layer: sat(x / width), and sgn(x) when the width is zero.
template <class S>
S layer(S x, S width) noexcept {
  return width > S(0) ? sat(x / width) : sgn(x);
}

/// sig(x, a), 0 < a < 1, with its infinite slope at zero replaced for |x| < core by l1 x + l2 sgn(x) x^2 (C1 at the core's edge).
template <class S>
S sig_core(S x, S a, S core) noexcept {
  const S m = std::abs(x);
  if (m >= core) return sig(x, a);
  return (S(2) - a) * std::pow(core, a - S(1)) * x + (a - S(1)) * std::pow(core, a - S(2)) * m * x;
}

/// Derivative of sig_core with respect to x.
template <class S>
S sig_core_slope(S x, S a, S core) noexcept {
  const S m = std::abs(x);
  if (m >= core) return a * std::pow(m, a - S(1));
  return (S(2) - a) * std::pow(core, a - S(1)) + S(2) * (a - S(1)) * std::pow(core, a - S(2)) * m;
}

template <class S>
Vec3<S> sgn(const Vec3<S>& x) noexcept {
  return {sgn(x[0]), sgn(x[1]), sgn(x[2])};
}
template <class S>
Vec3<S> sig(const Vec3<S>& x, S a) noexcept {
  return {sig(x[0], a), sig(x[1], a), sig(x[2], a)};
}
template <class S>
Vec3<S> sat_sig(const Vec3<S>& x, S a) noexcept {
  return {sat_sig(x[0], a), sat_sig(x[1], a), sat_sig(x[2], a)};
}
template <class S>
Vec3<S> layer(const Vec3<S>& x, S width) noexcept {
  return {layer(x[0], width), layer(x[1], width), layer(x[2], width)};
}

/// slope x + gain sig_core(x, power, core), elementwise: terminal sliding surfaces, and the ways that lead to them.
template <class S>
struct TerminalShape {
  S slope, gain = S(0), power = S(1), core = S(1);

  /// Added to `to`, the linear part first: near a surface the two all but cancel, and single precision feels the order.
  Vec3<S> operator()(const Vec3<S>& x, const Vec3<S>& to = Vec3<S>::Zero()) const noexcept {
    Vec3<S> out = to + slope * x;
    if (gain > S(0))
      for (int i = 0; i < 3; ++i) out[i] += gain * sig_core(x[i], power, core);
    return out;
  }
  /// Its derivative while x moves at xdot.
  Vec3<S> rate(const Vec3<S>& x, const Vec3<S>& xdot) const noexcept {
    Vec3<S> along = Vec3<S>::Constant(slope);
    if (gain > S(0))
      for (int i = 0; i < 3; ++i) along[i] += gain * sig_core_slope(x[i], power, core);
    return along.cwiseProduct(xdot);
  }
};

/// Elementwise clip.
template <class S>
VecN<S> clip(const VecN<S>& u, const VecN<S>& lo, const VecN<S>& up) noexcept {
  VecN<S> out(u.size());
  for (Eigen::Index i = 0; i < u.size(); ++i) out[i] = u[i] < lo[i] ? lo[i] : (u[i] > up[i] ? up[i] : u[i]);
  return out;
}

/// Commands at a limit. One that rests (u = 0) is not saturated, also where zero is its limit: a closed nozzle.
template <class S>
Mask saturated(const VecN<S>& u, const VecN<S>& lo, const VecN<S>& up) noexcept {
  Mask out;
  for (int i = 0; i < u.size(); ++i) out.set(i, u[i] != S(0) && (u[i] <= lo[i] || u[i] >= up[i]));
  return out;
}

}  // namespace gyrostat
