// SPDX-License-Identifier: MIT
/// @file  Effort against the worst missing torque that the uncertainty of the effectiveness allows: a second-order cone problem.
///
///   minimise  1/2 sum p_i (u_i - u_pref_i)^2 + residual_weight/2 worst(u)^2 over the box
///
/// worst: |W r| + s_max |diag(effectiveness_bound effectiveness) u| (bound), the exact worst case of a full error matrix of that
/// norm (exact), or |W r| + margin as printed in Yang et al. 2023, eq. (23) (paper_constant); r = tau - D diag(effectiveness) u.
/// Page: docs/components/robust_socp.md
#pragma once
#include "gyrostat/flight/allocators/parts/optimal_allocator.hpp"

namespace gyrostat {

template <class S>
class RobustSocp : public OptimalAllocator<S> {
 public:
  static constexpr const char* name = "robust_socp";

  struct Params : OptimalAllocatorParams<S> {
    S residual_weight;
    WorstCase worst_case = WorstCase::bound;
    S margin = S(0);

    static constexpr void describe(auto& p, auto&& field) {
      OptimalAllocatorParams<S>::describe(p, field);
      field(p.residual_weight,
            Field{"residual_weight", "", 1e-6, 1e12, "price of the squared worst missing torque against effort"});
      field(p.worst_case,
            Choice{"worst_case", "bound|exact|paper_constant", "closed-form bound, exact worst case, or |r| + margin"});
      field(p.margin, Field{"margin", "N m", 0, 1e6, "constant added to |r|; used by paper_constant alone"});
    }
    explicit Params(const Setup<S>& setup) noexcept
        : OptimalAllocatorParams<S>(setup), residual_weight(S(1e3) * RobustSocp::per_squared_axis(setup)) {}
  };

  static Status<S> check(const Setup<S>& setup, const Params& params) noexcept {
    return RobustSocp::check_shared(setup, params);
  }

  RobustSocp(Unchecked, const Setup<S>& setup, const Params& params) noexcept
      : OptimalAllocator<S>(setup, params, AllocationMode::robust_socp) {
    this->problem().residual_weight = params.residual_weight;
    this->problem().worst_case = params.worst_case;
    this->problem().margin = params.margin;
  }

  void telemetry(auto&& log) const {
    log("theta", this->solution().theta);
    log("multiplier_B", this->solution().multiplier);
    log("primal", this->solution().primal);
  }
};

}  // namespace gyrostat
