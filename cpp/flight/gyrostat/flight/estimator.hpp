// SPDX-License-Identifier: MIT
/// @file  An observer with its detector: the half of the stack that may also run beside the loop (shadow pairs).
#pragma once
#include "gyrostat/core/concepts.hpp"
#include "gyrostat/flight/guard.hpp"

namespace gyrostat {

/// Steps observer and detector in order. A non-finite output restarts its component; `step` then says so with
/// Flag::component_reset in the estimate's status.
template <Observer O, Detector D>
class Estimator {
 public:
  using Scalar = typename O::Scalar;
  static constexpr bool cannot_throw = noexcept(std::declval<O&>().step(std::declval<const Measurement<Scalar>&>(),
                                                                        std::declval<const Allocation<Scalar>&>())) &&
                                       noexcept(std::declval<D&>().step(std::declval<const Estimate<Scalar>&>(),
                                                                        std::declval<const Allocation<Scalar>&>()));

  Estimator(const Vehicle<Scalar>& vehicle, O o, D d)
      : observer(std::move(o)), detector(std::move(d)), vehicle_(vehicle) {}

  void start(const Measurement<Scalar>& y) noexcept(cannot_throw) {
    x_ = observer.start(y);
    if (!is_finite(x_)) healthy_instead(y);
    det_ = detector.start(x_);
    if (!is_finite(det_)) det_ = Detection<Scalar>::none(vehicle_);
  }

  void step(const Measurement<Scalar>& y, const Allocation<Scalar>& last) noexcept(cannot_throw) {
    x_ = observer.step(y, last);
    if (!is_finite(x_)) {
      x_ = observer.start(y);
      if (!is_finite(x_)) healthy_instead(y);
      x_.status.set(Flag::component_reset);
    }
    det_ = detector.step(x_, last);
    if (!is_finite(det_)) {
      det_ = detector.start(x_);
      if (!is_finite(det_)) det_ = Detection<Scalar>::none(vehicle_);
      x_.status.set(Flag::component_reset);
    }
  }

  const Estimate<Scalar>& estimate() const noexcept { return x_; }
  const Detection<Scalar>& detection() const noexcept { return det_; }

  O observer;
  D detector;

 private:
  void healthy_instead(const Measurement<Scalar>& y) noexcept {
    x_ = Estimate<Scalar>::healthy(y);
    x_.status.set(Flag::component_reset);
  }

  Vehicle<Scalar> vehicle_;
  Estimate<Scalar> x_;
  Detection<Scalar> det_;
};

}  // namespace gyrostat
