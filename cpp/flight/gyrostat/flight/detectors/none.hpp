// SPDX-License-Identifier: MIT
/// @file  No detection: nothing changed, nothing failed, the spares stay off. Page: docs/components/none.md
#pragma once
#include "gyrostat/core/params.hpp"

namespace gyrostat {

/// The detector of stacks that need none. Fits every vehicle.
template <class S>
class NoDetector {
 public:
  using Scalar = S;
  static constexpr const char* name = "none";
  static constexpr bool axiswise = true;

  struct Params {
    explicit Params(const Setup<S>&) noexcept {}
    static constexpr void describe(auto&, auto&&) {}
  };

  static Status<S> check(const Setup<S>&, const Params&) noexcept { return {}; }

  NoDetector(Unchecked, const Setup<S>&, const Params&) noexcept {}

  [[nodiscard]] Detection<S> start(const Vehicle<S>& vehicle, const Estimate<S>&) noexcept {
    return Detection<S>::none(vehicle);
  }
  [[nodiscard]] Detection<S> step(const Vehicle<S>& vehicle, const Estimate<S>&, const Allocation<S>&) noexcept {
    return Detection<S>::none(vehicle);
  }

  void telemetry(auto&&) const {}
};

}  // namespace gyrostat
