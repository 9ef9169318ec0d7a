// SPDX-License-Identifier: MIT
/// @file  Time integration: CVODE (variable order and step, keeps its history) or classical Runge-Kutta of order 4.
#pragma once
#include <array>
#include <cstdint>
#include <memory>
#include <stdexcept>
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

/// Classical Runge-Kutta with a fixed number of equal steps a sample (each piece of a sample split by a switch has its own).
struct Rk4 {
  static constexpr const char* name = "rk4";
  int substeps = 1;

  static constexpr void describe(auto& p, auto&& field) {
    field(p.substeps, Field{"substeps", "", 1, 1e6, "steps a sample"});
  }
};

using Integrator = std::variant<Cvode, Rk4>;

struct IntegratorStatistics {
  std::uint64_t steps = 0, rhs_evaluations = 0, restarts = 0;
};

/// CVODE gave up.
class IntegrationError : public std::runtime_error {
 public:
  IntegrationError(double time, int flag);
  double time;  ///< s, that was reached
  int flag;     ///< CVODE's return code
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

 private:
  struct Memory;
  std::unique_ptr<Memory> memory_;
};

}  // namespace gyrostat::truth
