// SPDX-License-Identifier: MIT
#include "gyrostat/truth/body.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <cmath>
#include <stdexcept>

namespace gyrostat::truth {
namespace {

/// Largest eigenvalue of the speeds' own dynamics, s' = -(1/Js + G' J^-1 G) C s.
double relaxation(const std::vector<Body::FrictionWheel>& wheels, const Mat3<double>& J_B_inverse) {
  const auto n = static_cast<Eigen::Index>(wheels.size());
  if (n == 0) return 0;
  Eigen::MatrixXd symmetric(n, n);  // similar to it
  for (Eigen::Index r = 0; r < n; ++r) {
    for (Eigen::Index c = 0; c < n; ++c) {
      const Body::FrictionWheel &a = wheels[static_cast<std::size_t>(r)], &b = wheels[static_cast<std::size_t>(c)];
      const double coupling = a.axis_B.dot(J_B_inverse * b.axis_B) + (r == c ? 1 / a.inertia : 0.0);
      symmetric(r, c) = std::sqrt(a.viscous * b.viscous) * coupling;
    }
  }
  return Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(symmetric, Eigen::EigenvaluesOnly).eigenvalues()[n - 1];
}

}  // namespace

Body::Body(const Mat3<double>& J_B_in, const Mat3N<double>& D_B_in, const Actuators& actuators)
    : J_B(J_B_in), J_B_inverse(J_B_in.inverse()), J_total_B(J_B_in), D_B(D_B_in) {
  const bool symmetric = (J_B - J_B.transpose()).norm() <= 1e-12 * J_B.norm();  // rounding of what the caller computed
  if (!J_B.allFinite() || !symmetric || Eigen::LLT<Mat3<double>>(J_B).info() != Eigen::Success) {
    throw std::invalid_argument(
        "body: the inertia (less the wheels' axial inertia) must be symmetric and positive definite");
  }
  const int n = actuators.size();
  if (D_B.cols() != n || !D_B.allFinite()) {
    throw std::invalid_argument("body: D_B must be finite with one column for each of the " + std::to_string(n) +
                                " actuators");
  }
  int wheels = 0;
  for (int i = 0; i < n; ++i) {
    if (!actuators.is_wheel(i)) continue;
    ++wheels;
    const Vec3<double> g = D_B.col(i);
    const double inertia = actuators.wheel_inertia[i];
    J_total_B += inertia * g * g.transpose();
    if (actuators.viscous_friction[i] > 0 || actuators.coulomb_friction[i] > 0) {
      friction_wheels.push_back({i, g, inertia, actuators.viscous_friction[i]});
    }
  }
  friction_rate = relaxation(friction_wheels, J_B_inverse);
  kind = wheels == 0 ? Kind::torquers : (wheels == n ? Kind::wheels : Kind::mixed);
}

}  // namespace gyrostat::truth
