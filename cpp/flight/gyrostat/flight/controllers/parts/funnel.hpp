// SPDX-License-Identifier: MIT
/// @file  Finite-time performance funnel of one error, and the error normalised by it.
///
///   rho(t) = rho_0 (1 - t / t_f)^(1/p) + rho_inf for t < t_f, rho_inf after     t: time since the last arm
///   lower = (side - delta_1) rho - rho_inf side,   upper = (side + delta_2) rho - rho_inf side   (side = 0: -+ max delta rho)
///   z = (2 q - lower - upper) / (upper - lower),   eps = ln((1 + z) / (1 - z))
///
/// Source: Yang, Yang, Ji, Ma 2023, eq. (11)-(14). Page: docs/components/prescribed_performance.md
#pragma once
#include <algorithm>
#include <cmath>

#include "gyrostat/core/power.hpp"

namespace gyrostat {

/// Shape that all axes share.
template <class S>
struct FunnelShape {
  S power;             ///< p < 1: the slope is continuous at t_f
  S rho_inf;           ///< half-width in the end
  S delta_1, delta_2;  ///< how far past zero, and how far out
};

/// One funnel, armed at an instant.
template <class S>
struct Funnel {
  S side = S(0);   ///< sign of the error at the arm; 0: too small to have one
  S rho_0 = S(0);  ///< what closes
  S t_f = S(1);    ///< s

  /// Around the error q, strictly: rho_0 = margin max(|q|, floor).
  static Funnel armed(S q, S margin, S floor, S t_f) noexcept {
    return {std::abs(q) < floor ? S(0) : sgn(q), margin * std::max(std::abs(q), floor), t_f};
  }
};

/// Bounds at an instant, with their slopes.
template <class S>
struct FunnelBounds {
  S lower, upper, lower_dot, upper_dot;
};

template <class S>
FunnelBounds<S> funnel_bounds(const Funnel<S>& f, const FunnelShape<S>& shape, S t) noexcept {
  S rho = shape.rho_inf, rhodot = S(0);
  if (t < f.t_f) {
    const S left = S(1) - t / f.t_f;
    const S inverse = S(1) / shape.power;
    const S slope = inverse == S(2) ? left : std::pow(left, inverse - S(1));
    rho += f.rho_0 * slope * left;
    rhodot = -f.rho_0 * inverse / f.t_f * slope;
  }
  const S widest = std::max(shape.delta_1, shape.delta_2);
  const S lo = f.side == S(0) ? -widest : f.side - shape.delta_1;
  const S up = f.side == S(0) ? widest : f.side + shape.delta_2;
  const S shift = shape.rho_inf * f.side;
  return {lo * rho - shift, up * rho - shift, lo * rhodot, up * rhodot};
}

/// Error and its transformation. Beyond |z| = z_max the logarithm goes on along its tangent: finite whatever happens.
template <class S>
struct Normalised {
  S z, eps, eps_dot;
};

template <class S>
Normalised<S> normalise(const FunnelBounds<S>& b, S q, S qdot, S z_max) noexcept {
  const S width = b.upper - b.lower;
  const S z = (S(2) * q - b.lower - b.upper) / width;
  const S zdot = (S(2) * qdot - b.lower_dot - b.upper_dot - z * (b.upper_dot - b.lower_dot)) / width;
  if (std::abs(z) <= z_max) return {z, std::log1p(z) - std::log1p(-z), S(2) * zdot / (S(1) - z * z)};
  const S edge = std::copysign(z_max, z);
  const S slope = S(2) / (S(1) - z_max * z_max);
  return {z, std::log1p(edge) - std::log1p(-edge) + slope * (z - edge), slope * zdot};
}

}  // namespace gyrostat
