// SPDX-License-Identifier: MIT
/// @file  A covariance of bounded size, held as its lower triangle: symmetric because there is nothing else.
///
/// Scalar measurements one after the other, no inverse. Page: docs/components/joint_kalman.md
#pragma once
#include <Eigen/Core>

namespace gyrostat {

/// @tparam most  largest number of states; the number of one filter is chosen at run time, and only its share is touched
template <class S, int most>
class Covariance {
 public:
  using Vector = Eigen::Matrix<S, Eigen::Dynamic, 1, 0, most, 1>;
  using Matrix = Eigen::Matrix<S, Eigen::Dynamic, Eigen::Dynamic, 0, most, most>;

  explicit Covariance(int states) noexcept : lower_(Matrix::Zero(states, states)) {}

  int size() const noexcept { return static_cast<int>(lower_.rows()); }
  void set_zero() noexcept { lower_.setZero(); }

  S variance(int j) const noexcept { return lower_(j, j); }
  S& variance(int j) noexcept { return lower_(j, j); }
  /// Of two states, the larger index first.
  S operator()(int row, int col) const noexcept { return lower_(row, col); }

  Vector column(int j) const noexcept {
    Vector out(size());
    out.head(j) = lower_.row(j).head(j).transpose();
    out.tail(size() - j) = lower_.col(j).tail(size() - j);
    return out;
  }

  /// += v f f'
  void widen(const Vector& f, S v) noexcept {
    for (int c = 0; c < size(); ++c) {
      if (f[c] == S(0)) continue;
      const S scale = v * f[c];
      lower_.col(c).tail(size() - c) += scale * f.tail(size() - c);
    }
  }

  /// State j was measured with variance R; returns the gain. What is left of its own row is written as a share, not as a
  /// difference: exact also where R is far below what was there.
  Vector measure(int j, S R) noexcept {
    const Vector before = column(j);
    const S spread = before[j] + R;
    const Vector gain = before / spread;
    const int n = size();
    for (int c = 0; c < n; ++c) lower_.col(c).tail(n - c) -= gain[c] * before.tail(n - c);
    const S left = R / spread;
    lower_.row(j).head(j) = left * before.head(j).transpose();
    lower_.col(j).tail(n - j) = left * before.tail(n - j);
    return gain;
  }

  /// State j is known afresh, with variance R, and tells nothing about the others.
  void renew(int j, S R) noexcept {
    lower_.row(j).head(j).setZero();
    lower_.col(j).tail(size() - j).setZero();
    lower_(j, j) = R;
  }

  /// The lower triangle; above it there are zeros.
  const Matrix& lower() const noexcept { return lower_; }
  Matrix& lower() noexcept { return lower_; }

 private:
  Matrix lower_;
};

}  // namespace gyrostat
