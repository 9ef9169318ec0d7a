// SPDX-License-Identifier: MIT
/// @file  Bounded proportional-derivative attitude law.
///
///   tau_B = -kp sigma_BR - kd ws tanh(omega_BR_B / ws) + feedforward of a moving reference,   |tau_i| <= kp + kd ws at rest
///
/// Source: the canonical bounded law in modified Rodrigues parameters (V = w'Jw/2 + 2 kp ln(1 + sigma'sigma)); it stands in
/// for the baseline that Li et al. 2018 cite without giving it. Page: docs/components/saturated_pd.md
#pragma once
#include "gyrostat/core/params.hpp"
#include "gyrostat/flight/controllers/parts/tracking.hpp"
#include "gyrostat/flight/parts/chart.hpp"
#include "gyrostat/flight/parts/stiffness.hpp"

namespace gyrostat {

/// No integral action; `compensate` takes the observer's torque.
template <class S>
class SaturatedPd {
 public:
  using Scalar = S;
  static constexpr const char* name = "saturated_pd";
  static constexpr bool axiswise = true;
  static constexpr bool regulates = true;

  struct Params {
    S kp;
    S kd;
    S ws;
    bool compensate = true;
    S shadow_switch = S(1);

    static constexpr void describe(auto& p, auto&& field) {
      field(p.kp, Field{"kp", "N m", 1e-9, 1e9, "torque per MRP"});
      field(p.kd, Field{"kd", "N m s", 1e-9, 1e9, "torque per rate, near zero"});
      field(p.ws, Field{"ws", "rad/s", 1e-9, 1e3, "rate at which the damping saturates"});
      field(p.compensate, Switch{"compensate", "subtract the observer's d_B"});
      field(p.shadow_switch, shadow_switch_field);
    }

    /// The default stiffness; the damping saturates at the torque that the attitude can ask for at most, kp.
    explicit Params(const Setup<S>& setup) noexcept {
      const Stiffness<S> k = default_stiffness(setup);
      kp = k.k_sigma;
      kd = k.k_omega;
      ws = k.k_sigma / k.k_omega;
    }
  };

  static constexpr Estimates uses(const Params& p) noexcept { return {.d_B = p.compensate}; }

  /// The sampled damping must be stable about the smallest inertia.
  static Status<S> check(const Setup<S>& setup, const Params& p) noexcept {
    const S J = smallest_inertia(setup.vehicle.J_B);
    return needs_body_coordinates(setup) && Status<S>::require(p.kd * setup.dt < S(2) * J, "kd * dt", p.kd * setup.dt,
                                                               S(2) * J, "<", Status<S>::Code::unstable);
  }

  SaturatedPd(Unchecked, const Setup<S>&, const Params& params) noexcept
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
    Vec3<S> damping;
    for (int i = 0; i < 3; ++i) damping[i] = params_.kd * params_.ws * std::tanh(error.omega_BR_B[i] / params_.ws);
    Demand<S> out;
    out.tau_B = error.feedforward_B - params_.kp * error.sigma_BR - damping;
    if (params_.compensate) out.tau_B -= x.d_B;
    return out;
  }

  Params params_;
  MrpSwitching<S> set_;
};

}  // namespace gyrostat
