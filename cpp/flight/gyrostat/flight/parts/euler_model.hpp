// SPDX-License-Identifier: MIT
/// @file  What flight knows of the motion besides its commands, in either kind of coordinates.
///
///   body           J w' = -w x (J w + D h_w) + D u + d_B
///   euler_angles   J chi_b' = J g(chi_a, chi_b) + D u + d_B      (omega_BN_B holds the Euler rates chi_b)
///
/// g is the printed model of a satellite on a circular orbit, axis by axis, with w0 the orbit rate:
///
///   col = [ -s(psi) c(th),  c(ph) c(psi) - s(ph) s(th) s(psi),  c(ph) s(th) s(psi) + s(ph) c(psi) ]
///   w = chi_b + w0 col,   r = [ -s(th), s(ph) c(th), c(ph) c(th) ]
///   g_i = -w0 col_i' + (J_j - J_k) / J_i (w_j w_k - 3 w0^2 r_j r_k),   (i, j, k) cyclic
///
/// Source: Cao, Gong, Xue, Wen 2023, eq. (1), with its misprinted terms after the pattern of the first row.
/// Page: docs/papers/cao2023.md
#pragma once
#include <cmath>

#include "gyrostat/core/attitude.hpp"
#include "gyrostat/core/params.hpp"

namespace gyrostat {

/// g, rad/s^2, of the Euler-angle model; J diagonal.
template <class S>
Vec3<S> euler_model_acceleration(const Vehicle<S>& vehicle, const Vec3<S>& angles, const Vec3<S>& rates) noexcept {
  const S w0 = vehicle.orbit_rate;
  const S sf = std::sin(angles[0]), cf = std::cos(angles[0]), st = std::sin(angles[1]), ct = std::cos(angles[1]);
  const S sp = std::sin(angles[2]), cp = std::cos(angles[2]);
  const S f = rates[0], t = rates[1], p = rates[2];
  const Vec3<S> col(-sp * ct, cf * cp - sf * st * sp, cf * st * sp + sf * cp);
  const Vec3<S> colrate(-cp * ct * p + sp * st * t,
                        -sf * cp * f - cf * sp * p - cf * st * sp * f - sf * ct * sp * t - sf * st * cp * p,
                        -sf * st * sp * f + cf * ct * sp * t + cf * st * cp * p + cf * cp * f - sf * sp * p);
  const Vec3<S> w = rates + w0 * col;
  const Vec3<S> r(-st, sf * ct, cf * ct);
  Vec3<S> g;
  for (int i = 0; i < 3; ++i) {
    const int j = (i + 1) % 3, k = (i + 2) % 3;
    const S ratio = (vehicle.J_B(j, j) - vehicle.J_B(k, k)) / vehicle.J_B(i, i);
    g[i] = ratio * (w[j] * w[k] - S(3) * w0 * w0 * r[j] * r[k]) - w0 * colrate[i];
  }
  return g;
}

/// N m, the part of J w' (of J chi_b') that is known without the commands: -w x (J w + D h_w), or J g.
/// @param angles  read in euler_angles coordinates only
template <class S>
Vec3<S> known_torque(const Vehicle<S>& vehicle, const Vec3<S>& angles, const Vec3<S>& omega_BN_B,
                     const Vec3<S>& h_B) noexcept {
  if (vehicle.coordinates == Coordinates::body) {
    return -omega_BN_B.cross(vehicle.J_B * omega_BN_B + h_B);
  }
  return vehicle.J_B.diagonal().cwiseProduct(euler_model_acceleration(vehicle, angles, omega_BN_B));
}

/// A body's reference with its Euler side filled from attitude, rate and acceleration: angles'' = E^-1 (omega' - E' angles').
/// At pitch +-90 deg there are no rates; they stay as they were.
template <class S>
Reference<S> with_euler(Reference<S> r) noexcept {
  r.euler.angles = euler(r.q_NR);
  if (std::abs(std::cos(r.euler.angles[1])) < S(1e-9)) return r;
  const Mat3<S> E_inv = euler_rate_matrix(r.euler.angles).inverse();
  r.euler.rates = E_inv * r.omega_RN_R;
  r.euler_accelerations =
      E_inv * (r.omegadot_RN_R - euler_rate_matrix_rate(r.euler.angles, r.euler.rates) * r.euler.rates);
  return r;
}

/// The Euler-angle model is one of principal axes and ideal torquers.
template <class S>
Status<S> fits_euler_model(const Setup<S>& setup) noexcept {
  if (setup.vehicle.coordinates == Coordinates::body) return {};
  Mat3<S> rest = setup.vehicle.J_B;
  rest.diagonal().setZero();
  return Status<S>::require(rest.norm() == S(0), "products of inertia in euler_angles coordinates (kg m^2)",
                            rest.norm(), S(0), "=", Status<S>::Code::wrong_chart) &&
         Status<S>::require(!setup.vehicle.wheels.any(), "wheels in euler_angles coordinates (bit mask)",
                            static_cast<S>(setup.vehicle.wheels.bits()), S(0), "=", Status<S>::Code::wrong_chart);
}

}  // namespace gyrostat
