// SPDX-License-Identifier: MIT
#include "gyrostat/truth/effectors/flexible_mode.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <cmath>
#include <cstdio>
#include <stdexcept>

namespace gyrostat::truth {

/// Of (I - delta J^-1 delta') eta'' = -omega^2 eta, made symmetric.
std::vector<double> free_frequencies(const Mat3<double>& J_B, const std::vector<FlexibleMode>& modes) {
  const auto m = static_cast<Eigen::Index>(modes.size());
  Eigen::Matrix<double, Eigen::Dynamic, 3> delta(m, 3);
  Eigen::VectorXd stiffness(m);
  for (Eigen::Index k = 0; k < m; ++k) {
    const FlexibleMode& mode = modes[static_cast<std::size_t>(k)];
    delta.row(k) = mode.delta_B.transpose();
    stiffness[k] = mode.omega * mode.omega;
  }
  const Mat3<double> rest = J_B - delta.transpose() * delta;
  const double least = Eigen::SelfAdjointEigenSolver<Mat3<double>>(rest, Eigen::EigenvaluesOnly).eigenvalues()[0];
  if (!(least > 0)) {
    std::array<char, 32> number{};
    std::snprintf(number.data(), number.size(), "%.4g", least);
    throw std::invalid_argument(
        std::string("the appendages carry more inertia than the vehicle: smallest eigenvalue of J - delta' delta is ") +
        number.data() + " kg m^2");
  }
  if (m == 0) return {};
  const Eigen::MatrixXd mass = Eigen::MatrixXd::Identity(m, m) - delta * J_B.inverse() * delta.transpose();
  const Eigen::GeneralizedSelfAdjointEigenSolver<Eigen::MatrixXd> modal(stiffness.asDiagonal(), mass,
                                                                        Eigen::EigenvaluesOnly);
  std::vector<double> out;
  for (const double square : modal.eigenvalues()) out.push_back(std::sqrt(square));
  return out;
}

}  // namespace gyrostat::truth
