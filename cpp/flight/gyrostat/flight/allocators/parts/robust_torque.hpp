// SPDX-License-Identifier: MIT
/// @file  Least effort plus h/2 (worst residual)^2: the second-order cone problem of robust allocation.
///
///     worst^2 = min over theta of  r'(I - theta Sb)^-1 r + spread^2/theta
///
/// turns it into the weighted problem for a fixed theta, which the dual Newton method solves with R = (I - theta Sb)/h and
/// effort weights p_i + h s_max^2 g_i^2/theta, around one scalar equation for theta in (0, 1]:
///
///     theta |Sb^(1/2) y| = h spread(tau),     or theta = 1 with <=.
///
/// Sb = I: the closed-form bound; else the exact worst case of worst_case.hpp. spread = s_max |diag(bound e) tau|, or a constant
/// (the margin of Yang et al. 2023, eq. (23)).
/// Page: docs/allocation.md
#pragma once
#include "gyrostat/flight/allocators/parts/dual_newton.hpp"

namespace gyrostat {

template <class S, int M, int N>
struct RobustTorque {
  using Torque = Eigen::Matrix<S, M, 1>;
  using Matrix = Eigen::Matrix<S, M, M>;

  // The problem, in the scaled units of the kernel.
  std::array<S, std::size_t(N)> effort, preferred;
  std::array<S, std::size_t(N)> growth;  ///< h s_max^2 (bound_i e_i)^2; zero for a constant margin
  Torque values = Torque::Ones();        ///< of Sb, whose eigenvectors are the axes of the problem
  S h = S(1);
  S margin = S(-1);  ///< constant spread; negative: it grows with tau

  // The answer, beside the kernel's multiplier.
  std::array<S, std::size_t(N)> tau;
  int outer = 0;
  bool capped = false;

  /// Solves from (y, theta); returns theta.
  S solve(DualNewton<S, M, N>& k, const Torque& start, S theta, int cap) noexcept {
    Found found{{S(0), S(1)}, false};
    if (uncertain(k.n)) {
      found = search(k, start, theta, cap);
    } else {
      weights(k, S(0));
      capped = !inside(k, start, found.split, cap);
    }
    theta = found.root ? settle(k, found.split, cap) : found.split.theta;
    refine(k, found.split.rest);
    return theta;
  }

 private:
  static constexpr bool single = sizeof(S) < 8;
  static constexpr S infinity = std::numeric_limits<S>::infinity();
  static constexpr S tolerance = single ? S(1e-4) : S(1e-10);  // relative, of theta |Sb^(1/2) y| against h spread
  static constexpr S coarse = single ? S(1e-2) : S(1e-5);      // of logit(theta), where settling is enough
  static constexpr S bottom = S(-23);                          // logit(theta): below, next to nothing is commanded
  static constexpr S top = single ? S(16) : S(36);             // above, 1 - theta is below rounding

  /// theta and 1 - theta, each with its own digits: near the apex of the cone the residual is (1 - theta) y / h.
  struct Split {
    S theta, rest;
    static Split at(S logit) noexcept {
      const S small = std::exp(-std::abs(logit)), large = S(1) / (S(1) + small);
      return logit < S(0) ? Split{small * large, large} : Split{large, small * large};
    }
    static constexpr Split one() noexcept { return {S(1), S(0)}; }
  };

  struct Found {
    Split split;
    bool root;  // false: an end of the interval, or out of iterations
  };

  /// The root in logit(theta), by Newton steps inside a bracket.
  Found search(DualNewton<S, M, N>& k, const Torque& start, S theta, int cap) noexcept {
    S lo = -infinity, up = infinity, postponed = -infinity,
      x = std::clamp(std::log(theta / (S(1) - theta)), bottom, top);
    bool tried_one = !(theta < S(1));
    Split split = tried_one ? Split::one() : Split::at(x);
    Torque y = start;
    for (outer = 1; outer <= 40; ++outer) {
      weights(k, split.theta);
      const bool apex = !(split.rest > S(0));
      const int before = k.steps;
      const bool reached = apex ? at_one(k, y, cap) : inside(k, y, split, cap);
      if (k.steps >= cap) break;
      const Torque Sy = values.cwiseProduct(k.y());
      const S ySy = std::max(k.y().dot(Sy), S(0));
      const S covered = split.theta * std::sqrt(ySy), worst = h * spread(k);
      const S f = reached ? covered - worst : infinity;
      if (reached) y = k.y();
      if (std::abs(f) <= tolerance * (covered + worst) || (apex && f <= S(0))) return {split, !apex};
      if (apex) {
        x = postponed > lo ? postponed : lo > -infinity ? middle(lo, up) : S(0);
        split = Split::at(x);
        continue;
      }
      if (f < S(0) && x >= top) return {Split::one(), false};
      if (f > S(0) && x <= bottom) return {split, false};
      (f > S(0) ? up : lo) = x;
      if (up - lo <= tolerance) return {split, true};
      const auto [step, rounding] = newton(k, split, Sy, ySy, worst);
      const bool unresolved = std::abs(step) <= rounding && (rounding < S(1) || up - lo < infinity);
      const bool still = k.steps == before && std::abs(step) <= coarse;
      if (std::abs(step) <= S(10) * tolerance || unresolved || still) return {split, true};
      const S next = std::clamp(x + std::clamp(step, S(-8), S(8)), bottom, top);
      const bool usable = std::isfinite(step) && next > lo && next < up && !(outer > 10 && outer % 2 == 0);
      if ((step > S(6) || !usable) && up == infinity && !tried_one) {
        tried_one = true;
        postponed = usable ? next : -infinity;
        split = Split::one();
      } else {
        x = usable ? next : middle(lo, up);
        split = Split::at(x);
      }
    }
    capped = true;
    return {split, false};
  }

  /// Of a bracket; the end of the interval where there is none yet.
  static S middle(S lo, S up) noexcept {
    if (up > top) return top;
    return lo < bottom && up - bottom < S(1) ? bottom : (std::max(lo, bottom) + up) / S(2);
  }

  /// I - (1 - rest) Sb: on the axis of the largest eigenvalue, which is 1, its digits are those of rest.
  Torque softness(S rest) const noexcept { return (Torque::Ones() - values) + rest * values; }

  /// At the root, y and theta made one: with the spread held, theta = h spread / |Sb^(1/2) y| belongs to y itself, and
  ///
  ///     F(y) = A tau(y) - b + (y - h spread Sb y / |Sb^(1/2) y|) / h
  ///
  /// has a Jacobian of 1/h along y where R has (1 - theta)/h. So the multiplier of a demand just out of reach, which R y = r
  /// leaves to rounding, follows from the size of the worst case. Across y it stays where it is but for `anchor`.
  S settle(DualNewton<S, M, N>& k, const Split& split, int cap) noexcept {
    constexpr S anchor = single ? S(1e-3) : S(1e-6);
    const Torque b = k.b;
    const bool ill = k.tolerance * h > S(1e-2) * tolerance * split.rest * k.y().norm();
    S theta = split.theta, last = S(0);
    for (int round = 0;; ++round) {
      const Torque y = k.y(), Sy = values.cwiseProduct(y);
      const S size = std::sqrt(y.dot(Sy)), worst = spread(k);
      if (!(size > S(0) && size < infinity && h * worst < infinity)) break;
      theta = std::min(h * worst / size, S(1));
      if (!ill || round == 5 || std::abs(size - last) <= S(1e-2) * tolerance * size) break;
      last = size;
      const S rest = std::max(split.rest, anchor);
      const Torque along = Sy / size;
      k.R = (S(1) - rest) * along * along.transpose();
      k.R.diagonal() += softness(rest);
      k.R /= h;
      k.b = b + worst * along;
      k.solve(y, std::min(cap, k.steps + 60));
    }
    k.b = b;
    return theta;
  }

  /// What the rounding of a large multiplier leaves of F, taken out of the unclipped commands themselves.
  void refine(const DualNewton<S, M, N>& k, S rest) noexcept {
    Matrix J = damping(k) * Matrix::Identity();
    for (int i = 0; i < k.n; ++i) {
      const std::size_t j = std::size_t(i);
      tau[j] = k.tau(i);
      if (k.is_free(i)) J += k.compliance[j] * k.a[j] * k.a[j].transpose();
    }
    for (int pass = 0; pass < 2; ++pass) {
      Torque F = softness(rest).cwiseProduct(k.y()) / h - k.b;
      for (int i = 0; i < k.n; ++i) F += tau[std::size_t(i)] * k.a[std::size_t(i)];
      Ldl<S, M> factor;
      if (!(F.cwiseAbs().maxCoeff() > S(10) * k.tolerance) || !factor.factor(J, S(0))) return;
      const Torque d = factor.solve(F);
      if (!d.allFinite()) return;
      for (int i = 0; i < k.n; ++i) {
        const std::size_t j = std::size_t(i);
        if (k.is_free(i)) tau[j] = std::min(std::max(tau[j] - k.compliance[j] * k.a[j].dot(d), k.lo[j]), k.up[j]);
      }
    }
  }

  static S damping(const DualNewton<S, M, N>& k) noexcept {
    S trace = S(0);
    for (int i = 0; i < k.n; ++i) trace += k.compliance[std::size_t(i)] * k.a[std::size_t(i)].squaredNorm();
    return (single ? S(1e-3) : S(1e-6)) * (trace > S(0) ? trace / S(M) : S(1));
  }

  bool uncertain(int n) const noexcept {
    bool any = margin > S(0);
    for (int i = 0; i < n; ++i) any = any || growth[std::size_t(i)] > S(0);
    return any;
  }

  void weights(DualNewton<S, M, N>& k, S theta) const noexcept {
    for (int i = 0; i < k.n; ++i) {
      const std::size_t j = std::size_t(i);
      const S p = growth[j] > S(0) ? effort[j] + growth[j] / theta : effort[j];
      k.compliance[j] = S(1) / p;
      k.preferred[j] = preferred[j] * effort[j] * k.compliance[j];
    }
  }

  S spread(const DualNewton<S, M, N>& k) const noexcept {
    if (margin >= S(0)) return margin;
    S sum = S(0);
    for (int i = 0; i < k.n; ++i) sum += growth[std::size_t(i)] * k.tau(i) * k.tau(i);
    return std::sqrt(sum / h);
  }

  bool inside(DualNewton<S, M, N>& k, const Torque& y, const Split& split, int cap) const noexcept {
    k.R = (softness(split.rest) / h).asDiagonal();
    k.centre.setZero();
    return k.solve(y, std::min(cap, k.steps + 60)) != NewtonOutcome::capped;
  }

  /// theta = 1: (I - Sb)/h is singular, wholly so for the bound, and the demand may be out of reach: false then.
  bool at_one(DualNewton<S, M, N>& k, Torque y, int cap) const noexcept {
    const Torque soft = softness(S(0)) / h;
    const Torque b = k.b;
    k.R = soft.asDiagonal();
    k.centre.setZero();
    const NewtonOutcome exact = k.solve(y, std::min(cap, k.steps + 60), /*stop_at_singular=*/true);
    if (exact == NewtonOutcome::converged) return true;
    if (exact == NewtonOutcome::floor && k.F().cwiseAbs().maxCoeff() <= S(10) * k.tolerance) return true;
    const S delta = damping(k);
    S last = std::numeric_limits<S>::infinity();
    bool reached = false;
    k.R.diagonal().array() += delta;
    for (int round = 0; round < 8 && !reached; ++round) {
      k.centre = y;
      k.b = b - soft.cwiseProduct(y);
      if (k.solve(y, std::min(cap, k.steps + 60)) == NewtonOutcome::capped) break;
      const S left = delta * (k.y() - y).cwiseAbs().maxCoeff();
      y = k.y();
      reached = left <= S(4) * k.tolerance;
      if (left > last / S(2)) break;
      last = left;
    }
    k.b = b;
    k.centre.setZero();
    return reached;
  }

  struct Step {
    S step, rounding;
  };

  /// Newton step of ln(theta |Sb^(1/2) y|) - ln(h spread) in logit(theta), and what the tolerance of F leaves open of it.
  Step newton(DualNewton<S, M, N>& k, const Split& split, const Torque& Sy, S ySy, S worst) const noexcept {
    const S theta = split.theta;
    std::array<S, std::size_t(N)> rate{};  // of tau_i with theta at fixed y
    Torque dF = -Sy / h;
    for (int i = 0; i < k.n; ++i) {
      const std::size_t j = std::size_t(i);
      if (!k.is_free(i)) continue;
      rate[j] = k.tau(i) * growth[j] * k.compliance[j] / (theta * theta);
      dF += rate[j] * k.a[j];
    }
    const Torque dy = -k.solve_jacobian(dF);
    S dspread = S(0);  // h^2 spread spread'
    if (margin < S(0))
      for (int i = 0; i < k.n; ++i) {
        const std::size_t j = std::size_t(i);
        if (k.is_free(i)) dspread += growth[j] * k.tau(i) * (rate[j] + k.a[j].dot(dy) * k.compliance[j]);
      }
    const S slope = (S(1) / theta + Sy.dot(dy) / ySy - h * dspread / (worst * worst)) * theta * split.rest;
    const S value = std::log(theta * std::sqrt(ySy) / worst);
    return {-value / slope, k.tolerance * k.solve_again(Sy).norm() / (ySy * std::abs(slope))};
  }
};

}  // namespace gyrostat
