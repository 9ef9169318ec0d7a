// SPDX-License-Identifier: MIT
#include "gyrostat/flight/controllers/integral_sliding_mode.hpp"

#include <gtest/gtest.h>

#include "alone.hpp"
#include "closed_loop.hpp"
#include "li2018.hpp"
#include "telemetry_log.hpp"

namespace gyrostat::test::test_integral_sliding_mode {
namespace {

using Law = IntegralSlidingMode<double>;
constexpr double infinity = std::numeric_limits<double>::infinity();

li2018::Stack<double> stack_with(const gyrostat::Setup<double>& s, const Law::Params& p) {
  li2018::Stack<double>::Params all(s);
  all.observer = li2018::observer<double>();
  all.controller = p;
  all.allocator = li2018::allocator<double>();
  return li2018::Stack<double>(unchecked, s, all);
}

/// Largest entry of a telemetry vector.
double largest(const Law& law, const char* name) {
  const std::vector<double> values = telemetry_of(law).at(name);
  double out = 0;
  for (const double v : values) out = std::max(out, std::abs(v));
  return out;
}

Body tilted(const gyrostat::Setup<double>& setup) {
  Body body(setup.vehicle);
  body.q_NB = quat_from_mrp<double>({-0.1579, 0.1368, 0.0947});
  return body;
}

TEST(IntegralSlidingMode, StartsOnItsSurfaceAndStaysThereOnTheNominalPlant) {
  // The trapezoid of the gyroscopic torque is all that is not exact. A wrong rule or order shows at once: a trapezoid of
  // the nominal torque, say, gives 1e-5.
  for (const auto& [dt, bound] : {std::pair{0.001, 1e-11}, {0.01, 1e-8}}) {
    const auto setup = li2018::setup(infinity, dt);
    auto stack = stack_with(setup, li2018::controller<double>());
    Body body = tilted(setup);
    double worst = 0;
    fly(stack, body, dt, static_cast<int>(60 / dt), nullptr, [&](int k) {
      if (k == 0) {
        EXPECT_EQ(largest(stack.controller, "s"), 0);
      }
      worst = std::max(worst, largest(stack.controller, "s"));
    });
    EXPECT_LT(worst, bound) << dt;
    EXPECT_GT(worst, 0);
  }
}

TEST(IntegralSlidingMode, StaysOnItsSurfaceWhileTheReferenceMoves) {
  const auto setup = li2018::setup(infinity, 0.01);
  auto stack = stack_with(setup, li2018::controller<double>());
  Body body = tilted(setup);
  Reference<double> ref;
  double worst = 0;
  fly(
      stack, body, setup.dt, 12000,
      [&](int k) {
        const double t = k * setup.dt;
        ref.q_NR = quat_exp<double>({0, 0, 0.5 * (1 - std::cos(0.1 * t))});
        ref.omega_RN_R = {0, 0, 0.05 * std::sin(0.1 * t)};
        ref.omegadot_RN_R = {0, 0, 0.005 * std::cos(0.1 * t)};
      },
      [&](int) { worst = std::max(worst, largest(stack.controller, "s")); }, &ref);
  EXPECT_LT(worst, 1e-7);  // as at rest, with the larger gyroscopic torque of a turn at 0.05 rad/s
  EXPECT_LT(rotation_angle<double>(ref.q_NR.conjugate() * body.q_NB), 1e-3);
}

TEST(IntegralSlidingMode, GainStaysAboveItsFloorLessOneStep) {
  const auto setup = li2018::setup(0.25, 0.01);
  auto stack = stack_with(setup, li2018::controller<double>());
  Body body = tilted(setup);
  body.d_B = {1e-3, -2e-3, 1.5e-3};
  body.effectiveness[2] = 0.4;
  double least = infinity;
  fly(stack, body, setup.dt, 6000, nullptr, [&](int) {
    const std::vector<double> gain = telemetry_of(stack.controller).at("gain");
    for (const double g : gain) least = std::min(least, g);
  });
  EXPECT_GE(least, 0.1 - 0.2 * setup.dt - 1e-15);
  EXPECT_LT(least, 0.1);
}

TEST(IntegralSlidingMode, GainFollowsThePublishedBranches) {
  auto p = li2018::controller<double>();
  p.s_lim = infinity;
  const auto setup = li2018::setup(infinity, 0.001);
  // A kick of the rate about the first axis puts s = J dw there; the gain then moves by one Euler step.
  const auto gain_step = [&](double s, double gain) {
    p.gain_0.setConstant(gain);
    Alone<Law> law(unchecked, setup, p);
    Measurement<double> y;
    y.h_w = VecN<double>::Zero(4);
    (void)law.start(Estimate<double>::healthy(y), {}, {});
    const double before = gain + setup.dt * (gain > p.mu ? -p.zeta1 : 0);  // at s = 0: zeta1 0^0 sgn(-eps), or zeta2 0
    y.omega_BN_B = setup.vehicle.J_B.inverse() * Vec3<double>(s, 0, 0);
    const Allocation<double> last = Allocation<double>::idle(4);
    (void)law.step(Estimate<double>::healthy(y), {}, {}, last);
    EXPECT_NEAR(telemetry_of(law).at("s")[0], s, 1e-9);  // gyroscopic share: h w x J w / 2
    EXPECT_NEAR(telemetry_of(law).at("gain")[0], before, 1e-15);
    (void)law.step(Estimate<double>::healthy(y), {}, {}, last);
    return telemetry_of(law).at("gain")[0] - before;
  };
  const double h = setup.dt, eps = p.eps;
  EXPECT_NEAR(gain_step(0.4 * eps, 0.15), -h * p.zeta1, 1e-9);                           // kappa = 0: 0^0 branch
  EXPECT_NEAR(gain_step(3 * eps, 0.15), h * p.zeta1 * 3 * eps, 1e-9);                    // kappa = 1
  EXPECT_NEAR(gain_step(0.75 * eps, 0.15), -h * p.zeta1 * std::sqrt(0.75 * eps), 1e-7);  // kappa = 1/2; slope 1/sqrt(s)
  EXPECT_NEAR(gain_step(0.75 * eps, 0.05), h * p.zeta2 * 0.75 * eps, 1e-9);              // below mu
}

TEST(IntegralSlidingMode, ClampHoldsTheMomentumErrorWhileTheLimiterIsBusy) {
  const auto setup = li2018::setup(0.25, 0.01);
  const auto worst_of = [&](double s_lim) {
    auto p = li2018::controller<double>();
    p.s_lim = s_lim;
    auto stack = stack_with(setup, p);
    Body body(setup.vehicle);
    body.q_NB = quat_from_mrp<double>({0.4, -0.5, 0.45});
    double worst = 0;
    fly(stack, body, setup.dt, 2000, nullptr, [&](int) { worst = std::max(worst, largest(stack.controller, "s")); });
    return worst;
  };
  EXPECT_LE(worst_of(0.05), 0.05);
  EXPECT_GT(worst_of(infinity), 0.5) << "the printed integral winds up";
}

TEST(IntegralSlidingMode, IdentitySurfaceGivesARate) {
  auto p = li2018::controller<double>();
  const auto setup = li2018::setup(infinity, 0.001);
  Alone<Law> momentum(unchecked, setup, p);
  p.surface = Law::Surface::identity;
  Alone<Law> rate(unchecked, setup, p);
  Measurement<double> y;
  y.h_w = VecN<double>::Zero(4);
  for (Alone<Law>* law : {&momentum, &rate}) (void)law->start(Estimate<double>::healthy(y), {}, {});
  y.omega_BN_B = {1e-3, 1e-3, -2e-3};
  for (Alone<Law>* law : {&momentum, &rate})
    (void)law->step(Estimate<double>::healthy(y), {}, {}, Allocation<double>::idle(4));
  const auto a = telemetry_of(momentum).at("s"), b = telemetry_of(rate).at("s");
  const Vec3<double> scaled = setup.vehicle.J_B * Vec3<double>(b[0], b[1], b[2]);
  for (int i = 0; i < 3; ++i) EXPECT_NEAR(scaled[i], a[static_cast<std::size_t>(i)], 1e-16);
}

TEST(IntegralSlidingMode, PrintedSignSwitchesTheWholeGainWhichStillFallsInsideEps) {
  auto p = li2018::controller<double>();
  p.switching = Law::Switching::sign;
  p.K3.setZero();
  p.K4.setZero();
  const auto setup = li2018::setup(infinity, 0.001);
  Alone<Law> law(unchecked, setup, p);
  Measurement<double> y;
  y.h_w = VecN<double>::Zero(4);
  const Demand<double> at_zero = law.start(Estimate<double>::healthy(y), {}, {});
  EXPECT_EQ(at_zero.tau_B.norm(), 0);  // sgn(0) = 0
  y.omega_BN_B = {1e-12, -1e-12, 0};
  const Demand<double> demand = law.step(Estimate<double>::healthy(y), {}, {}, Allocation<double>::idle(4));
  const double gain = 0.15 - setup.dt * p.zeta1;  // one step at s = 0: kappa = 0, sgn(|s| - eps) = -1
  EXPECT_NEAR(demand.tau_B[0], -gain, 1e-9);
  EXPECT_NEAR(demand.tau_B[1], gain, 1e-9);
}

TEST(IntegralSlidingMode, AJumpOfTheStateLeavesTheSurfaceWhereItWas) {
  const auto setup = li2018::setup(0.25, 0.01);
  Alone<Law> law(unchecked, setup, li2018::controller<double>());
  Estimate<double> x = Estimate<double>::healthy(tilted(setup).measured<double>(0));
  const Allocation<double> last = Allocation<double>::idle(static_cast<int>(x.h_w.size()));
  (void)law.start(x, {}, {});
  for (int k = 0; k < 10; ++k) (void)law.step(x, {}, {}, last);
  const std::vector<double> s = telemetry_of(law).at("s");
  EXPECT_GT(largest(law, "s"), 1e-6) << "nothing turned it, as the law had asked for";
  x.omega_BN_B += Vec3<double>(1, -2, 3);
  ++x.event;
  (void)law.step(x, {}, {}, last);
  EXPECT_EQ(telemetry_of(law).at("s"), s);
  (void)law.step(x, {}, {}, last);
  EXPECT_NE(telemetry_of(law).at("s"), s) << "it goes on";
}

TEST(IntegralSlidingMode, RestartForgetsTheIntegral) {
  const auto setup = li2018::setup(0.25, 0.01);
  auto stack = stack_with(setup, li2018::controller<double>());
  Body body = tilted(setup);
  const auto kick = [&](int k) {
    if (k == 199) body.omega_BN_B[0] += 1e-3;
  };
  fly(stack, body, setup.dt, 200, kick, nullptr);
  ASSERT_GT(largest(stack.controller, "s"), 1e-6);
  stack.reset();
  auto fresh = stack_with(setup, li2018::controller<double>());
  const Measurement<double> y = body.measured<double>(0);
  EXPECT_EQ(stack.step(y, {}).u, fresh.step(y, {}).u);
  EXPECT_EQ(largest(stack.controller, "s"), 0);
}

TEST(IntegralSlidingModeCheck, RefusesALayerTooSteepForTheSample) {
  const auto setup = li2018::setup(0.25, 0.01);
  auto p = li2018::controller<double>();
  EXPECT_TRUE(Law::check(setup, p).ok());
  p.eps = 1e-4;  // (7.2 + 0.1 / 1e-4) * 0.01 = 10
  EXPECT_EQ(Law::check(setup, p).code, Status<double>::Code::unstable);
  EXPECT_NEAR(Law::check(setup, p).value, 10.072, 1e-9);
  p.switching = Law::Switching::sign;  // as printed: no slope to check
  EXPECT_TRUE(Law::check(setup, p).ok());
}

}  // namespace
}  // namespace gyrostat::test::test_integral_sliding_mode
