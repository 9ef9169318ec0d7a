// SPDX-License-Identifier: MIT
/// @file  Solves (B'B) x = v from the rows of B by Householder reflections, without forming B'B: small parts of B keep their
///        digits beside large ones, where a Cholesky factor of B'B loses them.
#pragma once
#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <limits>

namespace gyrostat {

/// @tparam Rows largest number of rows
template <class S, int M, int Rows>
class OrthogonalFactor {
 public:
  using Vector = Eigen::Matrix<S, M, 1>;

  void clear() noexcept { rows_ = 0; }
  void add_row(const Vector& row) noexcept { B_.row(rows_++) = row.transpose(); }

  /// Leaves the triangular factor in the first M rows. At least M rows are needed.
  /// @return false when a diagonal element is below `rank_tolerance` of the largest
  bool factor(S rank_tolerance) noexcept {
    S top = S(0);
    for (int j = 0; j < M; ++j) {
      S norm = S(0);
      for (int i = j; i < rows_; ++i) norm += B_(i, j) * B_(i, j);
      norm = std::sqrt(norm);
      top = std::max(top, norm);
      if (norm > S(0)) {
        const S alpha = B_(j, j) > S(0) ? -norm : norm;
        const S head = B_(j, j) - alpha;
        B_(j, j) = head;
        for (int c = j + 1; c < M; ++c) {
          S along = S(0);
          for (int i = j; i < rows_; ++i) along += B_(i, j) * B_(i, c);
          along /= alpha * head;
          for (int i = j; i < rows_; ++i) B_(i, c) += along * B_(i, j);
        }
        diagonal_[j] = alpha;
      } else {
        diagonal_[j] = S(0);
      }
    }
    const S smallest = top * std::numeric_limits<S>::epsilon() * S(1e-2) + std::numeric_limits<S>::min();
    bool full_rank = true;
    for (int j = 0; j < M; ++j) {
      full_rank = full_rank && std::abs(diagonal_[j]) > rank_tolerance * top;
      if (!(std::abs(diagonal_[j]) > smallest)) diagonal_[j] = smallest;
    }
    return full_rank;
  }

  Vector solve(Vector x) const noexcept {
    for (int i = 0; i < M; ++i) {
      for (int k = 0; k < i; ++k) x[i] -= B_(k, i) * x[k];
      x[i] /= diagonal_[i];
    }
    for (int i = M - 1; i >= 0; --i) {
      for (int k = i + 1; k < M; ++k) x[i] -= B_(i, k) * x[k];
      x[i] /= diagonal_[i];
    }
    return x;
  }

 private:
  Eigen::Matrix<S, Rows, M> B_;
  Vector diagonal_;
  int rows_ = 0;
};

}  // namespace gyrostat
