// SPDX-License-Identifier: MIT
/// The worst residual under uncertain effectiveness: order of its three models, against samples and vertices.
#include <gtest/gtest.h>

#include <Eigen/Dense>

#include "flight/allocators/any_solver.hpp"
#include "gyrostat/flight/allocators/parts/worst_case.hpp"

namespace gyrostat::test::test_worst_case {
namespace {

using certificate::Real;

class WorstCases : public testing::TestWithParam<Kind> {
 protected:
  bool single() const { return GetParam().single; }
  double tolerance() const { return single() ? 1e-5 : 1e-13; }

  Outcome solve(Posed p, WorstCase worst_case) {
    p.mode = AllocationMode::robust_socp;
    p.worst_case = worst_case;
    p.residual_weight = 300;
    solver->reset();
    return solver->solve(p);
  }

  std::unique_ptr<AnySolver> solver = GetParam().solver();
  Random random{11};
};
INSTANTIATE_TEST_SUITE_P(, WorstCases, testing::ValuesIn(all_kinds()),
                         [](const auto& kind) { return name_of(kind.param); });

TEST_P(WorstCases, AreReportedAsAnIndependentSearchFindsThem) {
  for (int k = 0; k < 60; ++k) {
    const Posed p = random_problem(random, std::size_t(GetParam().rows), 6);
    for (const WorstCase worst_case : {WorstCase::bound, WorstCase::exact}) {
      const Outcome s = solve(p, worst_case);
      const certificate::Spread spread(s.q.D);
      const Real bound = certificate::worst_bound(s.q, spread, s.command),
                 exact = certificate::worst_exact(s.q, spread, s.command);
      EXPECT_NEAR(double(s.worst_case), double(worst_case == WorstCase::bound ? bound : exact), tolerance());
      EXPECT_GE(s.worst_case, s.residual_norm - tolerance());
      EXPECT_LE(exact, bound + 1e-15L);
    }
  }
}

/// Residuals of every size against the error, all but none of it along the strongest axis: the root lies anywhere in (0, 1].
TEST(ExactWorstCase, IsFoundWhereverItsRootLies) {
  Random random(17);
  int close_to_one = 0;
  for (int k = 0; k < 4000; ++k) {
    Eigen::Matrix<double, 3, 5> D;
    for (int i = 0; i < 5; ++i) D.col(i) = random.vector<double>(1);
    const TorqueSpread<double, 3> spread(D, 0x1Fu);
    Vec3<double> along;
    for (int j = 0; j < 3; ++j) along[j] = random.log_uniform(j == 2 ? 1e-16 : 1e-6, 1);
    const Vec3<double> r = spread.axes * along;
    const double rho = random.log_uniform(1e-6, 1);

    certificate::Problem q;  // nothing is delivered, all is missing; one actuator carries the error
    q.D.assign(3, certificate::Vector(5));
    q.A.assign(3, certificate::Vector(5, 0));
    for (std::size_t j = 0; j < 3; ++j) {
      q.u.push_back(r[Eigen::Index(j)]);
      for (std::size_t i = 0; i < 5; ++i) q.D[j][i] = D(Eigen::Index(j), Eigen::Index(i));
    }
    q.g = {rho, 0, 0, 0, 0};
    const certificate::Vector one{1, 0, 0, 0, 0};
    const double right = double(certificate::worst_exact(q, certificate::Spread(q.D), one));
    EXPECT_NEAR(spread.exact(r, rho) / right, 1, 1e-13) << k;  // rounding of a few terms, and of the eigenvectors
    close_to_one += along[2] < 1e-9 * spread.s_max * rho;
  }
  EXPECT_GT(close_to_one, 500);
}

TEST_P(WorstCases, NoSampledErrorExceedsTheExactOneAndSomeComeNear) {
  std::mt19937_64 engine(3);
  std::normal_distribution<double> normal;
  for (int k = 0; k < 20; ++k) {
    const Outcome s = solve(random_problem(random, std::size_t(GetParam().rows), 6), WorstCase::exact);
    const certificate::Vector r = certificate::residual(s.q, s.command);
    const Real rho = certificate::uncertain_norm(s.q, s.command);
    Real largest = 0;
    for (int sample = 0; sample < 4000; ++sample) {  // r - D x, |x| = rho
      certificate::Vector x(6);
      for (Real& v : x) v = normal(engine);
      const Real length = certificate::norm(x);
      certificate::Vector off = r;
      for (std::size_t j = 0; j < off.size(); ++j) off[j] -= rho / length * certificate::dot(s.q.D[j], x);
      largest = std::max(largest, certificate::norm(off));
    }
    EXPECT_LE(largest, s.worst_case + tolerance());
    EXPECT_GE(largest, 0.7L * s.worst_case);  // 4000 directions in six dimensions come within 45 degrees of the worst
  }
}

TEST_P(WorstCases, IndependentErrorsOfEachActuatorStayBelow) {
  // Diagonal errors |delta_i| <= eps_i are contained in the full matrices of that norm: all vertices are tried.
  for (int k = 0; k < 40; ++k) {
    const Outcome s = solve(random_problem(random, std::size_t(GetParam().rows), 6), WorstCase::exact);
    const certificate::Vector r = certificate::residual(s.q, s.command);
    Real largest = 0;
    for (unsigned signs = 0; signs < 64; ++signs) {
      certificate::Vector off = r;
      for (std::size_t j = 0; j < off.size(); ++j)
        for (std::size_t i = 0; i < 6; ++i)
          off[j] += ((signs >> i & 1u) ? 1 : -1) * s.q.D[j][i] * s.q.g[i] * s.command[i];
      largest = std::max(largest, certificate::norm(off));
    }
    EXPECT_LE(largest, s.worst_case + tolerance());
  }
}

TEST_P(WorstCases, GrowWithTheUncertainty) {
  for (int k = 0; k < 30; ++k) {
    Posed p = random_problem(random, std::size_t(GetParam().rows), 6);
    const Numbers bound = p.bound;
    for (const WorstCase worst_case : {WorstCase::bound, WorstCase::exact}) {
      Real last = 0;
      for (const double share : {0.0, 0.3, 0.6, 1.0}) {
        for (std::size_t i = 0; i < 6; ++i) p.bound[i] = share * bound[i];
        const Real value = solve(p, worst_case).primal;  // the optimum of a larger objective
        EXPECT_GE(value, last * (1 - (single() ? 1e-3L : 1e-9L)));
        last = value;
      }
    }
  }
}

TEST_P(WorstCases, RobustAllocationHasTheSmallestOfAllModesForItsEffort) {
  for (int k = 0; k < 30; ++k) {
    const Posed p = random_problem(random, std::size_t(GetParam().rows), 8);
    const Outcome robust = solve(p, WorstCase::bound);
    const certificate::Spread spread(robust.q.D);
    Posed other = p;
    for (const AllocationMode mode : {AllocationMode::lexicographic, AllocationMode::weighted_least_squares}) {
      other.mode = mode;
      solver->reset();
      const Outcome s = solver->solve(other);
      const Real rival = certificate::robust_primal(robust.q, spread, s.command, 300, certificate::Shape::bound, 0);
      EXPECT_GE(rival, robust.primal * (1 - (single() ? 1e-3L : 1e-9L)));
    }
  }
}

}  // namespace
}  // namespace gyrostat::test::test_worst_case
