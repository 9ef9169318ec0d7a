// SPDX-License-Identifier: MIT
// Default parameters fly any vehicle: what they are made of, and closed loops on vehicles of very different size.
#include <gtest/gtest.h>

#include "closed_loop.hpp"
#include "contract/stacks.hpp"
#include "gyrostat/flight/allocators/pseudo_inverse.hpp"
#include "gyrostat/flight/controllers/fast_terminal_sliding_mode.hpp"
#include "gyrostat/flight/controllers/finite_time.hpp"
#include "gyrostat/flight/controllers/integral_sliding_mode.hpp"
#include "gyrostat/flight/controllers/mrp_feedback.hpp"
#include "gyrostat/flight/controllers/prescribed_performance.hpp"
#include "gyrostat/flight/controllers/saturated_pd.hpp"
#include "gyrostat/flight/detectors/none.hpp"
#include "gyrostat/flight/observers/adaptive_iterative_learning.hpp"
#include "gyrostat/flight/observers/finite_time_disturbance.hpp"
#include "gyrostat/flight/observers/iterative_learning.hpp"
#include "gyrostat/flight/observers/passthrough.hpp"
#include "gyrostat/flight/parts/effectiveness_floor.hpp"
#include "gyrostat/flight/stack.hpp"
#include "vehicles.hpp"

namespace gyrostat::test::test_defaults {
namespace {

TEST(TorqueAuthority, IsTheRadiusOfTheTorqueSet) {
  // The pyramid's nearest faces have normals (1, 0, 1) / sqrt 2 and alike: 0.2 N m * 4 * sqrt(2/3) / 2.
  EXPECT_NEAR(torque_authority(ftc_4rw<double>().vehicle), 0.2 * 2 * std::sqrt(2.0 / 3), 1e-15);
  const Mat3<double> I = Mat3<double>::Identity();
  EXPECT_NEAR(torque_authority(vehicle_with<double>(I, I, 0.3, 0.1).vehicle), 0.3, 1e-15);
}

TEST(TorqueAuthority, CountsNoSpareNoMissingAxisAndNoUnknownLimit) {
  auto setup = ftc_4rw<double>();
  setup.vehicle.spare.set(0);
  EXPECT_LT(torque_authority(setup.vehicle), 0.2);  // one wheel less
  setup.vehicle.spare.set(1);
  EXPECT_EQ(torque_authority(setup.vehicle), 0);  // two wheels span a plane
  EXPECT_GT(usable_torque(setup.vehicle), 0);
  setup = ftc_4rw<double>();
  setup.vehicle.D_B.row(2) *= 0.005;  // nearly coplanar: what allocators drop is not counted on
  EXPECT_EQ(torque_authority(setup.vehicle), 0);
  EXPECT_GT(usable_torque(setup.vehicle), 0.1);
  setup = ftc_4rw<double>();
  setup.vehicle.u_up.setConstant(std::numeric_limits<double>::infinity());
  setup.vehicle.u_lo = -setup.vehicle.u_up;
  EXPECT_TRUE(std::isinf(torque_authority(setup.vehicle)));
  EXPECT_TRUE(std::isfinite(usable_torque(setup.vehicle)));
}

TEST(TorqueAuthority, OneSidedLimitsCountOnTheirSide) {
  auto setup = vehicle_with<double>(Mat3<double>::Identity(), Mat3<double>::Identity(), 0.3, 0.1);
  setup.vehicle.u_lo[1] = -0.1;
  EXPECT_NEAR(torque_authority(setup.vehicle), 0.1, 1e-15);
  setup.vehicle.u_lo[1] = 0;  // one thruster cannot push both ways
  EXPECT_EQ(torque_authority(setup.vehicle), 0);
}

TEST(DefaultStiffness, IsDampedAndSlowAgainstTheSample) {
  for (const double dt : {0.001, 0.1, 5.0}) {
    auto setup = ftc_4rw<double>();
    setup.dt = dt;
    const Stiffness<double> k = default_stiffness(setup);
    const double J = largest_inertia(setup.vehicle.J_B);
    EXPECT_NEAR(k.k_omega / J, 2 * 0.8 * std::sqrt(k.k_sigma / 4 / J), 1e-15);  // 2 zeta w of J phi'' = -k phi / 4
    EXPECT_LE(k.frequency * dt, 0.05);
  }
}

TEST(ObserverPeriods, AreFewerOnlyWhereTheLawIsNearlyAsFast) {
  auto setup = ftc_4rw<double>();
  EXPECT_EQ(observer_periods(setup, 10.0), 10);  // 100 Hz: the law's time is 7 s
  setup.dt = 0.1;
  const double small = smallest_inertia(setup.vehicle.J_B), large = largest_inertia(setup.vehicle.J_B);
  EXPECT_NEAR(observer_periods(setup, 10.0) * setup.dt * default_stiffness(setup).frequency, 0.05 * small / large,
              1e-15);
  setup.dt = 0.5;
  EXPECT_EQ(observer_periods(setup, 10.0), 2);
}

TEST(EffectivenessFloor, OfAnObserverMustNotBeBelowTheAllocators) {
  using O = IterativeLearningObserver<float>;
  using A = PseudoInverse<float>;
  const auto setup = ftc_4rw<float>();
  typename O::Params o(setup);
  typename A::Params a(setup);
  const auto ok = [&] {
    return actuators_can_recover(effectiveness_floor_of<O>(o), effectiveness_floor_of<A>(a)).ok();
  };
  EXPECT_TRUE(ok());
  o.e_min = 0.049f;
  EXPECT_FALSE(ok());
  a.use_effectiveness = false;
  EXPECT_TRUE(ok());
  EXPECT_TRUE(actuators_can_recover(
                  effectiveness_floor_of<PassthroughObserver<float>>(PassthroughObserver<float>::Params(setup)), 1.0f)
                  .ok());
}

struct Craft {
  const char* name;
  double J, u_max, dt, d;  // kg m^2, N m, s, N m of disturbance
};
const Craft crafts[] = {{"small_satellite", 0, 0.2, 0.01, 2.7e-3},  // J = 0: the reference vehicle itself
                        {"cubesat", 1, 1e-3, 0.1, 1e-5},
                        {"cubesat_1u", 0.002, 1e-3, 0.05, 1e-6},
                        {"large", 2000, 5, 0.1, 0.02},
                        {"slow_large", 2000, 5, 0.5, 0.02}};

gyrostat::Setup<double> setup_of(const Craft& c) {
  if (c.J == 0) return ftc_4rw<double>();
  return vehicle_with<double>(c.J / 20 * satellite_inertia<double>(), pyramid<double>(), c.u_max, c.dt);
}

template <class O, class C>
AnyStack<double> stack_of_defaults(const gyrostat::Setup<double>& s) {
  using Stack = FlightStack<O, NoDetector<double>, C, PseudoInverse<double>>;
  const Status<double> status = Stack::check(s, typename Stack::Params(s));
  EXPECT_TRUE(status.ok()) << status.quantity;
  return stack_of<O, NoDetector<double>, C, PseudoInverse<double>>(s);
}

/// Pointing error, deg, at the end of the library's reference scenario: tumbling slowly from (.1, .2, -.3), one wheel at 40 %
/// from a third of the time on, constant disturbance.
template <class O, class C>
double final_error_deg(const Craft& c) {
  const auto setup = setup_of(c);
  const double slow = default_stiffness(ftc_4rw<double>()).frequency / default_stiffness(setup).frequency;
  AnyStack<double> stack = stack_of_defaults<O, C>(setup);
  Body body(setup.vehicle);
  body.q_NB = quat_from_mrp<double>({0.1, 0.2, -0.3});
  body.omega_BN_B = Vec3<double>(0.01, -0.02, 0.03) / slow;
  body.d_B = c.d * Vec3<double>(1, -2, 1.5).normalized();
  const int samples = static_cast<int>(60 * slow / setup.dt);  // 60 s on the reference vehicle
  fly(
      stack, body, setup.dt, samples,
      [&](int k) {
        if (k == samples / 3) body.effectiveness[2] = 0.4;
      },
      nullptr);
  EXPECT_TRUE(stack.last().u.allFinite());
  return degrees(rotation_angle(body.q_NB));
}

TEST(Defaults, TurnHalfAroundFromRest) {
  using O = FiniteTimeDisturbanceObserver<double>;
  const auto setup = ftc_4rw<double>();
  const auto error_deg = [&](AnyStack<double> stack) {
    Body body(setup.vehicle);
    body.q_NB = quat_exp<double>(3.0 * Vec3<double>(2, -1, 2) / 3);
    fly(stack, body, setup.dt, 20000, nullptr, nullptr);
    return degrees(rotation_angle(body.q_NB));
  };
  EXPECT_LT(error_deg(stack_of_defaults<O, IntegralSlidingMode<double>>(setup)), 0.01);
  EXPECT_LT(error_deg(stack_of_defaults<O, FiniteTime<double>>(setup)), 0.01);
  EXPECT_LT(error_deg(stack_of_defaults<O, MrpFeedback<double>>(setup)), 0.01);
  EXPECT_LT(error_deg(stack_of_defaults<O, SaturatedPd<double>>(setup)), 0.01);
  EXPECT_LT(error_deg(stack_of_defaults<O, PrescribedPerformance<double>>(setup)), 0.01);
  EXPECT_LT(error_deg(stack_of_defaults<O, FastTerminalSlidingMode<double>>(setup)), 0.01);
}

class VehicleDefaults : public testing::TestWithParam<Craft> {};

TEST_P(VehicleDefaults, ObserverAndSlidingModePointThroughAFault) {
  using O = FiniteTimeDisturbanceObserver<double>;
  EXPECT_LT((final_error_deg<O, IntegralSlidingMode<double>>(GetParam())), 0.05);
  EXPECT_LT((final_error_deg<O, FiniteTime<double>>(GetParam())), 0.05);
}

TEST_P(VehicleDefaults, SlidingModeAlonePointsThroughAFault) {
  EXPECT_LT((final_error_deg<PassthroughObserver<double>, IntegralSlidingMode<double>>(GetParam())), 1);
}

TEST_P(VehicleDefaults, ProportionalLawsPointThroughAFaultWithTheirOffset) {
  using O = PassthroughObserver<double>;
  EXPECT_LT((final_error_deg<O, MrpFeedback<double>>(GetParam())), 1);
  EXPECT_LT((final_error_deg<O, SaturatedPd<double>>(GetParam())), 1);
  EXPECT_LT((final_error_deg<O, FiniteTime<double>>(GetParam())), 1);
}

TEST_P(VehicleDefaults, LearningObserversPointThroughAFault) {
  EXPECT_LT((final_error_deg<AdaptiveIterativeLearningObserver<double>, PrescribedPerformance<double>>(GetParam())), 1);
  EXPECT_LT((final_error_deg<IterativeLearningObserver<double>, FastTerminalSlidingMode<double>>(GetParam())), 1);
}

INSTANTIATE_TEST_SUITE_P(Craft, VehicleDefaults, testing::ValuesIn(crafts),
                         [](const auto& craft) { return std::string(craft.param.name); });

}  // namespace
}  // namespace gyrostat::test::test_defaults
