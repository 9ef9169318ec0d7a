// SPDX-License-Identifier: MIT
/// @file  Iterative learning observer of actuator effectiveness with constant gains.
///
/// Source: the baseline of Yang, Yang, Ji, Ma 2023 (their [6], [9]): eq. (4) without adaptation and without k2.
/// Page: docs/components/iterative_learning.md
#pragma once
#include "gyrostat/flight/observers/parts/iterative_learning_loop.hpp"
#include "gyrostat/flight/parts/chart.hpp"

namespace gyrostat {

/// With k3 = 1, k5 = 0 the error loop is s^2 + k1 s + k4 / dt; k1 = k4 = 1 / dt is dead beat.
template <class S>
class IterativeLearningObserver {
 public:
  using Scalar = S;
  static constexpr const char* name = "iterative_learning";
  static constexpr Estimates estimates{.d_B = true, .effectiveness = true};
  static constexpr bool axiswise = true;
  static constexpr bool switching = true;  ///< an actuator crosses its gate

  struct Params : IterativeLearningParams<S> {
    S k1;
    S k4;

    static constexpr void describe(auto& p, auto&& field) {
      field(p.k1, Field{"k1", "1/s", 0, 1e9, "gain of the rate error in the rate observer"});
      field(p.k4, Field{"k4", "1/s", 0, 1e9, "learning gain"});
      IterativeLearningParams<S>::describe(p, field);
    }
    /// Natural frequency 0.1 / dt, critically damped.
    explicit Params(const Setup<S>& setup) noexcept : IterativeLearningParams<S>(setup) {
      k1 = S(0.2) / setup.dt;
      k4 = S(0.01) / setup.dt;
    }
  };

  static constexpr S effectiveness_floor(const Params& p) noexcept { return p.e_min; }

  static Status<S> check(const Setup<S>& setup, const Params& p) noexcept {
    const bool stable = effectiveness_loop_is_stable(setup.dt, p.k1, p.k3, p.k4, p.k5, p.delay);
    return needs_body_coordinates(setup) &&
           Status<S>::require(stable, "learning loop (k1, k3, k4, k5, delay): roots inside the unit circle",
                              static_cast<S>(stable), S(1), "=", Status<S>::Code::unstable);
  }

  IterativeLearningObserver(Unchecked, const Setup<S>& setup, const Params& params) noexcept
      : learning_(setup, params), gains_{params.k1, S(0), params.k4} {}

  [[nodiscard]] Estimate<S> start(const Vehicle<S>& vehicle, const Measurement<S>& y) noexcept {
    learning_.start(vehicle, y);
    return learning_.estimate(vehicle, y);
  }
  [[nodiscard]] Estimate<S> step(const Vehicle<S>& vehicle, const Measurement<S>& y,
                                 const Allocation<S>& last) noexcept {
    learning_.observe(vehicle, y, last, gains_, S(1));
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

  void telemetry(auto&& log) const { log("error", learning_.error()); }

 private:
  IterativeLearningLoop<S> learning_;
  LearningGains<S> gains_;
};

}  // namespace gyrostat
