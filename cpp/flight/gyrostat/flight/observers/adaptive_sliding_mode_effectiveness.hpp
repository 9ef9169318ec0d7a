// SPDX-License-Identifier: MIT
/// @file  Adaptive sliding-mode observer of actuator effectiveness: gradient adaptation beside a switching correction.
///
///   J what' = -what x (J what + D h_w) + D diag(u) e + L w~ + rho sgn(w~),   w~ = w - what
///   rho'    = k_rho |w~| where |w~| > dead_zone, at most rho_max;   e' = Proj[ gamma diag(u) D' w~ ] onto [0, 1.15]
///   issued: clipped to [e_min, 1], the rest in d_B
///
/// The standard form; it stands in for the observer that Cao, Gong, Han 2022 compare with and give no equations of.
/// Page: docs/components/adaptive_sliding_mode_effectiveness.md
#pragma once
#include <algorithm>
#include <cmath>

#include "gyrostat/core/params.hpp"
#include "gyrostat/core/power.hpp"
#include "gyrostat/flight/observers/parts/issued_effectiveness.hpp"
#include "gyrostat/flight/observers/parts/rate_predictor.hpp"
#include "gyrostat/flight/parts/chart.hpp"
#include "gyrostat/flight/parts/effectiveness_floor.hpp"
#include "gyrostat/flight/parts/stiffness.hpp"

namespace gyrostat {

template <class S>
class AdaptiveSlidingModeEffectivenessObserver {
 public:
  using Scalar = S;
  static constexpr const char* name = "adaptive_sliding_mode_effectiveness";
  static constexpr Estimates estimates{.d_B = true, .effectiveness = true};
  static constexpr bool axiswise = true;
  static constexpr bool switching = true;

  struct Params {
    S gamma;
    Vec3<S> L;
    S k_rho;
    S rho_max;
    S dead_zone;
    S e_min = default_effectiveness_floor<S>;
    bool hand_on = true;

    static constexpr void describe(auto& p, auto&& field) {
      field(p.gamma, Field{"gamma", "1/(N m rad)", 0, 1e12, "rate of adaptation"});
      field(p.L, Field{"L", "N m s", 0, 1e9, "correction of the predicted rate"});
      field(p.k_rho, Field{"k_rho", "N m/rad", 0, 1e9, "rate of the switching gain"});
      field(p.rho_max, Field{"rho_max", "N m", 0, 1e9, "largest switching gain"});
      field(p.dead_zone, Field{"dead_zone", "rad/s", 0, 1e3, "rate errors up to this leave the switching gain alone"});
      field(p.e_min, Field{"e_min", "", 0, 1,
                           "smallest estimate; no less than the e_min of the allocator, or it would stay there"});
      field(p.hand_on, Switch{"hand_on", "what the issued effectiveness leaves over goes into d_B; false: it is lost"});
    }

    /// L makes the rate error forget a tenth a period; gamma gives e the time constant of a hundred periods under a third of
    /// the usable torque; the switching gain is a percent of it.
    explicit Params(const Setup<S>& setup) noexcept {
      const S a = usable_torque(setup.vehicle), J = smallest_inertia(setup.vehicle.J_B);
      L.setConstant(S(0.1) * J / setup.dt);
      gamma = S(0.01) / setup.dt * L[0] * S(9) / (a * a);
      rho_max = S(0.01) * a;
      dead_zone = S(0.5) * a * setup.dt / J;
      k_rho = S(1) / setup.dt * rho_max * S(0.01) / dead_zone;
    }
  };

  static constexpr S effectiveness_floor(const Params& p) noexcept { return p.e_min; }

  /// Sampled, an axis with l = L dt / J and g = gamma u^2 dt^2 / J has z^2 - (2 - l - g) z + 1 - l under a steady command and
  /// z^2 - (l - g) z - (1 - l) under one that alternates: inside the unit circle (Jury) for g < 4 - 2 l and for g < 2 l. Held
  /// here to the largest command that flight knows.
  static Status<S> check(const Setup<S>& setup, const Params& p) noexcept {
    const auto unstable = Status<S>::Code::unstable;
    const S least = smallest_inertia(setup.vehicle.J_B), most = largest_inertia(setup.vehicle.J_B);
    S u = S(0);
    for (int i = 0; i < setup.vehicle.actuators(); ++i) {
      if (setup.vehicle.magnetorquers.test(i)) continue;  // in A m^2, and weak beside the others
      const S limit = std::max(setup.vehicle.u_up[i], -setup.vehicle.u_lo[i]);
      u = std::max(u, std::isfinite(limit) ? limit : usable_torque(setup.vehicle));
    }
    const S decay = p.L.maxCoeff() * setup.dt / least;
    const S drive = p.gamma * u * u * setup.dt * setup.dt / least;
    const S damping = S(2) * p.L.minCoeff() * setup.dt / most;
    return needs_body_coordinates(setup) &&
           Status<S>::require(decay < S(1), "L * dt / J", decay, S(1), "<", unstable) &&
           Status<S>::require(drive < damping, "gamma (u_max dt)^2 / J against 2 L dt / J", drive, damping, "<",
                              unstable);
  }

  AdaptiveSlidingModeEffectivenessObserver(Unchecked, const Setup<S>& setup, const Params& params) noexcept
      : dt_(setup.dt), params_(params), predict_(setup) {
    effectiveness_.setOnes(setup.vehicle.actuators());
  }

  [[nodiscard]] Estimate<S> start(const Vehicle<S>& vehicle, const Measurement<S>& y) noexcept {
    predict_.start(vehicle, y);
    rho_.setZero();
    effectiveness_.setOnes();
    return estimate(vehicle, y, VecN<S>::Zero(effectiveness_.size()));
  }

  /// Every later sample: Euler steps; the regressor is the command that acted over the interval just ended.
  [[nodiscard]] Estimate<S> step(const Vehicle<S>& vehicle, const Measurement<S>& y,
                                 const Allocation<S>& last) noexcept {
    const Mat3N<S>& D_B = y.axes.of(vehicle.D_B);
    const Vec3<S>& error = predict_.step(vehicle, y, effectiveness_, last.u);
    for (Eigen::Index i = 0; i < effectiveness_.size(); ++i) {
      const S e = effectiveness_[i] + dt_ * params_.gamma * last.u[i] * D_B.col(i).dot(error);
      effectiveness_[i] =
          params_.hand_on ? std::clamp(e, S(0), S(1) + effectiveness_headroom<S>) : std::clamp(e, params_.e_min, S(1));
    }
    for (int a = 0; a < 3; ++a) {
      const S size = std::abs(error[a]);
      if (size > params_.dead_zone) rho_[a] = std::min(rho_[a] + dt_ * params_.k_rho * size, params_.rho_max);
    }
    predict_.correct(params_.L.cwiseProduct(error) + rho_.cwiseProduct(sgn(error)));
    return estimate(vehicle, y, last.u);
  }

  /// Nothing is learned.
  [[nodiscard]] Estimate<S> skip(const Vehicle<S>& vehicle, const Measurement<S>& y,
                                 const Allocation<S>& last) noexcept {
    predict_.skip(vehicle, y);
    return estimate(vehicle, y, last.u);
  }

  /// The measured rate has moved by `step`, rad/s, without motion.
  void shift_rate(const Vec3<S>& step) noexcept { predict_.shift_rate(step); }

  void telemetry(auto&& log) const {
    log("rate_error", predict_.error());
    log("rho", rho_);
  }

 private:
  Estimate<S> estimate(const Vehicle<S>& vehicle, const Measurement<S>& y, const VecN<S>& u) const noexcept {
    Estimate<S> x = Estimate<S>::healthy(y);
    issue_effectiveness<S>(x, effectiveness_, params_.e_min, S(1), y.axes.of(vehicle.D_B), u);
    return x;
  }

  S dt_;
  Params params_;
  RatePredictor<S> predict_;
  VecN<S> effectiveness_;
  Vec3<S> rho_ = Vec3<S>::Zero();  ///< N m
};

}  // namespace gyrostat
