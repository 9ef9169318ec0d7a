// SPDX-License-Identifier: MIT
/// @file  Stability of a learning observer once it is sampled.
///
/// With a = exp(-M h) and b = (1 - a) / M the error of one axis obeys
///
///   e[k+1] = a e[k] - b f[k],   f[k] = k1 f[k-N] + k2 e[k] + k3 e[k-N]
///   z^(N+1) + (b k2 - a) z^N - k1 z + (a k1 + b k3) = 0
///
/// For even N the half-sample-rate mode z = -1 meets the unit circle at tanh(M h / 2) / M = (1 - k1) / (k2 + k3).
#pragma once
#include <array>
#include <cmath>

#include "gyrostat/flight/observers/parts/schur.hpp"
#include "gyrostat/flight/parts/delay_line.hpp"

namespace gyrostat {

/// Gains of the learning law and the step that it is sampled with.
struct LearningErrorLoop {
  double M, k1, k2, k3;
  double step;  ///< s, from one update of e to the next
  int delay;    ///< steps that the memory looks back, 1 ... max_delay

  /// Whether every root of the characteristic polynomial lies inside the circle of this radius.
  bool inside(double radius) const noexcept {
    const double a = std::exp(-M * step), b = (1 - a) / M;
    const int degree = delay + 1;
    std::array<double, max_delay + 2> p{};
    // Coefficients of p(radius z) / radius^degree, lowest power first; a delay of one merges the middle two.
    p[0] += (a * k1 + b * k3) * std::pow(radius, -degree);
    p[1] -= k1 * std::pow(radius, 1 - degree);
    p[static_cast<std::size_t>(delay)] += (b * k2 - a) / radius;
    p[static_cast<std::size_t>(degree)] += 1;
    return roots_inside_unit_circle(p, degree);
  }

  /// Largest modulus of the roots, to 1e-9, by bisection.
  double spectral_radius() const noexcept {
    double lo = 0, hi = 1;
    while (!inside(hi) && hi < 1e6) hi *= 2;
    while (hi - lo > 1e-9 * hi) {
      const double middle = 0.5 * (lo + hi);
      (middle > 0 && inside(middle) ? hi : lo) = middle;
    }
    return hi;
  }
};

}  // namespace gyrostat
