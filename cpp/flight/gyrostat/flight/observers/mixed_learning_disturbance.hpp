// SPDX-License-Identifier: MIT
/// @file  Mixed learning observer: the lumped torque is learnt from the present and a past error of the predicted rate.
///
///   what[k+1] = what + dt J^-1 ( -what x (J what + D h_w) + D u + learnt + K1 e + theta1 sat(e / width) ),   e = w - what
///   learnt[k] = theta2 learnt[k-n] + K2 (sigma1 e[k-n] + sigma2 e[k])
///
/// Source: Wang, Jia, Yu 2023, eq. (5)-(6), with an optional layer and clamp. Page: docs/components/mixed_learning_disturbance.md
#pragma once
#include <Eigen/LU>
#include <limits>

#include "gyrostat/core/params.hpp"
#include "gyrostat/core/power.hpp"
#include "gyrostat/flight/parts/chart.hpp"
#include "gyrostat/flight/parts/mixed_learning.hpp"

namespace gyrostat {

/// u is the issued command, so that a limit of the actuators is not learnt as a fault. All that the nominal model does not
/// explain comes out in d_B; the effectiveness stays one.
template <class S>
class MixedLearningDisturbanceObserver {
 public:
  using Scalar = S;
  static constexpr const char* name = "mixed_learning_disturbance";
  static constexpr Estimates estimates{.d_B = true};
  static constexpr bool axiswise = true;
  static constexpr bool switching = true;  ///< the sign term, when there is one

  enum class Start : std::uint8_t { measured, zero };

  struct Params {
    Mat3<S> K1;
    Mat3<S> K2;
    S sigma1;
    S sigma2;
    S theta1 = S(0);
    S theta2 = S(0.9995);
    S width = S(0);
    int delay = 1;
    S clamp;
    Start start = Start::measured;

    static constexpr void describe(auto& p, auto&& field) {
      constexpr double infinite = std::numeric_limits<double>::infinity();
      field(p.K1, Field{"K1", "N m s", -1e9, 1e9, "gain of the rate error"});
      field(p.K2, Field{"K2", "N m s", -1e9, 1e9, "torque learnt per rate error"});
      field(p.sigma1, Field{"sigma1", "", -1, 1, "share of the error `delay` samples ago; 0: repetitive learning"});
      field(p.sigma2, Field{"sigma2", "", 0, 1, "share of the present error; 0: iterative learning"});
      field(p.theta1, Field{"theta1", "N m", 0, 1e9, "sign term; biases the learnt torque by itself"});
      field(p.theta2, Field{"theta2", "", 0, 1, "kept of the torque learnt `delay` samples ago"});
      field(p.width, Field{"width", "rad/s", 0, 1e9, "boundary layer of the sign term; 0: sign"});
      field(p.delay, Field{"delay", "samples", 1, max_delay, "learning interval"});
      field(p.clamp, Field{"clamp", "N m", 0, infinite, "largest learnt torque, each axis"});
      field(p.start, Choice{"start", "measured|zero", "rate at start: as measured, or zero as printed"});
    }

    MixedLearningGains<S> learning() const noexcept { return {K2, sigma2, sigma1, theta2, delay, clamp}; }
    S slope() const noexcept { return width > S(0) ? theta1 / width : S(0); }

    /// The six design steps with P1 proportional to J J, which gives every axis a double pole at b = 1 / T with T of 33 periods
    /// or `observer_periods`: K2 = b^2 dt J, K1 = 2 b J; theta2 = 0.9995 from eps = 2.5e-4, sigma1 inside its condition. Clamped
    /// at twice the usable torque.
    explicit Params(const Setup<S>& setup) noexcept {
      const Mat3<S>& J = setup.vehicle.J_B;
      const S b = S(1) / (observer_periods(setup, S(33)) * setup.dt);
      K2 = b * b * setup.dt * J;
      K1 = S(2) * b * J;
      // (14) with the unit of rate in which K1 meets (11): sigma1 < Jmin / Jmax sqrt(4 sigma2 / (b dt (1 + 1 / eps + 1)))
      const S ratio = smallest_inertia(J) / largest_inertia(J);
      sigma1 = std::min(S(0.1), S(0.9) * ratio * std::sqrt(S(3.6) / (b * setup.dt * S(4002))));
      sigma2 = S(1) - sigma1;
      clamp = S(2) * usable_torque(setup.vehicle);
    }
  };

  /// The sampled error loop must be stable, inside the layer and out of it.
  static Status<S> check(const Setup<S>& setup, const Params& p) noexcept {
    return needs_body_coordinates(setup) && learning_loop_is_stable(setup, p.K1, p.slope(), p.learning());
  }

  MixedLearningDisturbanceObserver(Unchecked, const Setup<S>& setup, const Params& params) noexcept
      : dt_(setup.dt), params_(params), J_inv_(setup.vehicle.J_B.inverse()), learning_(params.learning()) {}

  /// First sample: the learning starts with the first error, which is zero unless the rate starts at zero.
  [[nodiscard]] Estimate<S> start(const Vehicle<S>& vehicle, const Measurement<S>& y) noexcept {
    learning_.reset();
    omega_hat_ = params_.start == Start::measured ? y.omega_BN_B : Vec3<S>(Vec3<S>::Zero());
    return learn(vehicle, y);
  }

  /// Every later sample: over the interval just ended `last.u` was held.
  [[nodiscard]] Estimate<S> step(const Vehicle<S>& vehicle, const Measurement<S>& y,
                                 const Allocation<S>& last) noexcept {
    const Vec3<S> gyro_B = omega_hat_.cross(vehicle.J_B * omega_hat_ + h_w_B_);
    const Vec3<S> sum = torque<S>(y.axes.of(vehicle.D_B), last.u) - gyro_B + learning_.learnt() + params_.K1 * error_ +
                        params_.theta1 * layer(error_, params_.width);
    omega_hat_ += dt_ * (J_inv_ * sum);
    return learn(vehicle, y);
  }

  /// Nothing is learned: the error stays, the prediction moves with the rate.
  [[nodiscard]] Estimate<S> skip(const Vehicle<S>& vehicle, const Measurement<S>& y, const Allocation<S>&) noexcept {
    omega_hat_ = y.omega_BN_B - error_;
    h_w_B_ = y.axes.momentum_B(vehicle.D_B, y.h_w);
    return estimate(y);
  }

  /// The measured rate has moved by `step`, rad/s, without motion.
  void shift_rate(const Vec3<S>& step) noexcept { omega_hat_ += step; }

  void telemetry(auto&& log) const {
    log("omega_hat", omega_hat_);
    log("error", error_);
    log("learnt", learning_.learnt());
  }

 private:
  Estimate<S> learn(const Vehicle<S>& vehicle, const Measurement<S>& y) noexcept {
    error_ = y.omega_BN_B - omega_hat_;
    h_w_B_ = y.axes.momentum_B(vehicle.D_B, y.h_w);
    learning_.update(error_);
    return estimate(y);
  }

  Estimate<S> estimate(const Measurement<S>& y) const noexcept {
    Estimate<S> x = Estimate<S>::healthy(y);
    x.d_B = learning_.learnt();
    return x;
  }

  S dt_;
  Params params_;
  Mat3<S> J_inv_;
  MixedLearning<S> learning_;
  Vec3<S> omega_hat_ = Vec3<S>::Zero();  ///< rad/s, predicted for this sample
  Vec3<S> error_ = Vec3<S>::Zero();      ///< rad/s
  Vec3<S> h_w_B_ = Vec3<S>::Zero();      ///< N m s, wheels at this sample
};

}  // namespace gyrostat
