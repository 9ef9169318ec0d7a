// SPDX-License-Identifier: MIT
/// @file  Iterative learning observer of actuator effectiveness whose gains follow the rate error.
///
///   |w~| > deadzone:  k1' = mu1 |w~|, k4' = mu4 |w~|;    else k' = -leak (k - k_0)
///   k2' = mu2 |w~| sgn(|w~| - chi) where k2 > k2_0, gamma elsewhere;    0 <= k2 <= k2_max
///
/// Source: Yang, Yang, Ji, Ma 2023, eq. (4)-(5), corrected. Page: docs/components/adaptive_iterative_learning.md
#pragma once
#include <algorithm>

#include "gyrostat/flight/observers/parts/iterative_learning_loop.hpp"
#include "gyrostat/flight/parts/chart.hpp"

namespace gyrostat {

template <class S>
class AdaptiveIterativeLearningObserver {
 public:
  using Scalar = S;
  static constexpr const char* name = "adaptive_iterative_learning";
  static constexpr Estimates estimates{.d_B = true, .effectiveness = true};
  static constexpr bool axiswise = true;
  static constexpr bool switching = true;  ///< gain laws

  struct Params : IterativeLearningParams<S> {
    S k1_0, k1_max, mu1;
    S k4_0, k4_max, mu4;
    S deadzone, leak;
    S k2_0, k2_max, mu2, chi, gamma, layer;

    static constexpr void describe(auto& p, auto&& field) {
      field(p.k1_0, Field{"k1_0", "1/s", 0, 1e9, "gain of the rate error at start and at rest"});
      field(p.k1_max, Field{"k1_max", "1/s", 0, 1e9, "its largest value"});
      field(p.mu1, Field{"mu1", "1/(rad s)", 0, 1e15, "its growth per rate error"});
      field(p.k4_0, Field{"k4_0", "1/s", 0, 1e9, "learning gain at start and at rest"});
      field(p.k4_max, Field{"k4_max", "1/s", 0, 1e9, "its largest value"});
      field(p.mu4, Field{"mu4", "1/(rad s)", 0, 1e15, "its growth per rate error"});
      field(p.deadzone, Field{"deadzone", "rad/s", 0, 1e3, "rate error above which k1 and k4 grow"});
      field(p.leak, Field{"leak", "1/s", 0, 1e9, "how fast they return below it; 0: they hold, as printed"});
      field(p.k2_0, Field{"k2_0", "N m", 0, 1e9, "switching gain at start, and its floor"});
      field(p.k2_max, Field{"k2_max", "N m", 0, 1e9, "its largest value; far below the smallest fault torque"});
      field(p.mu2, Field{"mu2", "N m/rad", 0, 1e15, "its rate per rate error"});
      field(p.chi, Field{"chi", "rad/s", 0, 1e3, "rate error where it turns round"});
      field(p.gamma, Field{"gamma", "N m/s", 0, 1e9, "its growth at the floor"});
      field(p.layer, Field{"layer", "rad/s", 0, 1e3, "boundary layer of the switching term; 0: sign"});
      IterativeLearningParams<S>::describe(p, field);
    }

    /// Natural frequency 0.07 ... 0.2 / dt, critically damped; from one end to the other in 40 samples at the edge of the
    /// dead zone, which is the rate that the usable torque makes in 1.5 samples. k2 stays below a hundredth of that torque.
    explicit Params(const Setup<S>& setup) noexcept : IterativeLearningParams<S>(setup) {
      const S h = setup.dt, a = usable_torque(setup.vehicle);
      k1_0 = S(0.14) / h;
      k1_max = S(0.4) / h;
      k4_0 = S(0.0049) / h;
      k4_max = S(0.04) / h;
      deadzone = S(1.5) * h * a / largest_inertia(setup.vehicle.J_B);
      mu1 = (k1_max - k1_0) / (S(40) * h * deadzone);
      mu4 = (k4_max - k4_0) / (S(40) * h * deadzone);
      leak = S(0.03) / h;
      k2_0 = S(8e-4) * a;
      k2_max = S(8e-3) * a;
      chi = layer = S(1.4) * deadzone;
      mu2 = k2_max / (S(2800) * h * deadzone);
      gamma = k2_max / (S(200) * h);
    }
  };

  static constexpr S effectiveness_floor(const Params& p) noexcept { return p.e_min; }

  /// The error loop must be stable at both ends of the gains; the switching term adds k2 / (layer J) to k1.
  static Status<S> check(const Setup<S>& setup, const Params& p) noexcept {
    const auto unstable = Status<S>::Code::unstable;
    const S extra = p.layer > S(0) ? p.k2_max / (p.layer * smallest_inertia(setup.vehicle.J_B)) : S(0);
    const bool slow = effectiveness_loop_is_stable(setup.dt, p.k1_0, p.k3, p.k4_0, p.k5, p.delay);
    const bool fast = effectiveness_loop_is_stable(setup.dt, p.k1_max + extra, p.k3, p.k4_max, p.k5, p.delay);
    return needs_body_coordinates(setup) && Status<S>::require(p.k1_0 <= p.k1_max, "k1_0", p.k1_0, p.k1_max, "<=") &&
           Status<S>::require(p.k4_0 <= p.k4_max, "k4_0", p.k4_0, p.k4_max, "<=") &&
           Status<S>::require(p.k2_0 <= p.k2_max, "k2_0", p.k2_0, p.k2_max, "<=") &&
           Status<S>::require(slow, "learning loop at k1_0, k4_0: roots inside the unit circle", static_cast<S>(slow),
                              S(1), "=", unstable) &&
           Status<S>::require(fast, "learning loop at k1_max, k4_max: roots inside the unit circle",
                              static_cast<S>(fast), S(1), "=", unstable);
  }

  AdaptiveIterativeLearningObserver(Unchecked, const Setup<S>& setup, const Params& params) noexcept
      : dt_(setup.dt), params_(params), learning_(setup, params), gains_(first()) {}

  [[nodiscard]] Estimate<S> start(const Vehicle<S>& vehicle, const Measurement<S>& y) noexcept {
    gains_ = first();
    learning_.start(vehicle, y);
    return learning_.estimate(vehicle, y);
  }

  /// The rate observer flies with the gains of the sample before, the learning step with the new ones.
  [[nodiscard]] Estimate<S> step(const Vehicle<S>& vehicle, const Measurement<S>& y,
                                 const Allocation<S>& last) noexcept {
    adapt(learning_.observe(vehicle, y, last, gains_, params_.layer));
    learning_.learn(vehicle, y, last, gains_.k4);
    return learning_.estimate(vehicle, y);
  }

  /// Nothing is learned.
  [[nodiscard]] Estimate<S> skip(const Vehicle<S>& vehicle, const Measurement<S>& y,
                                 const Allocation<S>& last) noexcept {
    learning_.skip(y, last);
    return learning_.estimate(vehicle, y);
  }

  /// The measured rate has moved by `step`, rad/s, without motion.
  void shift_rate(const Vec3<S>& step) noexcept { learning_.shift_rate(step); }

  void telemetry(auto&& log) const {
    log("error", learning_.error());
    log("gains", Eigen::Matrix<S, 1, 3>(gains_.k1, gains_.k2, gains_.k4));  // three numbers, no axes
  }

 private:
  LearningGains<S> first() const noexcept { return {params_.k1_0, params_.k2_0, params_.k4_0}; }

  void adapt(S m) noexcept {
    const Params& p = params_;
    if (m > p.deadzone) {
      gains_.k1 += dt_ * p.mu1 * m;
      gains_.k4 += dt_ * p.mu4 * m;
    } else {
      gains_.k1 -= dt_ * p.leak * (gains_.k1 - p.k1_0);
      gains_.k4 -= dt_ * p.leak * (gains_.k4 - p.k4_0);
    }
    gains_.k2 += dt_ * (gains_.k2 > p.k2_0 ? p.mu2 * m * sgn(m - p.chi) : p.gamma);
    gains_.k1 = std::min(gains_.k1, p.k1_max);
    gains_.k4 = std::min(gains_.k4, p.k4_max);
    gains_.k2 = std::clamp(gains_.k2, S(0), p.k2_max);
  }

  S dt_;
  Params params_;
  IterativeLearningLoop<S> learning_;
  LearningGains<S> gains_;
};

}  // namespace gyrostat
