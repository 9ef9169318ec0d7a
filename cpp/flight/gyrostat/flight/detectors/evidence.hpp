// SPDX-License-Identifier: MIT
/// @file  What changed, on which actuator, of which class: from the momentum of wheels, and from the torque that the observer
///        cannot explain where an actuator stores none.
///
///   wheel      y = (h_begin - h_end) / T against the mean command        declared, classed, recovered one by one
///   torquer    D diag(e - 1) u + d_B against D_i u_i                     its gain
///
/// An actuator is dropped only when it is stuck, was asked both ways, stayed so, and the others can do without it.
///
/// Source: own. Page: docs/components/evidence.md
#pragma once
#include <algorithm>
#include <cmath>
#include <cstdint>

#include "gyrostat/core/params.hpp"
#include "gyrostat/flight/detectors/parts/torque_evidence.hpp"
#include "gyrostat/flight/detectors/parts/wheel_evidence.hpp"
#include "gyrostat/flight/parts/stiffness.hpp"

namespace gyrostat {

/// Fits every vehicle and every observer: of wheels it reads the measured momentum and the command alone.
template <class S>
class EvidenceDetector {
 public:
  using Scalar = S;
  static constexpr const char* name = "evidence";
  static constexpr bool axiswise = true;
  static constexpr bool switching = true;

  struct Params {
    S tolerance = S(0.01);
    S z = S(5);
    S block;
    S momentum_noise;
    S momentum_delay = S(1);
    S failed_below = S(0.06);
    bool drop = true;
    S confirm = S(5);
    S margin = S(0.1);
    S retry = S(60);
    bool use_momentum = true;
    bool use_torque;
    S disturbance = S(0.1);

    static constexpr void describe(auto& p, auto&& field) {
      field(p.tolerance,
            Field{"tolerance", "", 1e-6, 1,
                  "smallest fault of a wheel that is sought, of its largest command; above unknown friction"});
      field(p.z, Field{"z", "", 0.1, 100, "variances of the noise of a pair that are not taken for a fault"});
      field(p.block, Field{"block", "s", 1e-6, 1e6, "over which command and output are averaged"});
      field(p.momentum_noise,
            Field{"momentum_noise", "N m s", 1e-12, 1e6,
                  "of a usual tachometer; the noise in use is measured, a fiftieth of this its least"});
      field(p.momentum_delay, Field{"momentum_delay", "samples", 0, 100, "most age of the momentum that is shown"});
      field(p.failed_below, Field{"failed_below", "", 0, 1, "gain that counts as stuck at zero"});
      field(p.drop, Switch{"drop", "wheels that are stuck for good are no longer used, where the others suffice"});
      field(p.confirm, Field{"confirm", "s", 0, 1e6, "for how long a wheel is stuck before it is dropped"});
      field(p.margin,
            Field{"margin", "", 0, 1, "torque that must be left in every direction, of what the vehicle has"});
      field(p.retry, Field{"retry", "s", 1e-3, 1e6, "until a dropped wheel is tried again; doubles each time"});
      field(p.use_momentum, Switch{"use_momentum", "wheels are judged by their momentum; off: as torquers"});
      field(p.use_torque, Switch{"use_torque", "actuators without momentum are judged by the observer's torque"});
      field(p.disturbance, Field{"disturbance", "", 0, 10,
                                 "rms of a torque that is no evidence, of what the vehicle has in every direction"});
    }

    /// Blocks of 0.03 over the natural frequency of the default law, two samples at least; a tachometer's noise of one
    /// thousandth of a second of the largest command; torque is watched where an actuator stores no momentum.
    explicit Params(const Setup<S>& setup) noexcept {
      block = std::max(S(2) * setup.dt, S(0.03) / default_stiffness(setup).frequency);
      momentum_noise = S(1e-3) * largest_command(setup.vehicle);
      use_torque = !(setup.vehicle.wheels == Mask::all(setup.vehicle.actuators()));
    }
  };

  static constexpr Estimates uses(const Params& p) noexcept {
    return {.d_B = p.use_torque, .effectiveness = p.use_torque};
  }

  /// A block of one sample is the noise of a difference.
  static Status<S> check(const Setup<S>& setup, const Params& p) noexcept {
    return Status<S>::require(p.block >= S(1.5) * setup.dt, "block", p.block, S(1.5) * setup.dt, ">=");
  }

  EvidenceDetector(Unchecked, const Setup<S>& setup, const Params& params) noexcept
      : params_(params),
        dt_(setup.dt),
        usable_(usable_torque(setup.vehicle)),
        by_momentum_(params.use_momentum ? setup.vehicle.wheels : Mask{}),
        by_torque_(params.use_torque ? Mask::all(setup.vehicle.actuators()).without(by_momentum_) : Mask{}) {
    forget(setup.vehicle);
  }

  [[nodiscard]] Detection<S> start(const Vehicle<S>& vehicle, const Estimate<S>& x) noexcept {
    forget(vehicle);
    event_ = x.event;
    return det_;
  }

  [[nodiscard]] Detection<S> step(const Vehicle<S>& vehicle, const Estimate<S>& x, const Allocation<S>& last) noexcept {
    named_ = recovered_ = Mask{};
    judged_ = false;
    const bool jumped = x.event != event_;
    event_ = x.event;
    look_at_wheels(vehicle, x, last.u, x.momentum_valid && !jumped);
    if (by_torque_.any()) look_at_torque(x.axes.of(vehicle.D_B), x, last.u, jumped);
    if (judged_ && det_.failed.any() && !enough_without(vehicle, x.axes.of(vehicle.D_B), det_.failed)) take_back();
    if (named_.any() || recovered_.any()) tell();
    return det_;
  }

  void telemetry(auto&& log) const {
    const auto n = det_.gain.size();
    VecN<S> delivered = VecN<S>::Zero(n), tolerance = delivered, noise = delivered;
    for (int i = 0; i < n; ++i) {
      if (!by_momentum_.test(i)) continue;
      noise[i] = wheels_[i].noise();
      if (wheels_[i].pairs().size() == 0) continue;
      delivered[i] = wheels_[i].pairs()[0].delivered;
      tolerance[i] = wheels_[i].pairs()[0].tolerance;
    }
    log("delivered", delivered);
    log("tolerance", tolerance);
    log("noise", noise);
    log("declared", static_cast<S>(declared_.bits()));
  }

 private:
  struct Dropped {
    S waits = S(0), next = S(0);  ///< s until it is tried again, and the time after
  };

  /// N m; where flight knows no limit, what defaults count on.
  static S largest_command(const Vehicle<S>& vehicle, int i) noexcept {
    const S limit = std::max(std::abs(vehicle.u_lo[i]), std::abs(vehicle.u_up[i]));
    const S lever = vehicle.D_B.col(i).norm();
    return std::isfinite(limit) && limit > S(0) ? limit : usable_torque(vehicle) / (lever > S(0) ? lever : S(1));
  }
  static S largest_command(const Vehicle<S>& vehicle) noexcept {
    S most = S(0);
    for (int i = 0; i < vehicle.actuators(); ++i) most = std::max(most, largest_command(vehicle, i));
    return most;
  }

  int actuators() const noexcept { return static_cast<int>(det_.gain.size()); }
  int block() const noexcept { return static_cast<int>(std::clamp(std::round(params_.block / dt_), S(2), S(5e7))); }

  void forget(const Vehicle<S>& vehicle) noexcept {
    det_ = Detection<S>::none(vehicle);
    named_ = recovered_ = declared_ = Mask{};
    const WheelRules<S> rules{dt_, block(), params_.z, params_.momentum_delay, params_.failed_below, params_.confirm};
    for (int i = 0; i < vehicle.actuators(); ++i) {
      const S most = vehicle.h_max.size() == 0 ? std::numeric_limits<S>::infinity() : vehicle.h_max[i];
      wheels_[i] = {rules, params_.tolerance * largest_command(vehicle, i), params_.momentum_noise, most};
      dropped_[i] = {S(0), params_.retry};
    }
    torque_ = TorqueEvidence<S>(vehicle.actuators(), block(), params_.disturbance * usable_);
  }

  void look_at_wheels(const Vehicle<S>& vehicle, const Estimate<S>& x, const VecN<S>& u, bool measured) noexcept {
    for (int i = 0; i < vehicle.actuators(); ++i) {
      if (!by_momentum_.test(i)) continue;
      if (det_.failed.test(i) && !tried_again(i)) continue;
      if (!measured || !(std::abs(u[i]) < S(1e12))) {
        wheels_[i].interrupt();
      } else if (wheels_[i].sample(x.h_w[i], u[i])) {
        judge(vehicle, x.axes.of(vehicle.D_B), i);
      }
    }
  }

  void judge(const Vehicle<S>& vehicle, const Mat3N<S>& D_B, int i) noexcept {
    using News = typename WheelEvidence<S>::News;
    const News news = wheels_[i].judge();
    judged_ = true;
    if (news == News::declared) named_.set(i);
    if (news == News::recovered) recovered_.set(i);
    const FaultFit<S>& fault = wheels_[i].fault();
    det_.classes[static_cast<std::size_t>(i)] = fault.fault;
    det_.gain[i] = fault.gain;
    det_.bias[i] = fault.bias;
    if (params_.drop && wheels_[i].useless() && spared(vehicle, D_B, i)) {
      det_.failed.set(i);
      dropped_[i].waits = dropped_[i].next;
      dropped_[i].next = std::min(S(2) * dropped_[i].next, S(64) * params_.retry);
    }
  }

  bool spared(const Vehicle<S>& vehicle, const Mat3N<S>& D_B, int i) const noexcept {
    Mask dropped = det_.failed;
    dropped.set(i);
    return enough_without(vehicle, D_B, dropped);
  }

  /// Whether the others have torque enough in every direction, with what is dropped pushing as it does. Of an unclear fault
  /// nobody knows what it leaves: nothing is counted.
  bool enough_without(const Vehicle<S>& vehicle, const Mat3N<S>& D_B, Mask dropped) const noexcept {
    ActuatorsInUse<S> left{Mask::all(vehicle.actuators()).without(dropped), det_.gain};
    for (int k = 0; k < vehicle.actuators(); ++k) {
      if (dropped.test(k)) left.against += det_.bias[k] * D_B.col(k);
      if (det_.classes[static_cast<std::size_t>(k)] == FaultClass::unclear) left.gain[k] = S(0);
    }
    left.gain = left.gain.cwiseMax(S(0)).cwiseMin(S(1));
    return torque_authority(vehicle, D_B, left) > params_.margin * usable_;
  }

  /// Another fault has made the dropped ones needed: all are used again, and judged anew.
  void take_back() noexcept {
    for (int i = 0; i < actuators(); ++i) {
      if (!det_.failed.test(i)) continue;
      det_.failed.set(i, false);
      wheels_[i].retry();
    }
  }

  bool tried_again(int i) noexcept {
    dropped_[i].waits -= dt_;
    if (dropped_[i].waits > S(0)) return false;
    det_.failed.set(i, false);
    wheels_[i].retry();
    return true;
  }

  void look_at_torque(const Mat3N<S>& D_B, const Estimate<S>& x, const VecN<S>& u, bool jumped) noexcept {
    if (jumped || !(u.cwiseAbs().maxCoeff() < S(1e12))) return torque_.forget();
    if (!torque_.sample(D_B, x, u)) return;
    const Mask faulty = det_.changed | named_;
    for (int i = 0; i < actuators(); ++i)
      if ((faulty & by_torque_).test(i)) det_.gain[i] = torque_.gain_of(D_B, i, faulty, det_.gain[i]);
    const auto answer = torque_.judge(D_B, by_torque_, faulty);
    if (answer.actuator < 0) return;
    named_.set(answer.actuator);
    det_.classes[static_cast<std::size_t>(answer.actuator)] = FaultClass::gain;
    det_.gain[answer.actuator] = answer.gain;
    torque_.forget();
  }

  void tell() noexcept {
    det_.changed = (det_.changed | named_).without(recovered_);
    if (named_.any()) det_.enabled = Mask::all(actuators());
    declared_ = named_;
    ++det_.event;
  }

  Params params_;
  S dt_;
  S usable_;                      ///< N m
  Mask by_momentum_, by_torque_;  ///< how each actuator is judged
  Detection<S> det_;
  WheelEvidence<S> wheels_[max_actuators];
  Dropped dropped_[max_actuators];
  TorqueEvidence<S> torque_;
  Mask named_, recovered_;  ///< at this sample
  Mask declared_;           ///< at the last event
  bool judged_ = false;     ///< a wheel, at this sample
  std::uint32_t event_ = 0;
};

}  // namespace gyrostat
