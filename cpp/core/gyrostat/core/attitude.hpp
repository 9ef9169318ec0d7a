// SPDX-License-Identifier: MIT
/// @file  Attitude: quaternion, modified Rodrigues parameters (MRP), Euler 3-2-1 and direction cosines.
///
/// One attitude of B relative to N has
///   q_NB      v_N = q_NB * v_B,  q_NB' = 1/2 q_NB (0, omega_BN_B)
///   sigma_BN  = n tan(phi/4) = vec(q_NB) / (1 + w(q_NB))
///   C_BN      v_B = C_BN v_N, the transpose of Eigen's q_NB.toRotationMatrix(); C_BN' = -[omega_BN_B x] C_BN
///   angles    roll phi, pitch theta, yaw psi: C_BN = R1(phi) R2(theta) R3(psi)
/// Page: docs/conventions.md
#pragma once
#include <cmath>

#include "gyrostat/core/types.hpp"

namespace gyrostat {

/// [a x], so that cross_matrix(a) * b = a x b.
template <class S>
Mat3<S> cross_matrix(const Vec3<S>& a) noexcept {
  Mat3<S> m;
  m << S(0), -a[2], a[1], a[2], S(0), -a[0], -a[1], a[0], S(0);
  return m;
}

// ---- quaternion ---------------------------------------------------------------------------------------------------

/// Rotation by the vector phi = angle * axis. Exact to rounding at any angle, zero included.
template <class S>
Quat<S> quat_exp(const Vec3<S>& phi) noexcept {
  const S half = phi.norm() / S(2);
  const S k = half < S(1e-4) ? S(0.5) - half * half / S(12)
                             : std::sin(half) / (S(2) * half);  // sin(x)/(2x); next term x^4/240 is below rounding
  return {std::cos(half), k * phi[0], k * phi[1], k * phi[2]};
}

/// Rotation vector of a unit quaternion, angle in [0, pi].
template <class S>
Vec3<S> quat_log(const Quat<S>& q) noexcept {
  const S short_way = q.w() < S(0) ? S(-1) : S(1);
  const Vec3<S> v = short_way * q.vec();
  const S n = v.norm();
  const S k = n < S(1e-6) ? S(2) + n * n / S(3) : S(2) * std::atan2(n, short_way * q.w()) / n;
  return k * v;
}

/// q_NB' for a body rate, with w' = -1/2 v.omega, v' = 1/2 (w omega + v x omega). Coefficients [w, x, y, z] follow Quat.
template <class S>
Quat<S> quat_rate(const Quat<S>& q_NB, const Vec3<S>& omega_BN_B) noexcept {
  const Vec3<S> v = q_NB.vec();
  const Vec3<S> vdot = S(0.5) * (q_NB.w() * omega_BN_B + v.cross(omega_BN_B));
  return {S(-0.5) * v.dot(omega_BN_B), vdot[0], vdot[1], vdot[2]};
}

/// The one of q and -q that has w >= 0: the rotation of at most pi.
template <class S>
Quat<S> short_way(const Quat<S>& q) noexcept {
  return q.w() < S(0) ? Quat<S>(-q.w(), -q.x(), -q.y(), -q.z()) : q;
}

/// C_BN of q_NB.
template <class S>
Mat3<S> dcm(const Quat<S>& q_NB) noexcept {
  return q_NB.toRotationMatrix().transpose();
}

/// Attitude and rate of the body relative to the reference, and the reference's rate in body axes.
template <class S>
struct AttitudeError {
  Quat<S> q_RB;
  Vec3<S> omega_BR_B;
  Vec3<S> omega_RN_B;
};

template <class S>
AttitudeError<S> attitude_error(const Quat<S>& q_NB, const Vec3<S>& omega_BN_B, const Quat<S>& q_NR,
                                const Vec3<S>& omega_RN_R) noexcept {
  const Quat<S> q_RB = q_NR.conjugate() * q_NB;
  const Vec3<S> omega_RN_B = q_RB.conjugate() * omega_RN_R;
  return {q_RB, omega_BN_B - omega_RN_B, omega_RN_B};
}

/// Angle of the rotation q, in [0, pi]; accurate near zero, where acos is not.
template <class S>
S rotation_angle(const Quat<S>& q) noexcept {
  return S(2) * std::atan2(q.vec().norm(), std::abs(q.w()));
}

// ---- modified Rodrigues parameters --------------------------------------------------------------------------------

/// MRP of q. The sign of q decides which of the two sets comes out: |sigma| <= 1 for w >= 0.
template <class S>
Vec3<S> mrp(const Quat<S>& q) noexcept {
  return q.vec() / (S(1) + q.w());
}

/// q of an MRP; |sigma| > 1 gives w < 0, so the path stays continuous.
template <class S>
Quat<S> quat_from_mrp(const Vec3<S>& sigma) noexcept {
  const S s2 = sigma.squaredNorm();
  const Vec3<S> v = S(2) * sigma / (S(1) + s2);
  return {(S(1) - s2) / (S(1) + s2), v[0], v[1], v[2]};
}

/// The other MRP of the same attitude. Not defined at zero.
template <class S>
Vec3<S> mrp_shadow(const Vec3<S>& sigma) noexcept {
  return -sigma / sigma.squaredNorm();
}

/// G(sigma), with sigma' = G(sigma) omega_BN_B (+ sign of the cross term: body rates).
template <class S>
Mat3<S> mrp_rate_matrix(const Vec3<S>& s) noexcept {
  return S(0.25) * ((S(1) - s.squaredNorm()) * Mat3<S>::Identity() + S(2) * cross_matrix(s) + S(2) * s * s.transpose());
}

/// Exact inverse of G(sigma).
template <class S>
Mat3<S> mrp_rate_matrix_inverse(const Vec3<S>& s) noexcept {
  const S k = S(1) + s.squaredNorm();
  return S(16) / (k * k) * mrp_rate_matrix(s).transpose();
}

/// Time derivative of G(sigma) along sigma'.
template <class S>
Mat3<S> mrp_rate_matrix_rate(const Vec3<S>& s, const Vec3<S>& sdot) noexcept {
  return S(0.25) * (S(-2) * s.dot(sdot) * Mat3<S>::Identity() + S(2) * cross_matrix(sdot) +
                    S(2) * (sdot * s.transpose() + s * sdot.transpose()));
}

// ---- Euler 3-2-1 --------------------------------------------------------------------------------------------------

/// q_NB of roll, pitch, yaw.
template <class S>
Quat<S> quat_from_euler(const Vec3<S>& angles) noexcept {
  const S cr = std::cos(angles[0] / 2), sr = std::sin(angles[0] / 2);
  const S cp = std::cos(angles[1] / 2), sp = std::sin(angles[1] / 2);
  const S cy = std::cos(angles[2] / 2), sy = std::sin(angles[2] / 2);
  return {cy * cp * cr + sy * sp * sr, cy * cp * sr - sy * sp * cr, cy * sp * cr + sy * cp * sr,
          sy * cp * cr - cy * sp * sr};
}

/// Roll, pitch, yaw of q_NB; pitch in [-pi/2, pi/2]. At pitch +-pi/2 only roll -+ yaw is defined and roll takes it all.
template <class S>
Vec3<S> euler(const Quat<S>& q_NB) noexcept {
  const Mat3<S> C = dcm(q_NB);
  const S sp = -C(0, 2);
  const S cp = std::hypot(C(1, 2), C(2, 2));
  if (cp < Eigen::NumTraits<S>::epsilon() * S(8)) {
    return {std::atan2(sp < S(0) ? -C(1, 0) : C(1, 0), C(1, 1)), std::atan2(sp, cp), S(0)};
  }
  return {std::atan2(C(1, 2), C(2, 2)), std::atan2(sp, cp), std::atan2(C(0, 1), C(0, 0))};
}

/// E(angles), with omega_BN_B = E angles'. det E = cos(pitch).
template <class S>
Mat3<S> euler_rate_matrix(const Vec3<S>& angles) noexcept {
  const S cr = std::cos(angles[0]), sr = std::sin(angles[0]);
  const S cp = std::cos(angles[1]), sp = std::sin(angles[1]);
  Mat3<S> E;
  E << S(1), S(0), -sp, S(0), cr, cp * sr, S(0), -sr, cp * cr;
  return E;
}

/// E' along the Euler rates.
template <class S>
Mat3<S> euler_rate_matrix_rate(const Vec3<S>& angles, const Vec3<S>& rates) noexcept {
  const S cr = std::cos(angles[0]), sr = std::sin(angles[0]);
  const S cp = std::cos(angles[1]), sp = std::sin(angles[1]);
  const S r = rates[0], p = rates[1];
  Mat3<S> E;
  E << S(0), S(0), -cp * p, S(0), -sr * r, cp * cr * r - sp * sr * p, S(0), -cr * r, -cp * sr * r - sp * cr * p;
  return E;
}

/// The angle less full turns, in [-pi, pi].
template <class S>
S wrapped(S angle) noexcept {
  return std::remainder(angle, S(6.28318530717958647693));
}

/// Euler rates of a body rate: E^-1 omega. Infinite at pitch +-pi/2.
template <class S>
Vec3<S> euler_rates(const Vec3<S>& angles, const Vec3<S>& omega_BN_B) noexcept {
  const S cr = std::cos(angles[0]), sr = std::sin(angles[0]);
  const S cp = std::cos(angles[1]), tp = std::tan(angles[1]);
  const S lift = sr * omega_BN_B[1] + cr * omega_BN_B[2];
  return {omega_BN_B[0] + tp * lift, cr * omega_BN_B[1] - sr * omega_BN_B[2], lift / cp};
}

}  // namespace gyrostat
