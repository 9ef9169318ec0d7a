// SPDX-License-Identifier: MIT
/// @file  Declares a change of effectiveness that stays beyond a threshold; enables the spares; can make silent faults audible.
///
///   |e_j - e_ref_j| > threshold without a gap for `persistence`, while |D_j u_j| >= u_gate        then e_ref_j = e_j, once it has settled
///   u_probe = dither sin(2 pi t / dither_period) v,   D v = 0
///
/// Source: chosen, the paper (Yang, Yang, Ji, Ma 2023) asks for a detector and gives none. Page: docs/components/threshold.md
#pragma once
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>

#include "gyrostat/core/params.hpp"
#include "gyrostat/flight/detectors/parts/null_space.hpp"
#include "gyrostat/flight/parts/effectiveness_regression.hpp"
#include "gyrostat/flight/parts/stiffness.hpp"

namespace gyrostat {

/// Works on every observer: what an observer puts into d_B is mapped onto the actuators that push and counts as a change of
/// their effectiveness. The price is that a disturbance reads as a fault where the command is small.
template <class S>
class ThresholdDetector {
 public:
  using Scalar = S;
  static constexpr const char* name = "threshold";
  static constexpr bool axiswise = true;
  static constexpr bool switching = true;

  struct Params {
    S threshold = S(0.2);
    S persistence;
    S hold_off;
    S settle;
    S u_gate;
    S failed_below = S(0.06);
    Mask unwatched;
    bool use_torque = true;
    S dither = S(0);
    S dither_period;

    static constexpr void describe(auto& p, auto&& field) {
      field(p.threshold, Field{"threshold", "", 1e-6, 10, "change of effectiveness that is declared"});
      field(p.persistence, Field{"persistence", "s", 0, 1e6, "for how long without a gap"});
      field(p.hold_off, Field{"hold_off", "s", 0, 1e6, "after a declaration an actuator is not looked at for so long"});
      field(p.settle, Field{"settle", "s", 0, 1e6,
                            "after a declaration the reference follows the estimate for so long, within hold_off"});
      field(p.u_gate, Field{"u_gate", "N m", 0, 1e9, "an actuator whose torque is below this is not looked at"});
      field(p.failed_below, Field{"failed_below", "", 0, 1, "effectiveness at a declaration that counts as useless"});
      field(p.unwatched, Field{"unwatched", "", 0, max_actuators - 1, "actuators that are not looked at"});
      field(p.use_torque, Switch{"use_torque", "map the observer's d_B onto the actuators that push"});
      field(p.dither, Field{"dither", "N m", 0, 1e9, "largest command of a probe without net torque; 0: none"});
      field(p.dither_period, Field{"dither_period", "s", 1e-6, 1e6, "of the probe's sine"});
    }

    /// Gate as in the learning observers; persistence 20 samples, settling 100, hold-off 400, probe period 400.
    explicit Params(const Setup<S>& setup) noexcept {
      u_gate = S(0.2) * usable_torque(setup.vehicle);
      persistence = S(20) * setup.dt;
      settle = S(100) * setup.dt;
      hold_off = dither_period = S(400) * setup.dt;
      unwatched = setup.vehicle.spare;
    }
  };

  static constexpr Estimates uses(const Params& p) noexcept { return {.d_B = p.use_torque, .effectiveness = true}; }

  /// A probe needs redundancy, room for it inside the limits, and four samples a period.
  static Status<S> check(const Setup<S>& setup, const Params& p) noexcept {
    const Status<S> settled = Status<S>::require(p.settle <= p.hold_off, "settle", p.settle, p.hold_off, "<=");
    if (!(p.dither > S(0))) return settled;
    const int n = setup.vehicle.actuators();
    const S room = n == 0 ? S(0) : std::min(setup.vehicle.u_up.minCoeff(), (-setup.vehicle.u_lo).minCoeff());
    const int free = NullSpace<S>(setup.vehicle.D_B, Mask::all(n)).dimension();
    return settled &&
           Status<S>::require(free >= 1, "actuators beyond those that the torque axes need, for dither",
                              static_cast<S>(free), S(1), ">=") &&
           Status<S>::require(p.dither < room, "dither", p.dither, room) &&
           Status<S>::require(p.dither_period >= S(4) * setup.dt, "dither_period", p.dither_period, S(4) * setup.dt,
                              ">=");
  }

  ThresholdDetector(Unchecked, const Setup<S>& setup, const Params& params) noexcept
      : params_(params),
        persistence_(ticks(params.persistence, setup.dt)),
        hold_off_(ticks(params.hold_off, setup.dt)),
        settle_(params.settle > S(0) ? ticks(params.settle, setup.dt) : 0),
        period_(ticks(params.dither_period, setup.dt)),
        null_(setup.vehicle.D_B, Mask::all(setup.vehicle.actuators())) {
    forget(setup.vehicle);
  }

  [[nodiscard]] Detection<S> start(const Vehicle<S>& vehicle, const Estimate<S>&) noexcept {
    forget(vehicle);
    return with_probe();
  }

  [[nodiscard]] Detection<S> step(const Vehicle<S>& vehicle, const Estimate<S>& x, const Allocation<S>& last) noexcept {
    look(x.axes.of(vehicle.D_B), x, last);
    Mask now;
    for (int j = 0; j < vehicle.actuators(); ++j) {
      if (quiet_[j] > 0) {
        if (watched_.test(j) && hold_off_ - quiet_[j] < settle_) reference_[j] = seen_[j];
        --quiet_[j];
        continue;
      }
      const bool beyond = watched_.test(j) && std::abs(seen_[j] - reference_[j]) > params_.threshold;
      beyond_[j] = beyond ? beyond_[j] + 1 : 0;
      if (beyond && beyond_[j] >= persistence_) now.set(j);
    }
    if (now.any()) declare(vehicle, now);
    return with_probe();
  }

  void telemetry(auto&& log) const {
    log("effectiveness", seen_);
    log("declared", static_cast<S>(declared_.bits()));
  }

 private:
  static std::int32_t ticks(S seconds, S dt) noexcept {
    return static_cast<std::int32_t>(std::min(std::max(std::round(seconds / dt), S(1)), S(2e9)));
  }

  void forget(const Vehicle<S>& vehicle) noexcept {
    det_ = Detection<S>::none(vehicle);
    if (params_.dither > S(0)) det_.enabled = Mask::all(vehicle.actuators());  // a probe takes all of the redundancy
    reference_ = seen_ = VecN<S>::Ones(vehicle.actuators());
    for (int j = 0; j < max_actuators; ++j) beyond_[j] = quiet_[j] = 0;
    watched_ = declared_ = Mask{};
    tick_ = 0;
    probed_ = -1;
    next_direction();
  }

  int actuators() const noexcept { return static_cast<int>(reference_.size()); }

  /// Effectiveness that the estimate amounts to, of the actuators that push.
  void look(const Mat3N<S>& D_B, const Estimate<S>& x, const Allocation<S>& last) noexcept {
    const Mask pushing = excited(D_B, last.u, params_.u_gate);
    watched_ = pushing.without(params_.unwatched);
    seen_ = x.effectiveness;
    if (params_.use_torque && !x.d_B.isZero(S(0))) seen_ += explained(D_B, last.u, x.d_B);
  }

  /// By those that were declared before, first: the others explain what no declared one can make.
  VecN<S> explained(const Mat3N<S>& D_B, const VecN<S>& u, const Vec3<S>& d_B) const noexcept {
    const S regularisation = S(1e-3) * std::max(params_.u_gate, Eigen::NumTraits<S>::epsilon());
    if (!det_.changed.any()) return explaining_change(D_B, u, watched_, regularisation, d_B);
    const Mat3<S> P = beyond<S>(D_B, det_.changed);
    const Mask others = watched_.without(det_.changed);
    const VecN<S> change = explaining_change<S>(P * D_B, u, others, regularisation, P * d_B);
    const Vec3<S> rest = d_B - torque<S>(D_B, change.cwiseProduct(u));
    return change + explaining_change(D_B, u, watched_ & det_.changed, regularisation, rest);
  }

  void declare(const Vehicle<S>& vehicle, Mask now) noexcept {
    for (int j = 0; j < vehicle.actuators(); ++j) {
      if (!now.test(j)) continue;
      reference_[j] = seen_[j];
      beyond_[j] = 0;
      quiet_[j] = hold_off_;
      det_.classes[static_cast<std::size_t>(j)] = FaultClass::gain;
      det_.gain[j] = seen_[j];
      if (seen_[j] < params_.failed_below && spared(vehicle, j)) det_.failed.set(j);
    }
    declared_ = now;
    det_.changed = det_.changed | now;
    det_.enabled = Mask::all(vehicle.actuators());
    ++det_.event;
  }

  /// Whether the others, spares and all, reach every direction of torque.
  bool spared(const Vehicle<S>& vehicle, int j) const noexcept {
    Mask failed = det_.failed;
    failed.set(j);
    const ActuatorsInUse<S> left{Mask::all(vehicle.actuators()).without(failed),
                                 reference_.cwiseMax(S(0)).cwiseMin(S(1))};
    return torque_authority(vehicle, left) > S(0);
  }

  /// The next actuator's null command; with one dimension of redundancy they are all the same up to the sign.
  void next_direction() noexcept {
    if (!(params_.dither > S(0))) return;
    for (int tries = 0; tries < actuators(); ++tries) {
      probed_ = (probed_ + 1) % actuators();
      direction_ = null_.direction(probed_);
      if (!direction_.isZero(S(0))) return;
    }
  }

  Detection<S> with_probe() noexcept {
    if (params_.dither > S(0)) {
      const S phase = S(2) * std::numbers::pi_v<S> * static_cast<S>(tick_) / static_cast<S>(period_);
      det_.u_probe = params_.dither * std::sin(phase) * direction_;
      if (++tick_ == period_) {
        tick_ = 0;
        next_direction();
      }
    }
    return det_;
  }

  Params params_;
  std::int32_t persistence_, hold_off_, settle_, period_;  ///< samples
  NullSpace<S> null_;
  Detection<S> det_;
  VecN<S> reference_, seen_, direction_;
  std::int32_t beyond_[max_actuators], quiet_[max_actuators];  ///< samples
  Mask watched_, declared_;
  std::int32_t tick_ = 0;
  int probed_ = -1;
};

}  // namespace gyrostat
