// SPDX-License-Identifier: MIT
/// @file  Attitude: quaternion, modified Rodrigues parameters (MRP), Euler 3-2-1 and direction cosines.
///
/// One attitude of B relative to N has
///   q_NB      v_N = q_NB * v_B,  q_NB' = 1/2 q_NB (0, omega_BN_B)
///   sigma_BN  = n tan(phi/4) = vec(q_NB) / (1 + w(q_NB))
///   C_BN      v_B = C_BN v_N, the transpose of Eigen's q_NB.toRotationMatrix(); C_BN' = -[omega_BN_B x] C_BN
///   angles    roll phi, pitch theta, yaw psi: C_BN = R1(phi) R2(theta) R3(psi)
///
/// Length and edges, one rule: a quaternion of any length but zero stands for its direction. What comes out is of the
/// same attitude and accurate to rounding also beside a full turn, half a turn and gimbal lock; on a singularity it is
/// the nearest description that exists. NaN, infinity and the zero quaternion describe no attitude: they give NaN.
/// Page: docs/conventions.md
#pragma once
#include <cmath>
#include <limits>

#include "gyrostat/core/types.hpp"

namespace gyrostat {

/// [a x], so that cross_matrix(a) * b = a x b.
template <class S>
Mat3<S> cross_matrix(const Vec3<S>& a) noexcept {
  Mat3<S> m;
  m << S(0), -a[2], a[1], a[2], S(0), -a[0], -a[1], a[0], S(0);
  return m;
}

namespace detail {

/// |v|^2 is a number that has not lost digits to the ends of the range.
template <class S>
bool in_range(S squared_norm) noexcept {
  constexpr S least = std::numeric_limits<S>::min() / std::numeric_limits<S>::epsilon();
  return squared_norm >= least && squared_norm <= std::numeric_limits<S>::max();
}

/// |v|, also where its square is beyond the range of numbers.
template <class V>
typename V::Scalar length(const V& v) noexcept {
  const typename V::Scalar squared = v.squaredNorm();
  if (in_range(squared)) return std::sqrt(squared);
  const typename V::Scalar scale = v.cwiseAbs().maxCoeff();
  return scale > typename V::Scalar(0) ? scale * V(v / scale).norm() : v.norm();
}

}  // namespace detail

// ---- quaternion ---------------------------------------------------------------------------------------------------

/// q / |q|; where |q| is 1 to rounding, q itself, bit for bit. NaN for the zero quaternion.
template <class S>
Quat<S> unit(const Quat<S>& q) noexcept {
  constexpr S rounding = S(16) * std::numeric_limits<S>::epsilon();  // a product of two, each of them measured
  if (std::abs(q.squaredNorm() - S(1)) <= rounding) return q;
  using Coefficients = Eigen::Matrix<S, 4, 1>;
  const Coefficients scaled = q.coeffs() / q.coeffs().cwiseAbs().maxCoeff();
  return Quat<S>(Coefficients(scaled / scaled.norm()));
}

/// Rotation by the vector phi = angle * axis. Exact to rounding at any angle, zero included.
template <class S>
Quat<S> quat_exp(const Vec3<S>& phi) noexcept {
  const S half = detail::length(phi) / S(2);
  const S k = half < S(1e-4) ? S(0.5) - half * half / S(12)
                             : std::sin(half) / (S(2) * half);  // sin(x)/(2x); next term x^4/240 is below rounding
  return {std::cos(half), k * phi[0], k * phi[1], k * phi[2]};
}

/// Rotation vector of q, angle in [0, pi].
template <class S>
Vec3<S> quat_log(const Quat<S>& q_any) noexcept {
  const Quat<S> q = unit(q_any);
  const S short_way = q.w() < S(0) ? S(-1) : S(1);
  const Vec3<S> v = short_way * q.vec();
  const S n = v.norm();
  const S k = n < S(1e-6) ? S(2) + n * n / S(3) : S(2) * std::atan2(n, short_way * q.w()) / n;
  return k * v;
}

/// q_NB' for a body rate, with w' = -1/2 v.omega, v' = 1/2 (w omega + v x omega). Linear in q_NB, whose length it keeps.
/// Coefficients [w, x, y, z] follow Quat.
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
  return unit(q_NB).toRotationMatrix().transpose();
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
  const Quat<S> q_RB = unit(q_NR).conjugate() * unit(q_NB);
  const Vec3<S> omega_RN_B = q_RB.conjugate() * omega_RN_R;
  return {q_RB, omega_BN_B - omega_RN_B, omega_RN_B};
}

/// Angle of the rotation q, in [0, pi]; accurate near zero, where acos is not.
template <class S>
S rotation_angle(const Quat<S>& q_any) noexcept {
  const Quat<S> q = unit(q_any);
  return S(2) * std::atan2(detail::length(Vec3<S>(q.vec())), std::abs(q.w()));
}

// ---- modified Rodrigues parameters --------------------------------------------------------------------------------

/// MRP of q. The sign of q decides which of the two sets comes out: |sigma| <= 1 for w >= 0. A full turn, w = -1, is at
/// infinity in its set: there, and where sigma would overflow, the other set's zero comes out.
template <class S>
Vec3<S> mrp(const Quat<S>& q_any) noexcept {
  const Quat<S> q = unit(q_any);
  if (!(q.w() < S(-0.9))) return q.vec() / (S(1) + q.w());
  const S n = detail::length(Vec3<S>(q.vec()));  // 1 + w = n^2 / (1 - w) without cancellation
  const Vec3<S> sigma = (q.vec() / n) * ((S(1) - q.w()) / n);
  return sigma.allFinite() ? sigma : Vec3<S>(Vec3<S>::Zero());
}

/// q of an MRP; |sigma| > 1 gives w < 0, so the path stays continuous.
template <class S>
Quat<S> quat_from_mrp(const Vec3<S>& sigma) noexcept {
  const S s2 = sigma.squaredNorm();
  if (s2 > std::numeric_limits<S>::max()) {  // sigma / s2 with one factor at a time
    const S n = detail::length(sigma);
    const Vec3<S> v = (sigma / n) * (S(2) / n);
    return {S(-1), v[0], v[1], v[2]};
  }
  const Vec3<S> v = S(2) * sigma / (S(1) + s2);
  return {(S(1) - s2) / (S(1) + s2), v[0], v[1], v[2]};
}

/// The other MRP of the same attitude, -sigma / |sigma|^2. That of zero is at infinity: there, and where it would
/// overflow, zero stays.
template <class S>
Vec3<S> mrp_shadow(const Vec3<S>& sigma) noexcept {
  const S s2 = sigma.squaredNorm();
  if (detail::in_range(s2)) return -sigma / s2;
  if (!sigma.allFinite()) return Vec3<S>::Constant(std::numeric_limits<S>::quiet_NaN());
  const S n = detail::length(sigma);
  const Vec3<S> shadow = -(sigma / n) / n;
  return shadow.allFinite() ? shadow : Vec3<S>(Vec3<S>::Zero());
}

/// G(sigma), with sigma' = G(sigma) omega_BN_B (+ sign of the cross term: body rates). Grows with |sigma|^2, as far as
/// numbers go.
template <class S>
Mat3<S> mrp_rate_matrix(const Vec3<S>& s) noexcept {
  return S(0.25) * ((S(1) - s.squaredNorm()) * Mat3<S>::Identity() + S(2) * cross_matrix(s) + S(2) * s * s.transpose());
}

/// Exact inverse of G(sigma).
template <class S>
Mat3<S> mrp_rate_matrix_inverse(const Vec3<S>& s) noexcept {
  const S k = S(1) + s.squaredNorm();
  if (k * k > std::numeric_limits<S>::max()) {  // all that is left of it so close to a full turn
    const S n = detail::length(s);
    const Vec3<S> axis = s / n;
    return (S(4) / n) * ((S(2) * axis * axis.transpose() - Mat3<S>::Identity()) / n);
  }
  return S(16) / (k * k) * mrp_rate_matrix(s).transpose();
}

/// Time derivative of G(sigma) along sigma'.
template <class S>
Mat3<S> mrp_rate_matrix_rate(const Vec3<S>& s, const Vec3<S>& sdot) noexcept {
  return S(0.25) * (S(-2) * s.dot(sdot) * Mat3<S>::Identity() + S(2) * cross_matrix(sdot) +
                    S(2) * (sdot * s.transpose() + s * sdot.transpose()));
}

// ---- Euler 3-2-1 --------------------------------------------------------------------------------------------------

/// The angle less full turns, in [-pi, pi].
template <class S>
S wrapped(S angle) noexcept {
  return std::remainder(angle, S(6.28318530717958647693));
}

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
  const Quat<S> q = unit(q_NB);
  const Mat3<S> C = dcm(q);
  const S sp = -C(0, 2);
  const S cp = std::hypot(C(1, 2), C(2, 2));
  if (cp > S(0.125)) return {std::atan2(C(1, 2), C(2, 2)), std::atan2(sp, cp), std::atan2(C(0, 1), C(0, 0))};
  // Near the lock these cosines are small differences of large numbers. Sum and difference of the angles are not:
  //   (w - y, x + z) = (cos - sin)(pitch/2) (cos, sin)((yaw + roll)/2)
  //   (w + y, z - x) = (cos + sin)(pitch/2) (cos, sin)((yaw - roll)/2)
  const S sum_cos = q.w() - q.y(), sum_sin = q.x() + q.z(), difference_cos = q.w() + q.y(),
          difference_sin = q.z() - q.x();
  const S minus = std::hypot(sum_cos, sum_sin), plus = std::hypot(difference_cos, difference_sin);
  const S pitch = std::atan2(sp, plus * minus);
  const S locked = S(4) * std::numeric_limits<S>::epsilon();
  if (minus < locked) return {S(-2) * std::atan2(difference_sin, difference_cos), pitch, S(0)};
  if (plus < locked) return {S(2) * std::atan2(sum_sin, sum_cos), pitch, S(0)};
  const S sum = std::atan2(sum_sin, sum_cos), difference = std::atan2(difference_sin, difference_cos);
  return {wrapped(sum - difference), pitch, wrapped(sum + difference)};
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

/// Euler rates of a body rate: E^-1 omega. They grow with 1 / cos(pitch), as far as pitch differs from +-pi/2.
template <class S>
Vec3<S> euler_rates(const Vec3<S>& angles, const Vec3<S>& omega_BN_B) noexcept {
  const S cr = std::cos(angles[0]), sr = std::sin(angles[0]);
  const S cp = std::cos(angles[1]), tp = std::tan(angles[1]);
  const S lift = sr * omega_BN_B[1] + cr * omega_BN_B[2];
  return {omega_BN_B[0] + tp * lift, cr * omega_BN_B[1] - sr * omega_BN_B[2], lift / cp};
}

}  // namespace gyrostat
