// SPDX-License-Identifier: MIT
#include "gyrostat/core/types.hpp"

#include <gtest/gtest.h>

#include "gyrostat/core/signals.hpp"

namespace gyrostat::test::test_types {
namespace {

TEST(Mask, HoldsEveryActuator) {
  for (int n = 0; n <= max_actuators; ++n) {
    const Mask all = Mask::all(n);
    for (int i = 0; i < max_actuators; ++i) EXPECT_EQ(all.test(i), i < n) << n << " " << i;
  }
}

TEST(Mask, SetsAndClearsOneWithoutTheOthers) {
  Mask m = Mask::all(4);
  m.set(2, false);
  EXPECT_EQ(m.bits(), 0b1011);
  m.set(15);
  EXPECT_TRUE(m.test(15));
  EXPECT_EQ(m.without(Mask::all(4)).bits(), 1u << 15);
  EXPECT_FALSE((m & Mask{}).any());
}

TEST(Flags, SeveralHoldAtOnce) {
  Flags f = Flag::rank_lost;
  f.set(Flag::breach);
  EXPECT_TRUE(f.has(Flag::rank_lost) && f.has(Flag::breach));
  EXPECT_FALSE(f.has(Flag::singular));
  EXPECT_EQ((f | Flags(Flag::singular)).bits(), 64 | 256 | 128);
}

TEST(Torque, AgreesWithTheMatrixProducts) {
  Mat3N<double> D(3, 4);
  D << 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12;
  VecN<double> u(4);
  u << 1, -1, 2, 0.5;
  const Vec3<double> by_eigen = D * u;
  EXPECT_EQ(torque<double>(D, u), by_eigen);  // small whole numbers: exact
  const VecN<double> projected = D.transpose() * by_eigen;
  EXPECT_EQ(project<double>(D, by_eigen), projected);
}

TEST(Estimate, HealthyMeansFullEffectivenessThatNobodyHasChecked) {
  Measurement<double> y;
  y.tick = 12;
  y.omega_BN_B = {1, 2, 3};
  y.h_w = VecN<double>::Constant(3, 0.5);
  const Estimate<double> x = Estimate<double>::healthy(y);
  EXPECT_EQ(x.tick, 12u);
  EXPECT_EQ(x.omega_BN_B, y.omega_BN_B);
  EXPECT_EQ(x.effectiveness, VecN<double>::Ones(3));
  EXPECT_TRUE((x.effectiveness_bound.array() == std::numeric_limits<double>::infinity()).all());
}

TEST(Detection, SparesAreOffUntilSomebodyEnablesThem) {
  Vehicle<double> vehicle;
  vehicle.D_B.resize(3, 4);
  vehicle.spare.set(3);
  EXPECT_EQ(Detection<double>::none(vehicle).enabled, Mask::all(3));
}

}  // namespace
}  // namespace gyrostat::test::test_types
