// SPDX-License-Identifier: MIT
/// @file  The torque closest to the demand, and of all commands that deliver it the one of least effort.
///
///   1. minimise |W (tau - A u)| over the box     2. among those, minimise sum p_i (u_i - u_pref_i)^2,   A = D diag(effectiveness)
///
/// An attainable demand is met exactly. Axes may be served in order of priority. Page: docs/components/lexicographic.md
#pragma once
#include "gyrostat/flight/allocators/parts/optimal_allocator.hpp"

namespace gyrostat {

template <class S>
class Lexicographic : public OptimalAllocator<S> {
 public:
  static constexpr const char* name = "lexicographic";

  struct Params : OptimalAllocatorParams<S> {
    Vec3<S> axis_priority = Vec3<S>::Zero();

    static constexpr void describe(auto& p, auto&& field) {
      OptimalAllocatorParams<S>::describe(p, field);
      field(p.axis_priority,
            Field{"axis_priority", "", 0, 2, "0 is served first, whatever it costs the others; equal: together"});
    }
    explicit Params(const Setup<S>& setup) noexcept : OptimalAllocatorParams<S>(setup) {}
  };

  static Status<S> check(const Setup<S>& setup, const Params& params) noexcept {
    return Lexicographic::check_shared(setup, params);
  }

  Lexicographic(Unchecked, const Setup<S>& setup, const Params& params) noexcept
      : OptimalAllocator<S>(setup, params, AllocationMode::lexicographic) {
    for (int r = 0; r < 3; ++r)
      this->problem().priority[std::size_t(r)] = static_cast<std::uint8_t>(params.axis_priority[r]);
  }

  void telemetry(auto&& log) const {
    log("multiplier_B", this->solution().multiplier);
    log("residual_B", this->solution().residual);
    log("unreachable_B", this->solution().infeasibility_direction);
  }
};

}  // namespace gyrostat
