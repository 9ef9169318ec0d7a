// SPDX-License-Identifier: MIT
/// @file  Laws over one piece of time, as polynomials, and the time at which something happens.
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

/// A polynomial of time of degree at most 4, for t in [t0, t0 + 1 / per_length].
template <class T>
struct Quartic {
  double t0 = 0, per_length = 0;
  int degree = 0;
  std::array<T, 5> c{};

  T operator()(double t) const noexcept {
    const double x = (t - t0) * per_length;
    if (degree <= 1) return c[0] + x * c[1];
    return c[0] + x * (c[1] + x * (c[2] + x * (c[3] + x * c[4])));
  }
};

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

/// Where a continuous f, not positive at lo (f_lo) and positive at hi (f_hi), becomes so, from above: within `tolerance` or
/// where f is at most `small`. Illinois variant of the false position: a handful of calls.
template <class F>
double first_positive(double lo, double f_lo, double hi, double f_hi, double tolerance, double small,
                      const F& f) noexcept {
  double weight_lo = f_lo, weight_hi = f_hi;
  int last = 0;
  while (hi - lo > tolerance && f_hi > small) {
    double x = (lo * weight_hi - hi * weight_lo) / (weight_hi - weight_lo);
    if (!(x > lo && x < hi)) x = 0.5 * (lo + hi);
    if (x <= lo || x >= hi) break;
    const double fx = f(x);
    const int side = fx > 0 ? 1 : -1;
    (side > 0 ? hi : lo) = x;
    (side > 0 ? weight_hi : weight_lo) = fx;
    if (side > 0) f_hi = fx;
    if (side == last) (side > 0 ? weight_lo : weight_hi) /= 2;
    last = side;
  }
  return hi;
}

}  // namespace gyrostat::truth
