// SPDX-License-Identifier: MIT
/// @file  Worst residual when the delivered torque v = diag(e) tau is wrong by E v, E any matrix of norm <= eps.
///
///     worst^2 = min over theta in (0, 1] of  r'(I - theta Sb)^-1 r + s_max^2 rho^2 / theta,   rho = |diag(eps e) tau|
///
/// with S = W D (W D)' over the actuators that can act, s_max^2 its largest eigenvalue and Sb = S / s_max^2: a trust-region problem without gap
/// (S-lemma). Replacing Sb by I gives the bound |r| + s_max rho. Page: docs/allocation.md
#pragma once
#include <Eigen/Core>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>

namespace gyrostat {

/// What the worst case needs of the geometry: computed when D, W or the active actuators change, not at every allocation.
template <class S, int M>
struct TorqueSpread {
  using Torque = Eigen::Matrix<S, M, 1>;
  using Matrix = Eigen::Matrix<S, M, M>;

  S s_max = S(0);
  Matrix Sb = Matrix::Zero();
  Matrix axes = Matrix::Identity();  ///< eigenvectors of Sb
  Torque values = Torque::Zero();    ///< its eigenvalues, the largest is 1

  TorqueSpread() = default;
  /// @param active bit i: actuator i can act; one that cannot delivers no error either
  template <class Columns>
  TorqueSpread(const Columns& WD, std::uint32_t active) noexcept {
    Matrix gram = Matrix::Zero();
    for (Eigen::Index i = 0; i < WD.cols(); ++i)
      if ((active >> i & 1u) != 0u) gram += WD.col(i) * WD.col(i).transpose();
    const Eigen::SelfAdjointEigenSolver<Matrix> eigen(gram);
    const S top = eigen.eigenvalues()[M - 1];
    if (!(top > S(0))) return;
    s_max = std::sqrt(top);
    Sb = gram / top;
    axes = eigen.eigenvectors();
    for (int k = 0; k < M; ++k) values[k] = std::clamp(eigen.eigenvalues()[k] / top, S(0), S(1));
  }

  S bound(S residual_norm, S rho) const noexcept { return residual_norm + s_max * rho; }

  /// Exact worst case, from above: any theta gives an upper bound, the best one gives equality.
  /// `theta` is where the search starts; 0 or 1 when nothing is known.
  S exact(const Torque& residual, S rho, S theta = S(0)) const noexcept {
    constexpr S epsilon = std::numeric_limits<S>::epsilon(), last = S(1) - epsilon;  // a pole may sit at 1
    const Torque r = axes.transpose() * residual;
    const S spread = s_max * s_max * rho * rho;
    S best = square(bound(residual.norm(), rho)), lo = S(0), up = S(1);
    if (!(theta > S(0) && theta < S(1))) theta = s_max * rho / (s_max * rho + std::abs(r[M - 1]));
    theta = std::min(theta, last);
    for (int k = 0; k < 60 && theta > lo && theta < up; ++k) {
      S value = spread / theta, slope = -value / theta, curvature = -S(2) * slope / theta;
      for (int j = 0; j < M; ++j) {
        if (r[j] == S(0)) continue;
        const S q = r[j] / (S(1) - theta * values[j]);
        value += q * r[j];
        slope += values[j] * q * q;
        curvature += S(2) * square(values[j] * q) / (S(1) - theta * values[j]);
      }
      best = value < best ? value : best;
      (slope > S(0) ? up : lo) = theta;
      const S next = std::min(theta - slope / curvature, last);
      if (!(std::abs(next - theta) > std::sqrt(epsilon) * std::min(theta, S(1) - theta))) break;
      theta = next > lo && next < up ? next : (lo + up) / S(2);
    }
    return std::sqrt(best);
  }

 private:
  static S square(S x) noexcept { return x * x; }
};

}  // namespace gyrostat
