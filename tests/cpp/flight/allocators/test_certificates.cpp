// SPDX-License-Identifier: MIT
/// Every mode on random problems, judged by certificates recomputed in extended precision from the returned numbers.
#include <gtest/gtest.h>

#include "flight/allocators/problems.hpp"

namespace gyrostat::test {
namespace {

using certificate::Real;
using certificate::Shape;

template <class S_>
struct Torques {
  using S = S_;
  static constexpr int M = 3, N = 16;
  static constexpr std::array actuators{3, 4, 6, 8, 12, 16};
  static constexpr bool single = sizeof(S) < 8;
};
template <class S_>
struct TorquesAndForces {
  using S = S_;
  static constexpr int M = 6, N = 12;
  static constexpr std::array actuators{6, 8, 12};
  static constexpr bool single = sizeof(S) < 8;
};

template <class T>
class Certificates : public testing::Test {
 public:
  using S = typename T::S;
  using Problem = RandomProblem<S, T::M, T::N>;
  using Solution = AllocationSolution<S, T::M, T::N>;
  static constexpr int count = 600;

  /// Calls judge(problem, independent problem, solution) for every random problem of a mode.
  template <class Pose, class Judge>
  void on_all(Pose pose, Judge judge) {
    Random random(20 + T::M * 100 + T::N);
    for (int k = 0; k < count; ++k) {
      Problem problem(random, T::actuators[std::size_t(k) % T::actuators.size()]);
      pose(problem.problem, random);
      const Solution solution = solve_cold(problem);
      const certificate::Problem q = problem.judged();
      ASSERT_EQ(certificate::box_violation(q, extended(solution.command)), 0) << "problem " << k;  // clipped, not rounded
      ASSERT_NE(solution.status, AllocationStatus::cap_reached) << "problem " << k;
      ASSERT_LE(solution.newton, 120) << "problem " << k;  // total cap 200
      ASSERT_LE(solution.outer, 40) << "problem " << k;
      judge(q, solution, k);
    }
  }

  static Real median(std::vector<Real> values) {
    std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2), values.end());
    return values[values.size() / 2];
  }
};

using Cases = testing::Types<Torques<double>, Torques<float>, TorquesAndForces<double>, TorquesAndForces<float>>;
TYPED_TEST_SUITE(Certificates, Cases);

TYPED_TEST(Certificates, ClosestTorqueIsWithinRoundingOfItsLowerBound) {
  // Target 1e-10 (float 1e-3) of the torque scale. Rounding alone leaves n epsilon; measured 1e-15 and 4e-7.
  const Real target = TypeParam::single ? 2e-5L : 1e-12L;
  this->on_all([](auto& p, Random&) { p.mode = AllocationMode::lexicographic; },
               [&](const certificate::Problem& q, const auto& s, int k) {
                 const Real scale = certificate::scale(q);
                 const certificate::Vector t = extended(s.command), r = certificate::residual(q, t);
                 const Real excess = s.status == AllocationStatus::optimal ? certificate::norm(r) : certificate::residual_excess(q, t, r);
                 EXPECT_LE(std::min(excess, certificate::norm(r)), target * scale) << k;
                 EXPECT_GE(excess, -1e-15L * scale) << k;  // a bound above the value would be no bound
               });
}

TYPED_TEST(Certificates, ClosestTorqueCostsLeastEffort) {
  const Real target = TypeParam::single ? 2e-5L : 1e-12L;  // of the effort of all limits; measured 1e-7 and 1e-17
  this->on_all([](auto& p, Random&) { p.mode = AllocationMode::lexicographic; },
               [&](const certificate::Problem& q, const auto& s, int k) {
                 const Real gap = certificate::effort_gap(q, extended(s.command), extended(s.multiplier));
                 const Real size = certificate::effort(q, q.up) + certificate::effort(q, q.lo);
                 EXPECT_LE(gap, target * size) << k;
                 EXPECT_GE(gap, -(TypeParam::single ? 1e-12L : 1e-17L) * size * (1 + certificate::norm(extended(s.multiplier)))) << k;
               });
}

TYPED_TEST(Certificates, UnreachableDemandsCarryAProof) {
  int unreachable = 0;
  this->on_all([](auto& p, Random&) { p.mode = AllocationMode::lexicographic; },
               [&](const certificate::Problem& q, const auto& s, int k) {
                 const certificate::Vector t = extended(s.command);
                 if (s.status != AllocationStatus::optimal_reduced || s.infeasibility_direction.squaredNorm() == 0) return;
                 ++unreachable;
                 // v'demand > max v'D e t in unweighted rows: the weighted direction is W^-1 v, here read off the residual.
                 certificate::Vector v = certificate::residual(q, t);
                 EXPECT_GT(certificate::dot(v, q.u), certificate::support(q, v)) << k;
               });
  EXPECT_GT(unreachable, this->count / 10);
}

TYPED_TEST(Certificates, WeightedLeastSquaresClosesItsGap) {
  const Real gamma = TypeParam::single ? 1e4L : 1e6L;
  std::vector<Real> gaps;
  this->on_all(
      [&](auto& p, Random&) {
        p.mode = AllocationMode::weighted_least_squares;
        p.residual_weight = static_cast<typename TypeParam::S>(gamma);
      },
      [&](const certificate::Problem& q, const auto& s, int k) {
        const Real primal = certificate::wls_primal(q, extended(s.command), s.residual_weight);
        const Real gap = primal - certificate::wls_dual(q, extended(s.multiplier), s.residual_weight);
        gaps.push_back(gap / primal);
        EXPECT_GE(gap, -1e-17L * (1 + primal)) << k;  // long double rounding
        EXPECT_LE(gap, (TypeParam::single ? 2e-3L : 1e-12L) * primal) << k;
        EXPECT_NEAR(s.primal, static_cast<double>(primal), (TypeParam::single ? 1e-4 : 1e-11) * static_cast<double>(primal)) << k;
      });
  EXPECT_LE(this->median(gaps), TypeParam::single ? 1e-5L : 1e-15L);
}

template <class T, class Fixture>
void robust_gap_closes(Fixture& fixture, WorstCase worst_case, Shape shape) {
  using S = typename T::S;
  std::vector<Real> gaps;
  fixture.on_all(
      [&](auto& p, Random& random) {
        p.mode = AllocationMode::robust_socp;
        p.worst_case = worst_case;
        p.residual_weight = S(random.log_uniform(10, T::single ? 1e4 : 1e5));
        p.margin = S(0.02);
      },
      [&](const certificate::Problem& q, const auto& s, int k) {
        const certificate::Spread spread(q.D);
        const certificate::Vector t = extended(s.command), y = extended(s.multiplier);
        const Real primal = certificate::robust_primal(q, spread, t, s.residual_weight, shape, S(0.02));
        const Real dual = certificate::robust_dual(q, spread, t, y, s.theta, s.residual_weight, shape, S(0.02));
        gaps.push_back((primal - dual) / primal);
        EXPECT_GE(primal - dual, -1e-16L * primal) << k;
        EXPECT_LE(primal - dual, (T::single ? 2e-3L : 1e-8L) * primal) << k;
        EXPECT_GE(static_cast<Real>(s.gap), (primal - dual) - (T::single ? 1e-5L : 1e-13L) * primal) << k;  // the reported gap is honest
      });
  EXPECT_LE(fixture.median(gaps), T::single ? 1e-5L : 1e-12L);
}

TYPED_TEST(Certificates, RobustBoundClosesItsGap) { robust_gap_closes<TypeParam>(*this, WorstCase::bound, Shape::bound); }
TYPED_TEST(Certificates, RobustExactClosesItsGap) { robust_gap_closes<TypeParam>(*this, WorstCase::exact, Shape::exact); }
TYPED_TEST(Certificates, ConstantMarginClosesItsGap) { robust_gap_closes<TypeParam>(*this, WorstCase::paper_constant, Shape::constant); }

TYPED_TEST(Certificates, ScaledShareIsProvenByACut) {
  const Real target = TypeParam::single ? 2e-4L : 1e-11L;
  int reduced = 0;
  this->on_all([](auto& p, Random&) { p.mode = AllocationMode::lexicographic_scaled; },
               [&](const certificate::Problem& q, const auto& s, int k) {
                 certificate::Vector r = certificate::residual(q, extended(s.command));
                 for (std::size_t j = 0; j < r.size(); ++j) r[j] -= (1 - Real(s.scale)) * q.u[j];
                 EXPECT_LE(certificate::norm(r), target * certificate::scale(q)) << k;  // delivered = scale * demand
                 EXPECT_LE(s.scale, 1) << k;
                 reduced += s.scale < 1 ? 1 : 0;
               });
  EXPECT_GT(reduced, this->count / 10);
}

}  // namespace
}  // namespace gyrostat::test
