// SPDX-License-Identifier: MIT
#include "gyrostat/flight/allocators/singularity_robust.hpp"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>

#include "../random.hpp"
#include "alone.hpp"
#include "gyrostat/flight/allocators/pseudo_inverse.hpp"
#include "gyrostat/flight/control_moment_gyros.hpp"
#include "vehicles.hpp"

namespace gyrostat::test::test_singularity_robust {
namespace {

static_assert(Geometry<ControlMomentGyros<double>, double> && Geometry<ControlMomentGyros<float>, float>);

/// The pyramid of 54.74 deg.
template <class S>
ControlMomentGyros<S> gyros() {
  const S across = std::sqrt(S(2) / S(3)), up = std::sqrt(S(1) / S(3));
  ControlMomentGyros<S> out;
  out.add(0, {across, 0, up}, {0, 1, 0}, S(20));
  out.add(1, {0, across, up}, {-1, 0, 0}, S(20));
  out.add(2, {-across, 0, up}, {0, -1, 0}, S(20));
  out.add(3, {0, -across, up}, {1, 0, 0}, S(20));
  return out;
}

template <class S>
gyrostat::Setup<S> agile() {
  gyrostat::Setup<S> setup = vehicle_with<S>(satellite_inertia<S>(), pyramid<S>(), S(20), S(0.05));
  setup.vehicle.D_B = gyros<S>().at(setup.vehicle, VecN<S>::Zero(4), VecN<S>::Zero(4)).D_B;
  setup.vehicle.moving_axes = true;
  return setup;
}

template <class S>
Estimate<S> at_angles(const gyrostat::Setup<S>& setup, const VecN<S>& gimbal) {
  Measurement<S> y;
  y.h_w = VecN<S>::Zero(4);
  y.gimbal = gimbal;
  ControlMomentGyros<S> geometry = gyros<S>();
  y.axes = geometry(setup.vehicle, y);
  return Estimate<S>::healthy(y);
}

template <class S>
VecN<S> angles(S a, S b, S c, S d) {
  VecN<S> out(4);
  out << a, b, c, d;
  return out;
}

template <class S>
typename SingularityRobust<S>::Params with(const gyrostat::Setup<S>& setup,
                                           typename SingularityRobust<S>::Method method) {
  typename SingularityRobust<S>::Params p(setup);
  p.method = method;
  return p;
}

TEST(SingularityRobust, IsThePseudoInverseWhereNothingIsSingular) {
  const auto setup = agile<double>();
  const auto det = Detection<double>::none(setup.vehicle);
  Random random(7);
  for (int k = 0; k < 100; ++k) {
    const auto x = at_angles<double>(setup, angles(random.uniform(-0.3, 0.3), random.uniform(-0.3, 0.3),
                                                   random.uniform(-0.3, 0.3), random.uniform(-0.3, 0.3)));
    Demand<double> demand;
    demand.tau_B = {random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1)};
    demand.u_pref = angles(random.uniform(-1, 1), 0.0, random.uniform(-1, 1), 0.1);
    auto robust = alone<SingularityRobust<double>>(setup);
    auto plain = alone<PseudoInverse<double>>(setup);
    const auto a = robust.step(demand, x, det), b = plain.step(demand, x, det);
    EXPECT_LT((a.u - b.u).norm(), 1e-4);
    EXPECT_EQ(a.status.bits(), 0);
    EXPECT_LT((a.achieved_B - demand.tau_B).norm(), 1e-4);
  }
}

template <class S>
class SingularityRobustOf : public testing::Test {};
using Scalars = testing::Types<float, double>;
TYPED_TEST_SUITE(SingularityRobustOf, Scalars);

/// Gimbals at -90, 0, 90, 0 deg: all axes across body x.
TYPED_TEST(SingularityRobustOf, AtASingularityItStaysFiniteAndOnlySwingingWeightsMoveGimbals) {
  using S = TypeParam;
  using Robust = SingularityRobust<S>;
  const auto setup = agile<S>();
  const auto det = Detection<S>::none(setup.vehicle);
  const S quarter = S(1.5707963267948966);
  auto x = at_angles<S>(setup, angles<S>(-quarter, 0, quarter, 0));
  Demand<S> demand;
  demand.tau_B = {-2, 0, 0};
  Alone<Robust> sr(unchecked, setup, with<S>(setup, Robust::Method::sr)),
      gsr(unchecked, setup, with<S>(setup, Robust::Method::gsr));
  const Allocation<S> stays = sr.step(demand, x, det);
  EXPECT_LT(stays.u.norm(), S(1e-3));
  EXPECT_TRUE(stays.status.has(Flag::singular) && stays.status.has(Flag::demand_not_met));
  S most = 0;
  for (Tick k = 0; k < 80; ++k) {
    x.tick = k;
    const Allocation<S> out = gsr.step(demand, x, det);
    ASSERT_TRUE(out.u.allFinite());
    most = std::max(most, out.u.norm());
  }
  EXPECT_GT(most, S(0.1));
}

/// The weights are positive definite at every phase, also after a year of samples, where float and double agree.
TEST(SingularityRobust, APhaseOfLongAgoIsTheSameInFloat) {
  const auto setup = agile<double>();
  const auto setup_f = agile<float>();
  Alone<SingularityRobust<double>> a(unchecked, setup, SingularityRobust<double>::Params(setup));
  Alone<SingularityRobust<float>> b(unchecked, setup_f, SingularityRobust<float>::Params(setup_f));
  auto x = at_angles<double>(setup, angles(-1.4, 0.1, 1.4, -0.1));
  auto x_f = at_angles<float>(setup_f, angles(-1.4f, 0.1f, 1.4f, -0.1f));
  Demand<double> demand;
  Demand<float> demand_f;
  demand.tau_B = {-0.1, 0.05, 0.02};
  demand_f.tau_B = demand.tau_B.cast<float>();
  for (Tick k = 20'000'000; k < 20'000'080; ++k) {
    x.tick = x_f.tick = k;
    const auto u = a.step(demand, x, Detection<double>::none(setup.vehicle)).u;
    const auto u_f = b.step(demand_f, x_f, Detection<float>::none(setup_f.vehicle)).u;
    ASSERT_LT((u - u_f.cast<double>()).norm(), 0.05 * u.norm()) << k;  // of a period of 0.05f: 0.02 rad in 11 days
  }
}

TEST(SingularityRobust, LockedGimbalsThatAreKnownTakeNoCommand) {
  const auto setup = agile<double>();
  auto det = Detection<double>::none(setup.vehicle);
  det.failed.set(2);
  auto x = at_angles<double>(setup, angles(0.2, -0.1, 0.3, 0.1));
  x.effectiveness[0] = 0.5;
  x.effectiveness[1] = 0.01;  // below e_min
  Demand<double> demand;
  demand.tau_B = {1, 0.5, -0.3};
  demand.u_pref = angles(0.0, 1.0, 1.0, 0.0);
  auto robust = alone<SingularityRobust<double>>(setup);
  const auto out = robust.step(demand, x, det);
  EXPECT_EQ(out.u[1], 0);
  EXPECT_EQ(out.u[2], 0);
  EXPECT_TRUE(out.status.has(Flag::singular));  // two axes are left
  det.failed = {};
  x.effectiveness[1] = 1;
  const auto three = robust.step(demand, x, det);
  EXPECT_LT((three.achieved_B - demand.tau_B).norm(), 1e-3);
}

/// D u is what the rotors lose while gimbals turn at u / h.
TEST(ControlMomentGyros, ATorqueIsWhatTheStoredMomentumLoses) {
  const auto setup = agile<double>();
  const ControlMomentGyros<double> geometry = gyros<double>();
  const VecN<double> h_w = angles(0.1, -0.2, 0.3, 0.4), u = angles(3.0, -2.0, 1.0, 0.5);
  const VecN<double> at = angles(0.3, -0.5, 1.1, 2.0), step = 1e-4 * u / 20;
  const Vec3<double> gone =
      geometry.at(setup.vehicle, at - step, h_w).h_B - geometry.at(setup.vehicle, at + step, h_w).h_B;
  EXPECT_LT((torque<double>(geometry.at(setup.vehicle, at, h_w).D_B, u) - gone / 2e-4).norm(), 1e-8);
  const Vec3<double> wheels = geometry.at(setup.vehicle, at, h_w).h_B - geometry.at(setup.vehicle, at, 0 * h_w).h_B;
  EXPECT_LT((wheels - torque<double>(setup.vehicle.D_B, h_w)).norm(), 1e-14);
}

TEST(ControlMomentGyros, AnglesThatCannotBeLeaveTheAxesWhereTheyWere) {
  const auto setup = agile<double>();
  ControlMomentGyros<double> geometry = gyros<double>();
  Measurement<double> y;
  y.h_w = VecN<double>::Zero(4);
  EXPECT_FALSE(geometry(setup.vehicle, y).move());
  y.gimbal = angles(0.1, 0.2, 0.3, 0.4);
  const Axes<double> first = geometry(setup.vehicle, y);
  EXPECT_EQ(geometry(setup.vehicle, y).revision, first.revision);
  y.gimbal[1] = std::numeric_limits<double>::quiet_NaN();
  const Axes<double> held = geometry(setup.vehicle, y);
  EXPECT_EQ(held.D_B, first.D_B);
  EXPECT_EQ(held.h_B, first.h_B);
  y.gimbal[1] = 0.21;
  EXPECT_NE(geometry(setup.vehicle, y).revision, first.revision);
}

}  // namespace
}  // namespace gyrostat::test::test_singularity_robust
