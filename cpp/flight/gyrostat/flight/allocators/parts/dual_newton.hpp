// SPDX-License-Identifier: MIT
/// @file  The kernel of all optimal allocators: a semismooth Newton method in the dual, of dimension M whatever the
///        number of actuators.
///
///     minimise over the box   sum_i (tau_i - preferred_i)^2 / (2 compliance_i)  subject to  A tau = b  (softened by R)
///     tau_i(y) = clip(preferred_i + compliance_i a_i'y, lo_i, up_i)
///     solve  F(y) = A tau(y) - b + R (y - centre) = 0,   R symmetric >= 0
///
/// F is the gradient of a convex, piecewise quadratic function of y. A full Newton step is taken where it stays on one
/// piece or does not overshoot; else the function is minimised exactly along it. With R > 0 that ends after finitely many
/// steps, and the count is capped besides. No heap, no exception, no state between calls but what the caller passes.
/// Page: docs/allocation.md
#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

#include "gyrostat/flight/allocators/parts/branch_free.hpp"
#include "gyrostat/flight/allocators/parts/ldl.hpp"
#include "gyrostat/flight/allocators/parts/orthogonal_factor.hpp"

namespace gyrostat {

/// How a solve ended.
enum class NewtonOutcome : std::uint8_t {
  converged,  ///< |F| below the tolerance
  floor,      ///< rounding lets |F| fall no further
  singular,   ///< asked to stop where the unclipped actuators do not span the torque space
  capped      ///< out of iterations
};

/// All quantities are scaled by the caller to order one.
template <class S, int M, int N>
class DualNewton {
  static_assert(N <= 32, "the clip pattern holds 32 actuators");

 public:
  using Torque = Eigen::Matrix<S, M, 1>;
  using Matrix = Eigen::Matrix<S, M, M>;

  // The problem.
  int n = 0;
  std::array<Torque, std::size_t(N)> a;
  std::array<S, std::size_t(N)> preferred, compliance, lo, up;
  Torque b;
  Matrix R;
  Torque centre;
  S tolerance = S(0);       ///< on the largest |F|
  S rank_tolerance = S(0);  ///< torque directions weaker than this fraction of the strongest count as absent

  int steps = 0;  ///< Newton steps taken since the caller set it to zero

  /// Starts at `y`. With `stop_at_singular` it returns as soon as a Jacobian has no full rank.
  NewtonOutcome solve(const Torque& y, int cap, bool stop_at_singular = false) noexcept {
    evaluate(y, now());
    S previous = S(0), best = std::numeric_limits<S>::infinity();
    bool same_piece = false;
    for (int stalled = 0;; ++steps) {
      const S size = largest(now().F);
      if (size <= tolerance) return NewtonOutcome::converged;
      stalled = size < S(0.9) * best ? 0 : stalled + 1;
      best = std::min(best, size);
      if ((same_piece && S(4) * size > previous) || stalled > 15) return NewtonOutcome::floor;
      if (steps >= cap) return NewtonOutcome::capped;
      if (!factor() && stop_at_singular) return NewtonOutcome::singular;
      previous = size;
      same_piece = advance(-solve_factored(now().F));
    }
  }

  /// The solution as if there were no limits, but for actuators that these hold at one number: one linear system, no start.
  /// False where it breaks a limit, or where the actuators do not span the torque space; then nothing is settled.
  bool solve_unlimited() noexcept {
    Point& p = now();
    std::uint32_t fixed = 0;
    Torque g = b + R * centre;
    p.J = R;
    for (int i = 0; i < n; ++i) {
      const size_t k = size_t(i);
      const bool still = lo[k] == up[k];
      fixed |= static_cast<std::uint32_t>(still) << i;
      const S rest = still ? lo[k] : preferred[k], weight = still ? S(0) : compliance[k];
      GYROSTAT_UNROLL
      for (int c = 0; c < M; ++c) {
        g[c] -= rest * a[k][c];
        const S weighted = weight * a[k][c];
        GYROSTAT_UNROLL
        for (int r = c; r < M; ++r) p.J(r, c) += weighted * a[k][r];
      }
    }
    p.below = p.above = fixed;
    if (!factor() || cancels_) return false;
    p.y = solve_factored(g);
    p.F = R * (p.y - centre) - b;
    bool inside = true;
    for (int i = 0; i < n; ++i) {
      const size_t k = size_t(i);
      S along = S(0);
      GYROSTAT_UNROLL
      for (int r = 0; r < M; ++r) along += a[k][r] * p.y[r];
      const bool still = (fixed >> i & 1u) != 0u;
      const S z = still ? lo[k] : preferred[k] + along * compliance[k];
      inside &= some(still, every(z > lo[k], z < up[k]));
      p.z[k] = z;
      p.F += z * a[k];
    }
    if (!inside || largest(p.F) > tolerance) return false;
    ++steps;
    return true;
  }

  const Torque& y() const noexcept { return points_[current_].y; }
  const Torque& F() const noexcept { return points_[current_].F; }
  /// Allocation at the current point: clipped, so inside the box without exception.
  S tau(int i) const noexcept {
    return std::min(std::max(points_[current_].z[size_t(i)], lo[size_t(i)]), up[size_t(i)]);
  }
  bool is_free(int i) const noexcept { return ((points_[current_].below | points_[current_].above) >> i & 1u) == 0u; }

  /// J^-1 v at the current point, J the derivative of F (regularised where that is singular).
  Torque solve_jacobian(const Torque& v) noexcept {
    factor();
    return solve_factored(v);
  }
  /// The same for another v, with the factor at hand.
  Torque solve_again(const Torque& v) const noexcept { return solve_factored(v); }

 private:
  struct Point {
    Torque y, F;
    Matrix J;                         // lower triangle
    std::array<S, std::size_t(N)> z;  // before clipping
    std::uint32_t below, above;       // clip pattern
  };
  using size_t = std::size_t;

  Point& now() noexcept { return points_[current_]; }

  static S largest(const Torque& v) noexcept {
    S m = S(0);
    for (int r = 0; r < M; ++r) m = std::max(m, std::abs(v[r]));
    return m;
  }

  void evaluate(const Torque& y, Point& p) const noexcept {
    const Torque off = y - centre;
    std::array<S, std::size_t(M)> F;
    std::array<S, std::size_t(M * (M + 1) / 2)> J;  // lower triangle, column by column
    GYROSTAT_UNROLL
    for (int r = 0, at = 0; r < M; ++r) {
      F[size_t(r)] = -b[r];
      GYROSTAT_UNROLL
      for (int c = 0; c < M; ++c) F[size_t(r)] += R(r, c) * off[c];
      GYROSTAT_UNROLL
      for (int c = r; c < M; ++c) J[size_t(at++)] = R(c, r);
    }
    std::uint32_t below = 0, above = 0;
    for (int i = 0; i < n; ++i) {
      const size_t k = size_t(i);
      const Torque& ai = a[k];
      S along = S(0);
      GYROSTAT_UNROLL
      for (int r = 0; r < M; ++r) along += ai[r] * y[r];
      const S z = preferred[k] + along * compliance[k];
      const std::uint32_t under = !(z > lo[k]), over = !(z < up[k]);
      const S t = std::min(std::max(z, lo[k]), up[k]);
      const S weight = (under | over) != 0u ? S(0) : compliance[k];
      GYROSTAT_UNROLL
      for (int c = 0, at = 0; c < M; ++c) {
        F[size_t(c)] += t * ai[c];
        const S weighted = weight * ai[c];
        GYROSTAT_UNROLL
        for (int r = c; r < M; ++r) J[size_t(at++)] += weighted * ai[r];
      }
      p.z[k] = z;
      below |= under << i;
      above |= over << i;
    }
    p.y = y;
    GYROSTAT_UNROLL
    for (int c = 0, at = 0; c < M; ++c) {
      p.F[c] = F[size_t(c)];
      GYROSTAT_UNROLL
      for (int r = c; r < M; ++r) p.J(r, c) = J[size_t(at++)];
    }
    p.below = below;
    p.above = above;
  }

  /// False when the unclipped actuators, with R, do not span the torque space.
  bool factor() noexcept {
    cancels_ = !ldl_.factor(now().J, std::sqrt(std::numeric_limits<S>::epsilon()));
    if (!cancels_) return true;
    orthogonal_.clear();
    for (int i = 0; i < n; ++i)
      if (is_free(i)) orthogonal_.add_row(std::sqrt(compliance[size_t(i)]) * a[size_t(i)]);
    Matrix L = R;  // Cholesky factor of R, column by column; an empty column where R is singular
    for (int j = 0; j < M; ++j) {
      const S root = L(j, j) > S(0) ? std::sqrt(L(j, j)) : S(0);
      Torque row = Torque::Zero();
      for (int i = j; i < M; ++i) row[i] = root > S(0) ? L(i, j) / root : S(0);
      for (int c = j + 1; c < M; ++c)
        for (int i = c; i < M; ++i) L(i, c) -= row[i] * row[c];
      orthogonal_.add_row(row);
    }
    return orthogonal_.factor(rank_tolerance);
  }

  Torque solve_factored(const Torque& v) const noexcept { return cancels_ ? orthogonal_.solve(v) : ldl_.solve(v); }

  /// One step along d; true when the full step stayed on one piece, where Newton's model is exact.
  bool advance(const Torque& d) noexcept {
    Point& from = now();
    Point& to = points_[current_ ^ 1u];
    evaluate(from.y + d, to);
    const S slope = d.dot(from.F);
    const bool same = from.below == to.below && from.above == to.above;
    if (!same && d.dot(to.F) > S(1e-3) * std::abs(slope)) {
      evaluate(from.y + minimiser(from, to, d) * d, to);
      current_ ^= 1u;
      return false;
    }
    current_ ^= 1u;
    return same;
  }

  /// Where along d, inside (0, 1), the slope d'F changes sign: it is piecewise linear with at most 2 n corners, which are
  /// halved by trying one of those left until none is inside the bracket.
  S minimiser(const Point& from, const Point& to, const Torque& d) const noexcept {
    std::array<S, std::size_t(N)> reach;
    std::array<S, std::size_t(2 * N)> corners;
    int left = 0;
    const S linear = d.dot(R * (from.y - centre) - b), quadratic = d.dot(R * d);
    for (int i = 0; i < n; ++i) {
      const size_t k = size_t(i);
      reach[k] = a[k].dot(d);
      const S rate = reach[k] * compliance[k];
      for (const S corner : {(lo[k] - from.z[k]) / rate, (up[k] - from.z[k]) / rate})
        if (corner > S(0) && corner < S(1)) corners[size_t(left++)] = corner;
    }
    const auto slope = [&](S t) noexcept {
      S sum = linear + t * quadratic;
      for (int i = 0; i < n; ++i) {
        const size_t k = size_t(i);
        sum += reach[k] * std::min(std::max(from.z[k] + t * reach[k] * compliance[k], lo[k]), up[k]);
      }
      return sum;
    };
    S t_lo = S(0), t_up = S(1), slope_lo = d.dot(from.F), slope_up = d.dot(to.F);
    while (left > 0) {
      const S t = corners[size_t(left / 2)], s = slope(t);
      if (s < S(0)) {
        t_lo = t;
        slope_lo = s;
      } else {
        t_up = t;
        slope_up = s;
      }
      int kept = 0;
      for (int k = 0; k < left; ++k)
        if (corners[size_t(k)] > t_lo && corners[size_t(k)] < t_up) corners[size_t(kept++)] = corners[size_t(k)];
      left = kept;
    }
    const S drop = slope_up - slope_lo;
    return drop > S(0) ? t_lo - slope_lo * (t_up - t_lo) / drop : t_up;
  }

  std::array<Point, 2> points_;
  unsigned current_ = 0;
  Ldl<S, M> ldl_;
  OrthogonalFactor<S, M, N + M> orthogonal_;
  bool cancels_ = false;
};

}  // namespace gyrostat
