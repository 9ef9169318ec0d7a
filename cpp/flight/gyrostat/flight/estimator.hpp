// SPDX-License-Identifier: MIT
/// @file  An observer with its detector: the half of the stack that may also run beside the loop (shadow pairs).
#pragma once
#include <algorithm>

#include "gyrostat/core/concepts.hpp"
#include "gyrostat/flight/guard.hpp"

namespace gyrostat {

/// Steps observer and detector in order. An output that is not finite restarts its component, and so does a torque d_B that
/// nothing on this vehicle could make; `step` then says so with Flag::component_reset in the estimate's status.
template <Observer O, Detector D>
class Estimator {
 public:
  using Scalar = typename O::Scalar;
  static constexpr bool cannot_throw = noexcept(std::declval<O&>().step(std::declval<const Measurement<Scalar>&>(),
                                                                        std::declval<const Allocation<Scalar>&>())) &&
                                       noexcept(std::declval<D&>().step(std::declval<const Estimate<Scalar>&>(),
                                                                        std::declval<const Allocation<Scalar>&>()));

  Estimator(const Vehicle<Scalar>& vehicle, O o, D d)
      : observer(std::move(o)), detector(std::move(d)), vehicle_(vehicle) {
    for (int i = 0; i < vehicle.actuators(); ++i)
      d_max_ += Scalar(1000) * vehicle.D_B.col(i).norm() * std::max(-vehicle.u_lo[i], vehicle.u_up[i]);
  }

  void start(const Measurement<Scalar>& y) noexcept(cannot_throw) {
    x_ = observer.start(y);
    if (!believable(x_)) healthy_instead(y);
    det_ = detector.start(x_);
    if (!is_finite(det_)) det_ = Detection<Scalar>::none(vehicle_);
  }

  void step(const Measurement<Scalar>& y, const Allocation<Scalar>& last) noexcept(cannot_throw) {
    x_ = observer.step(y, last);
    if (!believable(x_)) {
      x_ = observer.start(y);
      if (!believable(x_)) healthy_instead(y);
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
  /// A finite number can be large enough that a law with a power below one would carry what it left behind for years.
  bool believable(const Estimate<Scalar>& x) const noexcept {
    return is_finite(x) &&
           !(x.d_B.template lpNorm<Eigen::Infinity>() > d_max_);  // NaN: a column of zeros without limits
  }
  void healthy_instead(const Measurement<Scalar>& y) noexcept {
    x_ = Estimate<Scalar>::healthy(y);
    x_.status.set(Flag::component_reset);
  }

  Vehicle<Scalar> vehicle_;
  Scalar d_max_ = Scalar(0);  ///< N m: a thousand times what all actuators have together
  Estimate<Scalar> x_;
  Detection<Scalar> det_;
};

}  // namespace gyrostat
