// SPDX-License-Identifier: MIT
/// @file  An observer with its detector: the half of the stack that may also run beside the loop (shadow pairs).
#pragma once
#include "gyrostat/core/concepts.hpp"
#include "gyrostat/flight/guard.hpp"

namespace gyrostat {

/// Steps observer and detector in order. An interval at whose ends rate and wheel momentum were not both measured, that no
/// motion leads across, or whose command was beyond sense, teaches nothing: the observer skips it. An impossible output
/// restarts its component; `step` then says so with Flag::component_reset in the estimate's status.
template <Observer O, Detector D>
class Estimator {
 public:
  using Scalar = typename O::Scalar;
  static constexpr bool cannot_throw =
      noexcept(std::declval<O&>().step(std::declval<const Vehicle<Scalar>&>(),
                                       std::declval<const Measurement<Scalar>&>(),
                                       std::declval<const Allocation<Scalar>&>())) &&
      noexcept(std::declval<D&>().step(std::declval<const Vehicle<Scalar>&>(), std::declval<const Estimate<Scalar>&>(),
                                       std::declval<const Allocation<Scalar>&>()));

  Estimator(const Setup<Scalar>& setup, O o, D d) : observer(std::move(o)), detector(std::move(d)), guard_(setup) {}

  void start(const Measurement<Scalar>& y) noexcept(cannot_throw) {
    actions_ = {};
    x_ = observer.start(guard_.vehicle(), y);
    if (!guard_.possible(x_)) healthy_instead(y);
    x_.axes = y.axes;
    x_.field_B = y.field_B;
    x_.event = event_ = y.event;
    x_.momentum_valid = y.momentum_valid;
    measured_ = y.rate_valid && y.momentum_valid;
    det_ = detector.start(guard_.vehicle(), x_);
    if (!guard_.possible(det_)) det_ = Detection<Scalar>::none(guard_.vehicle());
  }

  void step(const Measurement<Scalar>& y, const Allocation<Scalar>& last) noexcept(cannot_throw) {
    actions_ = {};
    const bool measured = y.rate_valid && y.momentum_valid;
    const bool teaches = measured && measured_ && y.event == event_ && guard_.sane(last.u);
    if (!y.rate_step.isZero(Scalar(0))) shift_rate(observer, y.rate_step);
    x_ = teaches ? observer.step(guard_.vehicle(), y, last) : skip_interval(observer, guard_.vehicle(), y, last);
    if (!guard_.possible(x_)) {
      x_ = observer.start(guard_.vehicle(), y);
      if (!guard_.possible(x_)) healthy_instead(y);
      restarted(actions_.observer);
    }
    x_.axes = y.axes;
    x_.field_B = y.field_B;
    x_.event = event_ = y.event;
    x_.momentum_valid = y.momentum_valid;
    measured_ = measured;
    det_ = detector.step(guard_.vehicle(), x_, last);
    if (!guard_.possible(det_)) {
      det_ = detector.start(guard_.vehicle(), x_);
      if (!guard_.possible(det_)) det_ = Detection<Scalar>::none(guard_.vehicle());
      restarted(actions_.detector);
    }
  }

  const Estimate<Scalar>& estimate() const noexcept { return x_; }
  const Detection<Scalar>& detection() const noexcept { return det_; }
  const Guard<Scalar>& guard() const noexcept { return guard_; }
  /// Which of the two was started again at this sample.
  const GuardActions& actions() const noexcept { return actions_; }

  O observer;
  D detector;

 private:
  void healthy_instead(const Measurement<Scalar>& y) noexcept {
    x_ = Estimate<Scalar>::healthy(y);
    restarted(actions_.observer);
  }
  void restarted(bool& which) noexcept {
    which = true;
    x_.status.set(Flag::component_reset);
  }

  Guard<Scalar> guard_;
  Estimate<Scalar> x_;
  Detection<Scalar> det_;
  GuardActions actions_;
  bool measured_ = true;     ///< rate and momentum at the sample before
  std::uint32_t event_ = 0;  ///< of the measurement before
};

}  // namespace gyrostat
