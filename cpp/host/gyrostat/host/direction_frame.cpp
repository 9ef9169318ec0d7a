// SPDX-License-Identifier: MIT
#include "gyrostat/host/direction_frame.hpp"

#include <Eigen/Geometry>

namespace gyrostat::host {
namespace {

Vec3<double> vee(const Mat3<double>& A) {
  return 0.5 * Vec3<double>(A(2, 1) - A(1, 2), A(0, 2) - A(2, 0), A(1, 0) - A(0, 1));
}

}  // namespace

MovingVector MovingVector::operator-() const { return {-p, -v, -a}; }

MovingVector MovingVector::operator-(const MovingVector& o) const { return {p - o.p, v - o.v, a - o.a}; }

MovingVector MovingVector::cross(const MovingVector& o) const {
  return {p.cross(o.p), v.cross(o.p) + p.cross(o.v), a.cross(o.p) + 2 * v.cross(o.v) + p.cross(o.a)};
}

MovingVector MovingVector::unit() const {
  const double n = p.norm();
  MovingVector e;
  e.p = p / n;
  e.v = (v - e.p * e.p.dot(v)) / n;
  e.a = (a - 2 * e.v * e.p.dot(v) - e.p * (e.v.dot(v) + e.p.dot(a))) / n;
  return e;
}

DirectionFrame::DirectionFrame(const Vec3<double>& to_first, const Vec3<double>& to_second) {
  const Vec3<double> a = to_first.normalized(), c3 = a.cross(to_second).normalized();
  axes_ << a, c3.cross(a), c3;
}

double DirectionFrame::apart(const MovingVector& first, const MovingVector& second) {
  return first.p.normalized().cross(second.p.normalized()).norm();
}

Reference<double> DirectionFrame::frame(const MovingVector& first, const MovingVector& second) const {
  const MovingVector e1 = first.unit(), e3 = e1.cross(second.unit()).unit(), e2 = e3.cross(e1);
  const auto matrix = [this](const Vec3<double>& x, const Vec3<double>& y, const Vec3<double>& z) {
    Mat3<double> m;
    m << x, y, z;
    return Mat3<double>(m * axes_.transpose());
  };
  const Mat3<double> R = matrix(e1.p, e2.p, e3.p);
  Reference<double> r;
  r.q_NR = Quat<double>(R).normalized();
  if (r.q_NR.w() < 0) r.q_NR.coeffs() = -r.q_NR.coeffs();
  r.omega_RN_R = vee(R.transpose() * matrix(e1.v, e2.v, e3.v));
  r.omegadot_RN_R = vee(R.transpose() * matrix(e1.a, e2.a, e3.a));
  return r;
}

}  // namespace gyrostat::host
