// SPDX-License-Identifier: MIT
#include "flight/allocators/any_solver.hpp"

#include "gyrostat/flight/allocators/parts/allocation_solver.hpp"

namespace gyrostat::test {
namespace {

using certificate::Real;

template <class Vector>
certificate::Vector extended(const Vector& v) {
  certificate::Vector out;
  for (Eigen::Index i = 0; i < v.size(); ++i) out.push_back(static_cast<Real>(v[i]));
  return out;
}

template <class S, int M, int N>
class Solver : public AnySolver {
 public:
  using Library = AllocationSolver<S, M, N>;

  Outcome solve(const Posed& posed) override {
    const Eigen::Index n = static_cast<Eigen::Index>(posed.actuators());
    typename Library::Geometry D(M, n);
    typename Library::Torque weight;
    for (int r = 0; r < M; ++r) {
      weight[r] = S(posed.row_weight[std::size_t(r)]);
      for (Eigen::Index i = 0; i < n; ++i) D(r, i) = S(posed.D[std::size_t(r)][std::size_t(i)]);
    }
    library_.configure(D, weight);
    typename Library::Problem p;
    for (int r = 0; r < M; ++r) {
      p.demand[r] = S(posed.demand[std::size_t(r)]);
      p.priority[std::size_t(r)] = static_cast<std::uint8_t>(posed.priority[std::size_t(r)]);
    }
    p.effectiveness = rounded(posed.effectiveness);
    p.lo = rounded(posed.lo);
    p.up = rounded(posed.up);
    p.preferred = rounded(posed.preferred);
    p.effort_weight = rounded(posed.effort_weight);
    p.bound = rounded(posed.bound);
    p.mode = posed.mode;
    p.worst_case = posed.worst_case;
    p.residual_weight = S(posed.residual_weight);
    p.margin = S(posed.margin);
    p.max_newton = posed.max_newton;
    p.try_unlimited = posed.try_unlimited;
    const typename Library::Solution s = library_.solve(p, state_);
    return {judged(D, weight, p),
            extended(s.command),
            extended(s.achieved),
            extended(s.multiplier),
            extended(s.infeasibility_direction),
            s.theta,
            s.scale,
            s.primal,
            s.gap,
            s.worst_case,
            s.residual_norm,
            s.residual_excess,
            s.residual_weight,
            s.saturated,
            s.newton,
            s.outer,
            s.status,
            s.warnings};
  }

  void reset() override { state_.reset(); }

  void spoil(double multiplier, double theta, AllocationMode mode) override {
    state_.multiplier.setConstant(S(multiplier));
    state_.theta = S(theta);
    state_.mode = mode;
    state_.valid = true;
  }

  Numbers state() const override {
    Numbers out{double(state_.theta), double(state_.mode), double(state_.valid)};
    for (int r = 0; r < M; ++r) out.push_back(double(state_.multiplier[r]));
    for (Eigen::Index i = 0; i < state_.command.size(); ++i) out.push_back(double(state_.command[i]));
    return out;
  }

 private:
  static PerActuator<S, N> rounded(const Numbers& v) {
    PerActuator<S, N> out(static_cast<Eigen::Index>(v.size()));
    for (std::size_t i = 0; i < v.size(); ++i) out[static_cast<Eigen::Index>(i)] = S(v[i]);
    return out;
  }

  static certificate::Problem judged(const typename Library::Geometry& D, const typename Library::Torque& weight,
                                     const typename Library::Problem& p) {
    certificate::Problem q;
    const std::size_t n = static_cast<std::size_t>(D.cols());
    q.A.assign(M, certificate::Vector(n));
    q.D = q.A_unweighted = q.A;
    for (int r = 0; r < M; ++r) {
      q.demand.push_back(p.demand[r]);
      q.row_weight.push_back(weight[r]);
      q.u.push_back(Real(weight[r]) * Real(p.demand[r]));
      for (std::size_t i = 0; i < n; ++i) {
        const Real d = D(r, static_cast<Eigen::Index>(i)), e = p.effectiveness[static_cast<Eigen::Index>(i)];
        const bool off = e < p.effectiveness_min || (p.lo[Eigen::Index(i)] == 0 && p.up[Eigen::Index(i)] == 0);
        q.D[std::size_t(r)][i] = off ? 0 : Real(weight[r]) * d;  // what cannot act delivers no error
        q.A_unweighted[std::size_t(r)][i] = d * e;
        q.A[std::size_t(r)][i] = Real(weight[r]) * d * e;
      }
    }
    q.lo = extended(p.lo);
    q.up = extended(p.up);
    q.preferred = extended(p.preferred);
    q.p = extended(p.effort_weight);
    q.g = extended(p.bound);
    for (std::size_t i = 0; i < n; ++i) q.g[i] *= Real(p.effectiveness[static_cast<Eigen::Index>(i)]);
    return q;
  }

  Library library_;
  typename Library::State state_;
};

}  // namespace

template <class S>
std::unique_ptr<AnySolver> solver_in(int rows) {
  if (rows == 3) return std::make_unique<Solver<S, 3, 16>>();
  return std::make_unique<Solver<S, 6, 12>>();
}
template std::unique_ptr<AnySolver> solver_in<GYROSTAT_TEST_SCALAR>(int rows);

}  // namespace gyrostat::test
