// SPDX-License-Identifier: MIT
/// @file  The other plant: the Euler-angle model that a family of publications prints for a satellite on a circular orbit.
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
#include "gyrostat/truth/held_plant.hpp"

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

class EulerPlant final : public HeldPlant {
 public:
  /// `initial.euler` instead of the quaternion; `omega_BN_B` are Euler rates, here and in everything that is seen of it.
  /// @throws std::invalid_argument with one line that says what does not fit: products of inertia, or a wheel
  EulerPlant(PlantModel model, const InitialState& initial, double dt);

  /// The gyro shows the Euler rates, the attitude sensor's error adds to the angles.
  Measurement<double> measure(Sensors& sensors) const;
  TruthSample sample() const;
  EulerState<double> euler() const noexcept { return {state_.angles, state_.omega_BN_B}; }
  /// Angles are states.
  static Vec3<double> angle_difference(const Vec3<double>& a, const Vec3<double>& b) noexcept { return a - b; }

 private:
  double fly_piece(double t1) override;
  void publish() override;

  EulerBody body_;
};

}  // namespace gyrostat::truth
