// SPDX-License-Identifier: MIT
/// @file  Every component of the library for both scalars, and the stack of them, compiled once: any_estimation.cpp and
///        any_actuation.cpp.
#pragma once
#include <algorithm>
#include <span>
#include <utility>

#include "gyrostat/flight/allocators.hpp"
#include "gyrostat/flight/controllers.hpp"
#include "gyrostat/flight/detectors.hpp"
#include "gyrostat/flight/navigators.hpp"
#include "gyrostat/flight/observers.hpp"
#include "stacks.hpp"

namespace gyrostat::test {

template <class Role>
struct ListOf;
template <class S>
struct ListOf<NavigatorRole<S>> : Navigators {};
template <class S>
struct ListOf<ObserverRole<S>> : Observers {};
template <class S>
struct ListOf<DetectorRole<S>> : Detectors {};
template <class S>
struct ListOf<ControllerRole<S>> : Controllers {};
template <class S>
struct ListOf<AllocatorRole<S>> : Allocators {};

/// Of every component of a list, in its order.
template <class Role>
std::span<const Maker<Role>> makers();

/// Number of a component in its list; the length of the list of one that is in none.
template <class T, class List = ListOf<RoleOf<T>>>
inline constexpr std::size_t number_of = []<std::size_t... i>(std::index_sequence<i...>) {
  std::size_t number = List::count;
  ((std::same_as<T, typename List::template at<typename T::Scalar, i>> ? number = i : 0), ...);
  return number;
}(std::make_index_sequence<List::count>{});

template <class T>
  requires(number_of<T> < ListOf<RoleOf<T>>::count)
struct Making<T> {
  static Maker<RoleOf<T>> maker() { return makers<RoleOf<T>>()[number_of<T>]; }
};

extern template class AnyStack<float>;
extern template class AnyStack<float, AnyNavigator<float>>;
extern template class AnyStack<double>;
extern template class AnyStack<double, AnyNavigator<double>>;

/// Lists of what stacks are made of; every component of the library unless it is said otherwise.
template <class S>
struct Parts {
  std::span<const Maker<ObserverRole<S>>> observers = makers<ObserverRole<S>>();
  std::span<const Maker<DetectorRole<S>>> detectors = makers<DetectorRole<S>>();
  std::span<const Maker<ControllerRole<S>>> controllers = makers<ControllerRole<S>>();
  std::span<const Maker<AllocatorRole<S>>> allocators = makers<AllocatorRole<S>>();

  /// So many stacks hold every component between them: the i-th has the i-th of each list, counted round.
  std::size_t stacks() const {
    return std::max({observers.size(), detectors.size(), controllers.size(), allocators.size()});
  }

  /// Stack number i, with the parameters that another setup has by default.
  template <class N = NoNavigator<S>, class G = FixedAxes>
  AnyStack<S, N, G> stack(std::size_t i, const Setup<S>& s, const Setup<S>& parameters_of, const N& navigator,
                          const G& geometry = {}) const {
    return {s,
            {observers[i % observers.size()], s, parameters_of},
            {detectors[i % detectors.size()], s, parameters_of},
            {controllers[i % controllers.size()], s, parameters_of},
            {allocators[i % allocators.size()], s, parameters_of},
            navigator,
            geometry};
  }
  AnyStack<S> stack(std::size_t i, const Setup<S>& s) const { return stack(i, s, s, no_navigator(s)); }
};

/// Calls `with` for stacks that between them hold every component of the lists.
template <class S>
void for_every_component(const Setup<S>& s, const Parts<S>& parts, auto&& with) {
  for (std::size_t i = 0; i < parts.stacks(); ++i) with(parts.stack(i, s));
}

}  // namespace gyrostat::test
