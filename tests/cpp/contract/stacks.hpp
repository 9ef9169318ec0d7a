// SPDX-License-Identifier: MIT
/// @file  Static stacks with default parameters, and measurements for them.
#pragma once
#include <algorithm>
#include <cmath>
#include <type_traits>
#include <utility>

#include "../flight/vehicles.hpp"
#include "gyrostat/flight/allocators/pseudo_inverse.hpp"
#include "gyrostat/flight/controllers.hpp"
#include "gyrostat/flight/detectors.hpp"
#include "gyrostat/flight/observers.hpp"
#include "gyrostat/flight/stack.hpp"

namespace gyrostat::test {

/// `T(setup, {})` does not compile: parameters that `check` refuses reach no component but by the word `unchecked`.
template <class T>
concept TakesNoUncheckedParameters =
    !std::is_constructible_v<T, const Setup<typename T::Scalar>&, const typename T::Params&>;

/// Of observer, detector, controller, allocator and, if it likes, navigator.
template <class O, class... Others>
auto stack_of(const Setup<typename O::Scalar>& s) {
  static_assert(TakesNoUncheckedParameters<O> && (TakesNoUncheckedParameters<Others> && ...));
  return by_default<FlightStack<O, Others...>>(s);
}

/// Calls `with` for stacks that between them hold every component of four lists (observers, detectors, controllers,
/// allocators) or five (navigators): the i-th stack has the i-th of each, counted round.
template <class S, class... Lists>
void for_every_component(const Setup<S>& s, auto&& with) {
  constexpr std::size_t stacks = std::max({Lists::count...});
  const auto one = [&]<std::size_t i>() { with(stack_of<typename Lists::template at<S, i>...>(s)); };
  [&]<std::size_t... i>(std::index_sequence<i...>) {
    (one.template operator()<i>(), ...);
  }(std::make_index_sequence<stacks>{});
}

/// A measurement of a body that turns and nods; no plant, so that nothing but flight is exercised.
template <class S>
Measurement<S> wobble(Tick tick, int actuators) {
  const double t = 0.01 * static_cast<double>(tick);
  const Eigen::Vector4d q(std::cos(0.2 * t), 0.3 * std::sin(t), 0.1 + 0.2 * std::cos(0.7 * t), -0.1);
  Measurement<S> y;
  y.tick = tick;
  y.q_NB = Quat<S>(static_cast<S>(q[0]), static_cast<S>(q[1]), static_cast<S>(q[2]), static_cast<S>(q[3])).normalized();
  y.omega_BN_B = {static_cast<S>(0.05 * std::sin(t)), static_cast<S>(0.02), static_cast<S>(-0.03 * std::cos(2 * t))};
  y.h_w = VecN<S>::Zero(actuators);
  return y;
}

}  // namespace gyrostat::test
