// SPDX-License-Identifier: MIT
/// @file  Effort against missing torque, in one strictly convex problem.
///
///   minimise  1/2 sum p_i (u_i - u_pref_i)^2 + residual_weight/2 |W (tau - A u)|^2 over the box,   A = D diag(effectiveness)
///
/// Unique, and Lipschitz in demand and effectiveness; an attainable demand is missed by about 1/residual_weight.
/// Page: docs/components/weighted_least_squares.md
#pragma once
#include "gyrostat/flight/allocators/parts/optimal_allocator.hpp"

namespace gyrostat {

template <class S>
class WeightedLeastSquares : public OptimalAllocator<S> {
 public:
  static constexpr const char* name = "weighted_least_squares";

  struct Params : OptimalAllocatorParams<S> {
    S residual_weight;

    static constexpr void describe(auto& p, auto&& field) {
      OptimalAllocatorParams<S>::describe(p, field);
      field(p.residual_weight,
            Field{"residual_weight", "", 1e-6, 1e12, "price of the squared missing torque against effort"});
    }
    /// 1e4 against an actuator with a unit axis: a thousandth of a per cent of an attainable demand is left.
    explicit Params(const Setup<S>& setup) noexcept
        : OptimalAllocatorParams<S>(setup), residual_weight(S(1e4) * WeightedLeastSquares::per_squared_axis(setup)) {}
  };

  static Status<S> check(const Setup<S>& setup, const Params& params) noexcept {
    return WeightedLeastSquares::check_shared(setup, params);
  }

  WeightedLeastSquares(Unchecked, const Setup<S>& setup, const Params& params) noexcept
      : OptimalAllocator<S>(setup, params, AllocationMode::weighted_least_squares) {
    this->problem().residual_weight = params.residual_weight;
  }

  void telemetry(auto&& log) const {
    log("multiplier_B", this->solution().multiplier);
    log("primal", this->solution().primal);
  }
};

}  // namespace gyrostat
