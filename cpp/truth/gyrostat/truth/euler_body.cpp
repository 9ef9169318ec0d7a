// SPDX-License-Identifier: MIT
#include "gyrostat/truth/euler_body.hpp"

#include <stdexcept>

#include "gyrostat/core/attitude.hpp"

namespace gyrostat::truth {
namespace {

/// Coordinate rotation about an axis.
Mat3<double> turn(int axis, double angle) noexcept {
  const int i = (axis + 1) % 3, j = (axis + 2) % 3;
  Mat3<double> R = Mat3<double>::Identity();
  R(i, i) = R(j, j) = std::cos(angle);
  R(i, j) = std::sin(angle);
  R(j, i) = -R(i, j);
  return R;
}

/// R' per unit rate: -[e x] R.
Mat3<double> turn_rate(int axis, const Mat3<double>& R) noexcept {
  const Vec3<double> e = Vec3<double>::Unit(axis);
  return -cross_matrix(e) * R;
}

}  // namespace

EulerBody::EulerBody(const Mat3<double>& J_B, double orbit_rate)
    : J_B_(J_B), J_(J_B.diagonal()), orbit_rate_(orbit_rate) {
  const Mat3<double> rest = J_B - Mat3<double>(J_.asDiagonal());
  if (rest.norm() > 0) throw std::invalid_argument("plant: the Euler-angle model needs a diagonal inertia");
}

Vec3<double> EulerBody::acceleration(const Vec3<double>& angles, const Vec3<double>& rates) const noexcept {
  const double w0 = orbit_rate_;
  const Mat3<double> R1 = turn(0, -angles[0]), R2 = turn(1, -angles[1]), R3 = turn(2, -angles[2]);
  const Vec3<double> n = R1 * R2 * R3.col(1);
  const Vec3<double> ndot = -rates[0] * (turn_rate(0, R1) * R2 * R3.col(1)) -
                            rates[1] * (R1 * turn_rate(1, R2) * R3.col(1)) -
                            rates[2] * (R1 * R2 * turn_rate(2, R3).col(1));
  const Vec3<double> r = turn(0, angles[0]) * turn(1, angles[1]).col(2);
  const Vec3<double> w = rates + w0 * n;
  const Vec3<double> moment = 3 * w0 * w0 * r.cross(J_.cwiseProduct(r)) - w.cross(J_.cwiseProduct(w));
  return moment.cwiseQuotient(J_) - w0 * ndot;
}

}  // namespace gyrostat::truth
