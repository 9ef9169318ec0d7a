// SPDX-License-Identifier: MIT
/// @file  What is asked of the allocation solver and what it answers. SI throughout.
///
/// M rows of torque (3, or 6 with forces), at most N actuators. W = diag(row weights) and D belong to the solver's
/// configuration; A = W D diag(effectiveness). Page: docs/allocation.md
#pragma once
#include <Eigen/Core>
#include <array>
#include <cstdint>

namespace gyrostat {

enum class AllocationMode : std::uint8_t {
  lexicographic,           ///< closest torque, then least effort
  lexicographic_scaled,    ///< the largest share of the demand along its own direction, then least effort
  weighted_least_squares,  ///< least effort + residual_weight/2 |W r|^2
  robust_socp              ///< least effort + residual_weight/2 (worst case of |W r|)^2
};

/// Worst residual under an effectiveness error of relative half-width `bound` (robust_socp).
enum class WorstCase : std::uint8_t {
  bound,          ///< |r| + s_max |diag(bound e) tau|: closed form, never below the exact one
  exact,          ///< exact for a full error matrix of that norm
  paper_constant  ///< |r| + margin, as printed in Yang et al. 2023, eq. (23): no model of uncertainty, kept for comparison
};

enum class AllocationStatus : std::uint8_t {
  optimal,          ///< optimal, and the demand is delivered (weighted modes: to a thousandth)
  optimal_reduced,  ///< optimal, but the demand cannot or is not to be delivered in full
  cap_reached,  ///< not proven optimal to the documented bound (an iteration limit, rounding): inside the box, gap reported
  bad_input  ///< refused: the previous command, clipped
};

/// Bits of AllocationSolution::warnings.
struct AllocationWarning {
  static constexpr std::uint8_t effectiveness_clamped = 1;  ///< above 1
  static constexpr std::uint8_t weight_capped = 2;   ///< residual or effort weight beyond what the scalar resolves
  static constexpr std::uint8_t demand_clamped = 4;  ///< demand or preference beyond 1/sqrt(epsilon) limits
  static constexpr std::uint8_t direction_lost =
      8;  ///< no part of the demand's ray is attainable: closest torque instead
};

template <class S, int N>
using PerActuator = Eigen::Matrix<S, Eigen::Dynamic, 1, 0, N, 1>;

/// One allocation. Per-actuator vectors have as many entries as the solver has columns.
template <class S, int M, int N>
struct AllocationProblem {
  using Torque = Eigen::Matrix<S, M, 1>;

  Torque demand = Torque::Zero();   ///< N m
  PerActuator<S, N> effectiveness;  ///< delivered / commanded, >= 0; above 1 is clamped
  PerActuator<S, N> lo, up;         ///< N m, limits of the command; infinite: none
  PerActuator<S, N> preferred;      ///< N m
  PerActuator<S, N> effort_weight;  ///< > 0
  PerActuator<S, N> bound;          ///< relative half-width of the effectiveness, >= 0
  AllocationMode mode = AllocationMode::lexicographic;
  WorstCase worst_case = WorstCase::bound;
  S residual_weight =
      S(1e4);       ///< gamma (weighted_least_squares), h (robust_socp); unit of effort_weight / (row weight D)^2
  S margin = S(0);  ///< N m (row-weighted), paper_constant only
  std::array<std::uint8_t, std::size_t(M)>
      priority{};  ///< rows of a smaller number are served first (lexicographic); equal: together
  /// Less than this is treated as failed: the closest torque would saturate such an actuator for nothing.
  S effectiveness_min = sizeof(S) < 8 ? S(1e-2) : S(1e-3);
  int max_newton = 200;  ///< limit of all Newton steps together
  /// First see whether the solution without limits is inside them: where it is, it is the solution. Not for robust_socp, whose
  /// worst case is not quadratic.
  bool try_unlimited = true;

  /// n healthy actuators of known effectiveness within +- `limit`, preferring zero, equal weights.
  static AllocationProblem symmetric(int n, S limit) noexcept {
    AllocationProblem p;
    p.effectiveness.setOnes(n);
    p.up.setConstant(n, limit);
    p.lo.setConstant(n, -limit);
    p.preferred.setZero(n);
    p.effort_weight.setOnes(n);
    p.bound.setZero(n);
    return p;
  }
};

/// What may be carried from one solve to the next: a warm start, and the command to repeat when an input is refused.
template <class S, int M, int N>
struct AllocationState {
  Eigen::Matrix<S, M, 1> multiplier = Eigen::Matrix<S, M, 1>::Zero();
  S theta = S(0.5);
  AllocationMode mode = AllocationMode::lexicographic;
  bool valid = false;
  PerActuator<S, N> command;  ///< N m; empty: none yet

  void reset() noexcept { *this = AllocationState{}; }
};

template <class S, int M, int N>
struct AllocationSolution {
  using Torque = Eigen::Matrix<S, M, 1>;

  PerActuator<S, N> command;           ///< N m, inside the box without exception
  Torque achieved = Torque::Zero();    ///< N m, D diag(effectiveness) command
  Torque residual = Torque::Zero();    ///< N m, demand - achieved
  S residual_norm = S(0);              ///< |W residual|
  S residual_excess = S(0);            ///< lexicographic modes: residual_norm less a proven lower bound of it
  Torque multiplier = Torque::Zero();  ///< y: with it anybody can check primal, dual and gap
  S theta = S(0);                      ///< robust_socp: split of the worst case
  S scale = S(1);                      ///< lexicographic_scaled: delivered share of the demand
  S worst_case = S(0);                 ///< worst |W r| under `bound`
  S primal = S(0), dual = S(0);        ///< lexicographic modes: effort, and its bound at the achieved torque
  S gap = S(0);                        ///< primal - dual, summed from terms that are never negative
  S residual_weight = S(0);            ///< as used, after capping
  Torque infeasibility_direction =
      Torque::Zero();           ///< v: v'demand > max over the box of v'D e tau; zero when there is none
  std::uint32_t saturated = 0;  ///< bit i: command i sits on a limit, and is not at rest (zero)
  int newton = 0, outer = 0;
  AllocationStatus status = AllocationStatus::optimal;
  std::uint8_t warnings = 0;
};

}  // namespace gyrostat
