// SPDX-License-Identifier: MIT
/// @file  Whether a polynomial has all its roots inside the unit circle: the stability of a sampled loop of one axis.
#pragma once
#include <array>
#include <cmath>
#include <cstddef>

namespace gyrostat {

/// Schur and Cohn's recursion. `p`: coefficients p[0] ... p[degree], the constant first; p[degree] is not zero.
template <class S, std::size_t N>
bool roots_inside_unit_circle(std::array<S, N> p, int degree) noexcept {
  std::array<S, N> lower{};
  for (std::size_t n = static_cast<std::size_t>(degree); n > 0; --n) {
    const S reflection = p[0] / p[n];
    if (!(std::abs(reflection) < S(1))) return false;
    for (std::size_t i = 0; i < n; ++i) lower[i] = p[i + 1] - reflection * p[n - 1 - i];
    p = lower;
  }
  return true;
}

}  // namespace gyrostat
