// SPDX-License-Identifier: MIT
/// @file  A frame from two directions that move: one body axis along the first, another as near to the second as it goes.
///
///     R = [e1 e2 e3] [a, c3 x a, c3]',   e3 = unit(e1 x s),  e2 = e3 x e1,  c3 = unit(a x c)
///     omega = vee(R' R'),  omegadot = vee(R' R''),  vee(A) = 1/2 (A32 - A23, A13 - A31, A21 - A12)
///
/// e1 and s are unit vectors along the two directions, a and c the body axes for them. Rate and acceleration are exact: every
/// derivative is written out, and what of R' R'' is not omegadot is symmetric.
#pragma once
#include <Eigen/Geometry>

#include "gyrostat/core/signals.hpp"

namespace gyrostat::host {

/// A vector with its first two derivatives, in axes that rest.
struct MovingVector {
  Vec3<double> p = Vec3<double>::Zero(), v = Vec3<double>::Zero(), a = Vec3<double>::Zero();

  MovingVector operator-() const { return {-p, -v, -a}; }
  MovingVector operator-(const MovingVector& o) const { return {p - o.p, v - o.v, a - o.a}; }

  MovingVector cross(const MovingVector& o) const {
    return {p.cross(o.p), v.cross(o.p) + p.cross(o.v), a.cross(o.p) + 2 * v.cross(o.v) + p.cross(o.a)};
  }
  /// Its direction.
  MovingVector unit() const {
    const double n = p.norm();
    MovingVector e;
    e.p = p / n;
    e.v = (v - e.p * e.p.dot(v)) / n;
    e.a = (a - 2 * e.v * e.p.dot(v) - e.p * (e.v.dot(v) + e.p.dot(a))) / n;
    return e;
  }
};

class DirectionFrame {
 public:
  /// @param to_first  body axis that points along the first direction, of any length
  /// @param to_second  body axis that points as near to the second as it goes; not along `to_first`
  DirectionFrame(const Vec3<double>& to_first, const Vec3<double>& to_second) {
    const Vec3<double> a = to_first.normalized(), c3 = a.cross(to_second).normalized();
    axes_ << a, c3.cross(a), c3;
  }

  /// Sine of the angle between the two directions: near zero they name no frame.
  static double apart(const MovingVector& first, const MovingVector& second) {
    return first.p.normalized().cross(second.p.normalized()).norm();
  }

  /// Attitude (of positive scalar part, or zero), rate and acceleration of the frame.
  Reference<double> frame(const MovingVector& first, const MovingVector& second) const {
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

 private:
  static Vec3<double> vee(const Mat3<double>& A) {
    return 0.5 * Vec3<double>(A(2, 1) - A(1, 2), A(0, 2) - A(2, 0), A(1, 0) - A(0, 1));
  }

  Mat3<double> axes_;  ///< columns: axes of the frame of the two directions, in those of the body
};

}  // namespace gyrostat::host
