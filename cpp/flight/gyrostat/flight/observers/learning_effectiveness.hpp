// SPDX-License-Identifier: MIT
/// @file  Learning observer of actuator effectiveness, in the form that learns: the direction of the input, no leak.
///
///   J what' = -what x (J what + D h_w) + D diag(u) e + inj,   inj = M w~ + n sgn(w~),   w~ = w - what
///   r[k]    = J (w~[k] - w~[k-1]) / dt + inj[k-1]                    = V e~ + d,  V = D diag(u[k-1])
///   e      += kappa V' (V V' + u0^2 I)^-1 r,   inside [0, 1.15];   actuators with |u| <= u_exc hold theirs
///   issued: clipped to [e_min, 1], the rest in d_B
///
/// Source: Cao, Gong, Han 2022, eq. (7)-(8), with l = 1, H1 = -H2 along the regressor and the known injection added back; for
/// three orthogonal actuators kappa u / (u^2 + u0^2) an axis. Page: docs/components/learning_effectiveness.md
#pragma once
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>

#include "gyrostat/core/params.hpp"
#include "gyrostat/core/power.hpp"
#include "gyrostat/flight/observers/parts/effectiveness_confidence.hpp"
#include "gyrostat/flight/observers/parts/issued_effectiveness.hpp"
#include "gyrostat/flight/observers/parts/rate_predictor.hpp"
#include "gyrostat/flight/parts/chart.hpp"
#include "gyrostat/flight/parts/effectiveness_floor.hpp"
#include "gyrostat/flight/parts/stiffness.hpp"

namespace gyrostat {

/// d_B holds what the issued effectiveness leaves over, no more: a torque that no command explains biases the estimate by
/// |d| / |u|, which `torque_error` bounds.
template <class S>
class LearningEffectivenessObserver {
 public:
  using Scalar = S;
  static constexpr const char* name = "learning_effectiveness";
  static constexpr Estimates estimates{.d_B = true, .effectiveness = true};
  static constexpr bool axiswise = true;
  static constexpr bool switching = true;  ///< holds below u_exc, sign of w~ where n > 0

  struct Params {
    S kappa = S(0.03);
    S u0;
    S u_exc;
    S e_min = default_effectiveness_floor<S>;
    Vec3<S> M;
    S n = S(0);
    S torque_error;
    S memory;
    S unknown_above = S(0.5);
    bool hand_on = true;

    static constexpr void describe(auto& p, auto&& field) {
      constexpr double infinite = std::numeric_limits<double>::infinity();
      field(p.kappa, Field{"kappa", "", 1e-6, 2, "share of the residual that is learned a sample"});
      field(p.u0, Field{"u0", "N m", 1e-12, 1e9, "command at which learning has half its rate"});
      field(p.u_exc, Field{"u_exc", "N m", 0, 1e9, "commands up to this one teach nothing: the estimate is held"});
      field(p.e_min, Field{"e_min", "", 0, 1,
                           "smallest estimate; no less than the e_min of the allocator, or it would stay there"});
      field(p.M, Field{"M", "N m s", 0, 1e9, "correction of the predicted rate"});
      field(p.n, Field{"n", "N m", 0, 1e9, "its switching part"});
      field(p.torque_error, Field{"torque_error", "N m", 1e-12, 1e9, "bound of what no command explains"});
      field(p.memory, Field{"memory", "s", 1e-3, infinite, "after so long without excitation nothing is known"});
      field(p.unknown_above, Field{"unknown_above", "", 1e-3, 1, "half-width from which the bound is infinite"});
      field(p.hand_on, Switch{"hand_on", "what the issued effectiveness leaves over goes into d_B; false: it is lost"});
    }

    /// Commands of 1.5 % of the usable torque are noise; what they hide is the torque error. The memory is a hundred time
    /// constants dt / kappa.
    explicit Params(const Setup<S>& setup) noexcept {
      u0 = S(0.015) * usable_torque(setup.vehicle);
      u_exc = torque_error = u0;
      M.setConstant(S(0.03) / setup.dt * smallest_inertia(setup.vehicle.J_B));
      memory = S(100) * setup.dt / kappa;
    }
  };

  static constexpr S effectiveness_floor(const Params& p) noexcept { return p.e_min; }

  /// Learning contracts for kappa < 2 whatever the commands, since V' (V V' + u0^2)^-1 V has its eigenvalues in [0, 1).
  static Status<S> check(const Setup<S>& setup, const Params& p) noexcept {
    const auto unstable = Status<S>::Code::unstable;
    const S J = smallest_inertia(setup.vehicle.J_B);
    return needs_body_coordinates(setup) && Status<S>::require(p.kappa < S(2), "kappa", p.kappa, S(2), "<", unstable) &&
           Status<S>::require(p.M.maxCoeff() * setup.dt < S(2) * J, "M * dt", p.M.maxCoeff() * setup.dt, S(2) * J, "<",
                              unstable);
  }

  LearningEffectivenessObserver(Unchecked, const Setup<S>& setup, const Params& params) noexcept
      : J_over_dt_(setup.vehicle.J_B / setup.dt),
        params_(params),
        predict_(setup),
        confidence_(setup.vehicle.actuators(), params.torque_error, setup.dt / params.memory) {
    effectiveness_.setOnes(setup.vehicle.actuators());
  }

  /// First sample: no interval has passed, so nothing is learned; healthy, and not known to be.
  [[nodiscard]] Estimate<S> start(const Vehicle<S>& vehicle, const Measurement<S>& y) noexcept {
    predict_.start(vehicle, y);
    effectiveness_.setOnes();
    confidence_.start();
    return estimate(vehicle, y, VecN<S>::Zero(effectiveness_.size()));
  }

  /// Every later sample. The regressor is the command that acted over the interval just ended.
  [[nodiscard]] Estimate<S> step(const Vehicle<S>& vehicle, const Measurement<S>& y,
                                 const Allocation<S>& last) noexcept {
    const Vec3<S> before = predict_.error();
    const Vec3<S>& error = predict_.step(vehicle, y, effectiveness_, last.u);
    learn(y.axes.of(vehicle.D_B), J_over_dt_ * (error - before) + predict_.injection_B(), last.u);
    predict_.correct(params_.M.cwiseProduct(error) + params_.n * sgn(error));
    return estimate(vehicle, y, last.u);
  }

  /// Nothing is learned, and with the time that passed something is forgotten.
  [[nodiscard]] Estimate<S> skip(const Vehicle<S>& vehicle, const Measurement<S>& y,
                                 const Allocation<S>& last) noexcept {
    predict_.skip(vehicle, y);
    confidence_.grow();
    return estimate(vehicle, y, last.u);
  }

  /// The measured rate has moved by `step`, rad/s, without motion.
  void shift_rate(const Vec3<S>& step) noexcept { predict_.shift_rate(step); }

  void telemetry(auto&& log) const {
    log("rate_error", predict_.error());
    VecN<S> information(effectiveness_.size());
    for (int i = 0; i < information.size(); ++i) information[i] = confidence_.information(i);
    log("information", information);
  }

 private:
  void learn(const Mat3N<S>& D_B, const Vec3<S>& residual_B, const VecN<S>& u) noexcept {
    confidence_.grow();
    Mat3N<S> V = D_B;
    bool excited = false;
    for (int i = 0; i < V.cols(); ++i) {
      const bool moves = std::abs(u[i]) > params_.u_exc;
      V.col(i) *= moves ? u[i] : S(0);
      excited = excited || moves;
    }
    if (!excited) return;
    confidence_.doubt(V, residual_B);
    Mat3<S> VVt = params_.u0 * params_.u0 * Mat3<S>::Identity();
    for (Eigen::Index i = 0; i < V.cols(); ++i) VVt += V.col(i) * V.col(i).transpose();
    const Mat3<S> inverse = VVt.inverse();
    Mat3N<S> K_transposed(3, V.cols());
    for (Eigen::Index i = 0; i < V.cols(); ++i) {
      K_transposed.col(i) = params_.kappa * (inverse * V.col(i));
      if (std::abs(u[i]) <= params_.u_exc) continue;  // held to the bit
      const S moved = effectiveness_[i] + K_transposed.col(i).dot(residual_B);
      effectiveness_[i] = params_.hand_on ? std::clamp(moved, S(0), S(1) + effectiveness_headroom<S>)
                                          : std::clamp(moved, params_.e_min, S(1));
    }
    confidence_.learn(K_transposed, V, (S(2) - params_.kappa) / params_.kappa);
  }

  Estimate<S> estimate(const Vehicle<S>& vehicle, const Measurement<S>& y, const VecN<S>& u) const noexcept {
    Estimate<S> x = Estimate<S>::healthy(y);
    issue_effectiveness<S>(x, effectiveness_, params_.e_min, S(1), y.axes.of(vehicle.D_B), u);
    for (int i = 0; i < effectiveness_.size(); ++i) {
      const S half = confidence_.half_width(i);
      if (half < params_.unknown_above && x.effectiveness[i] > S(0))
        x.effectiveness_bound[i] = half / x.effectiveness[i];
    }
    return x;
  }

  Mat3<S> J_over_dt_;
  Params params_;
  RatePredictor<S> predict_;
  EffectivenessConfidence<S> confidence_;
  VecN<S> effectiveness_;
};

}  // namespace gyrostat
