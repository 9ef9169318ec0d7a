// SPDX-License-Identifier: MIT
/// @file  Learning observer of actuator effectiveness as it was printed, for the record: it does not estimate the fault.
///
///   J what' = -what x (J what + D h_w) + D diag(u) e + M w~ + n sgn(w~),   w~ = w - what
///   e[k]    = clip( l e[k-nd] + D' (H1 w~[k] + H2 w~[k-nd]), e_min, 1 ),   nd = round(delay / dt)
///
/// Source: Cao, Gong, Han 2022, eq. (7)-(8). The learning term lacks the direction of the command, l < 1 leaks, and n hides every
/// torque deficit below it. Page: docs/components/learning_effectiveness_printed.md
#pragma once
#include <algorithm>
#include <cmath>

#include "gyrostat/core/params.hpp"
#include "gyrostat/core/power.hpp"
#include "gyrostat/flight/observers/parts/rate_predictor.hpp"
#include "gyrostat/flight/parts/chart.hpp"
#include "gyrostat/flight/parts/delay_line.hpp"
#include "gyrostat/flight/parts/effectiveness_floor.hpp"
#include "gyrostat/flight/parts/stiffness.hpp"

namespace gyrostat {

/// It has no measure of its own quality: its bound stays infinite.
template <class S>
class LearningEffectivenessPrintedObserver {
 public:
  using Scalar = S;
  static constexpr const char* name = "learning_effectiveness_printed";
  static constexpr Estimates estimates{.effectiveness = true};
  static constexpr bool axiswise = true;
  static constexpr bool switching = true;

  enum class Direction : std::uint8_t { none, command };

  struct Params {
    S l = S(1);
    Vec3<S> H1;
    Vec3<S> H2 = Vec3<S>::Zero();
    Vec3<S> M;
    S n = S(0);
    S layer = S(0);
    S delay;
    S e_min = default_effectiveness_floor<S>;
    Direction direction = Direction::command;
    S u_exc;

    static constexpr void describe(auto& p, auto&& field) {
      field(p.l, Field{"l", "", 0, 1, "share of the earlier estimate that is kept; below 1 it leaks"});
      field(p.H1, Field{"H1", "s/rad", -1e9, 1e9, "gain of the rate error"});
      field(p.H2, Field{"H2", "s/rad", -1e9, 1e9, "gain of the earlier rate error"});
      field(p.M, Field{"M", "N m s", 0, 1e9, "correction of the predicted rate"});
      field(p.n, Field{"n", "N m", 0, 1e9, "its switching part"});
      field(p.layer, Field{"layer", "rad/s", 0, 1e3, "boundary layer of the switching part; 0: sign, as printed"});
      field(p.delay, Field{"delay", "s", 1e-9, 1e6, "how long ago the earlier values are, a whole number of periods"});
      field(p.e_min, Field{"e_min", "", 0, 1,
                           "smallest estimate; no less than the e_min of the allocator, or it would stay there"});
      field(p.direction, Choice{"direction", "none|command",
                                "of the learning term: none as printed; sign of the command, held below u_exc"});
      field(p.u_exc, Field{"u_exc", "N m", 0, 1e9, "smallest command that teaches, with direction = command"});
    }

    /// Not the printed numbers, which make every loop a relay: no leak, the direction of the command, no switching part; the
    /// estimate closes a hundredth of its error a period under the usable torque.
    explicit Params(const Setup<S>& setup) noexcept {
      const S a = usable_torque(setup.vehicle), J = smallest_inertia(setup.vehicle.J_B);
      delay = setup.dt;
      M.setConstant(S(0.1) / setup.dt * J);
      H1 = S(0.01) / a * M;
      u_exc = S(0.015) * a;
    }
  };

  static constexpr S effectiveness_floor(const Params& p) noexcept { return p.e_min; }

  /// The prediction must be stable by itself, the delay a whole number of periods.
  static Status<S> check(const Setup<S>& setup, const Params& p) noexcept {
    const S J = smallest_inertia(setup.vehicle.J_B);
    const S periods = p.delay / setup.dt;
    return needs_body_coordinates(setup) &&
           Status<S>::require(std::abs(periods - std::round(periods)) < S(1e-3), "delay / dt off a whole number",
                              std::abs(periods - std::round(periods)), S(1e-3)) &&
           Status<S>::require(periods > S(0.5), "delay / dt", periods, S(1), ">=") &&
           Status<S>::require(periods < S(max_delay) + S(0.5), "delay / dt", periods, S(max_delay), "<=") &&
           Status<S>::require(p.M.maxCoeff() * setup.dt < S(2) * J, "M * dt", p.M.maxCoeff() * setup.dt, S(2) * J, "<",
                              Status<S>::Code::unstable);
  }

  LearningEffectivenessPrintedObserver(Unchecked, const Setup<S>& setup, const Params& params) noexcept
      : params_(params),
        predict_(setup),
        past_(static_cast<int>(std::lround(params.delay / setup.dt)), healthy(setup.vehicle.actuators())) {}

  /// First sample: before it the estimate was one and the rate error zero. The printed recursion already applies.
  [[nodiscard]] Estimate<S> start(const Vehicle<S>& vehicle, const Measurement<S>& y) noexcept {
    predict_.start(vehicle, y);
    const int n = vehicle.actuators();
    past_.fill(healthy(n));
    return learn(vehicle, y, VecN<S>::Zero(n));
  }

  [[nodiscard]] Estimate<S> step(const Vehicle<S>& vehicle, const Measurement<S>& y,
                                 const Allocation<S>& last) noexcept {
    predict_.step(vehicle, y, effectiveness_, last.u);
    return learn(vehicle, y, last.u);
  }

  /// Nothing is learned.
  [[nodiscard]] Estimate<S> skip(const Vehicle<S>& vehicle, const Measurement<S>& y, const Allocation<S>&) noexcept {
    predict_.skip(vehicle, y);
    return estimate(y);
  }

  /// The measured rate has moved by `step`, rad/s, without motion.
  void shift_rate(const Vec3<S>& step) noexcept { predict_.shift_rate(step); }

  void telemetry(auto&& log) const { log("rate_error", predict_.error()); }

 private:
  struct Past {
    VecN<S> effectiveness;
    Vec3<S> error;
  };
  static Past healthy(int n) noexcept { return {VecN<S>::Ones(n), Vec3<S>::Zero()}; }

  Estimate<S> learn(const Vehicle<S>& vehicle, const Measurement<S>& y, const VecN<S>& u) noexcept {
    const Mat3N<S>& D_B = y.axes.of(vehicle.D_B);
    const Vec3<S>& error = predict_.error();
    const Past& past = past_.oldest();
    const Vec3<S> lesson = params_.H1.cwiseProduct(error) + params_.H2.cwiseProduct(past.error);
    const VecN<S> earlier = past.effectiveness;
    effectiveness_.resize(earlier.size());
    for (Eigen::Index i = 0; i < earlier.size(); ++i) {
      const S pull = D_B.col(i).dot(lesson);
      S e = params_.l * earlier[i] + pull;
      if (params_.direction == Direction::command)
        e = std::abs(u[i]) > params_.u_exc ? params_.l * earlier[i] + sgn(u[i]) * pull : earlier[i];
      effectiveness_[i] = std::clamp(e, params_.e_min, S(1));
    }
    past_.push({effectiveness_, error});
    predict_.correct(params_.M.cwiseProduct(error) + params_.n * layer(error, params_.layer));
    return estimate(y);
  }

  Estimate<S> estimate(const Measurement<S>& y) const noexcept {
    Estimate<S> x = Estimate<S>::healthy(y);
    x.effectiveness = effectiveness_;
    return x;
  }

  Params params_;
  RatePredictor<S> predict_;
  DelayLine<Past> past_;
  VecN<S> effectiveness_;
};

}  // namespace gyrostat
