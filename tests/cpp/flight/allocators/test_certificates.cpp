// SPDX-License-Identifier: MIT
/// Every mode on random problems, judged by certificates recomputed in extended precision from the returned numbers.
#include <gtest/gtest.h>

#include "flight/allocators/any_solver.hpp"

namespace gyrostat::test::test_certificates {
namespace {

using certificate::Real;
using certificate::Shape;
using certificate::Vector;

struct Settings {
  AllocationMode mode;
  WorstCase worst_case = WorstCase::bound;
  double least_weight = 1e4, largest_weight = 1e4, margin = 0;
  bool at_edge = false;
};

class Certificates : public testing::TestWithParam<Kind> {
 protected:
  static constexpr std::size_t count = 600;
  bool single() const { return GetParam().single; }

  /// Random problems of 3 to 16 actuators (6 to 12 for six rows), solved cold.
  std::vector<Outcome> solve(const Settings& settings) const {
    const std::size_t rows = static_cast<std::size_t>(GetParam().rows);
    const std::vector<std::size_t> actuators =
        rows == 3 ? std::vector<std::size_t>{3, 4, 6, 8, 12, 16} : std::vector<std::size_t>{6, 8, 12};
    const std::unique_ptr<AnySolver> solver = GetParam().solver();
    Random random(20);
    std::vector<Outcome> out;
    int unproven = 0;
    for (std::size_t k = 0; k < count; ++k) {
      const std::size_t n = actuators[k % actuators.size()];
      Posed p =
          settings.at_edge ? problem_at_edge(random, rows, n, distance(random, k)) : random_problem(random, rows, n);
      p.mode = settings.mode;
      p.worst_case = settings.worst_case;
      p.residual_weight = random.log_uniform(settings.least_weight, settings.largest_weight);
      p.margin = settings.margin;
      solver->reset();
      out.push_back(solver->solve(p));
      EXPECT_EQ(certificate::box_violation(out[k].q, out[k].command), 0) << "problem " << k;  // clipped, not rounded
      unproven += out[k].status == AllocationStatus::cap_reached ? 1 : 0;
      EXPECT_LE(out[k].newton, 120) << "problem " << k;  // the cap is 200
      EXPECT_LE(out[k].outer, 40) << "problem " << k;
    }
    EXPECT_LE(unproven,
              settings.at_edge && rows == 6 ? 1 : 0);  // and says so: six rows at the edge, with dead actuators
    return out;
  }

  /// 1e-13 to 1, inside and outside in turn.
  static double distance(Random& random, std::size_t k) { return random.log_uniform(1e-13, 1) * (k % 2 == 0 ? 1 : -1); }

  static Real median(std::vector<Real> values) {
    std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2), values.end());
    return values[values.size() / 2];
  }

  void robust_gap_closes(WorstCase worst_case, Shape shape, bool at_edge = false) const {
    const Real margin = single() ? Real(0.02f) : Real(0.02);
    std::vector<Real> gaps;
    for (const Outcome& s : solve({AllocationMode::robust_socp, worst_case, 10, single() ? 1e4 : 1e5, 0.02, at_edge})) {
      const certificate::Spread spread(s.q.D);
      const Real primal = certificate::robust_primal(s.q, spread, s.command, s.residual_weight, shape, margin);
      const Real dual =
          certificate::robust_dual(s.q, spread, s.command, s.multiplier, s.theta, s.residual_weight, shape, margin);
      gaps.push_back((primal - dual) / primal);
      EXPECT_GE(primal - dual, -1e-16L * primal);
      if (s.status != AllocationStatus::cap_reached) {
        EXPECT_LE(primal - dual, (single() ? 2e-3L : 1e-8L) * primal);
      }
      EXPECT_GE(s.gap, (primal - dual) - (single() ? 1e-5L : 1e-13L) * primal);  // the reported gap is honest
    }
    EXPECT_LE(median(gaps), single() ? 1e-5L : 1e-12L);
  }
};

INSTANTIATE_TEST_SUITE_P(, Certificates, testing::ValuesIn(all_kinds()),
                         [](const auto& kind) { return name_of(kind.param); });

TEST_P(Certificates, ClosestTorqueIsWithinRoundingOfItsLowerBound) {
  // Of the torque scale. Rounding alone leaves n epsilon (4e-15, 2e-6), times the condition of the unclipped actuators.
  const Real target = single() ? 1e-4L : 1e-11L;
  for (const Outcome& s : solve({AllocationMode::lexicographic})) {
    const Real scale = certificate::scale(s.q);
    const Vector r = certificate::residual(s.q, s.command);
    const Real excess = std::min(certificate::residual_excess(s.q, s.command, r),
                                 certificate::unweighted_excess(s.q, s.command, s.infeasibility_direction));
    EXPECT_LE(excess, target * scale);
    EXPECT_GE(excess, -1e-15L * scale);  // a bound above the value would be no bound
  }
}

TEST_P(Certificates, ClosestTorqueCostsLeastEffort) {
  // Of the effort at the limits. Measured 1e-7 and 1e-12, where multipliers of 1e7 meet unclipped actuators.
  const Real target = single() ? 2e-5L : 1e-10L;
  for (const Outcome& s : solve({AllocationMode::lexicographic})) {
    const Real gap = certificate::effort_gap(s.q, s.command, s.multiplier);
    const Real size = certificate::effort(s.q, s.q.up) + certificate::effort(s.q, s.q.lo);
    const Real y = certificate::norm(s.multiplier), rounding = GetParam().epsilon() * y * certificate::norm(s.q.up);
    EXPECT_LE(gap, target * size + rounding);  // the multiplier itself is rounded
    EXPECT_GE(gap, -1e-17L * size * (1 + y));
  }
}

TEST_P(Certificates, UnreachableDemandsCarryAProof) {
  std::size_t proofs = 0;
  for (const Outcome& s : solve({AllocationMode::lexicographic})) {
    const Vector& v = s.infeasibility_direction;
    if (certificate::norm(v) == 0) continue;
    ++proofs;
    EXPECT_EQ(s.status, AllocationStatus::optimal_reduced);
    EXPECT_GT(certificate::dot(v, s.q.demand), certificate::support(s.q, s.q.A_unweighted, v));
  }
  EXPECT_GT(proofs, count / 5);
}

TEST_P(Certificates, WeightedLeastSquaresClosesItsGap) {
  const double gamma = single() ? 1e4 : 1e6;
  std::vector<Real> gaps;
  for (const Outcome& s : solve({AllocationMode::weighted_least_squares, WorstCase::bound, gamma, gamma})) {
    const Real primal = certificate::wls_primal(s.q, s.command, s.residual_weight);
    const Real gap = primal - certificate::wls_dual(s.q, s.multiplier, s.residual_weight);
    gaps.push_back(gap / primal);
    EXPECT_GE(gap, -1e-18L * (1 + certificate::norm(s.multiplier)));  // rounding of the dual itself
    EXPECT_LE(gap, (single() ? 2e-3L : 1e-12L) * primal);
    EXPECT_LE(std::abs(s.primal - primal), (single() ? 1e-4L : 1e-11L) * primal);
  }
  EXPECT_LE(median(gaps), single() ? 1e-5L : 1e-15L);
}

TEST_P(Certificates, RobustBoundClosesItsGap) { robust_gap_closes(WorstCase::bound, Shape::bound); }
TEST_P(Certificates, RobustExactClosesItsGap) { robust_gap_closes(WorstCase::exact, Shape::exact); }
TEST_P(Certificates, ConstantMarginClosesItsGap) { robust_gap_closes(WorstCase::paper_constant, Shape::constant); }

TEST_P(Certificates, RobustBoundClosesItsGapThroughTheEdge) {
  robust_gap_closes(WorstCase::bound, Shape::bound, /*at_edge=*/true);
}
TEST_P(Certificates, RobustExactClosesItsGapThroughTheEdge) {
  robust_gap_closes(WorstCase::exact, Shape::exact, /*at_edge=*/true);
}
TEST_P(Certificates, ConstantMarginClosesItsGapThroughTheEdge) {
  robust_gap_closes(WorstCase::paper_constant, Shape::constant, /*at_edge=*/true);
}

TEST_P(Certificates, ClosestTorqueAndLeastSquaresKeepTheirBoundsThroughTheEdge) {
  for (const Outcome& s : solve({AllocationMode::lexicographic, WorstCase::bound, 1e4, 1e4, 0, /*at_edge=*/true})) {
    const Vector r = certificate::residual(s.q, s.command);
    const Real excess = std::min(certificate::residual_excess(s.q, s.command, r),
                                 certificate::unweighted_excess(s.q, s.command, s.infeasibility_direction));
    EXPECT_LE(excess, (single() ? 1e-4L : 1e-11L) * certificate::scale(s.q));
  }
  for (const Outcome& s :
       solve({AllocationMode::weighted_least_squares, WorstCase::bound, 10, 1e4, 0, /*at_edge=*/true})) {
    const Real primal = certificate::wls_primal(s.q, s.command, s.residual_weight);
    EXPECT_LE(primal - certificate::wls_dual(s.q, s.multiplier, s.residual_weight),
              (single() ? 2e-3L : 1e-12L) * primal);
  }
}

/// The corner of three body axes and their sum, a billionth beyond: the residual is all but zero, and its direction says
/// nothing of the size of the multiplier.
TEST(RobustAtTheApex, IsProvenABillionthBeyondACorner) {
  const double s = 1 / std::sqrt(3.0), corner[4] = {0.25, 0.25, -0.25, 0.25};
  Posed p = Posed::with_axes({{1, 0, 0, s}, {0, 1, 0, s}, {0, 0, 1, s}}, 0.25);
  for (std::size_t r = 0; r < 3; ++r)
    for (std::size_t i = 0; i < 4; ++i) p.demand[r] += (1 + 1e-9) * p.D[r][i] * corner[i];
  p.bound.assign(4, 0.1);
  p.mode = AllocationMode::robust_socp;
  p.residual_weight = 1e3;
  const Outcome out = Kind{"double3", false, 3}.solver()->solve(p);
  const certificate::Spread spread(out.q.D);
  const Real primal = certificate::robust_primal(out.q, spread, out.command, 1e3, Shape::bound, 0);
  const Real dual =
      certificate::robust_dual(out.q, spread, out.command, out.multiplier, out.theta, 1e3, Shape::bound, 0);
  EXPECT_NE(out.status, AllocationStatus::cap_reached);
  EXPECT_LE(primal - dual, 1e-8L * primal);
}

TEST_P(Certificates, StatusSaysNoMoreThanTheyDo) {
  // Weights and bounds far beyond sense, and few Newton steps: what is called optimal is proven so all the same.
  const std::size_t rows = static_cast<std::size_t>(GetParam().rows);
  const std::unique_ptr<AnySolver> solver = GetParam().solver();
  Random random(23);
  int unproven = 0;
  for (std::size_t k = 0; k < 600; ++k) {
    Posed p = problem_at_edge(random, rows, rows + k % 7, distance(random, k));
    for (double& b : p.bound) b *= random.log_uniform(1e-3, 1e2);
    p.residual_weight = random.log_uniform(1e-2, 1e12);
    p.max_newton = k % 3 == 0 ? 3 : 200;
    p.mode = k % 2 == 0 ? AllocationMode::robust_socp : AllocationMode::weighted_least_squares;
    solver->reset();
    const Outcome s = solver->solve(p);
    const Real h = s.residual_weight;
    const certificate::Spread spread(s.q.D);
    const bool robust = k % 2 == 0;
    const Real primal = robust ? certificate::robust_primal(s.q, spread, s.command, h, Shape::bound, 0)
                               : certificate::wls_primal(s.q, s.command, h);
    const Real dual = robust
                          ? certificate::robust_dual(s.q, spread, s.command, s.multiplier, s.theta, h, Shape::bound, 0)
                          : certificate::wls_dual(s.q, s.multiplier, h);
    unproven += s.status == AllocationStatus::cap_reached;
    if (s.status == AllocationStatus::cap_reached) continue;
    const Real rounding = (single() ? 4e-7L : 2e-13L) * certificate::scale(s.q) * certificate::norm(s.multiplier);
    EXPECT_LE(primal - dual, (single() ? 2e-3L : robust ? 1e-8L : 1e-12L) * primal + rounding) << k;
  }
  EXPECT_GT(unproven, 30);  // the short ones
}

TEST_P(Certificates, ScaledShareIsTheLargestOne) {
  const Real target = single() ? 1e-4L : 1e-10L;
  std::size_t reduced = 0;
  for (const Outcome& s : solve({AllocationMode::lexicographic_scaled})) {
    EXPECT_EQ(s.warnings & AllocationWarning::direction_lost, 0);  // zero torque is in every box here
    Vector r = certificate::residual(s.q, s.command);
    for (std::size_t j = 0; j < r.size(); ++j) r[j] -= (1 - s.scale) * s.q.u[j];
    EXPECT_LE(certificate::norm(r), target * certificate::scale(s.q));  // what is delivered: scale * demand
    EXPECT_LE(s.scale, 1);
    if (certificate::norm(s.infeasibility_direction) == 0) continue;
    ++reduced;
    const Vector& v = s.infeasibility_direction;  // no share above this one can be had
    const Real largest = certificate::support(s.q, s.q.A_unweighted, v) / certificate::dot(v, s.q.demand);
    EXPECT_NEAR(static_cast<double>(s.scale), static_cast<double>(largest), single() ? 1e-4 : 1e-10);
  }
  EXPECT_GT(reduced, count / 5);
}

/// Solves that end long before the optimum: the gap that is reported is the one that the returned numbers have.
TEST_P(Certificates, ASolveThatEndsEarlyReportsItsGap) {
  struct {
    AllocationMode mode;
    WorstCase worst_case;
    Shape shape;
  } const cases[] = {{AllocationMode::weighted_least_squares, WorstCase::bound, Shape::bound},
                     {AllocationMode::robust_socp, WorstCase::bound, Shape::bound},
                     {AllocationMode::robust_socp, WorstCase::exact, Shape::exact},
                     {AllocationMode::robust_socp, WorstCase::paper_constant, Shape::constant}};
  const std::unique_ptr<AnySolver> solver = GetParam().solver();
  Random random(23);
  for (const auto& c : cases) {
    int early = 0;
    for (int k = 0; k < 150; ++k) {
      Posed p = random_problem(random, static_cast<std::size_t>(GetParam().rows), 8);
      p.mode = c.mode;
      p.worst_case = c.worst_case;
      p.residual_weight = random.log_uniform(10, 1e3);
      p.margin = 0.02;
      p.max_newton = 1 + k % 4;
      for (double& e : p.effectiveness) e = std::max(e, 0.2);  // all can act
      solver->reset();
      const Outcome s = solver->solve(p);
      const certificate::Spread spread(s.q.D);
      const Real h = s.residual_weight, margin = single() ? Real(0.02f) : Real(0.02);
      const bool weighted = c.mode == AllocationMode::weighted_least_squares || (s.theta == 0 && margin == 0);
      const Real primal = weighted ? certificate::wls_primal(s.q, s.command, h)
                                   : certificate::robust_primal(s.q, spread, s.command, h, c.shape, margin);
      const Real dual =
          weighted ? certificate::wls_dual(s.q, s.multiplier, h)
                   : certificate::robust_dual(s.q, spread, s.command, s.multiplier, s.theta, h, c.shape, margin);
      // Rounding.
      const double rounding = single() ? 1e-4 : 1e-11;
      EXPECT_NEAR(double(s.primal / primal), 1, rounding) << int(c.mode) << ' ' << k;
      EXPECT_NEAR(double(s.gap / primal), double((primal - dual) / primal), rounding * double(1 + s.gap / primal))
          << int(c.mode) << ' ' << int(c.worst_case) << ' ' << k;
      early += s.gap > 1e-3L * primal ? 1 : 0;
    }
    EXPECT_GT(early, 20) << int(c.mode) << ' ' << int(c.worst_case);
  }
}

}  // namespace
}  // namespace gyrostat::test::test_certificates
