// SPDX-License-Identifier: MIT
// What of the equations of motion is linear: modes of the free body, and bearings. Eigen's solvers are compiled here alone.
#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <array>
#include <cmath>
#include <cstdio>
#include <stdexcept>
#include <string>

#include "gyrostat/truth/rigid_plant_definitions.hpp"

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

double detail::relaxation(const std::vector<FrictionWheel>& wheels, const Mat3<double>& J_B_inverse) {
  const auto n = static_cast<Eigen::Index>(wheels.size());
  if (n == 0) return 0;
  Eigen::MatrixXd symmetric(n, n);  // similar to it
  for (Eigen::Index r = 0; r < n; ++r) {
    for (Eigen::Index c = 0; c < n; ++c) {
      const FrictionWheel &a = wheels[static_cast<std::size_t>(r)], &b = wheels[static_cast<std::size_t>(c)];
      const double coupling = a.axis_B.dot(J_B_inverse * b.axis_B) + (r == c ? 1 / a.inertia : 0.0);
      symmetric(r, c) = std::sqrt(a.viscous * b.viscous) * coupling;
    }
  }
  return Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(symmetric, Eigen::EigenvaluesOnly).eigenvalues()[n - 1];
}

}  // namespace gyrostat::truth
