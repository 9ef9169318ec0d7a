// SPDX-License-Identifier: MIT
#include "gyrostat/truth/standstill.hpp"

#include <Eigen/LU>
#include <cmath>

namespace gyrostat::truth {
namespace {

constexpr int most_exchanges = 1000;  // a handful is usual: axial inertias are small beside the body's

/// The direction that a wheel should have, given how the body turns when all others keep theirs.
int right_direction(const StandingWheel& w, const Vec3<double>& omegadot_B) noexcept {
  const double turned = w.axis_B.dot(omegadot_B);
  if (w.direction == 0) {
    const double needed = -w.drive - w.inertia * turned;
    return needed > w.dry ? 1 : (needed < -w.dry ? -1 : 0);
  }
  const double slip = -(w.drive + w.direction * w.dry) - w.inertia * turned;
  const double rounding = 1e-14 * (std::abs(w.drive) + w.dry);
  return w.direction * slip < -rounding ? 0 : w.direction;
}

}  // namespace

void Standstill::settle(const Mat3<double>& J_B, const Vec3<double>& torque_B) noexcept {
  for (int exchanges = 0; exchanges < most_exchanges; ++exchanges) {
    Mat3<double> J = J_B;
    Vec3<double> moment = torque_B;
    for (int i = 0; i < count; ++i) {
      const StandingWheel& w = wheels[static_cast<std::size_t>(i)];
      if (w.direction == 0) {
        J += w.inertia * w.axis_B * w.axis_B.transpose();
      } else {
        moment += (w.drive + w.direction * w.dry) * w.axis_B;
      }
    }
    const Vec3<double> omegadot = J.inverse() * moment;
    bool changed = false;
    for (int i = 0; i < count && !changed; ++i) {
      StandingWheel& w = wheels[static_cast<std::size_t>(i)];
      const int direction = right_direction(w, omegadot);
      changed = direction != w.direction;
      w.direction = direction;
    }
    if (!changed) return;
  }
}

}  // namespace gyrostat::truth
