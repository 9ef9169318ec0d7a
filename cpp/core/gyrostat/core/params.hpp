// SPDX-License-Identifier: MIT
/// @file  How a component describes and checks its parameters: default, unit, range and meaning are written once.
///
///     struct Params {
///       S gain = S(2);
///       static constexpr void describe(auto& p, auto&& field) {
///         field(p.gain, Field{"gain", "1/s", 0, 1e2, "rate of the correction"});
///       }
///     };
///
/// `describe` calls `field` once a parameter, with the member and a Field (numbers, vectors, matrices; the range holds
/// for every element) or a Choice (an enum; the options in the order of its values) or a Switch (a bool). Defaults that
/// depend on the vehicle are written in `static Params defaults(const Setup<S>&)`.
#pragma once
#include <limits>
#include <numbers>

#include "gyrostat/core/signals.hpp"

namespace gyrostat {

/// As a bound in a Field: any finite number. An infinite bound means that infinity itself is allowed.
inline constexpr double unbounded = std::numeric_limits<double>::max();

/// As a bound of an attitude angle, rad: no attitude needs more than one turn.
inline constexpr double full_turn = 2 * std::numbers::pi;

/// A number, vector or matrix, with its unit and the closed range of each element.
struct Field {
  const char* name;
  const char* unit;  ///< "" when dimensionless
  double lo, hi;
  const char* meaning;
  const char* mistaken = "";  ///< what a number outside looks like, for the message: "degrees"
};

/// An enum whose values count from 0.
struct Choice {
  const char* name;
  const char* options;  ///< "first|second|third"
  const char* meaning;
};

/// A bool.
struct Switch {
  const char* name;
  const char* meaning;
};

/// Result of a component's `check`: refused parameters come with the number and the limit.
template <class S>
struct Status {
  enum class Code : std::uint8_t {
    ok,
    refused,     ///< cannot work
    unstable,    ///< would diverge or not come back; `allow_unstable` overrides
    wrong_chart  ///< the law does not fit the vehicle's coordinates
  };
  Code code = Code::ok;
  const char* quantity = "";  ///< what was compared
  S value = S(0), limit = S(0);
  const char* relation = "<";  ///< the relation that ought to hold between value and limit

  constexpr bool ok() const noexcept { return code == Code::ok; }

  /// ok when `holds`; else a refusal that says "quantity = value, must be relation limit".
  static constexpr Status require(bool holds, const char* quantity, S value, S limit, const char* relation = "<",
                                  Code code = Code::refused) noexcept {
    return holds ? Status{} : Status{code, quantity, value, limit, relation};
  }
  /// Both must hold; the first that does not is reported.
  constexpr Status operator&&(const Status& next) const noexcept { return ok() ? next : *this; }
};

/// Default parameters of a component for a vehicle.
template <class Component, class S>
typename Component::Params default_params(const Setup<S>& setup) noexcept {
  if constexpr (requires { Component::Params::defaults(setup); }) {
    return Component::Params::defaults(setup);
  } else {
    return typename Component::Params{};
  }
}

/// What a component says of parameters; ok where it has nothing to check.
template <class Component, class S>
Status<S> component_check(const Setup<S>& setup, const typename Component::Params& params) noexcept {
  if constexpr (requires { Component::check(setup, params); }) {
    return Component::check(setup, params);
  } else {
    return {};
  }
}

/// Name of a counter in telemetry: its increments become dated events of the result.
struct Counter {
  const char* name;
};

/// Estimates beyond the measured state: those that an observer makes, or those that another component uses.
struct Estimates {
  bool d_B = false;
  bool effectiveness = false;

  constexpr bool operator==(const Estimates&) const noexcept = default;
};

/// What is known of a component beyond its signals; each is a `static constexpr` of the component, nothing when absent.
struct Traits {
  bool axiswise = false;   ///< equivariant under signed permutations of the body axes
  bool switching = false;  ///< discontinuous: float does not follow double sample by sample
  bool regulates = false;  ///< a controller that closes the loop on attitude
  Estimates estimates;     ///< what an observer estimates
};

template <class Component>
constexpr Traits traits_of() noexcept {
  Traits t;
  if constexpr (requires { Component::axiswise; }) t.axiswise = Component::axiswise;
  if constexpr (requires { Component::switching; }) t.switching = Component::switching;
  if constexpr (requires { Component::regulates; }) t.regulates = Component::regulates;
  if constexpr (requires { Component::estimates; }) t.estimates = Component::estimates;
  return t;
}

/// What a controller or allocator makes up for, and what a detector watches: their
/// `static constexpr Estimates uses(const Params&)`. A controller subtracts d_B, an allocator divides by effectiveness.
template <class Component>
constexpr Estimates uses_of(const typename Component::Params& params) noexcept {
  if constexpr (requires { Component::uses(params); }) {
    return Component::uses(params);
  } else {
    return {};
  }
}

}  // namespace gyrostat
