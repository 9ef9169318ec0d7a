// SPDX-License-Identifier: MIT
/// @file  The other body: the Euler-angle model that a family of publications prints for a satellite on a circular orbit.
///
///     chi_a' = chi_b,   J chi_b' = J g(chi_a, chi_b) + D delivered + d
///
/// chi_a are roll, pitch, yaw against the orbital frame, chi_b their rates, which the model takes for body rates. With
///
///     n(chi_a) = second column of R1(-roll) R2(-pitch) R3(-yaw),   r = R1(roll) R2(pitch) e3,   w = chi_b + w0 n
///     J g = -w0 J n' - w x J w + 3 w0^2 r x J r,   J diagonal
///
/// This is not the dynamics of a body on that orbit (the yaw turn of r cancels, the signs of n are those of -chi_a and the
/// kinematic matrix is missing): it is there to repeat what was published. It has no singular attitude.
///
/// Source: Cao, Gong, Xue, Wen 2023, eq. (1); the terms that are misprinted there follow from the pattern of the first row.
/// State and actuators are those of momentum_form.hpp: y = [ chi_a, 0, H ], H = J chi_b + D p.
#pragma once
#include <cmath>

#include "gyrostat/truth/momentum_form.hpp"

namespace gyrostat::truth {

/// Its parameters: principal moments of inertia and the orbit.
class EulerBody {
 public:
  /// @throws std::invalid_argument unless the inertia is diagonal
  EulerBody(const Mat3<double>& J_B, double orbit_rate);

  /// g, rad/s^2.
  Vec3<double> acceleration(const Vec3<double>& angles, const Vec3<double>& rates) const noexcept;
  const Mat3<double>& J_B() const noexcept { return J_B_; }

 private:
  Mat3<double> J_B_;
  Vec3<double> J_;
  double orbit_rate_;
};

/// All that its right-hand side needs.
struct EulerMotion {
  const EulerBody& euler;
  Motion motion;
};

/// y' of the state y at time t. `varying`: external torque depends on time or state.
template <bool varying>
void euler_derivative(const EulerMotion& m, double t, const double* y, double* ydot) noexcept {
  const Vec3<double> angles{y[0], y[1], y[2]}, H{y[4], y[5], y[6]};
  const Vec3<double> Jw = H - m.motion.held.stored_B(t);
  const Vec3<double> rates = m.motion.held.J_B_inverse * Jw;
  Vec3<double> d_B = m.motion.external.constant_B();
  if constexpr (varying) d_B = m.motion.external.torque_B(t, Quat<double>::Identity(), rates);
  const Vec3<double> Hdot = m.euler.J_B() * m.euler.acceleration(angles, rates) + d_B;
  for (int i = 0; i < 3; ++i) {
    ydot[i] = rates[i];
    ydot[4 + i] = Hdot[i];
  }
  ydot[3] = 0;
}

}  // namespace gyrostat::truth
