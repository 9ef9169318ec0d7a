// SPDX-License-Identifier: MIT
// Times the allocation solver and DAQP's C function in one process with one clock: a library for peers.py, which gives the
// problems and, when DAQP is installed, the address of its `daqp_quadprog`.
#include <chrono>
#include <cstdint>

#include "gyrostat/flight/allocators/parts/allocation_solver.hpp"

namespace {

using Clock = std::chrono::steady_clock;
using namespace gyrostat;

double nanoseconds(Clock::time_point from) {
  return std::chrono::duration<double, std::nano>(Clock::now() - from).count();
}

// What daqp_quadprog(result, problem, settings) reads and writes, as laid out in DAQP 0.11; settings may be null.
struct DaqpProblem {
  int n, m, ms;
  double *H, *f, *A, *upper, *lower;
  int *sense, *break_points;
  int levels, type;
};
struct DaqpResult {
  double *x, *lambda;
  double value, slack;
  int flag, iterations, nodes;
  double solve_time, setup_time;
};
using Daqp = void (*)(DaqpResult*, DaqpProblem*, void*);

/// One row of peers.py's arrays.
struct Row {
  const double *D, *effectiveness, *bound, *demand;
  double h;
};

template <int M, int N>
class Bench {
 public:
  using Solver = AllocationSolver<double, M, N>;
  static constexpr double limit = 0.25, gamma = 1e6;
  static constexpr int repeats = 3;  // in a row, of which the fastest counts

  /// Nanoseconds of: least squares cold, warm, DAQP, lexicographic, scaled, robust bound, robust exact.
  void run(const Row& row, Daqp daqp, double* ns, double* difference) {
    typename Solver::Geometry D(M, N);
    for (int r = 0; r < M; ++r)
      for (int i = 0; i < N; ++i) D(r, i) = row.D[r * N + i];
    solver_.configure(D);
    typename Solver::Problem p = Solver::Problem::symmetric(N, limit);
    for (int i = 0; i < N; ++i) {
      p.effectiveness[i] = row.effectiveness[i];
      p.bound[i] = row.bound[i];
    }
    for (int r = 0; r < M; ++r) p.demand[r] = row.demand[r];
    p.mode = AllocationMode::weighted_least_squares;
    p.residual_weight = gamma;
    PerActuator<double, N> u;
    ns[0] = fastest([&](double& t) { u = cold(p, t).command; });
    typename Solver::Problem next = p;
    next.demand *= 1.02;
    ns[1] = fastest([&](double& t) {
      typename Solver::State state;
      double before = 0.0;
      timed(p, state, before);
      timed(next, state, t);
    });
    ns[2] = daqp == nullptr ? 0.0 : fastest([&](double& t) { t = time_daqp(D, p, daqp, u, *difference); });
    p.mode = AllocationMode::lexicographic;
    ns[3] = fastest([&](double& t) { cold(p, t); });
    p.mode = AllocationMode::lexicographic_scaled;
    ns[4] = fastest([&](double& t) { cold(p, t); });
    p.mode = AllocationMode::robust_socp;
    p.residual_weight = row.h;
    ns[5] = fastest([&](double& t) { cold(p, t); });
    p.worst_case = WorstCase::exact;
    ns[6] = fastest([&](double& t) { cold(p, t); });
  }

 private:
  static double fastest(auto&& run) {
    double best = 1e18;
    for (int k = 0; k < repeats; ++k) {
      double t = 0.0;
      run(t);
      best = std::min(best, t);
    }
    return best;
  }
  typename Solver::Solution timed(const typename Solver::Problem& p, typename Solver::State& state, double& ns) {
    const Clock::time_point start = Clock::now();
    const typename Solver::Solution s = solver_.solve(p, state);
    ns = nanoseconds(start);
    return s;
  }
  typename Solver::Solution cold(const typename Solver::Problem& p, double& ns) {
    typename Solver::State state;
    return timed(p, state, ns);
  }

  /// The call alone; forming the Hessian is not counted.
  double time_daqp(const typename Solver::Geometry& D, const typename Solver::Problem& p, Daqp daqp,
                   const PerActuator<double, N>& own, double& difference) {
    double H[N * N], f[N], lo[N], up[N], x[N], lambda[N];
    int sense[N] = {};
    for (int i = 0; i < N; ++i) {
      for (int j = 0; j < N; ++j)
        H[i * N + j] = gamma * p.effectiveness[i] * p.effectiveness[j] * D.col(i).dot(D.col(j)) + (i == j ? 1.0 : 0.0);
      f[i] = -gamma * p.effectiveness[i] * D.col(i).dot(p.demand);
      lo[i] = -limit;
      up[i] = limit;
    }
    DaqpProblem problem{N, N, N, H, f, nullptr, up, lo, sense, nullptr, 0, 0};
    DaqpResult result{x, lambda, 0, 0, 0, 0, 0, 0, 0};
    const Clock::time_point start = Clock::now();
    daqp(&result, &problem, nullptr);
    const double ns = nanoseconds(start);
    for (int i = 0; i < N; ++i) difference = std::max(difference, std::abs(x[i] - own[i]));
    return ns;
  }

  Solver solver_;
};

template <int M, int N>
double run(int count, const Row& first, const double* h, Daqp daqp, double* ns) {
  static Bench<M, N> bench;
  double difference = 0.0;
  for (int k = 0; k < count; ++k) {
    const Row row{first.D + k * M * N, first.effectiveness + k * N, first.bound + k * N, first.demand + k * M, h[k]};
    bench.run(row, daqp, ns + 7 * k, &difference);
  }
  return difference;
}

}  // namespace

/// @param daqp address of daqp_quadprog, or null   @param ns (count, 7)
/// @return largest difference of a command from DAQP's; -1 for a size that is not compiled
extern "C" double gyrostat_time_allocation(int rows, int n, int count, const double* D, const double* effectiveness,
                                           const double* bound, const double* demand, const double* h, void* daqp,
                                           double* ns) {
  const Row first{D, effectiveness, bound, demand, 0.0};
  const Daqp call = reinterpret_cast<Daqp>(reinterpret_cast<std::uintptr_t>(daqp));
  if (rows == 3 && n == 4) return run<3, 4>(count, first, h, call, ns);
  if (rows == 3 && n == 6) return run<3, 6>(count, first, h, call, ns);
  if (rows == 3 && n == 8) return run<3, 8>(count, first, h, call, ns);
  if (rows == 3 && n == 16) return run<3, 16>(count, first, h, call, ns);
  if (rows == 6 && n == 12) return run<6, 12>(count, first, h, call, ns);
  return -1.0;
}
