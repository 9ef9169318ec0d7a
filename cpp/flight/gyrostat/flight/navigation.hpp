// SPDX-License-Identifier: MIT
/// @file  A navigator with its guard: what cannot be was not measured, and what it makes of the rest could be.
#pragma once
#include "gyrostat/core/concepts.hpp"
#include "gyrostat/flight/guard.hpp"
#include "gyrostat/flight/navigators/none.hpp"

namespace gyrostat {

/// Steps a navigator with every sample. An impossible output starts it again; is that impossible too, sensors are flown as they
/// are. A navigator may have `passes_on()`: while it is true nothing is copied, and nothing asked.
template <Navigator N>
class Navigation {
 public:
  using Scalar = typename N::Scalar;
  static constexpr bool cannot_throw = noexcept(
      std::declval<N&>().step(std::declval<const Vehicle<Scalar>&>(), std::declval<const Measurement<Scalar>&>()));

  explicit Navigation(N n) : navigator(std::move(n)) {}

  const Measurement<Scalar>& take(const Guard<Scalar>& guard, const Measurement<Scalar>& in) noexcept(cannot_throw) {
    if constexpr (requires { navigator.passes_on(); })
      if (navigator.passes_on()) return in;
    const bool again = started_ && in.tick != 0 && in.tick == sensed_.tick;  // not renewed
    sensed_ = in;
    sensed_.attitude_valid = !again && in.attitude_valid && guard.attitude_possible(in);
    sensed_.rate_valid = !again && in.rate_valid && guard.rate_possible(in.omega_BN_B);
    sensed_.momentum_valid = !again && in.momentum_valid && guard.momentum_possible(in.h_w);
    sensed_.field_valid =
        !again && in.field_valid && guard.field_possible(in.field_B) && guard.field_possible(in.field_N);
    sensed_.sun_valid = !again && in.sun_valid && guard.sun_possible(in.sun_B) && guard.sun_possible(in.sun_N);
    y_ = started_ ? navigator.step(guard.vehicle(), sensed_) : navigator.start(guard.vehicle(), sensed_);
    restarted_ = !guard.possible(y_);
    if (restarted_) {
      y_ = navigator.start(guard.vehicle(), sensed_);
      if (!guard.possible(y_)) y_ = sensed_;
    }
    started_ = true;
    return y_;
  }

  /// Whether the navigator was started again at this sample.
  bool restarted() const noexcept { return restarted_; }
  void reset() noexcept { started_ = restarted_ = false; }

  N navigator;

 private:
  Measurement<Scalar> sensed_, y_;
  bool started_ = false, restarted_ = false;
};

/// Nothing to keep.
template <class S>
class Navigation<NoNavigator<S>> {
 public:
  static constexpr bool cannot_throw = true;

  explicit Navigation(NoNavigator<S> n) noexcept : navigator(n) {}
  const Measurement<S>& take(const Guard<S>&, const Measurement<S>& in) const noexcept { return in; }
  constexpr bool restarted() const noexcept { return false; }
  void reset() noexcept {}

  NoNavigator<S> navigator;
};

}  // namespace gyrostat
