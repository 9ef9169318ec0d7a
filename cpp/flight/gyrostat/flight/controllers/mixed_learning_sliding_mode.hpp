// SPDX-License-Identifier: MIT
/// @file  Linear sliding mode that cancels the observer's torque and learns what is left from the sliding variable.
///
///   s = w_e + delta q
///   tau_B = equivalent - k_lin s - k_sgn sat(s / width) - learnt - d_B
///   learnt[k] = theta3 learnt[k-n] + K3 (sigma3 s[k-n] + sigma4 s[k])
///
/// Source: Wang, Jia, Yu 2023, eq. (27)-(31), tracking and layer added. Page: docs/components/mixed_learning_sliding_mode.md
#pragma once
#include <algorithm>
#include <limits>

#include "gyrostat/flight/controllers/parts/rate_attitude_surface.hpp"
#include "gyrostat/flight/parts/chart.hpp"
#include "gyrostat/flight/parts/mixed_learning.hpp"

namespace gyrostat {

template <class S>
class MixedLearningSlidingMode {
 public:
  using Scalar = S;
  using Surface = TerminalShape<S>;
  static constexpr const char* name = "mixed_learning_sliding_mode";
  static constexpr bool axiswise = true;
  static constexpr bool switching = true;
  static constexpr bool regulates = true;

  struct Params : SurfaceGains<S> {
    Mat3<S> K3;
    S sigma3 = S(0.01);
    S sigma4 = S(0.99);
    S theta3 = S(0.999);
    int delay = 1;
    S clamp;
    bool compensate = true;

    static constexpr void describe(auto& p, auto&& field) {
      constexpr double infinite = std::numeric_limits<double>::infinity();
      SurfaceGains<S>::describe(p, field);
      field(p.K3, Field{"K3", "N m s", -1e9, 1e9, "torque learnt per s"});
      field(p.sigma3, Field{"sigma3", "", -1, 1, "share of s `delay` samples ago"});
      field(p.sigma4, Field{"sigma4", "", 0, 1, "share of the present s"});
      field(p.theta3, Field{"theta3", "", 0, 1, "kept of the torque learnt `delay` samples ago"});
      field(p.delay, Field{"delay", "samples", 1, max_delay, "learning interval"});
      field(p.clamp, Field{"clamp", "N m", 0, infinite, "largest learnt torque, each axis"});
      field(p.compensate, Switch{"compensate", "subtract the observer's d_B"});
    }

    MixedLearningGains<S> learning() const noexcept { return {K3, sigma4, sigma3, theta3, delay, clamp}; }

    /// `SurfaceGains`, but the attitude decays at the frequency f of the linear part. The learning has twice that bandwidth, so that
    /// it does not settle last, keeps 0.999, and is clamped at a tenth of the usable torque: a slew winds it up no further. Neither
    /// doubles where that would exceed `fastest_law`: sampled slowly, with an observer that learns beside it, the loop would swing
    /// through weakened actuators.
    explicit Params(const Setup<S>& setup) noexcept : SurfaceGains<S>(setup) {
      const S f = std::min(S(2) * default_stiffness(setup).frequency, fastest_law(setup));
      this->delta = std::max(this->delta, f);
      K3 = f * f * setup.dt * setup.vehicle.J_B;
      clamp = S(0.1) * usable_torque(setup.vehicle);
    }
  };

  static constexpr Estimates uses(const Params& p) noexcept { return {.d_B = p.compensate}; }

  /// The sampled loop of s must be stable, inside the layer and out of it.
  static Status<S> check(const Setup<S>& setup, const Params& p) noexcept {
    return needs_body_coordinates(setup) &&
           learning_loop_is_stable(setup, Mat3<S>(p.k_lin * Mat3<S>::Identity()), p.slope(), p.learning());
  }

  MixedLearningSlidingMode(Unchecked, const Setup<S>&, const Params& params) noexcept
      : MixedLearningSlidingMode(params, {params.delta}, {}) {}

  /// First sample: nothing learnt before.
  [[nodiscard]] Demand<S> start(const Vehicle<S>& vehicle, const Estimate<S>& x, const Detection<S>&,
                                const Reference<S>& ref) noexcept {
    learning_.reset();
    event_ = x.event;
    return demand(vehicle, x, ref);
  }
  [[nodiscard]] Demand<S> step(const Vehicle<S>& vehicle, const Estimate<S>& x, const Detection<S>&,
                               const Reference<S>& ref, const Allocation<S>&) noexcept {
    return demand(vehicle, x, ref);
  }

  void telemetry(auto&& log) const {
    log("s", s_);
    log("learnt", learning_.learnt());
  }

 protected:
  /// Reaching torque k sig^power(s) of another law with this learning.
  struct PowerReaching {
    S k = S(0);
    S power = S(1);
  };

  MixedLearningSlidingMode(const Params& params, const Surface& surface, const PowerReaching& reaching) noexcept
      : params_(params), surface_(surface), power_reaching_(reaching), learning_(params.learning()) {}

 private:
  Demand<S> demand(const Vehicle<S>& vehicle, const Estimate<S>& x, const Reference<S>& ref) noexcept {
    const typename RateAttitudeSurface<S>::Value at = surface_(vehicle, x, ref);
    s_ = at.s;
    if (x.event == event_) learning_.update(s_);  // a jump of the state teaches nothing
    event_ = x.event;
    Demand<S> out;
    out.tau_B = at.equivalent_B + params_.reaching(s_) - learning_.learnt();
    if (power_reaching_.k > S(0)) out.tau_B -= power_reaching_.k * sig(s_, power_reaching_.power);
    if (params_.compensate) out.tau_B -= x.d_B;
    return out;
  }

  Params params_;
  RateAttitudeSurface<S> surface_;
  PowerReaching power_reaching_;
  MixedLearning<S> learning_;
  Vec3<S> s_ = Vec3<S>::Zero();  ///< rad/s
  std::uint32_t event_ = 0;      ///< of the estimate before
};

}  // namespace gyrostat
