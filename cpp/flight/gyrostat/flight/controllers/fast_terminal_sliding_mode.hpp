// SPDX-License-Identifier: MIT
/// @file  Fast terminal sliding mode on the vector part of the attitude error.
///
///   s = w_e + b1 q_ev + b2 sig^r(q_ev),   tau_B as in controllers/sliding_tracking.hpp
///
/// Source: the baseline of Yang, Yang, Ji, Ma 2023. Page: docs/components/fast_terminal_sliding_mode.md
#pragma once
#include "gyrostat/flight/controllers/parts/sliding_tracking.hpp"
#include "gyrostat/flight/parts/chart.hpp"

namespace gyrostat {

/// Takes the short way that it finds at the start and at every jump of the reference, and keeps to it in between.
template <class S>
class FastTerminalSlidingMode {
 public:
  using Scalar = S;
  static constexpr const char* name = "fast_terminal_sliding_mode";
  static constexpr bool axiswise = true;
  static constexpr bool regulates = true;

  struct Params {
    S b1, b2, r = S(0.6), core = S(0.005);
    S b3, b4, s_core;

    static constexpr void describe(auto& p, auto&& field) {
      field(p.b1, Field{"b1", "rad/s", 0, 1e3, "slope of the surface in the vector part of the error quaternion"});
      field(p.b2, Field{"b2", "rad/s", 0, 1e3, "its terminal part"});
      field(p.r, Field{"r", "", 0.05, 1, "power of the terminal parts"});
      field(p.core, Field{"core", "", 1e-12, 1, "below this the power of the error is a polynomial"});
      field(p.b3, Field{"b3", "N m s", 0, 1e9, "linear gain of s"});
      field(p.b4, Field{"b4", "N m (rad/s)^-r", 0, 1e9, "terminal gain of s"});
      field(p.s_core, Field{"s_core", "rad/s", 1e-12, 1e3, "below this the power of s is a polynomial"});
    }

    /// With w the default natural frequency, a the usable torque: b1 = 1.3 w, b3 closes s at 8 w (0.1 / dt at most), the terminal
    /// part of s asks for 0.03 a at s = w.
    explicit Params(const Setup<S>& setup) noexcept {
      const S w = default_stiffness(setup).frequency;
      b1 = S(1.3) * w;
      b2 = S(0.13) * w;
      b3 = std::min(S(8) * w, S(0.1) / setup.dt) * largest_inertia(setup.vehicle.J_B);
      b4 = S(0.03) * usable_torque(setup.vehicle) / std::pow(w, r);
      s_core = S(0.05) * w;
    }
  };

  static constexpr Estimates uses(const Params&) noexcept { return {.d_B = true}; }

  static Status<S> check(const Setup<S>& setup, const Params& p) noexcept {
    const S J = smallest_inertia(setup.vehicle.J_B);
    const S slope = p.b3 + p.b4 * sig_core_slope(S(0), p.r, p.s_core);
    return needs_body_coordinates(setup) &&
           Status<S>::require(slope * setup.dt < S(2) * J, "(b3 + b4 (2 - r) s_core^(r-1)) * dt", slope * setup.dt,
                              S(2) * J, "<", Status<S>::Code::unstable);
  }

  FastTerminalSlidingMode(Unchecked, const Setup<S>&, const Params& p) noexcept
      : gains_{{p.b1, p.b2, p.r, p.core}, {p.b3, p.b4, p.r, p.s_core}} {}

  [[nodiscard]] Demand<S> start(const Vehicle<S>& vehicle, const Estimate<S>& x, const Detection<S>&,
                                const Reference<S>& ref) noexcept {
    side_ = short_side(x, ref);
    event_ = ref.event;
    return demand(vehicle, x, ref);
  }
  [[nodiscard]] Demand<S> step(const Vehicle<S>& vehicle, const Estimate<S>& x, const Detection<S>&,
                               const Reference<S>& ref, const Allocation<S>&) noexcept {
    if (ref.event != event_) side_ = short_side(x, ref);
    event_ = ref.event;
    return demand(vehicle, x, ref);
  }

  void telemetry(auto&& log) const {
    log("s", s_);
    log("q_error", qv_);
  }

 private:
  Demand<S> demand(const Vehicle<S>& vehicle, const Estimate<S>& x, const Reference<S>& ref) noexcept {
    const SlidingError<S> error = sliding_error(x, ref, side_);
    const SlidingLaw<S> law = sliding_law(vehicle, x, ref, error, gains_, error.qv, error.qvdot);
    s_ = law.s;
    qv_ = error.qv;
    Demand<S> out;
    out.tau_B = law.tau_B;
    return out;
  }

  SlidingGains<S> gains_;
  S side_ = S(1);
  std::uint32_t event_ = 0;
  Vec3<S> s_ = Vec3<S>::Zero(), qv_ = Vec3<S>::Zero();
};

}  // namespace gyrostat
