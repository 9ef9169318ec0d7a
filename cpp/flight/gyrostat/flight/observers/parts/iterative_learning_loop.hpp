// SPDX-License-Identifier: MIT
/// @file  What the iterative learning observers of actuator effectiveness share: rate observer, learning step, stability.
///
///   J what' = D (e .* u) + J k1 w~ + k2 sat(w~ / layer) - what x (J what + D h_w)        w~ = w - what
///   y = J (k4 w~ + k5 w~(t - T))
///   e = k3 e(t - T) + Phi' (Phi Phi' + reg^2 I)^-1 y,   Phi = D diag(u)
///
/// Source: Yang, Yang, Ji, Ma 2023, eq. (4), with the torques mapped onto the actuators. Valid where the torque of an actuator
/// is large against what disturbs. Page: docs/components/adaptive_iterative_learning.md
#pragma once
#include <Eigen/LU>
#include <array>

#include "gyrostat/core/params.hpp"
#include "gyrostat/core/power.hpp"
#include "gyrostat/flight/observers/parts/issued_effectiveness.hpp"
#include "gyrostat/flight/observers/parts/schur.hpp"
#include "gyrostat/flight/parts/delay_line.hpp"
#include "gyrostat/flight/parts/effectiveness_floor.hpp"
#include "gyrostat/flight/parts/effectiveness_regression.hpp"
#include "gyrostat/flight/parts/stiffness.hpp"

namespace gyrostat {

/// Gains of one sample.
template <class S>
struct LearningGains {
  S k1;  ///< 1/s
  S k2;  ///< N m
  S k4;  ///< 1/s
};

/// Parameters that the learning observers have in common.
template <class S>
struct IterativeLearningParams {
  S k3 = S(1);
  S k5 = S(0);
  int delay = 1;
  S u_gate;
  S u_reg;
  S e_min = default_effectiveness_floor<S>;
  S e_max = S(1);
  S uncertainty = S(0.1);
  Mask frozen;
  bool hand_on = true;

  static constexpr void describe(auto& p, auto&& field) {
    field(p.k3, Field{"k3", "", 0, 1, "memory of the effectiveness; below 1 it leaks and biases"});
    field(p.k5, Field{"k5", "1/s", 0, 1e9, "gain of the rate error one interval ago"});
    field(p.delay, Field{"delay", "samples", 1, max_delay, "learning interval T"});
    field(p.u_gate, Field{"u_gate", "N m", 0, 1e9, "an actuator whose torque is below this keeps its effectiveness"});
    field(p.u_reg, Field{"u_reg", "N m", 1e-12, 1e9, "regularisation of the regressor"});
    field(p.e_min, Field{"e_min", "", 0, 1,
                         "smallest estimate; no less than the e_min of the allocator, or it would stay there"});
    field(p.e_max, Field{"e_max", "", 1, 10, "largest estimate"});
    field(p.uncertainty, Field{"uncertainty", "", 0, 1, "relative half-width claimed for an estimate once excited"});
    field(p.frozen,
          Field{"frozen", "", 0, max_actuators - 1, "actuators held at 1: more than three cannot be told apart"});
    field(p.hand_on, Switch{"hand_on", "what the issued effectiveness leaves over goes into d_B; false: it is lost"});
  }

  /// The gate is a fifth of the usable torque; spares are held at one.
  explicit IterativeLearningParams(const Setup<S>& setup) noexcept : frozen(setup.vehicle.spare) {
    const S a = usable_torque(setup.vehicle);
    u_gate = S(0.2) * a;
    u_reg = S(0.08) * a;
  }
};

/// The error loop of one sampled axis with full excitation,
///
///   w~[k+1] = (1 - h k1) w~[k] + h g[k],   g[k+1] = k3 g[k+1-L] - k4 w~[k+1] - k5 w~[k+1-L]
///   z^(L+1) + (h k4 - 1 + h k1) z^L - k3 z + (1 - h k1) k3 + h k5
///
/// has its roots inside the unit circle.
template <class S>
bool effectiveness_loop_is_stable(S h, S k1, S k3, S k4, S k5, int delay) noexcept {
  std::array<S, max_delay + 2> p{};  // the constant first
  const S a = S(1) - h * k1;
  p[0] = a * k3 + h * k5;
  p[1] += -k3;
  p[static_cast<std::size_t>(delay)] += h * k4 - a;
  p[static_cast<std::size_t>(delay + 1)] = S(1);
  return roots_inside_unit_circle(p, delay + 1);
}

/// Rate observer and learning step; the gains come from outside, once a sample.
template <class S>
class IterativeLearningLoop {
 public:
  using Params = IterativeLearningParams<S>;

  IterativeLearningLoop(const Setup<S>& setup, const Params& params) noexcept
      : dt_(setup.dt),
        params_(params),
        J_inv_(setup.vehicle.J_B.inverse()),
        e_(VecN<S>::Ones(setup.vehicle.actuators())),
        past_e_(params.delay, e_),
        past_error_(params.delay, Vec3<S>::Zero()) {}

  void start(const Vehicle<S>& vehicle, const Measurement<S>& y) noexcept {
    omega_ = y.omega_BN_B;
    h_w_ = y.h_w;
    error_.setZero();
    e_.setOnes();
    u_.setZero(vehicle.actuators());
    seen_ = Mask{};
    past_e_.fill(e_);
    past_error_.fill(error_);
  }

  /// Over an interval that taught nothing: w~ stays, the predicted rate moves with the measured one.
  void skip(const Measurement<S>& y, const Allocation<S>& last) noexcept {
    omega_ = y.omega_BN_B - error_;
    u_ = last.u;
    h_w_ = y.h_w;
  }

  /// The measured rate has moved by `step`, rad/s, without motion.
  void shift_rate(const Vec3<S>& step) noexcept { omega_ += step; }

  /// First half: the rate observer over the interval just ended, by the midpoint rule. Returns |w~|.
  S observe(const Vehicle<S>& vehicle, const Measurement<S>& y, const Allocation<S>& last, const LearningGains<S>& k,
            S layer_width) noexcept {
    const VecN<S> before = h_w_;
    h_w_ = y.h_w;
    const Vec3<S> tau_B = torque<S>(y.axes.of(vehicle.D_B), e_.cwiseProduct(last.u)) + vehicle.J_B * (k.k1 * error_) +
                          k.k2 * layer(error_, layer_width);
    const Vec3<S> h_w_B = y.axes.momentum_B(vehicle.D_B, S(0.5) * (before + h_w_));
    const auto rate = [&](const Vec3<S>& w) -> Vec3<S> { return J_inv_ * (tau_B - w.cross(vehicle.J_B * w + h_w_B)); };
    const Vec3<S> middle = omega_ + dt_ / S(2) * rate(omega_);
    omega_ += dt_ * rate(middle);
    u_ = last.u;
    error_ = y.omega_BN_B - omega_;
    return error_.norm();
  }

  /// Second half: the error becomes effectiveness, of those actuators that pushed.
  void learn(const Vehicle<S>& vehicle, const Measurement<S>& y, const Allocation<S>& last, S k4) noexcept {
    const Vec3<S> y_B = vehicle.J_B * (k4 * error_ + params_.k5 * past_error_.oldest());
    const Mat3N<S>& D_B = y.axes.of(vehicle.D_B);
    const Mask informative = excited(D_B, last.u, params_.u_gate).without(params_.frozen);
    const VecN<S> change = explaining_change(D_B, last.u, informative, params_.u_reg, y_B);
    const VecN<S>& before = past_e_.oldest();
    for (int i = 0; i < vehicle.actuators(); ++i) {
      if (!informative.test(i)) continue;
      const S e = params_.k3 * before[i] + change[i];
      const S least = params_.hand_on ? S(0) : params_.e_min;
      const S most = params_.hand_on ? params_.e_max + effectiveness_headroom<S> : params_.e_max;
      e_[i] = e < least ? least : (e > most ? most : e);
    }
    seen_ = seen_ | informative;
    past_e_.push(e_);
    past_error_.push(error_);
  }

  Estimate<S> estimate(const Vehicle<S>& vehicle, const Measurement<S>& y) const noexcept {
    Estimate<S> x = Estimate<S>::healthy(y);
    issue_effectiveness<S>(x, e_, params_.e_min, params_.e_max, y.axes.of(vehicle.D_B), u_);
    for (int i = 0; i < vehicle.actuators(); ++i)
      if (seen_.test(i)) x.effectiveness_bound[i] = params_.uncertainty;
    return x;
  }

  const Vec3<S>& error() const noexcept { return error_; }

 private:
  S dt_;
  Params params_;
  Mat3<S> J_inv_;
  Vec3<S> omega_ = Vec3<S>::Zero();  ///< rad/s, what
  Vec3<S> error_ = Vec3<S>::Zero();  ///< rad/s, w~
  VecN<S> h_w_;                      ///< N m s, at the latest sample
  VecN<S> u_;                        ///< N m, of the interval just ended
  VecN<S> e_;                        ///< as believed
  Mask seen_;                        ///< excited at least once
  DelayLine<VecN<S>> past_e_;
  DelayLine<Vec3<S>> past_error_;
};

}  // namespace gyrostat
