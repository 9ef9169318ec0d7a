// SPDX-License-Identifier: MIT
#include "flight/closed_loop.hpp"

namespace gyrostat::test {

Vec3<double> Body::fault_B(const VecN<double>& u) const { return D_B * (effectiveness.cwiseProduct(u) - u); }

void Body::advance(const VecN<double>& u, double h) {
  const Vec3<double> tau = D_B * effectiveness.cwiseProduct(u) + d_B;
  const Mat3<double> J_inv = J_B.inverse();
  using State = Eigen::Matrix<double, 7, 1>;
  const auto rate = [&](const State& x) {
    const Quat<double> q(Eigen::Vector4d(x.head<4>()));
    const Vec3<double> w = x.tail<3>();
    State xdot;
    xdot << quat_rate(q, w).coeffs(), J_inv * (tau - w.cross(J_B * w));
    return xdot;
  };
  State x;
  x << q_NB.coeffs(), omega_BN_B;
  const State k1 = rate(x), k2 = rate(x + h / 2 * k1), k3 = rate(x + h / 2 * k2), k4 = rate(x + h * k3);
  x += h / 6 * (k1 + 2 * k2 + 2 * k3 + k4);
  q_NB = Quat<double>(Eigen::Vector4d(x.head<4>())).normalized();
  omega_BN_B = x.tail<3>();
}

}  // namespace gyrostat::test
