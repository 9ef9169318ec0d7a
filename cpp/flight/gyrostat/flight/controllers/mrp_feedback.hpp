// SPDX-License-Identifier: MIT
/// @file  Proportional-derivative attitude law in modified Rodrigues parameters.
///
///   tau_B = -K sigma_BR - P omega_BR_B + feedforward of a moving reference
///
/// No integral action: a constant disturbance d leaves the offset |sigma| = |d| / K where no observer finds it or `compensate`
/// is off. Page: docs/components/mrp_feedback.md
#pragma once
#include "gyrostat/core/params.hpp"
#include "gyrostat/flight/controllers/parts/tracking.hpp"
#include "gyrostat/flight/parts/chart.hpp"
#include "gyrostat/flight/parts/stiffness.hpp"

namespace gyrostat {

/// Asymptotically stable for every K, P > 0 on a healthy vehicle (V = w'Jw/2 + 2 K ln(1 + sigma'sigma)).
template <class S>
class MrpFeedback {
 public:
  using Scalar = S;
  static constexpr const char* name = "mrp_feedback";
  static constexpr bool axiswise = true;
  static constexpr bool regulates = true;

  struct Params {
    S K;
    S P;
    bool compensate = true;
    S shadow_switch = S(1);

    static constexpr void describe(auto& p, auto&& field) {
      field(p.K, Field{"K", "N m", 1e-9, 1e9, "torque per MRP"});
      field(p.P, Field{"P", "N m s", 1e-9, 1e9, "torque per rate"});
      field(p.compensate, Switch{"compensate", "subtract the observer's d_B"});
      field(p.shadow_switch, shadow_switch_field);
    }

    /// The default stiffness.
    explicit Params(const Setup<S>& setup) noexcept {
      const Stiffness<S> k = default_stiffness(setup);
      K = k.k_sigma;
      P = k.k_omega;
    }
  };

  static constexpr Estimates uses(const Params& p) noexcept { return {.d_B = p.compensate}; }

  /// The sampled damping must be stable about the smallest inertia.
  static Status<S> check(const Setup<S>& setup, const Params& p) noexcept {
    const S J = smallest_inertia(setup.vehicle.J_B);
    return needs_body_coordinates(setup) && Status<S>::require(p.P * setup.dt < S(2) * J, "P * dt", p.P * setup.dt,
                                                               S(2) * J, "<", Status<S>::Code::unstable);
  }

  MrpFeedback(Unchecked, const Setup<S>&, const Params& params) noexcept
      : params_(params), set_(params.shadow_switch) {}

  [[nodiscard]] Demand<S> start(const Vehicle<S>& vehicle, const Estimate<S>& x, const Detection<S>&,
                                const Reference<S>& ref) noexcept {
    set_.start();
    return demand(vehicle, x, ref);
  }
  [[nodiscard]] Demand<S> step(const Vehicle<S>& vehicle, const Estimate<S>& x, const Detection<S>&,
                               const Reference<S>& ref, const Allocation<S>&) noexcept {
    return demand(vehicle, x, ref);
  }

  void telemetry(auto&&) const {}

 private:
  Demand<S> demand(const Vehicle<S>& vehicle, const Estimate<S>& x, const Reference<S>& ref) noexcept {
    const Tracking<S> error = track(vehicle, x, ref, set_);
    Demand<S> out;
    out.tau_B = error.feedforward_B - params_.K * error.sigma_BR - params_.P * error.omega_BR_B;
    if (params_.compensate) out.tau_B -= x.d_B;
    return out;
  }

  Params params_;
  MrpSwitching<S> set_;
};

}  // namespace gyrostat
