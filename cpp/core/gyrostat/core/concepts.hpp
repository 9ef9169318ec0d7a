// SPDX-License-Identifier: MIT
/// @file  What a component must offer. `start` is called at the first sample, when no interval has passed yet.
///
/// Every call begins with the nominal vehicle. The stack holds it, once, and it is the same in every call and in the `Setup` that
/// the component was made from: a component keeps what it has computed from it, and no copy.
#pragma once
#include <concepts>

#include "gyrostat/core/params.hpp"

namespace gyrostat {

/// Turns what sensors show into what ideal ones would: attitude, rate without bias, validity. It sees every sample, those with
/// nothing valid in them too.
template <class T>
concept Navigator =
    requires(T navigator, const Vehicle<typename T::Scalar>& vehicle, const Measurement<typename T::Scalar>& y) {
      { navigator.start(vehicle, y) } -> std::convertible_to<Measurement<typename T::Scalar>>;
      { navigator.step(vehicle, y) } -> std::convertible_to<Measurement<typename T::Scalar>>;
    };

template <class T>
concept Observer = requires(T observer, const Vehicle<typename T::Scalar>& vehicle,
                            const Measurement<typename T::Scalar>& y, const Allocation<typename T::Scalar>& last) {
  { observer.start(vehicle, y) } -> std::same_as<Estimate<typename T::Scalar>>;
  { observer.step(vehicle, y, last) } -> std::same_as<Estimate<typename T::Scalar>>;
};

/// An observer may have `skip(vehicle, y, last)`, called instead of `step` for an interval that teaches nothing (estimator.hpp).
/// It takes its state from `y` and keeps what it has learned. Without it `step` is called; where `y` was not measured it has been
/// carried on by the model with what the observer had estimated, so that there is little to learn.
template <Observer T>
Estimate<typename T::Scalar> skip_interval(
    T& observer, const Vehicle<typename T::Scalar>& vehicle, const Measurement<typename T::Scalar>& y,
    const Allocation<typename T::Scalar>& last) noexcept(noexcept(observer.step(vehicle, y, last))) {
  static_assert(!requires { observer.skip(y, last); }, "skip(vehicle, y, last): without the vehicle nobody calls it");
  if constexpr (requires { observer.skip(vehicle, y, last); }) {
    return observer.skip(vehicle, y, last);
  } else {
    return observer.step(vehicle, y, last);
  }
}

/// Told before `step` that the measured rate has moved by `step` (rad/s) without motion: rates that an observer remembers move
/// with it (`shift_rate`), or it would take the difference for a torque.
template <Observer T>
void shift_rate(T& observer, const Vec3<typename T::Scalar>& step) {
  if constexpr (requires { observer.shift_rate(step); }) observer.shift_rate(step);
}

template <class T>
concept Detector = requires(T detector, const Vehicle<typename T::Scalar>& vehicle,
                            const Estimate<typename T::Scalar>& x, const Allocation<typename T::Scalar>& last) {
  { detector.start(vehicle, x) } -> std::same_as<Detection<typename T::Scalar>>;
  { detector.step(vehicle, x, last) } -> std::same_as<Detection<typename T::Scalar>>;
};

template <class T>
concept Controller = requires(T controller, const Vehicle<typename T::Scalar>& vehicle,
                              const Estimate<typename T::Scalar>& x, const Detection<typename T::Scalar>& det,
                              const Reference<typename T::Scalar>& ref, const Allocation<typename T::Scalar>& last) {
  { controller.start(vehicle, x, det, ref) } -> std::same_as<Demand<typename T::Scalar>>;
  { controller.step(vehicle, x, det, ref, last) } -> std::same_as<Demand<typename T::Scalar>>;
};

template <class T>
concept Allocator =
    requires(T allocator, const Vehicle<typename T::Scalar>& vehicle, const Demand<typename T::Scalar>& demand,
             const Estimate<typename T::Scalar>& x, const Detection<typename T::Scalar>& det) {
      allocator.reset(vehicle);
      { allocator.step(vehicle, demand, x, det) } -> std::same_as<Allocation<typename T::Scalar>>;
    };

}  // namespace gyrostat
