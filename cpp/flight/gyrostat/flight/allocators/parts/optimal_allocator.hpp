// SPDX-License-Identifier: MIT
/// @file  What the optimal allocators of the catalogue share: the vehicle's limits, masks and estimates become one
///        allocation problem, its answer an Allocation. Page: docs/allocation.md
#pragma once
#include <algorithm>
#include <cmath>

#include "gyrostat/core/params.hpp"
#include "gyrostat/core/power.hpp"
#include "gyrostat/flight/allocators/parts/allocation_solver.hpp"
#include "gyrostat/flight/parts/effectiveness_floor.hpp"
#include "gyrostat/flight/parts/served_geometry.hpp"

namespace gyrostat {

/// What limits an actuator of reduced effectiveness e.
enum class BoundPolicy : std::uint8_t {
  physical,  ///< its command, as before: it delivers up to e u_max
  derated    ///< e u_max on the command, as printed in Yang et al. 2023, eq. (21): it delivers up to e^2 u_max
};

/// Parameters that all optimal allocators have.
template <class S>
struct OptimalAllocatorParams {
  VecN<S> effort_weight;
  S uncertainty_weight = S(0);
  Vec3<S> axis_weight = Vec3<S>::Ones();
  BoundPolicy bound_policy = BoundPolicy::physical;
  S bound_cap = S(0.1);
  S e_min = default_effectiveness_floor<S>;
  S rank_tolerance = default_rank_tolerance<S>;
  int max_newton = 200;

  explicit OptimalAllocatorParams(const Setup<S>& setup) noexcept
      : effort_weight(VecN<S>::Ones(setup.vehicle.actuators())) {}

  static constexpr void describe(auto& p, auto&& field) {
    field(p.effort_weight,
          Field{"effort_weight", "", 1e-6, 1e6, "price of an actuator's squared torque against the others'"});
    field(p.uncertainty_weight, Field{"uncertainty_weight", "", 0, 1e6,
                                      "added to effort_weight, times (effectiveness_bound effectiveness)^2"});
    field(p.axis_weight, Field{"axis_weight", "", 1e-3, 1e3, "how much a missing torque about each body axis matters"});
    field(p.bound_policy,
          Choice{"bound_policy", "physical|derated", "limit of a weakened actuator: u_max, or effectiveness u_max"});
    field(p.bound_cap,
          Field{"bound_cap", "", 0, 1, "effectiveness_bound is taken as this where it is larger or unknown"});
    field(p.e_min, Field{"e_min", "", 1e-3, 1, "weaker actuators are not used"});
    field(p.rank_tolerance, rank_tolerance_field);
    field(p.max_newton,
          Field{"max_newton", "", 1, 1000, "Newton steps a sample; beyond them the best so far is issued"});
  }
};

/// Base of the catalogue's optimal allocators. Rate limits go first: where they and the limits have no command in common
/// (derated limits of an actuator that just failed), the command moves towards its limits as fast as it may.
template <class S>
class OptimalAllocator {
 public:
  using Scalar = S;
  using Solver = AllocationSolver<S, 3, max_actuators>;

  static constexpr Estimates uses(const OptimalAllocatorParams<S>&) noexcept { return {.effectiveness = true}; }
  static constexpr S effectiveness_floor(const OptimalAllocatorParams<S>& p) noexcept { return p.e_min; }

  /// The previous command is zero again (or the limit nearest to it), the warm start forgotten.
  void reset(const Vehicle<S>& vehicle) noexcept {
    state_.reset();
    u_ = clip<S>(VecN<S>::Zero(vehicle.actuators()), vehicle.u_lo, vehicle.u_up);
    geometry_.reset();
  }

  [[nodiscard]] Allocation<S> step(const Vehicle<S>& vehicle, const Demand<S>& demand, const Estimate<S>& x,
                                   const Detection<S>& det) noexcept {
    use(x.axes.of(vehicle.D_B), det.enabled.without(det.failed), x);
    pose(vehicle, demand, x);
    state_.command = u_;
    solution_ = solver_.solve(problem_, state_);

    Allocation<S> out;
    out.u = solution_.command;
    out.demand_B = demand.tau_B;
    out.achieved_B = torque<S>(x.axes.of(vehicle.D_B), x.effectiveness.cwiseProduct(out.u));
    for (int i = 0; i < vehicle.actuators(); ++i)
      out.saturated.set(i, usable_.test(i) && (solution_.saturated >> i & 1u) != 0u);
    out.worst_case = solution_.worst_case;
    out.gap = has_weight() ? solution_.gap : solution_.residual_excess;
    out.iterations = solution_.newton;
    out.status = flags();
    u_ = out.u;
    return out;
  }

 protected:
  OptimalAllocator(const Setup<S>& setup, const OptimalAllocatorParams<S>& params, AllocationMode mode) noexcept
      : du_max_(setup.vehicle.u_rate * setup.dt), params_(params), geometry_(params.e_min, params.rank_tolerance) {
    problem_ = Problem::symmetric(setup.vehicle.actuators(), S(0));
    problem_.mode = mode;
    problem_.effectiveness_min = S(0);  // decided with the geometry
    problem_.max_newton = params.max_newton;
    reset(setup.vehicle);
  }

  /// Residual weights have the unit of 1 / D^2: the strongest actuator's torque axis sets it.
  static S per_squared_axis(const Setup<S>& setup) noexcept {
    S top = S(0);
    for (int i = 0; i < setup.vehicle.actuators(); ++i) top = std::max(top, setup.vehicle.D_B.col(i).squaredNorm());
    return top > S(0) ? S(1) / top : S(1);
  }

  static Status<S> check_shared(const Setup<S>& setup, const OptimalAllocatorParams<S>& params) noexcept {
    const int n = setup.vehicle.actuators();
    const auto given = params.effort_weight.size();
    return Status<S>::require(n >= 1, "actuators", static_cast<S>(n), S(1), ">=") &&
           Status<S>::require(given == n, "length of effort_weight", static_cast<S>(given), static_cast<S>(n), "==");
  }

  const typename Solver::Solution& solution() const noexcept { return solution_; }
  typename Solver::Problem& problem() noexcept { return problem_; }

 private:
  using Problem = typename Solver::Problem;

  bool has_weight() const noexcept {
    return problem_.mode == AllocationMode::weighted_least_squares || problem_.mode == AllocationMode::robust_socp;
  }

  /// The axes of the usable actuators, as far as they are served. What is dropped is gone from both sides of the problem.
  void use(const Mat3N<S>& D_B, Mask usable, const Estimate<S>& x) noexcept {
    const int n = static_cast<int>(D_B.cols()), rank = geometry_.rank();
    VecN<S> e(n);
    for (int i = 0; i < n; ++i) e[i] = usable.test(i) ? std::clamp(x.effectiveness[i], S(0), S(1)) : S(0);
    if (!geometry_.update(D_B, usable, e, x.axes.revision)) return;
    const bool changed = !(usable == usable_) || geometry_.rank() != rank || !state_.valid;
    if (!changed && x.axes.revision == revision_ && rank == 3) return;
    usable_ = usable;
    revision_ = x.axes.revision;
    Mat3N<S> D = D_B;
    for (int i = 0; i < n; ++i) D.col(i) = usable.test(i) ? geometry_.served(D.col(i)) : Vec3<S>(Vec3<S>::Zero());
    solver_.configure(D, params_.axis_weight);
    if (changed) state_.valid = false;
  }

  void pose(const Vehicle<S>& vehicle, const Demand<S>& demand, const Estimate<S>& x) noexcept {
    problem_.demand = geometry_.served(demand.tau_B);
    const S rounding = S(64) * Eigen::NumTraits<S>::epsilon();
    ignored_ = (demand.tau_B - problem_.demand).norm() > rounding * demand.tau_B.norm();
    for (int i = 0; i < vehicle.actuators(); ++i) {
      const bool usable = usable_.test(i);
      const S e = usable ? std::clamp(x.effectiveness[i], S(0), S(1)) : S(0);
      const S bound = std::min(x.effectiveness_bound[i], params_.bound_cap), spread = bound * e;
      problem_.effectiveness[i] = geometry_.effectiveness()[i];
      problem_.bound[i] = std::max(bound, S(0));
      problem_.preferred[i] = usable && demand.u_pref.size() != 0 ? demand.u_pref[i] : S(0);
      problem_.effort_weight[i] = params_.effort_weight[i] + params_.uncertainty_weight * spread * spread;
      const S share = params_.bound_policy == BoundPolicy::derated && usable ? e : S(1);
      limit(i, limited(vehicle.u_lo[i], share), limited(vehicle.u_up[i], share));
    }
  }

  static S limited(S limit, S share) noexcept { return std::isfinite(limit) ? limit * share : limit; }

  /// [lo, up] as far as the rate limit reaches it from the previous command.
  void limit(int i, S lo, S up) noexcept {
    const S slowest = u_[i] - du_max_[i], fastest = u_[i] + du_max_[i];
    problem_.lo[i] = std::min(std::max(lo, slowest), fastest);
    problem_.up[i] = std::max(std::min(up, fastest), slowest);
  }

  Flags flags() const noexcept {
    Flags f;
    if (solution_.status == AllocationStatus::optimal_reduced || ignored_) f.set(Flag::demand_not_met);
    if (solution_.status == AllocationStatus::cap_reached) f.set(Flag::cap_reached);
    if (solution_.status == AllocationStatus::bad_input) f.set(Flag::bad_input);
    if (geometry_.rank() < 3) f.set(Flag::rank_lost);
    return f;
  }

  VecN<S> du_max_;  ///< N m a sample
  OptimalAllocatorParams<S> params_;
  ServedGeometry<S> geometry_;
  Solver solver_;
  Problem problem_;
  typename Solver::State state_;
  typename Solver::Solution solution_;
  Mask usable_;
  std::uint32_t revision_ = 0;  ///< of the axes that the solver has
  VecN<S> u_;                   ///< issued at the previous sample
  bool ignored_ = false;        ///< the demand has a part along an axis that is not served
};

}  // namespace gyrostat
