// SPDX-License-Identifier: MIT
/// @file  The flight half of the loop: the one place where the order of things is written, and the guard.
///
/// Guard: a non-finite input holds the last valid one; a non-finite output restarts its component and the clipped
/// previous command is issued again; the command is clipped to its box and its rate once more. Each sets a Flag in the status.
/// Page: docs/architecture.md
#pragma once
#include <algorithm>
#include <utility>

#include "gyrostat/core/power.hpp"
#include "gyrostat/flight/estimator.hpp"

namespace gyrostat {

template <Observer O, Detector D, Controller C, Allocator A>
class FlightStack {
 public:
  using Scalar = typename O::Scalar;
  static constexpr bool cannot_throw =
      Estimator<O, D>::cannot_throw &&
      noexcept(std::declval<C&>().step(
          std::declval<const Estimate<Scalar>&>(), std::declval<const Detection<Scalar>&>(),
          std::declval<const Reference<Scalar>&>(), std::declval<const Allocation<Scalar>&>())) &&
      noexcept(std::declval<A&>().step(std::declval<const Demand<Scalar>&>(), std::declval<const Estimate<Scalar>&>(),
                                       std::declval<const Detection<Scalar>&>()));

  FlightStack(const Setup<Scalar>& setup, O observer, D detector, C controller_, A allocator_)
      : estimator(setup.vehicle, std::move(observer), std::move(detector)),
        controller(std::move(controller_)),
        allocator(std::move(allocator_)),
        vehicle_(setup.vehicle),
        du_max_(setup.vehicle.u_rate * setup.dt),
        last_(idle()) {}

  /// One sample. The first call with a finite measurement starts the components; none before it has an effect.
  const Allocation<Scalar>& step(const Measurement<Scalar>& y_in,
                                 const Reference<Scalar>& ref_in) noexcept(cannot_throw) {
    Flags status;
    hold_last_valid(y_in, y_, y_valid_, status);
    y_.tick = y_in.tick;
    hold_last_valid(ref_in, ref_, ref_valid_, status);
    if (!y_valid_ || !ref_valid_) {
      last_.status = status;
      return last_;
    }
    if (started_) {
      estimator.step(y_, last_);
      demand_ = controller.step(estimator.estimate(), estimator.detection(), ref_, last_);
    } else {
      allocator.reset();
      estimator.start(y_);
      demand_ = controller.start(estimator.estimate(), estimator.detection(), ref_);
      started_ = true;
    }
    const Estimate<Scalar>& x = estimator.estimate();
    const Detection<Scalar>& det = estimator.detection();
    bool hold = x.status.has(Flag::component_reset);
    if (!is_finite(demand_)) {
      demand_ = controller.start(x, det, ref_);
      if (!is_finite(demand_)) demand_ = {};
      hold = true;
    }
    if (demand_.u_pref.size() == 0) demand_.u_pref.setZero(vehicle_.actuators());
    if (det.u_probe.size() != 0) demand_.u_pref += det.u_probe;
    Allocation<Scalar> next = allocator.step(demand_, x, det);
    if (!is_finite(next)) {
      allocator.reset();
      hold = true;
    }
    if (hold) {
      const VecN<Scalar> previous = last_.u;
      next = Allocation<Scalar>::idle(vehicle_.actuators());
      next.u = previous;
      next.demand_B = demand_.tau_B;
      next.achieved_B = torque<Scalar>(vehicle_.D_B, x.effectiveness.cwiseProduct(previous));
      status.set(Flag::component_reset);
      status.set(Flag::command_held);
    }
    clip_once_more(next, x);
    next.status = next.status | x.status | demand_.status | status;
    last_ = next;
    return last_;
  }

  /// As constructed: the next step starts the components again.
  void reset() noexcept {
    started_ = y_valid_ = ref_valid_ = false;
    last_ = idle();
  }

  const Estimate<Scalar>& estimate() const noexcept { return estimator.estimate(); }
  const Detection<Scalar>& detection() const noexcept { return estimator.detection(); }
  const Demand<Scalar>& demand() const noexcept { return demand_; }
  /// What was issued last.
  const Allocation<Scalar>& last() const noexcept { return last_; }

  Estimator<O, D> estimator;
  C controller;
  A allocator;

 private:
  Allocation<Scalar> idle() const noexcept {
    Allocation<Scalar> a = Allocation<Scalar>::idle(vehicle_.actuators());
    a.u = clip<Scalar>(a.u, vehicle_.u_lo, vehicle_.u_up);
    return a;
  }

  template <class Signal>
  static void hold_last_valid(const Signal& in, Signal& held, bool& valid, Flags& status) noexcept {
    if (is_finite(in)) {
      held = in;
      valid = true;
    } else {
      status.set(Flag::input_held);
    }
  }

  void clip_once_more(Allocation<Scalar>& a, const Estimate<Scalar>& x) const noexcept {
    const VecN<Scalar> lo = vehicle_.u_lo.cwiseMax(last_.u - du_max_);
    const VecN<Scalar> up = vehicle_.u_up.cwiseMin(last_.u + du_max_);
    const VecN<Scalar> inside = clip<Scalar>(a.u, lo, up);
    const bool outside = inside != a.u;
    a.u = inside;
    a.saturated = a.saturated | saturated<Scalar>(a.u, lo, up);
    if (outside) a.achieved_B = torque<Scalar>(vehicle_.D_B, x.effectiveness.cwiseProduct(a.u));
  }

  Vehicle<Scalar> vehicle_;
  VecN<Scalar> du_max_;  ///< N m a sample
  Measurement<Scalar> y_;
  Reference<Scalar> ref_;
  Demand<Scalar> demand_;
  Allocation<Scalar> last_;
  bool started_ = false, y_valid_ = false, ref_valid_ = false;
};

}  // namespace gyrostat
