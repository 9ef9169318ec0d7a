// SPDX-License-Identifier: MIT
#include "gyrostat/flight/observers/parts/compensation_margin.hpp"

#include <gtest/gtest.h>

#include "../algebra.hpp"
#include "../random.hpp"
#include "closed_loop.hpp"
#include "li2018.hpp"
#include "telemetry_log.hpp"

namespace gyrostat::test::test_compensation_margin {
namespace {

/// Largest real part of the eigenvalues of the loop itself: sigma' = w', what' observer, sliding correction of slope r.
/// Written from the block diagram (one axis, J = 1), not from the characteristic polynomial.
double abscissa(double m, double r, double l1, double l2) {
  // States: momentum error s, observer error z1, eta. Command u = -theta - r s with theta = l1 z1 + eta.
  // Plant s' = m u; observer what' = u + theta, so z1' = m u - u - theta; eta' = l2 z1.
  Eigen::RowVector3d theta(0, l1, 1), s(1, 0, 0);
  const Eigen::RowVector3d u = -theta - r * s;
  Eigen::Matrix3d M;
  M.row(0) = m * u;
  M.row(1) = (m - 1) * u - theta;
  M.row(2) << 0, l2, 0;
  return eigenvalues(M).real().maxCoeff();
}

TEST(CompensationMargin, StabilityIsThatOfTheRootsOfTheLoop) {
  Random random(41);
  for (int trial = 0; trial < 5000; ++trial) {
    const double m = random.log_uniform(0.01, 1), r = random.log_uniform(0.01, 100);
    const double l1 = random.log_uniform(0.01, 100), l2 = random.log_uniform(0.01, 100);
    const double a = abscissa(m, r, l1, l2);
    if (std::abs(a) < 1e-9) continue;
    EXPECT_EQ(compensation_is_stable(m, r, l1, l2), a < 0) << m << " " << r << " " << l1 << " " << l2;
  }
}

TEST(CompensationMargin, CriticalEffectivenessIsTheWorstCorrection) {
  Random random(42);
  for (int trial = 0; trial < 200; ++trial) {
    const double l1 = random.log_uniform(0.1, 10), l2 = random.log_uniform(0.01, 10);
    const double critical = critical_effectiveness(l1, l2);
    double worst = 0;
    for (double r = 1e-3; r < 1e3; r *= 1.01) worst = std::max(worst, l2 * r / ((r + l1) * (l1 * r + l2)));
    EXPECT_LE(worst, critical * (1 + 1e-12));
    EXPECT_GT(worst, critical * (1 - 1e-4));  // a grid of 1 % around a smooth maximum
    const double r = std::sqrt(l2);
    EXPECT_TRUE(compensation_is_stable(critical * 1.001, r, l1, l2));
    EXPECT_FALSE(compensation_is_stable(critical * 0.999, r, l1, l2));
  }
}

TEST(CompensationMargin, PublishedGainsNeedNineteenPercent) {
  EXPECT_NEAR(critical_effectiveness(1.0, 0.6), 0.19, 0.001);
  EXPECT_LT(critical_effectiveness(1.0, 0.05), 0.04);
}

TEST(CompensationMargin, NonlinearLoopFollowsIt) {
  // Uniform effectiveness without limits: 0.3 settles, 0.1 ends in a limit cycle (as the li2018 study measured).
  const auto amplitude = [](double effectiveness) {
    const auto setup = li2018::setup(std::numeric_limits<double>::infinity(), 0.01);
    auto stack = li2018::stack(setup);
    Body body(setup.vehicle);
    body.q_NB = quat_from_mrp<double>({-0.1579, 0.1368, 0.0947});
    body.d_B = {-1.5e-3, 3.75e-3, 2.25e-3};
    body.effectiveness.setConstant(effectiveness);
    double late = 0;
    fly(stack, body, setup.dt, 10000, nullptr, [&](int k) {
      const std::vector<double> z1 = telemetry_of(stack.estimator.observer).at("z1");
      if (k > 9000)
        for (const double z : z1) late = std::max(late, std::abs(z));
    });
    return late;
  };
  EXPECT_LT(amplitude(0.3), 1e-8);
  EXPECT_GT(amplitude(0.1), 1e-3);
}

}  // namespace
}  // namespace gyrostat::test::test_compensation_margin
