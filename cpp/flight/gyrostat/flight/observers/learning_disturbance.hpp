// SPDX-License-Identifier: MIT
/// @file  Learning disturbance observer: an estimate that is corrected by the error now and by the error one interval ago.
///
///   J what' = known + D u + J (M e + fhat),   e = w - what
///   fhat(t) = k1 fhat(t - Tc) + k2 e(t) + k3 e(t - Tc),   d_B = J fhat
///
/// `known` is the gyroscopic torque, or J g in Euler-angle coordinates (euler_model.hpp). k3 = 0 is the learning observer
/// of Chen and Saif 2007. Source: Cao, Gong, Xue, Wen 2023, eq. (3)-(6). Valid for any bounded lumped acceleration.
/// Page: docs/components/learning_disturbance.md
#pragma once
#include <Eigen/LU>
#include <cmath>

#include "gyrostat/flight/observers/parts/learning_error_loop.hpp"
#include "gyrostat/flight/parts/euler_model.hpp"
#include "gyrostat/flight/parts/stiffness.hpp"

namespace gyrostat {

/// u is the issued command: all of a fault comes out in d_B, the effectiveness stays one.
template <class S>
class LearningDisturbanceObserver {
 public:
  using Scalar = S;
  static constexpr const char* name = "learning_disturbance";
  static constexpr Estimates estimates{.d_B = true};
  static constexpr bool axiswise = true;

  enum class Form : std::uint8_t { held, rolling };
  enum class Start : std::uint8_t { measured, zero };

  struct Params {
    S M;
    S k1 = S(0.98);
    S k2;
    S k3;
    S interval;
    Form form = Form::held;
    Start start = Start::measured;

    static constexpr void describe(auto& p, auto&& field) {
      field(p.M, Field{"M", "1/s", 1e-9, 1e9, "gain of the rate error in the model"});
      field(p.k1, Field{"k1", "", 0, 1, "share of the estimate that is kept from one interval ago"});
      field(p.k2, Field{"k2", "1/s", 0, 1e9, "learning gain of the rate error now"});
      field(p.k3,
            Field{"k3", "1/s", 0, 1e9, "learning gain of the rate error one interval ago; 0: the traditional law"});
      field(p.interval, Field{"interval", "s", 0, 1e6, "learning interval Tc, a whole number of periods"});
      field(p.form, Choice{"form", "held|rolling",
                           "the estimate learns once an interval and is held, or every sample from one interval ago"});
      field(p.start, Choice{"start", "measured|zero", "rate that the observer starts from"});
    }

    /// Held, learning every sample: with M T = 4, k2 T = 1.5, k3 T = 0.5 and T of 10 periods or `observer_periods` a disturbance
    /// is found within 1.5 T, to M (1 - k1) / (M (1 - k1) + k2 + k3) = 3.8 %.
    explicit Params(const Setup<S>& setup) noexcept {
      const S T = observer_periods(setup, S(10)) * setup.dt;
      M = S(4) / T;
      k2 = S(1.5) / T;
      k3 = S(0.5) / T;
      interval = setup.dt;
    }
  };

  /// The interval must be whole and fit the memory, and the sampled recursion must be stable.
  static Status<S> check(const Setup<S>& setup, const Params& p) noexcept {
    const S periods = p.interval / setup.dt;
    const S error = std::abs(periods - std::round(periods));
    const Status<S> whole =
        fits_euler_model(setup) &&
        Status<S>::require(std::round(periods) >= S(1), "interval / dt", periods, S(1), ">=") &&
        Status<S>::require(std::round(periods) <= S(max_delay), "interval / dt", periods, S(max_delay), "<=") &&
        Status<S>::require(error <= S(64) * Eigen::NumTraits<S>::epsilon() * periods,
                           "distance of interval / dt from a whole number", error, S(0), "=") &&
        Status<S>::require(p.k1 < S(1), "k1", p.k1, S(1), "<");
    if (!whole.ok()) return whole;
    const double radius = recursion(setup, p).spectral_radius();
    return Status<S>::require(radius < 1, "spectral radius of the sampled recursion", static_cast<S>(radius), S(1), "<",
                              Status<S>::Code::unstable);
  }

  /// What `check` asks: the recursion of the form that is flown.
  static LearningErrorLoop recursion(const Setup<S>& setup, const Params& p) noexcept {
    const int N = periods(setup, p);
    const bool held = p.form == Form::held;
    return {static_cast<double>(p.M),
            static_cast<double>(p.k1),
            static_cast<double>(p.k2),
            static_cast<double>(p.k3),
            static_cast<double>(setup.dt) * (held ? N : 1),
            held ? 1 : N};
  }

  LearningDisturbanceObserver(Unchecked, const Setup<S>& setup, const Params& params) noexcept
      : dt_(setup.dt),
        params_(params),
        J_inv_(setup.vehicle.J_B.inverse()),
        hold_(params.form == Form::held ? periods(setup, params) : 1),
        decay_(std::exp(-params.M * setup.dt)),
        gain_(-std::expm1(-params.M * setup.dt) / params.M),
        memory_(params.form == Form::held ? 1 : periods(setup, params), Learned{}) {}

  /// First sample: nothing is remembered.
  [[nodiscard]] Estimate<S> start(const Vehicle<S>& vehicle, const Measurement<S>& y) noexcept {
    memory_.fill(Learned{});
    f_hat_.setZero();
    e_ = params_.start == Start::measured ? Vec3<S>(Vec3<S>::Zero()) : y.omega_BN_B;
    age_ = 0;
    remember(vehicle, y);
    learn();
    return estimate(vehicle, y);
  }

  /// Every later sample: e has moved by the exact solution over the interval just ended, for its mean acceleration.
  [[nodiscard]] Estimate<S> step(const Vehicle<S>& vehicle, const Measurement<S>& y,
                                 const Allocation<S>& last) noexcept {
    const Vec3<S> before_B = known_B_, change = y.omega_BN_B - omega_;
    remember(vehicle, y);
    const Vec3<S> explained_B = S(0.5) * (before_B + known_B_) + torque<S>(y.axes.of(vehicle.D_B), last.u);
    e_ = decay_ * e_ + gain_ * (change / dt_ - J_inv_ * explained_B - f_hat_);
    if (++age_ == hold_) {
      age_ = 0;
      learn();
    }
    return estimate(vehicle, y);
  }

  /// Nothing is learned: e stays, and the learning interval waits.
  [[nodiscard]] Estimate<S> skip(const Vehicle<S>& vehicle, const Measurement<S>& y, const Allocation<S>&) noexcept {
    remember(vehicle, y);
    return estimate(vehicle, y);
  }

  /// The measured rate has moved by `step`, rad/s, without motion.
  void shift_rate(const Vec3<S>& step) noexcept { omega_ += step; }

  void telemetry(auto&& log) const {
    log("f_hat", f_hat_);
    log("e", e_);
  }

 private:
  struct Learned {
    Vec3<S> f_hat = Vec3<S>::Zero(), e = Vec3<S>::Zero();
  };

  static int periods(const Setup<S>& setup, const Params& p) noexcept {
    const S N = std::round(p.interval / setup.dt);
    return N >= S(1) ? (N <= S(max_delay) ? static_cast<int>(N) : max_delay) : 1;
  }

  void learn() noexcept {
    const Learned& old = memory_.oldest();
    f_hat_ = params_.k1 * old.f_hat + params_.k2 * e_ + params_.k3 * old.e;
    memory_.push({f_hat_, e_});
  }

  void remember(const Vehicle<S>& vehicle, const Measurement<S>& y) noexcept {
    omega_ = y.omega_BN_B;
    known_B_ = known_torque<S>(vehicle, y.euler.angles, y.omega_BN_B, y.axes.momentum_B(vehicle.D_B, y.h_w));
  }

  Estimate<S> estimate(const Vehicle<S>& vehicle, const Measurement<S>& y) noexcept {
    if (age_ == 0) d_B_ = vehicle.J_B * f_hat_;
    Estimate<S> x = Estimate<S>::healthy(y);
    x.d_B = d_B_;
    return x;
  }

  S dt_;
  Params params_;
  Mat3<S> J_inv_;
  int hold_;        ///< samples from one learning step to the next
  int age_ = 0;     ///< samples since the last one
  S decay_, gain_;  ///< of e over one sample
  DelayLine<Learned> memory_;
  Vec3<S> omega_ = Vec3<S>::Zero();    ///< rad/s, at the previous sample
  Vec3<S> known_B_ = Vec3<S>::Zero();  ///< N m, at the previous sample
  Vec3<S> f_hat_ = Vec3<S>::Zero();    ///< rad/s^2
  Vec3<S> e_ = Vec3<S>::Zero();        ///< rad/s
  Vec3<S> d_B_ = Vec3<S>::Zero();      ///< N m
};

}  // namespace gyrostat
