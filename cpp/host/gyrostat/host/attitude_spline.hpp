// SPDX-License-Identifier: MIT
/// @file  Attitude through rows of a table: between two rows a cubic of the rotation vector from the row before.
///
///     q(t) = q_i quat_exp(p),   p(t_i) = 0,  p'(t_i) = w_i,   p(t_i+1) = L_i,  p'(t_i+1) = Jr(L_i)^-1 w_i+1,   L_i = quat_log(q_i* q_i+1)
///
/// Attitude and rate are continuous and both have closed forms; the acceleration jumps at rows.
#pragma once
#include <cstddef>
#include <vector>

#include "gyrostat/core/signals.hpp"

namespace gyrostat::host {

/// Rate and acceleration, in the axes turned by quat_exp(p), of a rotation vector p in motion.
struct RotationVectorMotion {
  Vec3<double> omega, omegadot;

  /// omega = p' - A p x p' + B p x (p x p'), and its derivative; by series below |p| = 0.05.
  static RotationVectorMotion of(const Vec3<double>& p, const Vec3<double>& v, const Vec3<double>& a);
  /// Derivative of the rotation vector p whose frame turns at w: Jr(p)^-1 w, |p| < 2 pi.
  static Vec3<double> rate_of(const Vec3<double>& p, const Vec3<double>& w);
};

class AttitudeSpline {
 public:
  static constexpr double largest_turn = 2.5;  ///< rad between two rows

  AttitudeSpline() = default;

  /// @param times  s, increasing, at least two
  /// @param rows  attitudes, one a time, of either sign: turned so that neighbours have a positive product
  /// @param rates  rad/s in the axes of each row; empty: of the parabola through a row and its neighbours, L / h at both ends
  AttitudeSpline(std::vector<double> times, std::vector<Quat<double>> rows, std::vector<Vec3<double>> rates);

  /// rad, from row i to the next.
  double turn(std::size_t i) const;

  /// At t, s; at rest before the first row and from the last on. A time within 1e-9 s of a row is at it.
  Reference<double> at(double t) const;

 private:
  double span(std::size_t i) const { return times_[i + 1] - times_[i]; }

  std::vector<double> times_;
  std::vector<Quat<double>> q_;
  std::vector<Vec3<double>> omega_, turns_;  ///< of each row; from it to the next
};

}  // namespace gyrostat::host
