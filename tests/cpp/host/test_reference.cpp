// SPDX-License-Identifier: MIT
#include "gyrostat/host/reference.hpp"

#include <gtest/gtest.h>

#include <numbers>
#include <stdexcept>

namespace gyrostat::host {
namespace {

using V3 = Vec3<double>;

const ReferenceSpec moving[] = {
    Slew{.from = V3(0.1, -0.2, 0.3), .to = V3(-0.4, 0.5, 1.2), .start = 0.5, .duration = 4},
    MrpSine{.offset = V3(0.1, 0, -0.05),
            .amplitude = V3(0.1, 0.1, 0.1),
            .frequency = V3(0.8, 0.6, 0.7),
            .phase = V3(0, 1, 2)},
    EulerSine{.offset = V3(2, 0, 0),
              .amplitude = V3(0, 0.3, 0.5),
              .frequency = V3(0, 1, 2),
              .phase = V3(0, 0.4, std::numbers::pi / 2)},
    RateSine{.euler = V3(0.1, -0.1, 0.1),
             .amplitude = V3(0.02, 0.02, 0.02),
             .frequency = V3(0.08, 0.08, 0.08),
             .phase = V3(0, std::numbers::pi / 2, 1)},
};

class MovingReference : public testing::TestWithParam<ReferenceSpec> {};
INSTANTIATE_TEST_SUITE_P(Kinds, MovingReference, testing::ValuesIn(moving));

// Central differences with dt = 1 ms leave dt^2/6 of the third derivative: below 2e-6 for these motions.
TEST_P(MovingReference, RateIsTheDerivativeOfTheAttitude) {
  const double dt = 1e-3;
  ReferencePath path(GetParam(), dt);
  for (Tick k = 1; k < 4000; k += 400) {
    const Quat<double> before = path.at(k - 1).q_NR;
    const Reference<double> now = path.at(k);
    const Quat<double> after = path.at(k + 1).q_NR;
    const V3 rate = quat_log<double>(before.conjugate() * after) / (2 * dt);
    EXPECT_LT((rate - now.omega_RN_R).norm(), 2e-6) << "tick " << k;
  }
}

TEST_P(MovingReference, AccelerationIsTheDerivativeOfTheRate) {
  const double dt = 1e-3;
  ReferencePath path(GetParam(), dt);
  for (Tick k = 1; k < 4000; k += 400) {
    const V3 before = path.at(k - 1).omega_RN_R;
    const V3 now = path.at(k).omegadot_RN_R;
    const V3 after = path.at(k + 1).omega_RN_R;
    EXPECT_LT(((after - before) / (2 * dt) - now).norm(), 5e-6) << "tick " << k;
  }
}

TEST_P(MovingReference, EulerSideFitsTheQuaternionSide) {
  const double dt = 1e-3;
  ReferencePath path(GetParam(), dt);
  for (Tick k = 0; k < 4000; k += 400) {
    const Reference<double> r = path.at(k);
    EXPECT_LT(rotation_angle<double>(quat_from_euler(r.euler.angles).conjugate() * r.q_NR), 1e-12);
    EXPECT_LT((euler_rate_matrix(r.euler.angles) * r.euler.rates - r.omega_RN_R).norm(), 1e-12);
  }
}

// The Magnus step has local error O(dt^5): halving dt must gain 2^4 over a fixed time.
TEST(RateSine, IsIntegratedToFourthOrder) {
  const RateSine spec{.amplitude = V3(0.9, 0.7, 0.8), .frequency = V3(1.3, 1.7, 0.9), .phase = V3(0, 1, 2)};
  const auto end = [&](int steps) {
    ReferencePath path(spec, 10.0 / steps);
    Quat<double> q;
    for (int k = 0; k <= steps; ++k) q = path.at(static_cast<Tick>(k)).q_NR;
    return q;
  };
  const Quat<double> exact = end(20000);
  const double coarse = rotation_angle<double>(exact.conjugate() * end(50));
  const double fine = rotation_angle<double>(exact.conjugate() * end(100));
  EXPECT_NEAR(std::log2(coarse / fine), 4.0, 0.3);
}

TEST(Slew, EndsAtRestOnItsTarget) {
  ReferencePath path(Slew{.to = V3(0.3, -0.2, 2.0), .start = 1, .duration = 5}, 0.5);
  EXPECT_EQ(path.at(2).omega_RN_R.norm(), 0.0);
  const Reference<double> end = path.at(12);
  EXPECT_LT((end.euler.angles - V3(0.3, -0.2, 2.0)).norm(), 1e-14);
  EXPECT_LT(end.omega_RN_R.norm(), 1e-15);
}

TEST(Steps, JumpAtTheirSampleAndCountEvents) {
  ReferencePath path(Steps{.times = {0, 80}, .euler = {{0.3, 0, 0}, {0, 0.4, 0}}, .mrp = {}}, 0.01);
  EXPECT_EQ(path.at(0).event, 0u);
  EXPECT_EQ(path.at(7999).euler.angles[1], 0.0);
  EXPECT_EQ(path.at(8000).event, 1u);
  EXPECT_NEAR(path.at(8000).euler.angles[1], 0.4, 1e-15);
}

TEST(Hold, TakesOneWayToSayTheAttitude) {
  ReferencePath path(Hold{.mrp = V3(0.1, 0.2, -0.3)}, 0.1);
  EXPECT_LT((mrp(path.at(3).q_NR) - V3(0.1, 0.2, -0.3)).norm(), 1e-15);
  EXPECT_THROW(ReferencePath(Hold{.mrp = V3(0.1, 0, 0), .euler = V3(0.1, 0, 0)}, 0.1), std::invalid_argument);
}

TEST(Steps, RefuseWhatDoesNotFit) {
  EXPECT_THROW(ReferencePath(Steps{.times = {0, 1}, .euler = {{0, 0, 0}}, .mrp = {}}, 0.1), std::invalid_argument);
  EXPECT_THROW(ReferencePath(Steps{.times = {1, 0}, .euler = {{0, 0, 0}, {0, 0, 1}}, .mrp = {}}, 0.1),
               std::invalid_argument);
  EXPECT_THROW(ReferencePath(Steps{.times = {0}, .euler = {{0, 0}}, .mrp = {}}, 0.1), std::invalid_argument);
}

}  // namespace
}  // namespace gyrostat::host
