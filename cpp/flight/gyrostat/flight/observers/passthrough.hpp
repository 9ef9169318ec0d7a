// SPDX-License-Identifier: MIT
/// @file  No estimation: the measured state, healthy actuators, no disturbance. Page: docs/components/passthrough.md
#pragma once
#include "gyrostat/core/params.hpp"

namespace gyrostat {

/// The observer of stacks that need none. Fits every vehicle.
template <class S>
class PassthroughObserver {
 public:
  using Scalar = S;
  static constexpr const char* name = "passthrough";
  static constexpr bool axiswise = true;

  struct Params {
    explicit Params(const Setup<S>&) noexcept {}
    static constexpr void describe(auto&, auto&&) {}
  };

  static Status<S> check(const Setup<S>&, const Params&) noexcept { return {}; }

  PassthroughObserver(Unchecked, const Setup<S>&, const Params&) noexcept {}

  [[nodiscard]] Estimate<S> start(const Vehicle<S>&, const Measurement<S>& y) noexcept {
    return Estimate<S>::healthy(y);
  }
  [[nodiscard]] Estimate<S> step(const Vehicle<S>&, const Measurement<S>& y, const Allocation<S>&) noexcept {
    return Estimate<S>::healthy(y);
  }

  void telemetry(auto&&) const {}
};

}  // namespace gyrostat
