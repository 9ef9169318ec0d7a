// SPDX-License-Identifier: MIT
/// @file  Optimal distribution of a torque over actuators with limits: four modes over one kernel, each with its certificate.
///
/// Heap-free, exception-free, bounded in iterations, deterministic. The command is inside the box for every input with a
/// valid box. Mathematics, modes and measured figures: docs/allocation.md
#pragma once
#include <bit>

#include "gyrostat/flight/allocators/parts/allocation_problem.hpp"
#include "gyrostat/flight/allocators/parts/branch_free.hpp"
#include "gyrostat/flight/allocators/parts/closest_torque.hpp"
#include "gyrostat/flight/allocators/parts/primal_polish.hpp"
#include "gyrostat/flight/allocators/parts/robust_torque.hpp"
#include "gyrostat/flight/allocators/parts/worst_case.hpp"

namespace gyrostat {

/// @tparam S float or double   @tparam M rows of torque (3 or 6)   @tparam N largest number of actuators
template <class S, int M, int N>
class AllocationSolver {
 public:
  using Scalar = S;
  using Torque = Eigen::Matrix<S, M, 1>;
  using Geometry = Eigen::Matrix<S, M, Eigen::Dynamic, 0, M, N>;
  using Problem = AllocationProblem<S, M, N>;
  using State = AllocationState<S, M, N>;
  using Solution = AllocationSolution<S, M, N>;

  /// @param D actuator axes in columns   @param row_weight > 0, how much a missing unit of each row matters
  /// @return false, and nothing changes, when something is not finite or a weight not positive
  bool configure(const Geometry& D, const Torque& row_weight = Torque::Ones()) noexcept {
    if (!D.allFinite() || !row_weight.allFinite() || !(row_weight.minCoeff() > S(0))) return false;
    D_ = D;
    W_ = row_weight;
    WD_ = row_weight.asDiagonal() * D;
    spread_known_ = false;
    for (Eigen::Index i = 0; i < D.cols(); ++i) column_size_[size_t(i)] = WD_.col(i).cwiseAbs().maxCoeff();
    return true;
  }

  int actuators() const noexcept { return static_cast<int>(D_.cols()); }

  [[nodiscard]] Solution solve(const Problem& p, State& state) noexcept {
    Solution out;
    if (!acceptable(p)) return refuse(p, state);
    scale(p, out);
    const Torque start = warm_start(p, state);
    kernel_.steps = 0;
    S theta = S(0);
    Closest closest;
    bool capped = false;
    switch (p.mode) {
      case AllocationMode::lexicographic:
        closest = by_priority(p, start, within(p, state), out);
        capped = closest.capped;
        break;
      case AllocationMode::lexicographic_scaled:
        closest = along_demand(p, start, within(p, state), out);
        capped = closest.capped;
        break;
      case AllocationMode::weighted_least_squares:
        kernel_.R = Eigen::Matrix<S, M, M>::Identity() / residual_weight_;
        kernel_.centre.setZero();
        capped = !(within(p, state) && kernel_.solve_unlimited()) &&
                 kernel_.solve(start, std::min(p.max_newton, 60)) == NewtonOutcome::capped;
        break;
      case AllocationMode::robust_socp:
        theta = robust(p, start, state, out, capped);
        break;
    }
    collect(p, closest);
    report(p, theta, closest, capped, out);
    remember(p, closest, out, state);
    return out;
  }

 private:
  using size_t = std::size_t;
  using Closest = ClosestTorque<S, M, N>;
  static constexpr bool single = sizeof(S) < 8;
  static constexpr S far = single ? S(4096) : S(1 << 26);  // 1/sqrt(epsilon), about
  static constexpr S weight_cap = single ? S(1e4) : S(1e8);

  /// The power of two at or below x: scaling by it is free of rounding.
  static S power_of_two(S x) noexcept {
    using Bits = std::conditional_t<single, std::uint32_t, std::uint64_t>;
    constexpr Bits exponent = single ? Bits{0x7F800000u} : static_cast<Bits>(0x7FF0000000000000ull);
    const S tiny = std::numeric_limits<S>::min() * S(1 << 20);
    return std::bit_cast<S>(static_cast<Bits>(std::bit_cast<Bits>(std::max(x, tiny)) & exponent));
  }

  bool box_acceptable(const Problem& p) const noexcept {
    const Eigen::Index n = D_.cols();
    if (p.lo.size() != n || p.up.size() != n) return false;
    constexpr S infinity = std::numeric_limits<S>::infinity();
    bool good = true;
    for (Eigen::Index i = 0; i < n; ++i) good &= every(p.lo[i] <= p.up[i], p.lo[i]<infinity, p.up[i]> - infinity);
    return good;
  }

  bool acceptable(const Problem& p) const noexcept {
    const Eigen::Index n = D_.cols();
    if (!box_acceptable(p)) return false;
    if (p.effectiveness.size() != n || p.preferred.size() != n || p.effort_weight.size() != n || p.bound.size() != n)
      return false;
    constexpr S infinity = std::numeric_limits<S>::infinity();
    bool good = p.residual_weight > S(0) && p.residual_weight < infinity && p.margin >= S(0) && p.margin < infinity &&
                p.effectiveness_min >= S(0) && p.max_newton > 0;
    for (Eigen::Index i = 0; i < n; ++i) {
      good &= every(p.effectiveness[i] >= S(0), p.effectiveness[i] < infinity, p.bound[i] >= S(0),
                    p.bound[i]<infinity, p.effort_weight[i]> S(0), p.effort_weight[i] < infinity,
                    std::abs(p.preferred[i]) < infinity);
    }
    for (int r = 0; r < M; ++r) good &= std::abs(p.demand[r]) < infinity;
    return good;
  }

  /// Previous command (zero when there is none) clipped to the box; zero when the box itself is bad.
  Solution refuse(const Problem& p, const State& state) const noexcept {
    const Eigen::Index n = D_.cols();
    Solution out;
    out.status = AllocationStatus::bad_input;
    out.command = PerActuator<S, N>::Zero(n);
    if (!box_acceptable(p)) return out;
    for (Eigen::Index i = 0; i < n; ++i) {
      const S before = state.command.size() == n && std::isfinite(state.command[i]) ? state.command[i] : S(0);
      out.command[i] = std::min(std::max(before, p.lo[i]), p.up[i]);
    }
    return out;
  }

  /// Fills the kernel with the problem in units in which torques, axes and effort weights are of order one.
  void scale(const Problem& p, Solution& out) noexcept {
    const int n = static_cast<int>(D_.cols());
    kernel_.n = n;
    choose_units(p, out);
    const S per_geometry = S(1) / geometry_, per_torque = S(1) / torque_, per_effort = S(1) / effort_;
    S size = S(0);
    std::uint32_t active = 0;
    for (int i = 0; i < n; ++i) {
      const size_t k = size_t(i);
      const S e = effectiveness_[k] * per_geometry;
      active |= static_cast<std::uint32_t>(e > S(0) && !(p.lo[i] == S(0) && p.up[i] == S(0))) << i;
      kernel_.a[k] = e * WD_.col(i);
      kernel_.lo[k] = std::max(p.lo[i] * per_torque, -far);  // far: no limit
      kernel_.up[k] = std::min(p.up[i] * per_torque, far);
      kernel_.preferred[k] = clamped(p.preferred[i] * per_torque, out.warnings);
      const S weight = p.effort_weight[i] * per_effort;
      weight_[k] = std::max(weight, S(1) / weight_cap);
      if (weight < weight_[k]) out.warnings |= AllocationWarning::weight_capped;
      kernel_.compliance[k] = S(1) / weight_[k];
      const S reach = std::max(std::abs(kernel_.lo[k]), std::abs(kernel_.up[k]));
      size += reach < far ? reach * e * column_size_[k] : S(0);
    }
    for (int r = 0; r < M; ++r) {
      kernel_.b[r] = clamped(W_[r] * p.demand[r] * (per_geometry * per_torque), out.warnings);
      size_ = std::max(r == 0 ? size : size_, std::abs(kernel_.b[r]));
    }
    if (!spread_known_ || active != active_) spread_ = TorqueSpread<S, M>(WD_, active);
    spread_known_ = true;
    active_ = active;
    kernel_.tolerance = (single ? S(2e-7) : S(1e-13)) * size_;
    kernel_.rank_tolerance = single ? S(3e-5) : S(1e-10);

    residual_weight_ = p.residual_weight * per_effort * geometry_ * geometry_;
    if (residual_weight_ > weight_cap || residual_weight_ < S(1) / weight_cap) {
      residual_weight_ = std::clamp(residual_weight_, S(1) / weight_cap, weight_cap);
      out.warnings |= AllocationWarning::weight_capped;
    }
    out.residual_weight = residual_weight_ * effort_ / (geometry_ * geometry_);
  }

  /// Powers of two near the largest axis, torque and effort weight.
  void choose_units(const Problem& p, Solution& out) noexcept {
    S geometry = S(0), limit = S(0), preferred = S(0), effort = S(0);
    for (int i = 0; i < kernel_.n; ++i) {
      const size_t k = size_t(i);
      const S e = p.effectiveness[i], lo = std::abs(p.lo[i]), up = std::abs(p.up[i]);
      if (e > S(1)) out.warnings |= AllocationWarning::effectiveness_clamped;
      effectiveness_[k] = e < p.effectiveness_min ? S(0) : std::min(e, S(1));
      geometry = std::max(geometry, effectiveness_[k] * column_size_[k]);
      limit = std::max(limit, lo < std::numeric_limits<S>::infinity() ? lo : S(0));
      limit = std::max(limit, up < std::numeric_limits<S>::infinity() ? up : S(0));
      preferred = std::max(preferred, std::abs(p.preferred[i]));
      effort = std::max(effort, p.effort_weight[i]);
    }
    geometry_ = geometry > S(0) ? power_of_two(geometry) : S(1);
    effort_ = power_of_two(effort);
    if (!(limit > S(0))) {  // no limits: the demand sets the scale
      limit = preferred;
      for (int r = 0; r < M; ++r) limit = std::max(limit, std::abs(W_[r] * p.demand[r]) / geometry_);
    }
    torque_ = limit > S(0) ? power_of_two(limit) : S(1);
  }

  static S clamped(S x, std::uint8_t& warnings) noexcept {
    if (std::abs(x) <= far) return x;
    warnings |= AllocationWarning::demand_clamped;
    return x > S(0) ? far : -far;
  }

  Torque warm_start(const Problem& p, const State& state) const noexcept {
    if (!state.valid || state.mode != p.mode) return Torque::Zero();
    const Torque y = state.multiplier * (geometry_ / (effort_ * torque_));
    const bool weighted = p.mode == AllocationMode::weighted_least_squares || p.mode == AllocationMode::robust_socp;
    const S largest = (weighted ? S(10) * residual_weight_ : single ? S(1e2) : S(1e6)) * (size_ + S(1));
    return y.allFinite() && y.cwiseAbs().maxCoeff() <= largest ? y : Torque::Zero();
  }

  /// Whether limits may well not matter: the command before was at none, or there was none.
  bool within(const Problem& p, const State& state) const noexcept {
    if (!p.try_unlimited) return false;
    bool inside = true;
    for (Eigen::Index i = 0; i < state.command.size() && i < p.lo.size(); ++i)
      inside &= some(every(state.command[i] > p.lo[i], state.command[i] < p.up[i]), p.lo[i] == p.up[i]);
    return inside;
  }

  /// Rows of the smallest priority number first; what they achieve is then held while the next come as close as they can.
  Closest by_priority(const Problem& p, const Torque& start, bool within, Solution& out) noexcept {
    const auto [first, last] = std::minmax_element(p.priority.begin(), p.priority.end());
    if (*first == *last) {
      const Closest closest = ClosestTorqueSolve<S, M, N>(kernel_, size_, p.max_newton).from(start, within);
      out.outer = closest.rounds + 1;
      return closest;
    }
    const std::array<Torque, std::size_t(N)> a = kernel_.a;
    const Torque b = kernel_.b;
    Closest closest;
    Eigen::Matrix<S, M, M> settled = Eigen::Matrix<S, M, M>::Zero();
    unsigned held = 0;
    bool attained = true;
    S excess = S(0);
    for (int level = *first; level <= *last; ++level) {
      unsigned rows = 0;
      for (int r = 0; r < M; ++r) rows |= p.priority[size_t(r)] == level ? 1u << r : 0u;
      if (rows == 0) continue;
      for (int i = 0; i < kernel_.n; ++i)
        for (int r = 0; r < M; ++r) kernel_.a[size_t(i)][r] = ((rows | held) >> r & 1u) != 0u ? a[size_t(i)][r] : S(0);
      for (int r = 0; r < M; ++r)
        if ((held >> r & 1u) == 0u) kernel_.b[r] = (rows >> r & 1u) != 0u ? b[r] : S(0);
      closest = ClosestTorqueSolve<S, M, N>(kernel_, size_, p.max_newton, held, settled).from(Torque::Zero());
      out.outer += closest.rounds + 1;
      attained = attained && closest.attained;
      excess = std::max(excess, closest.excess);
      if (!closest.attained) settled += settle(closest);
      held |= rows;
      for (int r = 0; r < M; ++r) {
        if ((rows >> r & 1u) == 0u) continue;
        kernel_.b[r] = S(0);
        for (int i = 0; i < kernel_.n; ++i) kernel_.b[r] += closest.tau[size_t(i)] * kernel_.a[size_t(i)][r];
      }
    }
    closest.attained = attained;
    closest.excess = excess;
    return closest;
  }

  /// A row that is as close as it comes leaves no choice to the actuators that act along the separating direction.
  Eigen::Matrix<S, M, M> settle(const Closest& closest) noexcept {
    constexpr S negligible = single ? S(1e-4) : S(1e-9);
    const S length = closest.direction.norm();
    if (!(length > S(0))) return Eigen::Matrix<S, M, M>::Zero();
    const Torque v = closest.direction / length;
    for (int i = 0; i < kernel_.n; ++i) {
      const size_t k = size_t(i);
      if (std::abs(kernel_.a[k].dot(v)) > negligible) kernel_.lo[k] = kernel_.up[k] = closest.tau[k];
    }
    return v * v.transpose();
  }

  /// The largest s in [0, 1] with s b attainable, by cuts: a direction v that separates s b from the attainable set proves
  /// s <= support(v) / v'b, and the next attempt is made there. Each cut is a face, so there are finitely many.
  Closest along_demand(const Problem& p, const Torque& start, bool within, Solution& out) noexcept {
    const Torque b = kernel_.b;
    S s = S(1);
    Torque cut = Torque::Zero();
    Closest closest;
    bool lost = false;
    for (int k = 0; k < 40; ++k) {
      kernel_.b = s * b;
      closest = ClosestTorqueSolve<S, M, N>(kernel_, size_, p.max_newton).from(start, within && k == 0);
      out.outer += closest.rounds + 1;
      if (closest.attained || closest.capped || !proven_out_of_reach(closest)) break;
      const S slope = closest.direction.dot(b);
      const S next = support(kernel_, closest.direction) / slope;
      lost = !(slope > S(0)) || next < S(0);
      if (lost || !(next < s)) break;
      s = next;
      cut = closest.direction;
    }
    if (lost) {
      out.warnings |= AllocationWarning::direction_lost;
      kernel_.b = b;
      closest = ClosestTorqueSolve<S, M, N>(kernel_, size_, p.max_newton).from(Torque::Zero());
      out.scale = S(0);
      return closest;
    }
    out.scale = s;
    closest.attained = s == S(1);
    closest.direction = cut;
    return closest;
  }

  /// A residual at the level of rounding has no direction that proves anything.
  bool proven_out_of_reach(const Closest& closest) const noexcept {
    return S(2) * closest.excess < residual(closest.tau).norm();
  }

  S robust(const Problem& p, const Torque& start, const State& state, Solution& out, bool& capped) noexcept {
    RobustTorque<S, M, N> robust;
    const S s_max = spread_.s_max / geometry_;
    for (int i = 0; i < kernel_.n; ++i) {
      const size_t k = size_t(i);
      const S g = s_max * p.bound[i] * effectiveness_[k];
      robust.effort[k] = weight_[k];
      robust.preferred[k] = kernel_.preferred[k];
      const S growth = std::min(residual_weight_ * g * g, single ? S(1e20) : S(1e100));  // finite over any theta
      robust.growth[k] = p.worst_case == WorstCase::paper_constant ? S(0) : growth;
    }
    if (p.worst_case == WorstCase::paper_constant) robust.margin = p.margin / (geometry_ * torque_);
    robust.h = residual_weight_;
    const bool warm = state.valid && state.mode == p.mode && state.theta > S(0) && state.theta <= S(1);
    const S first = warm ? state.theta : S(0.5);
    S theta = S(0);
    if (p.worst_case == WorstCase::exact) {
      robust.values = spread_.values;
      theta = along_axes([&](const Torque& y) { return robust.solve(kernel_, y, first, p.max_newton); }, start);
    } else {
      theta = robust.solve(kernel_, start, first, p.max_newton);
      y_ = kernel_.y();
    }
    command_ = robust.tau;
    capped = robust.capped;
    out.outer = robust.outer;
    return theta;
  }

  /// A solve in the eigenvectors of Sb: there R is diagonal, and its small element is not lost beside the large ones.
  S along_axes(auto&& solve, const Torque& start) noexcept {
    const auto& axes = spread_.axes;
    const std::array<Torque, std::size_t(N)> a = kernel_.a;
    const Torque b = kernel_.b;
    for (int i = 0; i < kernel_.n; ++i) kernel_.a[size_t(i)] = axes.transpose() * a[size_t(i)];
    kernel_.b = axes.transpose() * b;
    const S theta = solve(Torque(axes.transpose() * start));
    y_ = axes * kernel_.y();
    kernel_.a = a;
    kernel_.b = b;
    return theta;
  }

  /// The command in the kernel's units, and the multiplier that goes with it.
  void collect(const Problem& p, const Closest& closest) noexcept {
    polished_ = is_lexicographic(p);
    if (polished_) {
      command_ = closest.tau;
      y_ = closest.y;
      return;
    }
    if (p.mode == AllocationMode::robust_socp) return;  // it left them
    for (int i = 0; i < kernel_.n; ++i) command_[size_t(i)] = kernel_.tau(i);
    y_ = kernel_.y();
    const bool cancels = y_.cwiseAbs().maxCoeff() * std::numeric_limits<S>::epsilon() > (single ? S(1e-5) : S(1e-9));
    if (!cancels) return;
    const Polished<S, M, N> polished = polish<S, M, N>(kernel_, S(1) / residual_weight_);
    polished_ = objective(polished.tau, polished.residual) <= objective(command_, residual(command_));
    if (polished_) command_ = polished.tau;
  }

  static bool is_lexicographic(const Problem& p) noexcept {
    return p.mode == AllocationMode::lexicographic || p.mode == AllocationMode::lexicographic_scaled;
  }

  Torque residual(const std::array<S, std::size_t(N)>& tau) const noexcept {
    Torque r = kernel_.b;
    for (int i = 0; i < kernel_.n; ++i) r -= tau[size_t(i)] * kernel_.a[size_t(i)];
    return r;
  }

  S objective(const std::array<S, std::size_t(N)>& tau, const Torque& r) const noexcept {
    S sum = residual_weight_ * r.squaredNorm();
    for (int i = 0; i < kernel_.n; ++i) {
      const S off = tau[size_t(i)] - kernel_.preferred[size_t(i)];
      sum += weight_[size_t(i)] * off * off;
    }
    return sum / S(2);
  }

  struct Certificate {
    S primal, gap;
  };

  /// SI values of what is issued, its worst case and certificate.
  void report(const Problem& p, S theta, const Closest& closest, bool capped, Solution& out) const noexcept {
    const int n = kernel_.n;
    const S per_torque = S(1) / torque_;
    out.command.resize(n);
    S uncertain = S(0), effort = S(0);
    for (int i = 0; i < n; ++i) {
      const size_t k = size_t(i);
      const S t = std::min(std::max(command_[k] * torque_, p.lo[i]), p.up[i]);
      const S delivered = effectiveness_[k] * t, off = (t - p.preferred[i]) * per_torque;
      out.command[i] = t;
      out.saturated |= static_cast<std::uint32_t>(every(t != S(0), some(t <= p.lo[i], t >= p.up[i]))) << i;
      out.achieved += delivered * D_.col(i);
      uncertain += (p.bound[i] * delivered) * (p.bound[i] * delivered);
      effort += weight_[k] * off * off;
    }
    out.residual = p.demand - out.achieved;
    const Torque weighted = W_.cwiseProduct(out.residual);
    out.residual_norm = weighted.norm();
    out.newton = kernel_.steps;
    out.theta = theta;
    out.worst_case = worst_case(p, weighted, out.residual_norm, std::sqrt(uncertain));
    out.multiplier = y_ * (effort_ * torque_ / geometry_);
    out.residual_excess = closest.attained ? out.residual_norm : std::max(closest.excess, S(0)) * (geometry_ * torque_);

    const S per_residual = S(1) / (geometry_ * torque_), unit = effort_ * torque_ * torque_;
    const Certificate c = certificate(p, theta, effort / S(2), weighted * per_residual, out.worst_case * per_residual,
                                      uncertain * per_torque * per_torque);
    out.primal = c.primal * unit;
    out.gap = c.gap * unit;
    out.dual = (c.primal - c.gap) * unit;

    const bool delivered = is_lexicographic(p) ? closest.attained : meets(p, out);
    if (capped || !proven(p, closest, c, out.worst_case * per_residual))
      out.status = AllocationStatus::cap_reached;
    else if (!delivered)
      out.status = AllocationStatus::optimal_reduced;
    if (out.status != AllocationStatus::optimal) prove_infeasible(p, closest, weighted, out);
  }

  /// The certificate is within the documented bound, or within what the kernel's tolerance of the torque leaves open of the
  /// objective: that decides where the torques are tiny against the limits.
  bool proven(const Problem& p, const Closest& closest, const Certificate& c, S worst) const noexcept {
    if (is_lexicographic(p)) return closest.excess <= (single ? S(1e-4) : S(1e-11)) * size_;
    const S relative = single ? S(2e-3) : p.mode == AllocationMode::robust_socp ? S(1e-8) : S(1e-12);
    const S left = S(4) * std::sqrt(S(M)) * kernel_.tolerance;  // of the residual, at most
    return c.gap <= relative * c.primal + residual_weight_ * left * (worst + left);
  }

  /// Weighted modes never deliver all of a demand: a thousandth may be missing.
  bool meets(const Problem& p, const Solution& out) const noexcept {
    return out.residual_norm * out.residual_norm <= S(1e-6) * W_.cwiseProduct(p.demand).squaredNorm();
  }

  S worst_case(const Problem& p, const Torque& weighted, S norm, S uncertain) const noexcept {
    if (p.mode == AllocationMode::robust_socp && p.worst_case == WorstCase::exact)
      return spread_.exact(weighted, uncertain);
    if (p.mode == AllocationMode::robust_socp && p.worst_case == WorstCase::paper_constant) return norm + p.margin;
    return spread_.bound(norm, uncertain);
  }

  /// In the kernel's units. The gap is a sum over cones and actuators, no term of which is negative.
  Certificate certificate(const Problem& p, S theta, S effort, const Torque& r, S worst, S uncertain) const noexcept {
    const S h = residual_weight_;
    if (is_lexicographic(p)) return {effort, box_gap(p, S(0))};
    if (p.mode == AllocationMode::weighted_least_squares || !(theta > S(0)))
      return {effort + h * r.squaredNorm() / S(2),
              h * (r - y_ / h).squaredNorm() / S(2) + (polished_ ? box_gap(p, S(0)) : S(0))};
    const S s2 = square(spread_.s_max / geometry_);
    const bool constant = p.worst_case == WorstCase::paper_constant;
    const S cone = constant ? constant_gap(worst, r, p.margin / (geometry_ * torque_))
                            : cone_gap(p, worst, r, s2 * uncertain, theta);
    return {effort + h * worst * worst / S(2), h * cone + box_gap(p, constant ? S(0) : h * s2 / theta)};
  }

  static S square(S x) noexcept { return x * x; }

  /// worst^2/2 less its linear lower bound from z = -y/h and sigma = s_max^2 G tau/theta; spread2 = |sigma|^2 theta^2/s_max^2.
  S cone_gap(const Problem& p, S worst, const Torque& r, S spread2, S theta) const noexcept {
    const Torque z = -y_ / residual_weight_;
    const S covered = p.worst_case == WorstCase::exact ? z.dot(spread_.Sb * z) : z.squaredNorm();
    const S kappa2 = z.squaredNorm() + std::max(S(0), spread2 / (theta * theta) - covered);
    return (worst * worst + kappa2) / S(2) + z.dot(r) - spread2 / theta;
  }

  /// The same for |r| + margin.
  S constant_gap(S worst, const Torque& r, S margin) const noexcept {
    const Torque z = -y_ / residual_weight_;
    const S kappa = std::max(z.norm(), margin);
    return square(worst - kappa) / S(2) + kappa * (worst - margin) + z.dot(r);
  }

  /// Of each actuator: its cost under the multiplier less the least it could be. `growth` times (bound e)^2 tau is the part
  /// of sigma.
  S box_gap(const Problem& p, S growth) const noexcept {
    S gap = S(0);
    for (int i = 0; i < kernel_.n; ++i) {
      const size_t k = size_t(i);
      const S t = command_[k], weight = weight_[k], g = p.bound[i] * effectiveness_[k];
      const S z = p.preferred[i] / torque_ + (kernel_.a[k].dot(y_) - growth * g * g * t) / weight;
      const S best = std::min(std::max(z, kernel_.lo[k]), kernel_.up[k]);
      gap += weight * (t - best) * (t + best - S(2) * z) / S(2);
    }
    return gap;
  }

  /// A torque direction along which the whole attainable set falls short of the demand, if there is one to be seen.
  void prove_infeasible(const Problem& p, const Closest& closest, const Torque& weighted,
                        Solution& out) const noexcept {
    const bool known = closest.direction.squaredNorm() > S(0);
    if (!known && !(out.residual_norm > S(0))) return;
    const Torque v = known ? closest.direction : Torque(weighted / out.residual_norm);
    Torque b;
    for (int r = 0; r < M; ++r) b[r] = W_[r] * p.demand[r] / (geometry_ * torque_);
    const S slack = S(16) * std::numeric_limits<S>::epsilon() * size_;
    if (v.dot(b) > support(kernel_, v) + slack) out.infeasibility_direction = W_.cwiseProduct(v);
  }

  /// The warm start keeps the multiplier, less what the proximal rounds piled up along the separating direction.
  void remember(const Problem& p, const Closest& closest, const Solution& out, State& state) const noexcept {
    Torque y = y_;
    const S along = closest.direction.dot(y), enough = S(10) * size_;
    if (along > enough) y -= (along - enough) * closest.direction;
    state.multiplier = y * (effort_ * torque_ / geometry_);
    state.theta = out.theta;
    state.mode = p.mode;
    state.valid = true;
    state.command = out.command;
  }

  Geometry D_{M, 0}, WD_{M, 0};
  Torque W_ = Torque::Ones();
  std::array<S, std::size_t(N)> column_size_{};  // largest element of each column of W D
  TorqueSpread<S, M> spread_;
  std::uint32_t active_ = 0;  // actuators in spread_
  bool spread_known_ = false;
  // Of the solve under way; nothing here is read by the next one.
  DualNewton<S, M, N> kernel_;
  std::array<S, std::size_t(N)> effectiveness_, weight_, command_;
  bool polished_ = false;  // command_ is not quite the kernel's
  Torque y_;
  S geometry_ = S(1), torque_ = S(1), effort_ = S(1), size_ = S(1), residual_weight_ = S(1);
};

}  // namespace gyrostat
