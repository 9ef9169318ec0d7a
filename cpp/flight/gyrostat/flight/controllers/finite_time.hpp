// SPDX-License-Identifier: MIT
/// @file  Homogeneous finite-time attitude law with the estimated torque fed forward.
///
///   tau_B = -k1 G(sigma)' sig^beta1(sigma) - k2 sat_beta2(omega) - d_B + feedforward of a moving reference
///
/// Source: Li, Hu, Yang, Postolache 2018, eq. (19)-(20). Page: docs/components/finite_time.md
#pragma once
#include "gyrostat/flight/controllers/parts/nominal_law.hpp"
#include "gyrostat/flight/parts/chart.hpp"

namespace gyrostat {

template <class S>
class FiniteTime {
 public:
  using Scalar = S;
  using Params = typename NominalLaw<S>::Params;
  static constexpr const char* name = "finite_time";
  static constexpr bool axiswise = true;
  static constexpr bool regulates = true;

  static constexpr Estimates uses(const Params&) noexcept { return {.d_B = true}; }

  static Status<S> check(const Setup<S>& setup, const Params& p) noexcept {
    return needs_body_coordinates(setup) && NominalLaw<S>::check(setup, p);
  }

  FiniteTime(Unchecked, const Setup<S>&, const Params& params) noexcept
      : nominal_(params), set_(params.shadow_switch) {}

  [[nodiscard]] Demand<S> start(const Vehicle<S>& vehicle, const Estimate<S>& x, const Detection<S>&,
                                const Reference<S>& ref) noexcept {
    set_.start();
    return demand(vehicle, x, ref);
  }
  [[nodiscard]] Demand<S> step(const Vehicle<S>& vehicle, const Estimate<S>& x, const Detection<S>&,
                               const Reference<S>& ref, const Allocation<S>&) noexcept {
    return demand(vehicle, x, ref);
  }

  void telemetry(auto&& log) const { log("u_nominal", u_nominal_); }

 private:
  Demand<S> demand(const Vehicle<S>& vehicle, const Estimate<S>& x, const Reference<S>& ref) noexcept {
    u_nominal_ = nominal_(track(vehicle, x, ref, set_));
    Demand<S> out;
    out.tau_B = u_nominal_ - x.d_B;
    return out;
  }

  NominalLaw<S> nominal_;
  MrpSwitching<S> set_;
  Vec3<S> u_nominal_ = Vec3<S>::Zero();  ///< N m
};

}  // namespace gyrostat
