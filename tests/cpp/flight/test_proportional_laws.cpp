// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include "../random.hpp"
#include "alone.hpp"
#include "closed_loop.hpp"
#include "gyrostat/flight/controllers/mrp_feedback.hpp"
#include "gyrostat/flight/controllers/open_loop.hpp"
#include "li2018.hpp"

namespace gyrostat::test::test_proportional_laws {
namespace {

template <class Law>
Demand<double> ask(Law law, const Vec3<double>& sigma, const Vec3<double>& omega,
                   const Vec3<double>& d_B = Vec3<double>::Zero()) {
  Measurement<double> y;
  y.q_NB = quat_from_mrp(sigma);
  y.omega_BN_B = omega;
  y.h_w = VecN<double>::Zero(4);
  Estimate<double> x = Estimate<double>::healthy(y);
  x.d_B = d_B;
  return law.step(x, {}, {}, Allocation<double>::idle(4));
}

template <class Law>
auto stack_of(const gyrostat::Setup<double>& s, const typename Law::Params& p) {
  using Stack = FlightStack<PassthroughObserver<double>, NoDetector<double>, Law, PseudoInverse<double>>;
  typename Stack::Params all(s);
  all.controller = p;
  return Stack(unchecked, s, all);
}

MrpFeedback<double>::Params uncompensated(double K, double P) {
  MrpFeedback<double>::Params p(ftc_4rw<double>());
  p.K = K;
  p.P = P;
  p.compensate = false;
  return p;
}

TEST(MrpFeedback, IsItsFormula) {
  const Alone<MrpFeedback<double>> law(unchecked, ftc_4rw<double>(), uncompensated(2, 7));
  const Vec3<double> sigma{0.1, -0.2, 0.3}, omega{0.01, 0.02, -0.03};
  EXPECT_LT((ask(law, sigma, omega).tau_B - (-2 * sigma - 7 * omega)).norm(), 1e-15);
  const Vec3<double> long_way = mrp_shadow(sigma);  // |sigma| > 1: the law takes the short way
  EXPECT_LT((ask(law, long_way, omega).tau_B - (-2 * sigma - 7 * omega)).norm(), 1e-15);
}

TEST(SaturatedPd, IsItsFormulaAndKeepsItsBound) {
  const auto p = li2018::saturated_pd<double>();
  const Alone<SaturatedPd<double>> law(unchecked, ftc_4rw<double>(), p);
  Random random(31);
  for (int trial = 0; trial < 200; ++trial) {
    const Vec3<double> sigma = 0.57 * random.vector<double>(1), omega = random.vector<double>(3);
    Vec3<double> expected;
    for (int i = 0; i < 3; ++i) {
      const double e = std::exp(2 * omega[i] / 0.1);  // tanh written out
      expected[i] = -10 * sigma[i] - 13 * 0.1 * (std::isinf(e) ? 1 : (e - 1) / (e + 1));
    }
    const Vec3<double> tau = ask(law, sigma, omega).tau_B;
    EXPECT_LT((tau - expected).norm(), 1e-13);  // exp(60) loses nothing that counts; 1.3 N m of roundings
    EXPECT_LE(tau.cwiseAbs().maxCoeff(), p.kp + p.kd * p.ws);
  }
}

TEST(ProportionalLaws, TheEstimateIsSubtractedUnlessCompensateIsOff) {
  const auto setup = ftc_4rw<double>();
  const Vec3<double> zero = Vec3<double>::Zero(), d_B{0.01, -0.02, 0.03};
  MrpFeedback<double>::Params mrp_params(setup);
  SaturatedPd<double>::Params pd_params(setup);
  EXPECT_EQ(ask(Alone<MrpFeedback<double>>(unchecked, setup, mrp_params), zero, zero, d_B).tau_B, Vec3<double>(-d_B));
  EXPECT_EQ(ask(Alone<SaturatedPd<double>>(unchecked, setup, pd_params), zero, zero, d_B).tau_B, Vec3<double>(-d_B));
  mrp_params.compensate = pd_params.compensate = false;
  EXPECT_EQ(ask(Alone<MrpFeedback<double>>(unchecked, setup, mrp_params), zero, zero, d_B).tau_B, zero);
  EXPECT_EQ(ask(Alone<SaturatedPd<double>>(unchecked, setup, pd_params), zero, zero, d_B).tau_B, zero);
}

/// Largest growth from sample to sample of V = w'Jw/2 + 2 k ln(1 + sigma'sigma), without disturbance and limits.
template <class Law>
double growth_of_energy(const typename Law::Params& p, double k) {
  const auto setup = vehicle_with<double>(satellite_inertia<double>(), pyramid<double>(),
                                          std::numeric_limits<double>::infinity(), 0.001);
  auto stack = stack_of<Law>(setup, p);
  Body body(setup.vehicle);
  body.q_NB = quat_from_mrp<double>({0.1, 0.2, -0.3});
  body.omega_BN_B = {0.01, -0.02, 0.03};
  double before = std::numeric_limits<double>::infinity(), growth = 0;
  fly(stack, body, setup.dt, 20000, nullptr, [&](int) {
    const double V =
        0.5 * body.omega_BN_B.dot(body.J_B * body.omega_BN_B) + 2 * k * std::log1p(mrp(body.q_NB).squaredNorm());
    growth = std::max(growth, V - before);
    before = V;
  });
  return growth;
}

TEST(ProportionalLaws, LyapunovFunctionsDoNotGrow) {
  // The hold alone lets V grow, when the rate is zero, by a few h^2 of J |acceleration|^2 = 1e-8.
  EXPECT_LT(growth_of_energy<MrpFeedback<double>>(uncompensated(1.2, 5), 1.2), 1e-8);
  const SaturatedPd<double>::Params p(ftc_4rw<double>());
  EXPECT_LT(growth_of_energy<SaturatedPd<double>>(p, p.kp), 1e-8);
}

TEST(MrpFeedback, ConstantDisturbanceLeavesTheOffsetOfItsPage) {
  const auto setup = ftc_4rw<double>();
  const MrpFeedback<double>::Params p(setup);
  auto stack = stack_of<MrpFeedback<double>>(setup, p);
  Body body(setup.vehicle);
  body.d_B = {1e-3, -2e-3, 1.5e-3};
  fly(stack, body, setup.dt, 20000, nullptr, nullptr);
  const Vec3<double> expected = body.d_B / p.K;
  EXPECT_LT((mrp(body.q_NB) - expected).norm(), 1e-6 * expected.norm());
  EXPECT_LT(degrees(rotation_angle(body.q_NB)), 1);
}

TEST(OpenLoop, IssuesItsCommandWhateverHappens) {
  const auto setup = ftc_4rw<double>();
  OpenLoop<double>::Params p(setup);
  EXPECT_EQ(p.command, VecN<double>::Zero(4));
  p.command << 0.05, -0.01, 0.02, 0.3;
  auto stack = stack_of<OpenLoop<double>>(setup, p);
  Body body(setup.vehicle);
  fly(stack, body, setup.dt, 10, nullptr, [&](int) {
    VecN<double> expected = p.command;
    expected[3] = 0.2;  // the limit
    EXPECT_EQ(stack.last().u, expected);
  });
}

TEST(OpenLoopCheck, RefusesAnotherNumberOfActuators) {
  const auto setup = ftc_4rw<double>();
  OpenLoop<double>::Params p(setup);
  p.command = VecN<double>::Zero(3);
  EXPECT_FALSE(OpenLoop<double>::check(setup, p).ok());
  EXPECT_EQ(OpenLoop<double>::check(setup, p).value, 3);
}

TEST(ProportionalLawsCheck, RefuseADampingThatTheSampleCannotCarry) {
  auto setup = ftc_4rw<double>();
  EXPECT_EQ(MrpFeedback<double>::check(setup, uncompensated(1, 3000)).code, Status<double>::Code::unstable);
  EXPECT_TRUE(MrpFeedback<double>::check(setup, uncompensated(1, 5)).ok());
  auto p = li2018::saturated_pd<double>();
  EXPECT_TRUE(SaturatedPd<double>::check(setup, p).ok());
  p.kd = 3000;
  EXPECT_EQ(SaturatedPd<double>::check(setup, p).code, Status<double>::Code::unstable);
  setup.vehicle.coordinates = Coordinates::euler_angles;
  EXPECT_EQ(MrpFeedback<double>::check(setup, uncompensated(1, 5)).code, Status<double>::Code::wrong_chart);
  EXPECT_EQ(SaturatedPd<double>::check(setup, li2018::saturated_pd<double>()).code, Status<double>::Code::wrong_chart);
}

}  // namespace
}  // namespace gyrostat::test::test_proportional_laws
