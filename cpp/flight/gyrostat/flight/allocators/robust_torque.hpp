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
#include "gyrostat/flight/allocators/dual_newton.hpp"

namespace gyrostat {

template <class S, int M, int N>
struct RobustTorque {
  using Torque = Eigen::Matrix<S, M, 1>;
  using Matrix = Eigen::Matrix<S, M, M>;

  // The problem, in the scaled units of the kernel.
  std::array<S, N> effort, preferred;
  std::array<S, N> growth;  ///< h s_max^2 (bound_i e_i)^2; zero for a constant margin
  Matrix Sb = Matrix::Identity();
  S h = S(1);
  S margin = S(-1);  ///< constant spread; negative: it grows with tau

  // The answer, beside the kernel's.
  int outer = 0;
  bool capped = false;

  /// Solves from (y, theta); returns theta.
  S solve(DualNewton<S, M, N>& k, const Torque& start, S theta, int cap) noexcept {
    constexpr bool single = sizeof(S) < 8;
    constexpr S tolerance = single ? S(1e-4) : S(1e-10);
    constexpr S edge = single ? S(1e-6) : S(1e-9);  // how close to 1 theta is resolved
    if (!uncertain(k.n)) {
      weights(k, S(0));
      k.R = Matrix::Identity() / h;
      k.centre.setZero();
      capped = k.solve(start, std::min(cap, k.steps + 60)) == NewtonOutcome::capped;
      return S(0);
    }
    S lo = S(0), up = S(1), postponed = S(0);
    bool tried_one = false;
    Torque y = start;
    for (outer = 1; outer <= 40; ++outer) {
      weights(k, theta);
      const bool reached = theta < S(1) ? inside(k, y, theta, cap) : at_one(k, y, cap);
      if (k.steps >= cap) break;
      const Torque Sy = Sb * k.y();
      const S ySy = std::max(k.y().dot(Sy), S(0));
      const S split = theta * std::sqrt(ySy), worst = h * spread(k);
      const S f = reached ? split - worst : std::numeric_limits<S>::infinity();
      if (reached) y = k.y();
      if (std::abs(f) <= tolerance * (split + worst) || (theta == S(1) && f <= S(0))) return theta;
      if (f > S(0) ? theta <= S(1e-10) : theta >= S(1) - S(2) * edge) return theta;
      (f > S(0) ? up : lo) = theta;
      if (up - lo <= tolerance * lo * (S(1) - lo)) return theta;
      const S middle = logistic((logit(std::max(lo, S(1e-10))) + logit(std::min(up, S(1) - edge))) / S(2));
      if (theta == S(1)) {
        theta = postponed > lo ? postponed : middle;
        continue;
      }
      const S step = newton(k, theta, Sy, ySy, worst);
      if (std::abs(step) <= S(10) * tolerance) return theta;  // rounding of y may keep f above its own tolerance
      const S next = logistic(logit(theta) + std::clamp(step, S(-8), S(8)));
      const bool usable = std::isfinite(step) && next > lo && next < up && !(outer > 10 && outer % 2 == 0);
      if (step > S(6) && up == S(1) && !tried_one) {
        tried_one = true;
        postponed = usable ? next : S(0);
        theta = S(1);
      } else {
        theta = std::clamp(usable ? next : middle, S(1e-10), S(1) - edge / S(2));
      }
    }
    capped = true;
    return theta;
  }

 private:
  static S logit(S t) noexcept { return std::log(t / (S(1) - t)); }
  static S logistic(S x) noexcept { return S(1) / (S(1) + std::exp(-x)); }

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

  bool inside(DualNewton<S, M, N>& k, const Torque& y, S theta, int cap) const noexcept {
    k.R = (Matrix::Identity() - theta * Sb) / h;
    k.centre.setZero();
    return k.solve(y, std::min(cap, k.steps + 60)) != NewtonOutcome::capped;
  }

  /// theta = 1: (I - Sb)/h is singular, wholly so for the bound, and the demand may be out of reach: false then.
  bool at_one(DualNewton<S, M, N>& k, Torque y, int cap) const noexcept {
    constexpr bool single = sizeof(S) < 8;
    const Matrix soft = (Matrix::Identity() - Sb) / h;
    const Torque b = k.b;
    k.R = soft;
    k.centre.setZero();
    const NewtonOutcome exact = k.solve(y, std::min(cap, k.steps + 60), /*stop_at_singular=*/true);
    if (exact == NewtonOutcome::converged || exact == NewtonOutcome::floor) return true;
    S trace = S(0);
    for (int i = 0; i < k.n; ++i) trace += k.compliance[std::size_t(i)] * k.a[std::size_t(i)].squaredNorm();
    const S delta = (single ? S(1e-3) : S(1e-6)) * (trace > S(0) ? trace / S(M) : S(1));
    S last = std::numeric_limits<S>::infinity();
    bool reached = false;
    k.R = soft + delta * Matrix::Identity();
    for (int round = 0; round < 8 && !reached; ++round) {
      k.centre = y;
      k.b = b - soft * y;
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

  /// Newton step of ln(theta |Sb^(1/2) y|) - ln(h spread) in logit(theta).
  S newton(DualNewton<S, M, N>& k, S theta, const Torque& Sy, S ySy, S worst) const noexcept {
    std::array<S, N> rate{};  // of tau_i with theta at fixed y
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
    const S slope = S(1) / theta + Sy.dot(dy) / ySy - h * dspread / (worst * worst);
    const S value = std::log(theta * std::sqrt(ySy) / worst);
    return -value / (slope * theta * (S(1) - theta));
  }
};

}  // namespace gyrostat
