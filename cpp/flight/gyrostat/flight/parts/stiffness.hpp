// SPDX-License-Identifier: MIT
/// @file  The scales that default parameters are made of: torque and acceleration at hand, stiffness, damping.
/// Page: docs/components/mrp_feedback.md
#pragma once
#include <Eigen/Eigenvalues>
#include <cmath>

#include "gyrostat/flight/parts/authority.hpp"

namespace gyrostat {

/// Smallest principal inertia, kg m^2.
template <class S>
S smallest_inertia(const Mat3<S>& J_B) noexcept {
  return Eigen::SelfAdjointEigenSolver<Mat3<S>>(J_B, Eigen::EigenvaluesOnly).eigenvalues()[0];
}

/// Largest principal inertia, kg m^2.
template <class S>
S largest_inertia(const Mat3<S>& J_B) noexcept {
  return Eigen::SelfAdjointEigenSolver<Mat3<S>>(J_B, Eigen::EigenvaluesOnly).eigenvalues()[2];
}

/// Torque, N m, that defaults count on: what every direction has. Where that says nothing (no limit known, or a
/// direction missing) 0.04 rad/s^2 about the axis of largest inertia.
template <class S>
S usable_torque(const Vehicle<S>& vehicle) noexcept {
  const S authority = torque_authority(vehicle);
  return std::isfinite(authority) && authority > S(0) ? authority : S(0.04) * largest_inertia(vehicle.J_B);
}

/// rad/s^2 about the axis of largest inertia.
template <class S>
S usable_acceleration(const Vehicle<S>& vehicle) noexcept {
  return usable_torque(vehicle) / largest_inertia(vehicle.J_B);
}

/// Gains of tau = -k_sigma sigma - k_omega omega.
template <class S>
struct Stiffness {
  S k_sigma;    ///< N m
  S k_omega;    ///< N m s
  S frequency;  ///< rad/s, natural frequency sqrt(k_sigma / (4 J)) about the axis of largest inertia
};

/// MRP of the attitude error, 45 deg, at which default laws ask for the usable torque.
template <class S>
inline constexpr S default_full_error = S(0.198912367379658007);  // tan(45 deg / 4)

/// Rate, 1/s, that a default law does not exceed where its slope could be made steeper: the command is held for dt.
template <class S>
S fastest_law(const Setup<S>& setup) noexcept {
  return S(0.05) / setup.dt;
}

/// Rule: at an error of 45 deg the law asks for the usable torque, and the damping is 0.8 of critical about the axis of
/// largest inertia J, k_omega = 0.8 sqrt(k_sigma J), since sigma is a quarter of a small angle. The natural frequency
/// stays below 0.05 / dt. With one of four wheels at 40 % this leaves margin for the offset of a constant disturbance.
template <class S>
Stiffness<S> default_stiffness(const Setup<S>& setup) noexcept {
  const S J = largest_inertia(setup.vehicle.J_B);
  const S wanted = std::sqrt(usable_torque(setup.vehicle) / (S(4) * J * default_full_error<S>));
  const S frequency = std::min(wanted, fastest_law(setup));
  const S k_sigma = S(4) * J * frequency * frequency;
  return {k_sigma, S(0.8) * std::sqrt(k_sigma * J), frequency};
}

/// Periods in which a default observer of a torque finds it: `usual`, fewer where that comes near the time in which the default
/// law corrects, 1 / frequency, less about the axis of smallest inertia. An estimate fed back through weakened actuators as
/// slowly as the law corrects makes the two swing against each other (`gyrostat check` has the limit): a twentieth of that time
/// keeps them apart; two periods at least.
template <class S>
S observer_periods(const Setup<S>& setup, S usual) noexcept {
  const S ratio = smallest_inertia(setup.vehicle.J_B) / largest_inertia(setup.vehicle.J_B);
  return std::min(usual, std::max(S(0.05) * ratio / (default_stiffness(setup).frequency * setup.dt), S(2)));
}

}  // namespace gyrostat
