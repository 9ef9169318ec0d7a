// SPDX-License-Identifier: MIT
/// @file  What the laws on the body share: the attitude error and the feed-forward of a moving reference.
#pragma once
#include "gyrostat/core/attitude.hpp"
#include "gyrostat/core/signals.hpp"
#include "gyrostat/flight/controllers/parts/mrp_switching.hpp"

namespace gyrostat {

/// Error of the body against the reference, and the torque that the motion of the reference itself needs.
template <class S>
struct Tracking {
  Vec3<S> sigma_BR;       ///< MRP of the error, of the short way (|sigma| <= 1) or of the set that the law follows
  Vec3<S> omega_BR_B;     ///< rad/s
  Vec3<S> feedforward_B;  ///< N m, zero for a reference at rest
  Vec3<S> momentum_B;     ///< N m s, J w + D h_w

  /// N m, keeps the rate error as it is where nothing disturbs: feed-forward and gyroscopic torque.
  Vec3<S> equivalent_B() const noexcept { return feedforward_B + omega_BR_B.cross(momentum_B); }
};

/// With w_r = C_BR omega_RN_R and h = J w + D h_w:
///
///   feedforward = J (C_BR w_R' - w x w_r) + w_r x h
///
/// which leaves J e' = -e x h + (tau - feedforward) + d for the rate error e = w - w_r: the plant at rest again.
/// `set` maps the error quaternion to the one of q and -q whose MRP is used.
template <class S>
Tracking<S> track(const Vehicle<S>& vehicle, const Estimate<S>& x, const Reference<S>& ref,
                  MrpSwitching<S>& set) noexcept {
  const AttitudeError<S> error = attitude_error(x.q_NB, x.omega_BN_B, ref.q_NR, ref.omega_RN_R);
  const Vec3<S> momentum_B = vehicle.J_B * x.omega_BN_B + x.axes.momentum_B(vehicle.D_B, x.h_w);
  const Vec3<S> acceleration_B = error.q_RB.conjugate() * ref.omegadot_RN_R - x.omega_BN_B.cross(error.omega_RN_B);
  return {mrp(set(error.q_RB)), error.omega_BR_B, vehicle.J_B * acceleration_B + error.omega_RN_B.cross(momentum_B),
          momentum_B};
}

/// The short way.
template <class S>
Tracking<S> track(const Vehicle<S>& vehicle, const Estimate<S>& x, const Reference<S>& ref) noexcept {
  MrpSwitching<S> short_way_always(S(1));
  return track(vehicle, x, ref, short_way_always);
}

}  // namespace gyrostat
