// SPDX-License-Identifier: MIT
/// @file  How a component describes and checks its parameters: default, unit, range and meaning are written once.
///
///     struct Params {
///       S gain;
///       explicit Params(const Setup<S>& setup) noexcept : gain(S(0.1) / setup.dt) {}
///       static constexpr void describe(auto& p, auto&& field) {
///         field(p.gain, Field{"gain", "1/s", 0, 1e2, "rate of the correction"});
///       }
///     };
///
/// Parameters come from a Setup and from nothing else: the constructor holds the defaults for the vehicle and the period. A
/// member has an initialiser where its default is the same on every vehicle.
/// `describe` calls `field` once a parameter, with the member and a Field (numbers, vectors, matrices; the range holds
/// for every element) or a Choice (an enum; the options in the order of its values) or a Switch (a bool).
#pragma once
#include <concepts>
#include <limits>
#include <numbers>
#include <optional>

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
  /// Also what would diverge, where the caller wants it so.
  constexpr bool ok(bool allow_unstable) const noexcept { return ok() || (allow_unstable && code == Code::unstable); }

  /// ok when `holds`; else a refusal that says "quantity = value, must be relation limit".
  static constexpr Status require(bool holds, const char* quantity, S value, S limit, const char* relation = "<",
                                  Code code = Code::refused) noexcept {
    return holds ? Status{} : Status{code, quantity, value, limit, relation};
  }
  /// Both must hold; the first that does not is reported, what cannot work before what would diverge.
  constexpr Status operator&&(const Status& next) const noexcept { return ok(!next.ok(true)) ? next : *this; }
};

/// Parameters that are made from a Setup: `Params{}` does not compile.
template <class P, class S>
concept ParamsOf = std::constructible_from<P, const Setup<S>&> && !std::default_initializable<P>;

/// What a component says of parameters; ok where it has nothing to check.
template <class Component, class S>
Status<S> component_check(const Setup<S>& setup, const typename Component::Params& params) noexcept {
  if constexpr (requires { Component::check(setup, params); }) {
    return Component::check(setup, params);
  } else {
    return {};
  }
}

/// First argument of the constructors of components: the caller answers for parameters that nobody has checked.
struct Unchecked {
  explicit constexpr Unchecked() noexcept = default;
};
inline constexpr Unchecked unchecked{};

/// A flight component or a whole stack: parameters from a Setup, and a constructor that says that it does not check.
template <class T>
concept Checkable =
    ParamsOf<typename T::Params, typename T::Scalar> &&
    std::constructible_from<T, Unchecked, const Setup<typename T::Scalar>&, const typename T::Params&> &&
    !std::constructible_from<T, const Setup<typename T::Scalar>&, const typename T::Params&>;

/// A component or a stack whose parameters its `check` has taken, or else the refusal.
///
///     typename Law::Params p(setup);
///     p.gain = S(2);
///     Checked<Law> law(setup, p);
///     if (!law) return report(law.status());
template <Checkable T>
class Checked {
 public:
  using Scalar = typename T::Scalar;

  /// @param allow_unstable  take parameters that would diverge as well
  Checked(const Setup<Scalar>& setup, const typename T::Params& params, bool allow_unstable = false) noexcept
      : status_(component_check<T>(setup, params)) {
    if (status_.ok(allow_unstable)) made_.emplace(unchecked, setup, params);
  }
  /// With default parameters.
  explicit Checked(const Setup<Scalar>& setup) noexcept : Checked(setup, typename T::Params(setup)) {}
  /// Refused for another reason.
  explicit Checked(const Status<Scalar>& refusal) noexcept : status_(refusal) {}

  explicit operator bool() const noexcept { return made_.has_value(); }
  /// What `check` said.
  const Status<Scalar>& status() const noexcept { return status_; }

  /// Only where there is one.
  T& operator*() noexcept { return *made_; }
  const T& operator*() const noexcept { return *made_; }
  T* operator->() noexcept { return &*made_; }
  const T* operator->() const noexcept { return &*made_; }

 private:
  Status<Scalar> status_;
  std::optional<T> made_;
};

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
