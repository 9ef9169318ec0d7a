// SPDX-License-Identifier: MIT
/// @file  Random allocation problems, and their translation for the independent judge.
#pragma once
#include "flight/allocators/certificate.hpp"
#include "gyrostat/flight/allocators/allocation_solver.hpp"
#include "random.hpp"

namespace gyrostat::test {

/// Half of the demands lie inside the attainable set, the others well outside or near its edge; a tenth of the actuators is
/// dead, the others keep 20 % or more.
template <class S, int M, int N>
struct RandomProblem {
  using Solver = AllocationSolver<S, M, N>;
  typename Solver::Geometry D;
  Eigen::Matrix<S, M, 1> row_weight;
  typename Solver::Problem problem;

  RandomProblem(Random& random, int n) : D(M, n), problem(Solver::Problem::symmetric(n, S(0))) {
    for (int i = 0; i < n; ++i) {
      for (int r = 0; r < M; ++r) D(r, i) = S(random.uniform(-1, 1));
      D.col(i) /= D.col(i).norm();
    }
    const bool weighted = random.uniform(0, 1) < 0.3, preferring = random.uniform(0, 1) < 0.3;
    for (int r = 0; r < M; ++r) row_weight[r] = weighted ? S(random.log_uniform(0.5, 2)) : S(1);
    const double kind = random.uniform(0, 1), far = kind < 0.5 ? 1 : kind < 0.8 ? random.uniform(1, 3) : 1.02;
    Eigen::Matrix<S, M, 1> demand = Eigen::Matrix<S, M, 1>::Zero();
    for (int i = 0; i < n; ++i) {
      problem.effectiveness[i] = random.uniform(0, 1) < 0.1 ? S(0) : S(random.uniform(0.2, 1));
      problem.up[i] = S(random.uniform(0.1, 0.3));
      problem.lo[i] = -S(random.uniform(0.1, 0.3));
      problem.effort_weight[i] = S(random.log_uniform(0.3, 3));
      problem.preferred[i] = preferring ? S(random.uniform(-0.1, 0.1)) : S(0);
      problem.bound[i] = S(random.uniform(0, 0.3));
      const double t = kind >= 0.5 ? (random.uniform(0, 1) < 0.5 ? -1 : 1) : random.uniform(-1, 1);
      demand += D.col(i) * (problem.effectiveness[i] * S(far * t) * (t > 0 ? problem.up[i] : -problem.lo[i]));
    }
    problem.demand = demand;
  }

  certificate::Problem judged() const {
    certificate::Problem q;
    const int n = static_cast<int>(D.cols());
    q.A.assign(M, certificate::Vector(std::size_t(n)));
    q.D = q.A;
    for (int r = 0; r < M; ++r) {
      q.u.push_back(certificate::Real(row_weight[r]) * certificate::Real(problem.demand[r]));
      for (int i = 0; i < n; ++i) {
        q.D[std::size_t(r)][std::size_t(i)] = certificate::Real(row_weight[r]) * certificate::Real(D(r, i));
        q.A[std::size_t(r)][std::size_t(i)] = q.D[std::size_t(r)][std::size_t(i)] * certificate::Real(problem.effectiveness[i]);
      }
    }
    for (int i = 0; i < n; ++i) {
      q.lo.push_back(problem.lo[i]);
      q.up.push_back(problem.up[i]);
      q.preferred.push_back(problem.preferred[i]);
      q.p.push_back(problem.effort_weight[i]);
      q.g.push_back(certificate::Real(problem.bound[i]) * certificate::Real(problem.effectiveness[i]));
    }
    return q;
  }
};

template <class Vector>
certificate::Vector extended(const Vector& v) {
  certificate::Vector out;
  for (Eigen::Index i = 0; i < v.size(); ++i) out.push_back(static_cast<certificate::Real>(v[i]));
  return out;
}

/// Solves from a cold start.
template <class S, int M, int N>
typename AllocationSolver<S, M, N>::Solution solve_cold(const RandomProblem<S, M, N>& random) {
  AllocationSolver<S, M, N> solver;
  solver.configure(random.D, random.row_weight);
  typename AllocationSolver<S, M, N>::State state;
  return solver.solve(random.problem, state);
}

}  // namespace gyrostat::test
