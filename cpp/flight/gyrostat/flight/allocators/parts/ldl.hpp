// SPDX-License-Identifier: MIT
/// @file  L D L' factor of a symmetric matrix of a few rows: no square root, no heap, the pivots looked at.
#pragma once
#include <Eigen/Core>

#include "gyrostat/flight/allocators/parts/unroll.hpp"

namespace gyrostat {

/// Factor of a symmetric positive definite M x M matrix; only its lower triangle is read.
template <class S, int M>
class Ldl {
 public:
  using Vector = Eigen::Matrix<S, M, 1>;
  using Matrix = Eigen::Matrix<S, M, M>;

  /// False when a pivot is not above `smallest` times its diagonal element: so much was lost by cancellation.
  bool factor(const Matrix& A, S smallest) noexcept {
    GYROSTAT_UNROLL
    for (int j = 0; j < M; ++j) {
      S pivot = A(j, j);
      GYROSTAT_UNROLL
      for (int k = 0; k < j; ++k) pivot -= L_(j, k) * scaled_(j, k);
      if (!(pivot > smallest * A(j, j))) return false;
      inverse_[j] = S(1) / pivot;
      GYROSTAT_UNROLL
      for (int i = j + 1; i < M; ++i) {
        S sum = A(i, j);
        GYROSTAT_UNROLL
        for (int k = 0; k < j; ++k) sum -= L_(i, k) * scaled_(j, k);
        scaled_(i, j) = sum;
        L_(i, j) = sum * inverse_[j];
      }
    }
    return true;
  }

  Vector solve(const Vector& b) const noexcept {
    Vector x = b;
    GYROSTAT_UNROLL
    for (int i = 1; i < M; ++i) GYROSTAT_UNROLL
    for (int k = 0; k < i; ++k) x[i] -= L_(i, k) * x[k];
    GYROSTAT_UNROLL
    for (int i = 0; i < M; ++i) x[i] *= inverse_[i];
    GYROSTAT_UNROLL
    for (int i = M - 2; i >= 0; --i) GYROSTAT_UNROLL
    for (int k = i + 1; k < M; ++k) x[i] -= L_(k, i) * x[k];
    return x;
  }

 private:
  Matrix L_, scaled_;  // strictly lower: L, and L D
  Vector inverse_;
};

}  // namespace gyrostat
