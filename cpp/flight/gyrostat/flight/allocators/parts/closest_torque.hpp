// SPDX-License-Identifier: MIT
/// @file  The torque closest to a demand, and of all commands that deliver it the one of least effort.
///
/// First the undamped Newton method (R = 0), which ends at a feasible demand exactly. Where the unclipped actuators stop
/// spanning the torque space, the demand is out of reach or at the edge: then proximal rounds (R = delta I, centre <- y),
/// each polished. With v along the residual,
///
///     |b - A tau'| >= v'b - max over the box of v'A tau'     for every tau' in the box, |v| = 1
///
/// proves how close to the smallest residual a round came. The effort needs no proof: tau(y) is least for what it delivers.
/// Page: docs/allocation.md
#pragma once
#include "gyrostat/flight/allocators/parts/dual_newton.hpp"
#include "gyrostat/flight/allocators/parts/primal_polish.hpp"

namespace gyrostat {

/// Largest v'A tau over the box.
template <class S, int M, int N>
S support(const DualNewton<S, M, N>& k, const Eigen::Matrix<S, M, 1>& v) noexcept {
  S sum = S(0);
  for (int i = 0; i < k.n; ++i) {
    const std::size_t j = std::size_t(i);
    const S reach = k.a[j].dot(v);
    sum += std::max(reach * k.lo[j], reach * k.up[j]);
  }
  return sum;
}

template <class S, int M, int N>
struct ClosestTorque {
  using Torque = Eigen::Matrix<S, M, 1>;

  std::array<S, std::size_t(N)> tau;
  Torque y = Torque::Zero();
  bool attained = false;
  bool capped = false;
  int rounds = 0;
  Torque direction = Torque::Zero();  ///< separates demand and attainable set
  S excess = S(0);                    ///< residual less its proven lower bound
  S effort_gap = S(0);                ///< effort less its lower bound at the torque delivered
};

/// One solve for the demand in `k.b`, in the scaled units of the kernel.
template <class S, int M, int N>
class ClosestTorqueSolve {
 public:
  using Torque = Eigen::Matrix<S, M, 1>;
  using Kernel = DualNewton<S, M, N>;
  using Result = ClosestTorque<S, M, N>;

  /// @param size of the torques of the problem   @param cap on the kernel's count of steps
  /// @param held bit r: row r keeps its demand (known to be attainable) exactly, and the others come as close as they can
  /// @param settled sum of v v' over directions in which nothing can move any more
  ClosestTorqueSolve(Kernel& kernel, S size, int cap, unsigned held = 0,
                     const Eigen::Matrix<S, M, M>& settled = Eigen::Matrix<S, M, M>::Zero()) noexcept
      : k(kernel), size_(size), cap_(cap), held_(held), settled_(settled) {}

  /// @param within  try first whether the limits matter at all
  Result from(const Torque& start, bool within = false) noexcept {
    Result out;
    S trace = S(0);
    for (int i = 0; i < k.n; ++i) trace += k.compliance[std::size_t(i)] * k.a[std::size_t(i)].squaredNorm();
    S delta = (single ? S(1e-3) : S(1e-6)) * (trace > S(0) ? trace / S(M) : S(1));
    Torque y = start;
    for (; out.rounds < 10; ++out.rounds) {
      if (exactly(y, within && out.rounds == 0)) {
        keep_current(out);
        out.attained = true;
        out.excess = S(0);
        return out;
      }
      if (out.rounds == 0 && k.y().norm() * delta <= S(10) * size_) y = k.y();  // later rounds go on from the last one
      proximal(y, delta);
      out.capped = k.steps >= cap_;
      judge(out);
      y = k.y();
      if (out.attained || out.capped || (out.excess <= excess_tolerance() && out.effort_gap <= effort_tolerance()))
        return out;
      delta = std::max(delta / S(10), left_ / largest_multiplier);
    }
    return out;
  }

 private:
  static constexpr bool single = sizeof(S) < 8;
  S excess_tolerance() const noexcept { return (single ? S(4e-7) : S(1e-13)) * size_; }
  static constexpr S largest_multiplier =
      single ? S(1e4) : S(1e9);  // a round adds residual / delta: beyond this its digits are lost
  static constexpr S effort_tolerance() noexcept { return single ? S(1e-6) : S(1e-13); }
  int budget() const noexcept { return std::min(cap_, k.steps + 60); }

  /// R = 0: succeeds when the demand is attained.
  bool exactly(const Torque& y, bool within) noexcept {
    k.R = settled_;
    k.centre.setZero();
    if (within && k.solve_unlimited()) return true;
    const NewtonOutcome outcome = k.solve(y, budget(), /*stop_at_singular=*/true);
    return outcome == NewtonOutcome::converged ||
           (outcome == NewtonOutcome::floor && k.F().norm() <= S(10) * excess_tolerance());
  }

  /// One round. Held rows are given a much smaller delta, and repeats of their own, so that they do not yield to the others.
  void proximal(const Torque& y, S delta) noexcept {
    constexpr S firm = single ? S(1e-3) : S(1e-6);
    Torque diagonal;
    for (int r = 0; r < M; ++r) diagonal[r] = is_held(r) ? delta * firm : delta;
    k.centre = y;
    k.R = settled_;
    for (int r = 0; r < M; ++r) k.R(r, r) += diagonal[r];
    for (int inner = 0; inner < 8; ++inner) {
      if (k.solve(k.centre, budget()) == NewtonOutcome::capped) return;
      if (held_error(diagonal.cwiseProduct(k.y() - k.centre)) <= S(4) * k.tolerance) return;
      for (int r = 0; r < M; ++r)
        if (is_held(r)) k.centre[r] = k.y()[r];
    }
  }

  /// Takes over the polished point, or the plain one, whichever is proven closer to the smallest residual.
  void judge(Result& out) noexcept {
    Result plain = out;
    keep_current(plain);
    Torque left = k.b;
    for (int i = 0; i < k.n; ++i) left -= plain.tau[std::size_t(i)] * k.a[std::size_t(i)];
    Polished<S, M, N> p = polish<S, M, N>(k, S(0), held_);
    prove(left, p.across, plain);
    Result polished = judged(p, out);
    if (!polished.attained && polished.excess > excess_tolerance()) {
      const Polished<S, M, N> q = polish<S, M, N>(k, S(0), held_, misplaced(polished));
      const Result released = judged(q, out);
      if (released.excess < polished.excess) {
        polished = released;
        p = q;
      }
    }
    const bool better = !plain.attained && (polished.attained || polished.excess <= plain.excess);
    left_ = length(better ? p.residual : left);
    out = better && polished.effort_gap <= S(1e3) * effort_tolerance() ? polished : plain;
  }

  Result judged(const Polished<S, M, N>& p, const Result& so_far) const noexcept {
    Result r = so_far;
    r.tau = p.tau;
    r.y = p.y;
    prove(p.residual, p.across, r);
    r.effort_gap = effort_gap(r);
    return r;
  }

  /// Actuators that could still push along the direction that ought to prove the residual: a large multiplier leaves open
  /// on which side of their limit they are.
  std::uint32_t misplaced(const Result& r) const noexcept {
    std::uint32_t out = 0;
    for (int i = 0; i < k.n; ++i) {
      const std::size_t j = std::size_t(i);
      const S reach = k.a[j].dot(r.direction);
      const S room = reach > S(0) ? k.up[j] - r.tau[j] : k.lo[j] - r.tau[j];
      out |= static_cast<std::uint32_t>(reach * room > S(0.1) * excess_tolerance()) << i;
    }
    return out;
  }

  /// Of a command that is not tau(y) exactly: its effort less the lower bound that y proves, from terms that are never negative.
  S effort_gap(const Result& r) const noexcept {
    S sum = S(0);
    for (int i = 0; i < k.n; ++i) {
      const std::size_t j = std::size_t(i);
      const S z = k.preferred[j] + k.compliance[j] * k.a[j].dot(r.y);
      const S best = std::min(std::max(z, k.lo[j]), k.up[j]);
      sum += (r.tau[j] - best) * (r.tau[j] + best - S(2) * z) / (S(2) * k.compliance[j]);
    }
    return sum;
  }

  /// Lower bound of the residual from a direction in which no unclipped actuator acts.
  void prove(const Torque& residual, const Torque& separating, Result& r) const noexcept {
    if (residual.cwiseAbs().maxCoeff() <= S(4) * k.tolerance) {
      r.attained = true;
      r.excess = S(0);
      return;
    }
    const S magnitude = length(separating), broken = held_error(residual);
    if (!(magnitude > S(0))) {
      r.excess = length(residual) + broken;
      return;
    }
    const Torque v = separating / magnitude;
    S shortfall = S(0);  // of v'A tau against its maximum over the box, from terms that are never negative
    for (int i = 0; i < k.n; ++i) {
      const std::size_t j = std::size_t(i);
      const S reach = k.a[j].dot(v);
      shortfall += reach > S(0) ? reach * (k.up[j] - r.tau[j]) : reach * (k.lo[j] - r.tau[j]);
    }
    const S size = length(residual);
    r.direction = v;
    r.excess = std::clamp(size - v.dot(residual) + shortfall, S(0), size) + broken;
  }

  void keep_current(Result& r) const noexcept {
    r.y = k.y();
    for (int i = 0; i < k.n; ++i) r.tau[std::size_t(i)] = k.tau(i);
  }

  bool is_held(int row) const noexcept { return (held_ >> row & 1u) != 0u; }

  S held_error(const Torque& residual) const noexcept {
    S worst = S(0);
    for (int r = 0; r < M; ++r) worst = is_held(r) ? std::max(worst, std::abs(residual[r])) : worst;
    return worst;
  }

  /// Of the rows that are not held.
  S length(const Torque& v) const noexcept {
    S sum = S(0);
    for (int r = 0; r < M; ++r) sum += is_held(r) ? S(0) : v[r] * v[r];
    return std::sqrt(sum);
  }

  Kernel& k;
  S size_;
  int cap_;
  unsigned held_;
  Eigen::Matrix<S, M, M> settled_;
  S left_ = S(0);  // residual of the last round
};

}  // namespace gyrostat
