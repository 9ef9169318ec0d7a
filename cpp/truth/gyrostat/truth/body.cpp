// SPDX-License-Identifier: MIT
#include "gyrostat/truth/body.hpp"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <stdexcept>

namespace gyrostat::truth {

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
      friction_wheels.push_back(
          {i, g, inertia, actuators.viscous_friction[i], actuators.coulomb_friction[i], actuators.coulomb_width});
    }
  }
  kind = wheels == 0 ? Kind::torquers : (wheels == n ? Kind::wheels : Kind::mixed);
}

}  // namespace gyrostat::truth
