// SPDX-License-Identifier: MIT
/// @file  Static stacks with default parameters, and measurements for them.
#pragma once
#include <cmath>
#include <type_traits>

#include "../flight/vehicles.hpp"
#include "any.hpp"
#include "gyrostat/flight/allocators/pseudo_inverse.hpp"
#include "gyrostat/flight/controllers/mrp_feedback.hpp"
#include "gyrostat/flight/controllers/open_loop.hpp"
#include "gyrostat/flight/detectors/none.hpp"
#include "gyrostat/flight/observers/passthrough.hpp"

namespace gyrostat::test {

/// `T(setup, {})` does not compile: parameters that `check` refuses reach no component but by the word `unchecked`.
template <class T>
concept TakesNoUncheckedParameters =
    !std::is_constructible_v<T, const Setup<typename T::Scalar>&, const typename T::Params&>;

/// Where a component is compiled: here, unless any_components.hpp knows it.
template <class T>
struct Making {
  static Maker<RoleOf<T>> maker() { return maker_of<T>(); }
};

template <class S>
NoNavigator<S> no_navigator(const Setup<S>& s) {
  return {unchecked, s, typename NoNavigator<S>::Params(s)};
}

/// Of observer, detector, controller and allocator, with default parameters.
template <TakesNoUncheckedParameters O, TakesNoUncheckedParameters D, TakesNoUncheckedParameters C,
          TakesNoUncheckedParameters A, class S = typename O::Scalar>
AnyStack<S> stack_of(const Setup<S>& s) {
  return {s,
          {Making<O>::maker(), s, s},
          {Making<D>::maker(), s, s},
          {Making<C>::maker(), s, s},
          {Making<A>::maker(), s, s},
          no_navigator(s),
          {}};
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
