// SPDX-License-Identifier: MIT
/// @file  What terminal sliding laws on the quaternion error share: kinematics, surface, control torque.
///
///   s = w_e + b1 xi + b2 sig^r(xi)
///   tau_B = w x (J w + D h_w) - J w_Delta - J (b1 + b2 sig^r'(xi)) .* xi' - b3 s - b4 sig^r(s) - d_B
///
/// with xi an error of the attitude, elementwise; sig^r has a polynomial core, w_Delta = w_e x C w_d - C w_d'.
/// Source: Yang, Yang, Ji, Ma 2023, eq. (15)-(16), corrected. Page: docs/components/prescribed_performance.md
#pragma once
#include "gyrostat/core/attitude.hpp"
#include "gyrostat/core/power.hpp"
#include "gyrostat/flight/controllers/parts/tracking.hpp"
#include "gyrostat/flight/parts/stiffness.hpp"

namespace gyrostat {

/// The error quaternion in the sign that was chosen, and its vector part's derivative.
template <class S>
struct SlidingError {
  Quat<S> q_RB;        ///< sign as held
  Vec3<S> omega_BR_B;  ///< rad/s
  Vec3<S> qv, qvdot;   ///< vector part, 1/s
};

/// `side` is +1 or -1: which of q and -q the law follows.
template <class S>
SlidingError<S> sliding_error(const Estimate<S>& x, const Reference<S>& ref, S side) noexcept {
  const AttitudeError<S> e = attitude_error(x.q_NB, x.omega_BN_B, ref.q_NR, ref.omega_RN_R);
  const Quat<S> q(side * e.q_RB.w(), side * e.q_RB.x(), side * e.q_RB.y(), side * e.q_RB.z());
  return {q, e.omega_BR_B, q.vec(), quat_rate(q, e.omega_BR_B).vec()};
}

/// The sign that makes the error the short way round.
template <class S>
S short_side(const Estimate<S>& x, const Reference<S>& ref) noexcept {
  return (ref.q_NR.conjugate() * x.q_NB).w() < S(0) ? S(-1) : S(1);
}

/// Gains of the surface and of the reaching law.
template <class S>
struct SlidingGains {
  TerminalShape<S> surface, reaching;
};

/// Surface and torque of one sample.
template <class S>
struct SlidingLaw {
  Vec3<S> s;      ///< rad/s
  Vec3<S> tau_B;  ///< N m
};

/// @param as_printed  the published torque: gyroscopic term with the opposite sign, the motion of the reference left out
template <class S>
SlidingLaw<S> sliding_law(const Vehicle<S>& vehicle, const Estimate<S>& x, const Reference<S>& ref,
                          const SlidingError<S>& error, const SlidingGains<S>& g, const Vec3<S>& xi,
                          const Vec3<S>& xidot, bool as_printed = false) noexcept {
  const Vec3<S> s = g.surface(xi, error.omega_BR_B);
  const Tracking<S> tracking = track(vehicle, x, ref);
  const Vec3<S> model_B = as_printed ? Vec3<S>(-x.omega_BN_B.cross(tracking.momentum_B)) : tracking.equivalent_B();
  return {s, model_B - vehicle.J_B * g.surface.rate(xi, xidot) - g.reaching(s) - x.d_B};
}

}  // namespace gyrostat
