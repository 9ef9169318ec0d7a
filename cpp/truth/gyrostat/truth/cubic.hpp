// SPDX-License-Identifier: MIT
/// @file  Laws over one piece of time, as cubics of x in [0, 1], and the time at which something happens.
#pragma once
#include <array>

namespace gyrostat::truth {

/// Powers of x.
using Cubic = std::array<double, 4>;

/// Gauss-Legendre nodes and weights on [-1, 1].
inline constexpr std::array<double, 4> gauss_node{-0.861136311594052575, -0.339981043584856265, 0.339981043584856265,
                                                  0.861136311594052575};
inline constexpr std::array<double, 4> gauss_weight{0.347854845137453857, 0.652145154862546143, 0.652145154862546143,
                                                    0.347854845137453857};

/// The cubic through f at the Gauss nodes.
inline Cubic cubic_through(const std::array<double, 4>& f) noexcept {
  std::array<double, 4> a{};  // coefficients of the shifted Legendre polynomials
  for (std::size_t j = 0; j < 4; ++j) {
    const double z = gauss_node[j], wf = 0.5 * gauss_weight[j] * f[j];
    a[0] += wf;
    a[1] += 3 * wf * z;
    a[2] += 5 * wf * (1.5 * z * z - 0.5);
    a[3] += 7 * wf * (2.5 * z * z - 1.5) * z;
  }
  return {a[0] - a[1] + a[2] - a[3], 2 * a[1] - 6 * a[2] + 12 * a[3], 6 * a[2] - 30 * a[3], 20 * a[3]};
}

inline double value(const Cubic& c, double x) noexcept { return c[0] + x * (c[1] + x * (c[2] + x * c[3])); }
/// Integral from 0 to x.
inline double integral(const Cubic& c, double x) noexcept {
  return x * (c[0] + x * (c[1] / 2 + x * (c[2] / 3 + x * c[3] / 4)));
}

/// Where `beyond` turns from false at lo to true at hi, from above.
template <class Predicate>
double bisect(double lo, double hi, double tolerance, const Predicate& beyond) noexcept {
  while (hi - lo > tolerance) {
    const double mid = 0.5 * (lo + hi);
    if (mid <= lo || mid >= hi) break;
    (beyond(mid) ? hi : lo) = mid;
  }
  return hi;
}

}  // namespace gyrostat::truth
