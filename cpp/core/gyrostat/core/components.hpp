// SPDX-License-Identifier: MIT
/// @file  A list of components of one role, written once: flight/observers.hpp and its like. The catalogue of the host and the
///        tests that every component must pass are fed from it.
#pragma once
#include <tuple>

#include "gyrostat/core/params.hpp"

namespace gyrostat {

template <template <class> class... T>
struct Components {
  static constexpr std::size_t count = sizeof...(T);

  /// Component number i, counted round.
  template <class S, std::size_t i>
  using at = std::tuple_element_t<i % count, std::tuple<T<S>...>>;

  /// Calls f.operator()<T<S>>() for each, in order.
  template <class S, class F>
  static void each(F&& f) {
    static_assert((Checkable<T<S>> && ...),
                  "see core/params.hpp: Params(setup), and a constructor that takes Unchecked");
    (f.template operator()<T<S>>(), ...);
  }
};

}  // namespace gyrostat
