// SPDX-License-Identifier: MIT
/// @file  Default stiffness and damping of attitude laws, from inertia, torque and period.
#pragma once
#include <cmath>

#include <Eigen/Eigenvalues>

#include "gyrostat/flight/authority.hpp"

namespace gyrostat {

/// Gains of tau = -k_sigma sigma - k_omega omega, for the axis of largest inertia.
template <class S>
struct Stiffness {
  S k_sigma;  ///< N m
  S k_omega;  ///< N m s
};

/// Smallest and largest principal inertia, kg m^2.
template <class S>
S smallest_inertia(const Mat3<S>& J_B) noexcept {
  return Eigen::SelfAdjointEigenSolver<Mat3<S>>(J_B, Eigen::EigenvaluesOnly).eigenvalues()[0];
}
template <class S>
S largest_inertia(const Mat3<S>& J_B) noexcept {
  return Eigen::SelfAdjointEigenSolver<Mat3<S>>(J_B, Eigen::EigenvaluesOnly).eigenvalues()[2];
}

/// Rule: an error of 60 deg (sigma = tan 15 deg) asks for the torque that every direction has, and the damping is
/// critical about the axis of largest inertia Jmax: k_omega = sqrt(k_sigma Jmax), since sigma is a quarter of a small
/// angle. The natural frequency sqrt(k_sigma / (4 Jmax)) stays below 0.05 / dt; where the authority says nothing
/// (unlimited or missing direction) it is 0.2 rad/s.
template <class S>
Stiffness<S> default_stiffness(const Setup<S>& setup) noexcept {
  const S sigma_60deg = S(0.267949192431122706);
  const S J_max = largest_inertia(setup.vehicle.J_B);
  const S authority = torque_authority(setup.vehicle);
  const bool usable = std::isfinite(authority) && authority > S(0);
  const S wanted = usable ? std::sqrt(authority / (sigma_60deg * S(4) * J_max)) : S(0.2);
  const S frequency = std::min(wanted, S(0.05) / setup.dt);
  const S k_sigma = S(4) * J_max * frequency * frequency;
  return {k_sigma, std::sqrt(k_sigma * J_max)};
}

}  // namespace gyrostat
