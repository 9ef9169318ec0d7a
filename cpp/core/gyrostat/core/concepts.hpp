// SPDX-License-Identifier: MIT
/// @file  What a component must offer. `start` is called at the first sample, when no interval has passed yet.
#pragma once
#include <concepts>

#include "gyrostat/core/params.hpp"

namespace gyrostat {

/// Turns what sensors show into what ideal ones would: attitude, rate without bias, validity. It sees every sample, those with
/// nothing valid in them too.
template <class T>
concept Navigator = requires(T navigator, const Measurement<typename T::Scalar>& y) {
  { navigator.start(y) } -> std::convertible_to<Measurement<typename T::Scalar>>;
  { navigator.step(y) } -> std::convertible_to<Measurement<typename T::Scalar>>;
};

template <class T>
concept Observer =
    requires(T observer, const Measurement<typename T::Scalar>& y, const Allocation<typename T::Scalar>& last) {
      { observer.start(y) } -> std::same_as<Estimate<typename T::Scalar>>;
      { observer.step(y, last) } -> std::same_as<Estimate<typename T::Scalar>>;
    };

/// An observer may have `skip(y, last)`, called instead of `step` for an interval that teaches nothing (estimator.hpp). It
/// takes its state from `y` and keeps what it has learned. Without it `step` is called; where `y` was not measured it has been
/// carried on by the model with what the observer had estimated, so that there is little to learn.
template <Observer T>
Estimate<typename T::Scalar> skip_interval(
    T& observer, const Measurement<typename T::Scalar>& y,
    const Allocation<typename T::Scalar>& last) noexcept(noexcept(observer.step(y, last))) {
  if constexpr (requires { observer.skip(y, last); }) {
    return observer.skip(y, last);
  } else {
    return observer.step(y, last);
  }
}

/// Told before `step` that the measured rate has moved by `step` (rad/s) without motion: rates that an observer remembers move
/// with it (`shift_rate`), or it would take the difference for a torque.
template <Observer T>
void shift_rate(T& observer, const Vec3<typename T::Scalar>& step) {
  if constexpr (requires { observer.shift_rate(step); }) observer.shift_rate(step);
}

template <class T>
concept Detector =
    requires(T detector, const Estimate<typename T::Scalar>& x, const Allocation<typename T::Scalar>& last) {
      { detector.start(x) } -> std::same_as<Detection<typename T::Scalar>>;
      { detector.step(x, last) } -> std::same_as<Detection<typename T::Scalar>>;
    };

template <class T>
concept Controller =
    requires(T controller, const Estimate<typename T::Scalar>& x, const Detection<typename T::Scalar>& det,
             const Reference<typename T::Scalar>& ref, const Allocation<typename T::Scalar>& last) {
      { controller.start(x, det, ref) } -> std::same_as<Demand<typename T::Scalar>>;
      { controller.step(x, det, ref, last) } -> std::same_as<Demand<typename T::Scalar>>;
    };

template <class T>
concept Allocator = requires(T allocator, const Demand<typename T::Scalar>& demand,
                             const Estimate<typename T::Scalar>& x, const Detection<typename T::Scalar>& det) {
  allocator.reset();
  { allocator.step(demand, x, det) } -> std::same_as<Allocation<typename T::Scalar>>;
};

}  // namespace gyrostat
