// SPDX-License-Identifier: MIT
/// @file  Whether whitened innovations can still be noise: their means at three time scales, squared, against a gate.
///
///   m_s += lambda_s (z - m_s),   lambda = 1, 1/8, 1/64;   of white z, (2 - lambda) / lambda |m|^2 is chi-squared
///
/// A jump shows at once in the first, a small lasting change in the last. Page: docs/components/joint_kalman.md
#pragma once
#include <Eigen/Core>
#include <array>

namespace gyrostat {

/// Of a channel with `n` components.
template <class S, int n>
class InnovationGate {
 public:
  using Innovation = Eigen::Matrix<S, n, 1>;

  void start() noexcept { means_.fill(Innovation::Zero()); }

  /// True where noise hardly explains it; the means begin anew then.
  bool exceeded(const Innovation& z, S gate) noexcept {
    bool beyond = false;
    S lambda = S(1);
    for (Innovation& m : means_) {
      m += lambda * (z - m);
      beyond = beyond || (S(2) - lambda) * m.squaredNorm() > gate * lambda;
      lambda /= S(8);
    }
    if (beyond) start();
    return beyond;
  }

 private:
  std::array<Innovation, 3> means_{Innovation::Zero(), Innovation::Zero(), Innovation::Zero()};
};

}  // namespace gyrostat
