// SPDX-License-Identifier: MIT
/// @file  No navigation: sensors are flown as they are, nothing is copied. Page: docs/components/none.md
#pragma once
#include "gyrostat/core/params.hpp"

namespace gyrostat {

/// The navigator of stacks whose sensors need none. Fits every vehicle.
template <class S>
class NoNavigator {
 public:
  using Scalar = S;
  static constexpr const char* name = "none";
  static constexpr bool axiswise = true;

  struct Params {
    explicit Params(const Setup<S>&) noexcept {}
    static constexpr void describe(auto&, auto&&) {}
  };

  static Status<S> check(const Setup<S>&, const Params&) noexcept { return {}; }

  NoNavigator(Unchecked, const Setup<S>&, const Params&) noexcept {}

  [[nodiscard]] const Measurement<S>& start(const Vehicle<S>&, const Measurement<S>& y) noexcept { return y; }
  [[nodiscard]] const Measurement<S>& step(const Vehicle<S>&, const Measurement<S>& y) noexcept { return y; }

  void telemetry(auto&&) const {}
};

}  // namespace gyrostat
