// SPDX-License-Identifier: MIT
/// @file  Last step in the primal: with the clipped actuators held, the others are computed from the torque they owe.
///
/// A large multiplier (demand out of reach, large residual weight) leaves few digits in preferred + a'y/p, because a'y is a
/// small difference of large terms. Here the unclipped actuators come from an orthogonal basis of their own torque directions
/// (rank revealed by pivoting), so no large number enters:
///
///     min |x|^2 + |B x - c|^2 / soft,   x = (tau - preferred)/sqrt(compliance),  B = A_free diag(sqrt(compliance)).
#pragma once
#include "gyrostat/flight/allocators/parts/dual_newton.hpp"

namespace gyrostat {

template <class S, int M, int N>
struct Polished {
  std::array<S, std::size_t(N)> tau;  ///< inside the box
  Eigen::Matrix<S, M, 1> y;           ///< multiplier moved along, so that it still explains the unclipped actuators
  Eigen::Matrix<S, M, 1> residual;    ///< b - A tau
  Eigen::Matrix<S, M, 1>
      across;  ///< a direction in which no unclipped actuator acts: the residual's own, where rows are equal
};

/// B = triangle Q' by pivoted Gram-Schmidt on the rows of B, carried out twice: Q is orthogonal to rounding. Rows that are
/// held come first, so that their share of Q, and of the solution, is settled before the others'.
template <class S, int M, int N>
class RowBasis {
 public:
  using Torque = Eigen::Matrix<S, M, 1>;

  /// @param rows the rows of B in columns; the first n entries of each count
  RowBasis(const Eigen::Matrix<S, N, M>& rows, int n, unsigned held) noexcept : n_(n) {
    rows_.topRows(n) = rows.topRows(n);
    for (int r = 0; r < M; ++r) largest_ = std::max(largest_, dot(rows_, r, rows_, r));
    largest_ = std::sqrt(largest_);
    collect(held);
    held_rank_ = rank_;
    held_ = held;
    collect(~held);
  }

  /// Least |x| among the least |B x - c|^2 + soft |x|^2, held rows first; as w with x = Q w.
  Torque coordinates(const Torque& c, S soft) const noexcept {
    Torque w = Torque::Zero();
    for (int pass = 0; pass < 2; ++pass) {
      solve_block(c, soft, 0, held_rank_, held_, w);
      solve_block(c, soft, held_rank_, rank_, ~held_, w);
    }
    return w;
  }

  /// y of least norm with B'y = Q w.
  Torque multiplier(const Torque& w) const noexcept {
    Torque y = Torque::Zero();
    transposed_block(w, held_rank_, rank_, ~held_, y);
    transposed_block(w, 0, held_rank_, held_, y);
    return y;
  }

  /// v with its components in the columns of the triangle removed: on rows that are not held by projection, on held rows by
  /// what balances those.
  Torque across(Torque v) const noexcept {
    if (rank_ == M) return v;
    Eigen::Matrix<S, M, M> T = triangle_;
    for (int r = 0; r < M; ++r)
      if (in(held_, r)) {
        v[r] = S(0);
        T.row(r).setZero();
      }
    for (int j = held_rank_; j < rank_; ++j) {
      for (int pass = 0; pass < 2; ++pass)
        for (int k = held_rank_; k < j; ++k) T.col(j) -= T.col(k).dot(T.col(j)) * T.col(k);
      T.col(j) /= T.col(j).norm();
    }
    for (int pass = 0; pass < 2; ++pass)
      for (int k = held_rank_; k < rank_; ++k) v -= T.col(k).dot(v) * T.col(k);
    transposed_block(Torque::Zero(), 0, held_rank_, held_, v);
    return v;
  }

  S x(int i, const Torque& w) const noexcept {
    S sum = S(0);
    for (int r = 0; r < rank_; ++r) sum += Q_(i, r) * w[r];
    return sum;
  }
  /// Q'e_i, times t
  void subtract(int i, S t, Torque& w) const noexcept {
    for (int r = 0; r < rank_; ++r) w[r] -= Q_(i, r) * t;
  }

 private:
  static constexpr S rank_tolerance = sizeof(S) < 8 ? S(1e-4) : S(1e-9);
  static bool in(unsigned rows, int r) noexcept { return (rows >> r & 1u) != 0u; }

  void collect(unsigned from) noexcept {
    while (rank_ < std::min(M, n_)) {
      int best = -1;
      S size = S(0);
      for (int r = 0; r < M; ++r) {
        const S norm = in(from, r) ? dot(rows_, r, rows_, r) : S(0);
        if (norm > size) {
          size = norm;
          best = r;
        }
      }
      size = std::sqrt(size);
      if (best < 0 || !(size > rank_tolerance * largest_)) return;
      for (int i = 0; i < n_; ++i) Q_(i, rank_) = rows_(i, best) / size;
      for (int pass = 0; pass < 2; ++pass)
        for (int r = 0; r < M; ++r) {
          const S along = dot(Q_, rank_, rows_, r);
          triangle_(r, rank_) += along;
          for (int i = 0; i < n_; ++i) rows_(i, r) -= along * Q_(i, rank_);
        }
      ++rank_;
    }
  }

  /// T'T over the given rows and columns; a unit diagonal keeps the other columns out.
  Ldl<S, M> normal(int begin, int end, unsigned rows, S soft) const noexcept {
    Eigen::Matrix<S, M, M> G = Eigen::Matrix<S, M, M>::Identity();
    for (int c = begin; c < end; ++c)
      for (int d = begin; d <= c; ++d) {
        S sum = c == d ? soft : S(0);
        for (int r = 0; r < M; ++r) sum += in(rows, r) ? triangle_(r, c) * triangle_(r, d) : S(0);
        G(c, d) = sum;
      }
    Ldl<S, M> factor;
    factor.factor(G, S(0));
    return factor;
  }

  /// Corrects w[begin..end) against what is left of c on the given rows.
  void solve_block(const Torque& c, S soft, int begin, int end, unsigned rows, Torque& w) const noexcept {
    if (begin == end) return;
    Torque g = Torque::Zero();
    for (int r = 0; r < M; ++r) {
      if (!in(rows, r)) continue;
      S left = c[r];
      for (int k = 0; k < rank_; ++k) left -= triangle_(r, k) * w[k];
      for (int k = begin; k < end; ++k) g[k] += triangle_(r, k) * left;
    }
    for (int k = begin; k < end; ++k) g[k] -= soft * w[k];
    w += normal(begin, end, rows, soft).solve(g);
  }

  /// Corrects y on the given rows so that (T'y)[begin..end) = w[begin..end).
  void transposed_block(const Torque& w, int begin, int end, unsigned rows, Torque& y) const noexcept {
    if (begin == end) return;
    Torque g = Torque::Zero();
    for (int k = begin; k < end; ++k) {
      g[k] = w[k];
      for (int r = 0; r < M; ++r) g[k] -= triangle_(r, k) * y[r];
    }
    const Torque z = normal(begin, end, rows, S(0)).solve(g);
    for (int r = 0; r < M; ++r)
      for (int k = begin; k < end; ++k) y[r] += in(rows, r) ? triangle_(r, k) * z[k] : S(0);
  }

  S dot(const Eigen::Matrix<S, N, M>& a, int i, const Eigen::Matrix<S, N, M>& b, int j) const noexcept {
    S sum = S(0);
    for (int k = 0; k < n_; ++k) sum += a(k, i) * b(k, j);
    return sum;
  }

  Eigen::Matrix<S, N, M> rows_, Q_;
  Eigen::Matrix<S, M, M> triangle_ = Eigen::Matrix<S, M, M>::Zero();
  int n_, rank_ = 0, held_rank_ = 0;
  unsigned held_ = 0;
  S largest_ = S(0);
};

/// The kernel's current point, polished. @param soft 1 / residual weight; zero: least squares, then least effort
/// @param held rows whose demand is met before the others'   @param released clipped actuators that count as unclipped
template <class S, int M, int N>
Polished<S, M, N> polish(const DualNewton<S, M, N>& k, S soft, unsigned held = 0, std::uint32_t released = 0) noexcept {
  const auto is_free = [&](int i) { return k.is_free(i) || (released >> i & 1u) != 0u; };
  using Torque = Eigen::Matrix<S, M, 1>;
  Polished<S, M, N> out;
  Torque owed = k.b;
  Eigen::Matrix<S, N, M> rows = Eigen::Matrix<S, N, M>::Zero();
  std::array<S, std::size_t(N)> root;
  for (int i = 0; i < k.n; ++i) {
    const std::size_t j = std::size_t(i);
    out.tau[j] = k.tau(i);
    root[j] = is_free(i) ? std::sqrt(k.compliance[j]) : S(0);
    owed -= (is_free(i) ? k.preferred[j] : out.tau[j]) * k.a[j];
    rows.row(i) = root[j] * k.a[j].transpose();
  }
  const RowBasis<S, M, N> basis(rows, k.n, held);
  const Torque w = basis.coordinates(owed, soft);
  Torque change = w;  // of Q'x against what y says
  out.residual = k.b;
  for (int i = 0; i < k.n; ++i) {
    const std::size_t j = std::size_t(i);
    if (is_free(i)) {
      basis.subtract(i, root[j] * k.a[j].dot(k.y()), change);
      out.tau[j] = std::min(std::max(k.preferred[j] + root[j] * basis.x(i, w), k.lo[j]), k.up[j]);
    }
    out.residual -= out.tau[j] * k.a[j];
  }
  out.y = k.y() + basis.multiplier(change);
  out.across = basis.across(out.residual);
  return out;
}

}  // namespace gyrostat
