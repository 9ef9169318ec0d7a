// SPDX-License-Identifier: MIT
/// @file  How much torque a vehicle has, for defaults that scale with it. Called once, at construction.
#pragma once
#include <algorithm>
#include <limits>

#include "gyrostat/flight/parts/served_geometry.hpp"

namespace gyrostat {

/// Some of a vehicle's actuators, at the gain that each of them has, against a torque that others push with.
template <class S>
struct ActuatorsInUse {
  Mask used;
  VecN<S> gain;                       ///< delivered / commanded
  Vec3<S> against = Vec3<S>::Zero();  ///< N m, body

  /// Everything but the spares, healthy.
  static ActuatorsInUse all(const Vehicle<S>& vehicle) noexcept {
    const int n = vehicle.actuators();
    return {Mask::all(n).without(vehicle.spare), VecN<S>::Ones(n), Vec3<S>::Zero()};
  }
};

/// N m along `direction` (unit vector, body) when every actuator in use pushes that way: the support function of the torque set.
template <class S>
S torque_along(const Vehicle<S>& vehicle, const Mat3N<S>& D_B, const Vec3<S>& direction,
               const ActuatorsInUse<S>& in_use) noexcept {
  S sum = S(0);
  for (int i = 0; i < vehicle.actuators(); ++i) {
    const S lever = direction.dot(D_B.col(i)) * in_use.gain[i];
    if (!in_use.used.test(i) || std::abs(lever) <= Eigen::NumTraits<S>::epsilon()) continue;  // 0 * infinity otherwise
    sum += lever * (lever > S(0) ? vehicle.u_up[i] : vehicle.u_lo[i]);
  }
  return sum;
}
template <class S>
S torque_along(const Vehicle<S>& vehicle, const Vec3<S>& direction) noexcept {
  return torque_along(vehicle, vehicle.D_B, direction, ActuatorsInUse<S>::all(vehicle));
}

/// Torque, N m, that the actuators in use can produce in every direction beyond what pushes against them: radius of the largest
/// ball about -`against` in the set { D diag(gain) u : u_lo <= u <= u_up }. Its faces are spanned by pairs of actuator axes.
/// Infinite when flight knows no limit; zero when a direction cannot be produced, or is so weak that allocators drop it by
/// default.
/// @param D_B  axes of the actuators, where they point now
template <class S>
S torque_authority(const Vehicle<S>& vehicle, const Mat3N<S>& D_B, const ActuatorsInUse<S>& in_use) noexcept {
  const int n = vehicle.actuators();
  ServedGeometry<S> geometry(S(0), default_rank_tolerance<S>);
  geometry.update(D_B, in_use.used, in_use.gain);
  if (geometry.rank() < 3) return S(0);
  S radius = std::numeric_limits<S>::infinity();
  bool spans = false;
  for (int i = 0; i < n; ++i) {
    for (int j = i + 1; j < n; ++j) {
      if (!in_use.used.test(i) || !in_use.used.test(j)) continue;
      const Vec3<S> a = D_B.col(i), b = D_B.col(j);
      const Vec3<S> across = a.cross(b);
      if (across.norm() <= S(1e-3) * a.norm() * b.norm()) continue;  // parallel axes span no face
      const Vec3<S> normal = across.normalized();
      const S taken = std::abs(normal.dot(in_use.against));
      radius = std::min({radius, torque_along<S>(vehicle, D_B, normal, in_use) - taken,
                         torque_along<S>(vehicle, D_B, Vec3<S>(-normal), in_use) - taken});
      spans = true;
    }
  }
  return spans ? std::max(radius, S(0)) : S(0);
}
template <class S>
S torque_authority(const Vehicle<S>& vehicle, const ActuatorsInUse<S>& in_use) noexcept {
  return torque_authority(vehicle, vehicle.D_B, in_use);
}
template <class S>
S torque_authority(const Vehicle<S>& vehicle) noexcept {
  return torque_authority(vehicle, ActuatorsInUse<S>::all(vehicle));
}

}  // namespace gyrostat
