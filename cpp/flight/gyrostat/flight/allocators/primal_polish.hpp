// SPDX-License-Identifier: MIT
/// @file  Last step in the primal: with the clipped actuators held, the others are computed from the torque they owe.
///
/// A large multiplier (demand out of reach, large residual weight) leaves few digits in preferred + a'y/p, because a'y is a
/// small difference of large terms. Here the unclipped actuators come from an orthogonal basis of their own torque directions
/// (rank revealed by pivoting), so no large number enters:
///
///     min |x|^2 + |B x - c|^2 / soft,   x = (tau - preferred)/sqrt(compliance),  B = A_free diag(sqrt(compliance)).
#pragma once
#include "gyrostat/flight/allocators/dual_newton.hpp"

namespace gyrostat {

template <class S, int M, int N>
struct Polished {
  std::array<S, N> tau;            ///< inside the box
  Eigen::Matrix<S, M, 1> y;        ///< multiplier moved along, so that it still explains the unclipped actuators
  Eigen::Matrix<S, M, 1> residual; ///< b - A tau
  Eigen::Matrix<S, M, 1> across;   ///< its part that no unclipped actuator can produce
};

/// B = triangle Q' by pivoted Gram-Schmidt on the rows of B, carried out twice: Q is orthogonal to rounding.
template <class S, int M, int N>
struct RowBasis {
  Eigen::Matrix<S, M, M> triangle = Eigen::Matrix<S, M, M>::Zero();
  Eigen::Matrix<S, N, M> Q;
  int rank = 0;

  /// @param rows the rows of B in columns; the first n entries of each count
  RowBasis(Eigen::Matrix<S, N, M> rows, int n, S rank_tolerance) noexcept {
    S first = S(0);
    for (; rank < std::min(M, n); ++rank) {
      int best = 0;
      S size = S(-1);
      for (int r = 0; r < M; ++r) {
        const S norm = dot(rows, r, rows, r, n);
        if (norm > size) {
          size = norm;
          best = r;
        }
      }
      size = std::sqrt(size);
      if (rank == 0) first = size;
      if (!(size > rank_tolerance * first)) return;
      for (int i = 0; i < n; ++i) Q(i, rank) = rows(i, best) / size;
      for (int pass = 0; pass < 2; ++pass)
        for (int r = 0; r < M; ++r) {
          const S along = dot(Q, rank, rows, r, n);
          triangle(r, rank) += along;
          for (int i = 0; i < n; ++i) rows(i, r) -= along * Q(i, rank);
        }
    }
  }

 private:
  static S dot(const Eigen::Matrix<S, N, M>& a, int i, const Eigen::Matrix<S, N, M>& b, int j, int n) noexcept {
    S sum = S(0);
    for (int k = 0; k < n; ++k) sum += a(k, i) * b(k, j);
    return sum;
  }
};

/// v less its components in the first `rank` columns of T; v itself when they span everything.
template <class S, int M>
Eigen::Matrix<S, M, 1> outside_span(Eigen::Matrix<S, M, M> T, int rank, Eigen::Matrix<S, M, 1> v) noexcept {
  if (rank == M) return v;
  for (int j = 0; j < rank; ++j) {
    for (int pass = 0; pass < 2; ++pass)
      for (int k = 0; k < j; ++k) T.col(j) -= T.col(k).dot(T.col(j)) * T.col(k);
    T.col(j) /= T.col(j).norm();
  }
  for (int pass = 0; pass < 2; ++pass)
    for (int k = 0; k < rank; ++k) v -= T.col(k).dot(v) * T.col(k);
  return v;
}

/// The kernel's current point, polished. @param soft 1 / residual weight; zero: least squares, then least effort
template <class S, int M, int N>
Polished<S, M, N> polish(const DualNewton<S, M, N>& k, S soft) noexcept {
  using Torque = Eigen::Matrix<S, M, 1>;
  constexpr S rank_tolerance = sizeof(S) < 8 ? S(1e-4) : S(1e-9);
  Polished<S, M, N> out;
  Torque owed = k.b;
  Eigen::Matrix<S, N, M> rows;
  std::array<S, N> root;
  for (int i = 0; i < k.n; ++i) {
    const std::size_t j = std::size_t(i);
    out.tau[j] = k.tau(i);
    root[j] = k.is_free(i) ? std::sqrt(k.compliance[j]) : S(0);
    owed -= (k.is_free(i) ? k.preferred[j] : out.tau[j]) * k.a[j];
    rows.row(i) = root[j] * k.a[j].transpose();
  }
  const RowBasis<S, M, N> basis(rows, k.n, rank_tolerance);
  const Eigen::Matrix<S, M, M>& T = basis.triangle;
  // Columns of T beyond the rank are zero: a unit diagonal keeps them out.
  Eigen::Matrix<S, M, M> normal = T.transpose() * T;
  for (int r = 0; r < M; ++r) normal(r, r) += r < basis.rank ? soft : S(1);
  Ldl<S, M> factor;
  factor.factor(normal, S(0));
  Torque w = factor.solve(T.transpose() * owed);
  w += factor.solve(T.transpose() * (owed - T * w) - soft * w);

  Torque change = w;  // of Q'x against what y says
  out.residual = k.b;
  for (int i = 0; i < k.n; ++i) {
    const std::size_t j = std::size_t(i);
    if (k.is_free(i)) {
      S x = S(0);
      for (int r = 0; r < basis.rank; ++r) {
        x += basis.Q(i, r) * w[r];
        change[r] -= basis.Q(i, r) * root[j] * k.a[j].dot(k.y());
      }
      out.tau[j] = std::min(std::max(k.preferred[j] + root[j] * x, k.lo[j]), k.up[j]);
    }
    out.residual -= out.tau[j] * k.a[j];
  }
  for (int r = basis.rank; r < M; ++r) change[r] = S(0);
  out.y = k.y() + T * factor.solve(change);
  out.across = outside_span<S, M>(T, basis.rank, out.residual);
  return out;
}

}  // namespace gyrostat
