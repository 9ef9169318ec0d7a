// SPDX-License-Identifier: MIT
/// @file  Time integration: CVODE (variable order and step, keeps its history), classical Runge-Kutta of order 4, or a
///        Runge-Kutta pair of order 5(4) that chooses its steps and has no history to lose.
#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <stdexcept>
#include <string>
#include <variant>

#include "gyrostat/core/params.hpp"

namespace gyrostat::truth {

/// Adams method of variable order and step.
struct Cvode {
  static constexpr const char* name = "cvode";
  double rtol = 1e-9, atol = 1e-12;
  bool restart_each_sample = false;  ///< forget the history at every sample; only there to measure what that costs

  static constexpr void describe(auto& p, auto&& field) {
    field(p.rtol, Field{"rtol", "", 1e-15, 1e-2, "relative tolerance of a step"});
    field(p.atol, Field{"atol", "", 1e-20, 1e-2, "absolute tolerance of a step, of quaternion and momentum (N m s)"});
  }
};

/// Classical Runge-Kutta with a fixed number of equal steps a sample (each piece of a sample split by a switch has its own);
/// more where the truth's own time constants need them.
struct Rk4 {
  static constexpr const char* name = "rk4";
  int substeps = 1;

  static constexpr void describe(auto& p, auto&& field) {
    field(p.substeps, Field{"substeps", "", 1, 1e5, "at least so many steps a sample"});
  }
};

/// The pair of Dormand and Prince, order 5(4): error controlled as CVODE is, without a history that a new command spoils.
struct Auto {
  static constexpr const char* name = "auto";
  double rtol = 1e-9, atol = 1e-15;

  static constexpr void describe(auto& p, auto&& field) {
    field(p.rtol,
          Field{"rtol", "", 1e-15, 1e-2, "error of a step, relative to the quaternion and to the largest momentum"});
    field(p.atol, Field{"atol", "", 1e-20, 1e-2, "error of a step, of quaternion and momentum (N m s)"});
  }
};

using Integrator = std::variant<Cvode, Rk4, Auto>;

struct IntegratorStatistics {
  std::uint64_t steps = 0, rhs_evaluations = 0, restarts = 0;
  /// Smooth pieces of time; a piece counts once for every half of the truth's shortest time constant in it. Without a
  /// history a method needs about one step for each.
  std::uint64_t pieces = 0;
};

/// The integration cannot go on: CVODE gave up, or a sample takes too much work.
class IntegrationError : public std::runtime_error {
 public:
  IntegrationError(double time, const std::string& why);
  double time;  ///< s, that was reached
};

/// y' = rhs(t, y); `context` is handed through.
using Rhs = void (*)(double t, const double* y, double* ydot, const void* context) noexcept;

/// One classical Runge-Kutta step of y[0..n) in place, n <= N; a fixed N = n unrolls.
template <int N, class F>
void rk4_step(const F& rhs, double t, double h, double* y, int n = N) noexcept {
  using State = std::array<double, static_cast<std::size_t>(N)>;
  const auto size = static_cast<std::size_t>(N == 7 ? N : n);
  State k1, k2, k3, k4, z{};
  rhs(t, y, k1.data());
  for (std::size_t i = 0; i < size; ++i) z[i] = y[i] + 0.5 * h * k1[i];
  rhs(t + 0.5 * h, z.data(), k2.data());
  for (std::size_t i = 0; i < size; ++i) z[i] = y[i] + 0.5 * h * k2[i];
  rhs(t + 0.5 * h, z.data(), k3.data());
  for (std::size_t i = 0; i < size; ++i) z[i] = y[i] + h * k3[i];
  rhs(t + h, z.data(), k4.data());
  for (std::size_t i = 0; i < size; ++i) y[i] += h / 6 * (k1[i] + 2 * (k2[i] + k3[i]) + k4[i]);
}

/// Dormand and Prince 1980: nodes, stages, and the last stage less the embedded solution of order 4.
struct DormandPrince {
  static constexpr std::size_t stages = 7;
  static constexpr std::array<double, stages> node{0, 1. / 5, 3. / 10, 4. / 5, 8. / 9, 1, 1};
  static constexpr std::array<std::array<double, stages - 1>, stages> stage{
      {{},
       {1. / 5},
       {3. / 40, 9. / 40},
       {44. / 45, -56. / 15, 32. / 9},
       {19372. / 6561, -25360. / 2187, 64448. / 6561, -212. / 729},
       {9017. / 3168, -355. / 33, 46732. / 5247, 49. / 176, -5103. / 18656},
       {35. / 384, 0, 500. / 1113, 125. / 192, -2187. / 6784, 11. / 84}}};
  static constexpr std::array<double, stages> error{71. / 57600,      0,         -71. / 16695, 71. / 1920,
                                                    -17253. / 339200, 22. / 525, -1. / 40};
};

/// One step of order 5 from y to `end`, both of n <= N elements: four of attitude, then momenta.
/// @return the largest estimated error of an element, in units of atol + rtol (largest of its kind); above 1 the step is
///         too long
template <int N, class F>
double pair_step(const Auto& tolerance, const F& rhs, double t, double h, int n, const double* y,
                 double* end) noexcept {
  using Pair = DormandPrince;
  std::array<std::array<double, static_cast<std::size_t>(N)>, Pair::stages> k;
  const auto size = static_cast<std::size_t>(n);
  for (std::size_t s = 0; s < Pair::stages; ++s) {
    for (std::size_t i = 0; i < size; ++i) {
      double slope = 0;
      for (std::size_t j = 0; j < s; ++j) slope += Pair::stage[s][j] * k[j][i];
      end[i] = y[i] + h * slope;
    }
    rhs(t + Pair::node[s] * h, end, k[s].data());
  }
  double worst = 0, attitude = 0, momentum = 0;
  for (std::size_t i = 0; i < size; ++i) {
    double& largest = i < 4 ? attitude : momentum;
    largest = std::max(largest, std::abs(y[i]));
  }
  for (std::size_t i = 0; i < size; ++i) {
    double error = 0;
    for (std::size_t s = 0; s < Pair::stages; ++s) error += Pair::error[s] * k[s][i];
    worst = std::max(worst, std::abs(h * error) / (tolerance.atol + tolerance.rtol * (i < 4 ? attitude : momentum)));
  }
  return worst;
}

/// CVODE's memory and vectors for one state.
class CvodeSolver {
 public:
  /// @throws std::runtime_error when CVODE cannot be set up
  CvodeSolver(const Cvode& options, int states);
  ~CvodeSolver();
  CvodeSolver(CvodeSolver&&) noexcept;
  CvodeSolver& operator=(CvodeSolver&&) noexcept;

  /// Forgets the history and begins at (t, y): first use, and after a discontinuity of the right-hand side.
  void restart(double t, const double* y);
  /// Integrates to t_end exactly, where y is written; rhs is never evaluated later than that.
  /// @throws IntegrationError
  void advance(Rhs rhs, const void* context, double t_end, double* y);
  IntegratorStatistics statistics() const;
  std::uint64_t steps() const noexcept;

 private:
  struct Memory;
  std::unique_ptr<Memory> memory_;
};

}  // namespace gyrostat::truth
