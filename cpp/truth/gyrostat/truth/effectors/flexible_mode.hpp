// SPDX-License-Identifier: MIT
/// @file  A bending mode of an appendage that is clamped to the vehicle, normalised to unit modal mass.
///
///     eta'' + 2 xi omega eta' + omega^2 eta + delta . w' = 0,      J w' + delta eta'' = ... - w x (J w + delta eta' + ...)
///
/// With the modal momentum p = eta' + delta . w no acceleration is left, and a command is no jump for it:
///
///     eta' = p - delta . w,   p' = -2 xi omega eta' - omega^2 eta,   momentum delta p,   the body keeps J - delta delta'
///
/// First order in eta: foreshortening, centrifugal stiffening and the share of eta in J are left out, which asks for rates far
/// below omega. Sources: Likins 1970; Di Gennaro 2003. Page: docs/flexible.md
#pragma once
#include "gyrostat/truth/effectors/effector.hpp"

namespace gyrostat::truth {

struct FlexibleMode {
  static constexpr const char* name = "flexible_mode";
  static constexpr int states = 2;  ///< eta, p
  static constexpr bool along_axis = false;
  static constexpr Storage storage = Storage::inner;
  static constexpr int channel = -1;

  Vec3<double> delta_B = Vec3<double>::Zero();  ///< kg^1/2 m, coupling with the body's rotation
  double omega = 1;                             ///< rad/s, with the body held
  double xi = 0;                                ///< damping ratio
  double eta = 0, eta_rate = 0;                 ///< kg^1/2 m, kg^1/2 m/s, at the start

  Mat3<double> inertia_B() const { return delta_B * delta_B.transpose(); }
  void start(const Scene& s, double* y) const noexcept {
    y[0] = eta;
    y[1] = eta_rate + delta_B.dot(s.omega_BN_B);
  }
  Vec3<double> momentum_B(const Scene&, double, const double* y) const noexcept { return y[1] * delta_B; }
  Vec3<double> momentum_rate_B(const Scene&, double, double, const double*, const double* ydot) const noexcept {
    return ydot[1] * delta_B;
  }
  void rates(const Scene& s, double, const double* y, double* ydot) const noexcept {
    ydot[0] = y[1] - delta_B.dot(s.omega_BN_B);
    ydot[1] = -omega * (2 * xi * ydot[0] + omega * y[0]);
  }
  /// What is seen of its states.
  void show(const Scene& s, double, const double* y, auto& state) const {
    const Eigen::Index mode = state.eta.size();
    state.eta.conservativeResize(mode + 1);
    state.eta_rate.conservativeResize(mode + 1);
    state.eta[mode] = y[0];
    state.eta_rate[mode] = y[1] - delta_B.dot(s.omega_BN_B);
  }
};

/// rad/s, ascending: of the modes on a body that is free to turn, with inertia J (appendages undeformed). Higher than with the
/// body held. Throws std::invalid_argument where the appendages carry more inertia than there is.
std::vector<double> free_frequencies(const Mat3<double>& J_B, const std::vector<FlexibleMode>& modes);

}  // namespace gyrostat::truth
