// SPDX-License-Identifier: MIT
/// @file  As much of the demand as can be had without turning it, by the command of least effort.
///
///   1. the largest s in [0, 1] with A u = s tau     2. among those, minimise sum p_i (u_i - u_pref_i)^2,   A = D diag(effectiveness)
///
/// Where no part of the demand can be had (rate limits may exclude zero torque) the closest torque is delivered.
/// Page: docs/components/lexicographic_scaled.md
#pragma once
#include "gyrostat/flight/allocators/parts/optimal_allocator.hpp"

namespace gyrostat {

template <class S>
class LexicographicScaled : public OptimalAllocator<S> {
 public:
  static constexpr const char* name = "lexicographic_scaled";

  struct Params : OptimalAllocatorParams<S> {
    explicit Params(const Setup<S>& setup) noexcept : OptimalAllocatorParams<S>(setup) {}
  };

  static Status<S> check(const Setup<S>& setup, const Params& params) noexcept {
    return LexicographicScaled::check_shared(setup, params);
  }

  LexicographicScaled(Unchecked, const Setup<S>& setup, const Params& params) noexcept
      : OptimalAllocator<S>(setup, params, AllocationMode::lexicographic_scaled) {}

  void telemetry(auto&& log) const {
    log("scale", this->solution().scale);
    log("multiplier_B", this->solution().multiplier);
  }
};

}  // namespace gyrostat
