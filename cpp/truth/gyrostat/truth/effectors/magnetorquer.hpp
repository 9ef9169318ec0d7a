// SPDX-License-Identifier: MIT
/// @file  Magnetorquers: a dipole along a body axis, which the field turns, torque_B = m axis_B x B_B.
///
/// The dipole is held and the field moves, so what is known exactly is the dipole's impulse P = -integral of m. Integrated is
/// the body's momentum with P axis_B x B_B in it, for which a new command is no jump:
///
///     (P a x B_B)' = -m a x B_B + P a x (C_BN B_N' - w x B_B)
///
/// The first term takes the torque out of the right-hand side, the second is left in it. Page: docs/orbit.md
#pragma once
#include "gyrostat/truth/effectors/effector.hpp"

namespace gyrostat::truth {

struct Magnetorquer {
  static constexpr const char* name = "magnetorquer";
  static constexpr int states = 0;
  static constexpr bool along_axis = false;
  static constexpr Storage storage = Storage::outer;

  int channel = -1;                            ///< its drive in A m^2
  Vec3<double> axis_B = Vec3<double>::Zero();  ///< of the dipole, unit

  Mat3<double> inertia_B() const { return Mat3<double>::Zero(); }
  Vec3<double> momentum_B(const Scene& s, double P, const double*) const noexcept {
    return P * axis_B.cross(s.field_B);
  }
  Vec3<double> torque_B(const Scene& s, double P, const double*) const noexcept {
    return P * axis_B.cross(s.field_rate_B());
  }
  Vec3<double> momentum_rate_B(const Scene& s, double P, double Pdot, const double*, const double*) const noexcept {
    return Pdot * axis_B.cross(s.field_B) + P * axis_B.cross(s.field_rate_B());
  }
  void rates(const Scene&, double, const double*, double*) const noexcept {}
};

}  // namespace gyrostat::truth
