// SPDX-License-Identifier: MIT
/// @file  The allocation solver behind one interface, whatever its scalar and size: the tests on it are written once, and the
///        solver's templates are compiled once, a file a scalar.
#pragma once
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "flight/allocators/certificate.hpp"
#include "gyrostat/flight/allocators/parts/allocation_problem.hpp"
#include "random.hpp"

namespace gyrostat::test {

using Numbers = std::vector<double>;

/// One allocation, in double; rounded to the solver's scalar when it is solved.
struct Posed {
  std::vector<Numbers> D;  // a row each
  Numbers row_weight, demand;
  Numbers effectiveness, lo, up, preferred, effort_weight, bound;
  AllocationMode mode = AllocationMode::lexicographic;
  WorstCase worst_case = WorstCase::bound;
  double residual_weight = 1e4, margin = 0;
  std::vector<int> priority;
  int max_newton = 200;
  bool try_unlimited = true;

  std::size_t rows() const { return D.size(); }
  std::size_t actuators() const { return D[0].size(); }

  /// n healthy actuators of known effectiveness within +- limit.
  static Posed with_axes(std::vector<Numbers> D, double limit) {
    Posed p;
    const std::size_t n = D[0].size();
    p.row_weight.assign(D.size(), 1);
    p.demand.assign(D.size(), 0);
    p.priority.assign(D.size(), 0);
    p.D = std::move(D);
    p.effectiveness.assign(n, 1);
    p.lo.assign(n, -limit);
    p.up.assign(n, limit);
    p.preferred.assign(n, 0);
    p.effort_weight.assign(n, 1);
    p.bound.assign(n, 0);
    return p;
  }
};

struct Outcome {
  certificate::Problem q;  // what was solved, as the solver's scalar rounded it
  certificate::Vector command, achieved, multiplier, infeasibility_direction;
  certificate::Real theta, scale, primal, gap, worst_case, residual_norm, residual_excess, residual_weight;
  std::uint32_t saturated;
  int newton, outer;
  AllocationStatus status;
  std::uint8_t warnings;
};

/// Keeps its warm start between calls.
class AnySolver {
 public:
  virtual ~AnySolver() = default;
  virtual Outcome solve(const Posed& posed) = 0;
  virtual void reset() = 0;
  /// Puts numbers into the warm start that no solve would leave there.
  virtual void spoil(double multiplier, double theta, AllocationMode mode) = 0;
  /// The warm start, to see whether it was touched.
  virtual Numbers state() const = 0;
};

/// Of three rows and up to 16 actuators, or of six and up to 12.
template <class S>
std::unique_ptr<AnySolver> solver_in(int rows);
extern template std::unique_ptr<AnySolver> solver_in<double>(int rows);
extern template std::unique_ptr<AnySolver> solver_in<float>(int rows);

/// A solver's scalar and size; the parameter of the typed tests.
struct Kind {
  std::string name;
  bool single;
  int rows;
  std::unique_ptr<AnySolver> solver() const { return single ? solver_in<float>(rows) : solver_in<double>(rows); }
  /// Rounding of the scalar.
  double epsilon() const { return single ? 1.2e-7 : 2.3e-16; }
};
inline std::string name_of(const Kind& kind) { return kind.name; }
inline std::vector<Kind> kinds_of_three_rows() { return {{"double3", false, 3}, {"float3", true, 3}}; }
inline std::vector<Kind> all_kinds() {
  return {{"double3", false, 3}, {"float3", true, 3}, {"double6", false, 6}, {"float6", true, 6}};
}

/// Half of the demands lie inside the attainable set, the others well outside or near its edge; a tenth of the actuators is
/// dead, the others keep 20 % or more.
inline Posed random_problem(Random& random, std::size_t rows, std::size_t n) {
  std::vector<Numbers> D(rows, Numbers(n));
  for (std::size_t i = 0; i < n; ++i) {
    double norm = 0;
    for (Numbers& row : D) norm += (row[i] = random.uniform(-1, 1)) * row[i];
    for (Numbers& row : D) row[i] /= std::sqrt(norm);
  }
  Posed p = Posed::with_axes(D, 0);
  const bool weighted = random.uniform(0, 1) < 0.3, preferring = random.uniform(0, 1) < 0.3;
  for (double& w : p.row_weight) w = weighted ? random.log_uniform(0.5, 2) : 1;
  const double kind = random.uniform(0, 1), far = kind < 0.5 ? 1 : kind < 0.8 ? random.uniform(1, 3) : 1.02;
  for (std::size_t i = 0; i < n; ++i) {
    p.effectiveness[i] = random.uniform(0, 1) < 0.1 ? 0 : random.uniform(0.2, 1);
    p.up[i] = random.uniform(0.1, 0.3);
    p.lo[i] = -random.uniform(0.1, 0.3);
    p.effort_weight[i] = random.log_uniform(0.3, 3);
    p.preferred[i] = preferring ? random.uniform(-0.1, 0.1) : 0;
    p.bound[i] = random.uniform(0, 0.3);
    const double t = kind >= 0.5 ? (random.uniform(0, 1) < 0.5 ? -1 : 1) : random.uniform(-1, 1);
    for (std::size_t r = 0; r < rows; ++r)
      p.demand[r] += D[r][i] * p.effectiveness[i] * far * t * (t > 0 ? p.up[i] : -p.lo[i]);
  }
  return p;
}

/// A demand at a relative distance from the surface of the attainable set, negative inside: off a corner, an edge or a face,
/// along the demand or across the surface.
inline Posed problem_at_edge(Random& random, std::size_t rows, std::size_t n, double distance) {
  Posed p = random_problem(random, rows, n);
  const auto chance = [&](double share) { return random.uniform(0, 1) < share; };
  const auto column = [&](std::size_t i) {
    Numbers a;
    for (const Numbers& row : p.D) a.push_back(row[i]);
    return a;
  };
  const auto along = [](const Numbers& a, const Numbers& b) {
    double sum = 0;
    for (std::size_t r = 0; r < a.size(); ++r) sum += a[r] * b[r];
    return sum;
  };
  if (rows == 3 && chance(0.3)) {  // the axes of the body and a pyramid, repeated: many corners and faces coincide
    const double s = 1 / std::sqrt(3.0);
    const double axes[7][3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {s, s, s}, {s, -s, s}, {-s, -s, s}, {-s, s, s}};
    for (std::size_t r = 0; r < rows; ++r)
      for (std::size_t i = 0; i < n; ++i) p.D[r][i] = axes[i % 7][r];
  }
  if (chance(0.5)) p.effectiveness.assign(n, 1);
  if (chance(0.5)) p.bound.assign(n, chance(0.5) ? 0.1 : random.log_uniform(1e-4, 0.5));

  // v: at right angles to 0 (a corner), 1 (an edge) or rows - 1 (a face) of the axes
  const double place = random.uniform(0, 1);
  const std::size_t flat = place < 0.2 ? 0 : place < 0.4 ? 1 : rows - 1;
  std::vector<Numbers> basis;
  Numbers v;
  for (std::size_t j = 0; j <= flat; ++j) {
    v = column(std::size_t(random.uniform(0, 1) * double(n)) % n);
    if (j == flat)
      for (double& x : v) x = random.uniform(-1, 1);
    for (int pass = 0; pass < 2; ++pass)
      for (const Numbers& q : basis) {
        const double c = along(q, v);
        for (std::size_t r = 0; r < rows; ++r) v[r] -= c * q[r];
      }
    const double norm = std::sqrt(along(v, v));
    if (norm < 1e-6) continue;  // the same axis once more
    for (double& x : v) x /= norm;
    basis.push_back(v);
  }
  p.demand.assign(rows, 0);
  for (std::size_t i = 0; i < n; ++i) {
    const double reach = along(v, column(i));
    const double t = std::abs(reach) < 1e-9 ? random.uniform(p.lo[i], p.up[i]) : reach > 0 ? p.up[i] : p.lo[i];
    for (std::size_t r = 0; r < rows; ++r) p.demand[r] += p.D[r][i] * p.effectiveness[i] * t;
  }
  const double size = std::sqrt(along(p.demand, p.demand));
  const bool radial = chance(0.5);
  for (std::size_t r = 0; r < rows; ++r) p.demand[r] += distance * (radial ? p.demand[r] : size * v[r]);
  return p;
}

}  // namespace gyrostat::test
