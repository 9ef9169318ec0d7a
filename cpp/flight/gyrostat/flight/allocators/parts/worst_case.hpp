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

  /// Exact worst case, from above: any theta gives an upper bound, the best one equality. In mu = 1/theta - 1 its square is
  ///
  ///     |r|^2 + sum of v_j r_j^2/(mu + 1 - v_j) + (1 + mu) (s_max rho)^2,
  ///
  /// convex, and least where |p| = s_max rho, p_j = sqrt(v_j) r_j/(mu + 1 - v_j), or at mu = 0 with <=. 1/|p| is concave and
  /// grows, so Newton steps on it rise to the root from any mu below; each term of |p| alone gives such a mu.
  S exact(const Torque& residual, S rho) const noexcept {
    const Torque r = axes.transpose() * residual;
    const Torque rest = Torque::Ones() - values;  // of the largest value: zero, a pole at mu = 0
    const S spread = s_max * rho, spread2 = spread * spread, r2 = r.squaredNorm();
    if (!(spread > S(0))) return residual.norm();
    S mu = S(0), best = square(bound(residual.norm(), rho));
    for (int j = 0; j < M; ++j) mu = std::max(mu, std::sqrt(values[j]) * std::abs(r[j]) / spread - rest[j]);
    for (int k = 0; k < 40; ++k) {
      S value = r2 + spread2 * (S(1) + mu), p2 = S(0), slope = S(0);
      for (int j = 0; j < M; ++j) {
        if (r[j] == S(0)) continue;
        const S q = r[j] / (mu + rest[j]);
        value += values[j] * q * r[j];
        p2 += values[j] * q * q;
        slope += values[j] * q * q / (mu + rest[j]);
      }
      best = std::min(best, value);
      if (!(p2 > spread2)) break;
      const S step = (std::sqrt(p2) / spread - S(1)) * p2 / slope;
      if (!(step * (p2 - spread2) > std::numeric_limits<S>::epsilon() * best)) break;  // it gains no more
      mu += step;
    }
    return std::sqrt(best);
  }

 private:
  static S square(S x) noexcept { return x * x; }
};

}  // namespace gyrostat
