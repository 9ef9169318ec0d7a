// SPDX-License-Identifier: MIT
#include "gyrostat/flight/allocators/pseudo_inverse.hpp"

#include <gtest/gtest.h>

#include "../algebra.hpp"
#include "../random.hpp"
#include "alone.hpp"
#include "vehicles.hpp"

namespace gyrostat::test::test_pseudo_inverse {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

template <class S>
struct Inputs {
  Demand<S> demand;
  Estimate<S> x;
  Detection<S> det;

  explicit Inputs(const gyrostat::Setup<S>& setup) {
    Measurement<S> y;
    y.h_w = VecN<S>::Zero(setup.vehicle.actuators());
    x = Estimate<S>::healthy(y);
    det = Detection<S>::none(setup.vehicle);
  }
};

gyrostat::Setup<double> unlimited() {
  return vehicle_with<double>(satellite_inertia<double>(), pyramid<double>(), infinity, 0.01);
}

template <class S>
class PseudoInverseOf : public testing::Test {};
using Scalars = testing::Types<float, double>;
TYPED_TEST_SUITE(PseudoInverseOf, Scalars);

TYPED_TEST(PseudoInverseOf, HealthyVehicleGivesTheRightInverseToRounding) {
  using S = TypeParam;
  const S tolerance = S(16) * Eigen::NumTraits<S>::epsilon();
  auto setup = vehicle_with<S>(satellite_inertia<S>(), pyramid<S>(), std::numeric_limits<S>::infinity(), S(0.01));
  auto allocator = alone<PseudoInverse<S>>(setup);
  Inputs<S> in(setup);
  const Mat3N<S>& D = setup.vehicle.D_B;
  for (int axis = 0; axis < 3; ++axis) {
    in.demand.tau_B = Vec3<S>::Unit(axis);
    const Allocation<S> out = allocator.step(in.demand, in.x, in.det);
    const VecN<S> expected = D.transpose() * (S(0.75) * in.demand.tau_B);  // D D' = 4/3 I
    EXPECT_LT((out.u - expected).norm(), tolerance);
    EXPECT_LT((D * out.u - in.demand.tau_B).norm(), tolerance);
    EXPECT_EQ(out.status.bits(), 0);
    EXPECT_FALSE(out.saturated.any());
  }
}

TYPED_TEST(PseudoInverseOf, AgreesWithTheSingularValueDecomposition) {
  using S = TypeParam;
  Random random(21);
  for (int trial = 0; trial < 200; ++trial) {
    const int n = 3 + trial % (max_actuators - 2);
    Mat3N<S> D(3, n);
    for (int i = 0; i < n; ++i) D.col(i) = random.vector<S>(1);
    auto setup = vehicle_with<S>(satellite_inertia<S>(), D, std::numeric_limits<S>::infinity(), S(0.01));
    Inputs<S> in(setup);
    for (int i = 0; i < n; ++i) in.x.effectiveness[i] = static_cast<S>(random.uniform(0.1, 1));
    in.demand.tau_B = random.vector<S>(1);
    const Eigen::MatrixXd A = (D * in.x.effectiveness.asDiagonal()).template cast<double>();
    const VectorXd singular = singular_values(A);
    const double condition = singular[0] / singular[2];
    if (condition > 50) continue;
    const Eigen::VectorXd expected = least_squares(A, in.demand.tau_B.template cast<double>());
    const Allocation<S> out = alone<PseudoInverse<S>>(setup).step(in.demand, in.x, in.det);
    // A A' has the condition squared.
    const double tolerance = 16 * double{Eigen::NumTraits<S>::epsilon()} * condition * condition * expected.norm();
    EXPECT_LT((out.u.template cast<double>() - expected).norm(), tolerance) << trial;
    EXPECT_FALSE(out.status.has(Flag::rank_lost));
  }
}

TEST(PseudoInverse, FailedSpareAndWeakActuatorsGetNothingAndTheOthersTakeOver) {
  auto setup = unlimited();
  Inputs<double> in(setup);
  in.demand.tau_B = {0.01, -0.02, 0.03};
  for (const char* reason : {"failed", "not enabled", "weak"}) {
    Inputs<double> now = in;
    if (reason[0] == 'f') now.det.failed.set(1);
    if (reason[0] == 'n') now.det.enabled.set(1, false);
    if (reason[0] == 'w') now.x.effectiveness[1] = 0.04;
    auto allocator = alone<PseudoInverse<double>>(setup);
    const Allocation<double> out = allocator.step(now.demand, now.x, now.det);
    EXPECT_EQ(out.u[1], 0) << reason;
    EXPECT_LT((setup.vehicle.D_B * out.u - in.demand.tau_B).norm(), 1e-15) << reason;
  }
}

TEST(PseudoInverse, EffectivenessIsMadeUpForUnlessSwitchedOff) {
  auto setup = unlimited();
  Inputs<double> in(setup);
  in.demand.tau_B = {0.01, -0.02, 0.03};
  in.x.effectiveness << 0.4, 1, 0.7, 0.02;
  const Allocation<double> with = alone<PseudoInverse<double>>(setup).step(in.demand, in.x, in.det);
  EXPECT_LT((with.achieved_B - in.demand.tau_B).norm(), 1e-15);
  EXPECT_FALSE(with.status.has(Flag::demand_not_met));
  PseudoInverse<double>::Params p(setup);
  p.use_effectiveness = false;
  const Allocation<double> without = Alone<PseudoInverse<double>>(unchecked, setup, p).step(in.demand, in.x, in.det);
  const VecN<double> expected = setup.vehicle.D_B.transpose() * (0.75 * in.demand.tau_B);
  EXPECT_LT((without.u - expected).norm(), 1e-15);
  const Vec3<double> achieved = setup.vehicle.D_B * in.x.effectiveness.cwiseProduct(without.u);
  EXPECT_LT((without.achieved_B - achieved).norm(), 1e-16);
  EXPECT_TRUE(without.status.has(Flag::demand_not_met)) << "flight knows that less arrives";
}

TEST(PseudoInverse, FollowsChangesOfMaskAndEffectiveness) {
  auto setup = unlimited();
  auto allocator = alone<PseudoInverse<double>>(setup);
  Inputs<double> in(setup);
  in.demand.tau_B = {0.01, -0.02, 0.03};
  const VecN<double> healthy = allocator.step(in.demand, in.x, in.det).u;
  in.x.effectiveness[0] = 0.5;
  const VecN<double> weak = allocator.step(in.demand, in.x, in.det).u;
  in.det.failed.set(2);
  const VecN<double> failed = allocator.step(in.demand, in.x, in.det).u;
  for (const VecN<double>& u : {weak, failed}) EXPECT_GT((u - healthy).norm(), 1e-3);
  in.det.failed.set(2, false);
  in.x.effectiveness[0] = 1;
  EXPECT_EQ(allocator.step(in.demand, in.x, in.det).u, healthy);
}

TEST(PseudoInverse, PreferenceMovesOnlyInTheNullSpace) {
  auto setup = unlimited();
  Inputs<double> in(setup);
  in.demand.tau_B = {0.01, -0.02, 0.03};
  in.demand.u_pref = VecN<double>::Zero(4);
  in.demand.u_pref << 0.1, 0.02, -0.03, 0.05;
  const Allocation<double> out = alone<PseudoInverse<double>>(setup).step(in.demand, in.x, in.det);
  EXPECT_LT((out.achieved_B - in.demand.tau_B).norm(), 1e-15);
  const VecN<double> moved =
      out.u - in.demand.u_pref;  // least-norm correction: orthogonal to the null space (1,-1,1,-1)
  VecN<double> null_space(4);
  null_space << 1, -1, 1, -1;
  ASSERT_LT((setup.vehicle.D_B * null_space).norm(), 1e-15);
  EXPECT_NEAR(moved.dot(null_space), 0, 1e-15);
}

TEST(PseudoInverse, PreferenceThatMakesTheDemandIsIssuedUnchanged) {
  auto setup = unlimited();
  Inputs<double> in(setup);
  in.demand.u_pref = VecN<double>::Zero(4);
  in.demand.u_pref << 0.1, 0.02, -0.03, 0.05;
  in.demand.tau_B = torque<double>(setup.vehicle.D_B, in.demand.u_pref);
  EXPECT_EQ(alone<PseudoInverse<double>>(setup).step(in.demand, in.x, in.det).u, in.demand.u_pref);
}

TEST(PseudoInverse, ClipsAndSaysSo) {
  auto setup = ftc_4rw<double>();
  Inputs<double> in(setup);
  in.demand.tau_B = {0.3, 0.3, 0};
  const Allocation<double> out = alone<PseudoInverse<double>>(setup).step(in.demand, in.x, in.det);
  EXPECT_EQ(out.u[0], 0.2);
  EXPECT_EQ(out.u[2], -0.2);
  EXPECT_EQ(out.saturated.bits(), 0b0101);
  EXPECT_TRUE(out.status.has(Flag::demand_not_met));
  EXPECT_FALSE(out.status.has(Flag::rank_lost));
  EXPECT_EQ(out.demand_B, in.demand.tau_B);
}

TEST(PseudoInverse, KeepsTheRateFromSampleToSample) {
  auto setup = ftc_4rw<double>();
  setup.vehicle.u_rate.setConstant(1.0);  // 0.01 N m a sample
  auto allocator = alone<PseudoInverse<double>>(setup);
  Inputs<double> in(setup);
  in.demand.tau_B = {0, 0, 0.2};
  VecN<double> before = VecN<double>::Zero(4);
  for (int k = 0; k < 20; ++k) {
    const Allocation<double> out = allocator.step(in.demand, in.x, in.det);
    EXPECT_LE((out.u - before).cwiseAbs().maxCoeff(), 0.01 + 1e-16);
    EXPECT_EQ(out.saturated.any(), k < 8);  // 0.0866 N m a wheel
    before = out.u;
  }
  EXPECT_LT((torque<double>(setup.vehicle.D_B, before) - in.demand.tau_B).norm(), 1e-15);
  allocator.reset();
  EXPECT_LE(allocator.step(in.demand, in.x, in.det).u.cwiseAbs().maxCoeff(), 0.01 + 1e-16);
}

TEST(PseudoInverse, DropsAnAxisThatOnlyMisalignmentReaches) {
  Mat3N<double> D(3, 3);
  D << 1, 0, 0.7, 0, 1, 0.7, 0.001, -0.002, 0.001;  // three wheels in a plane, a tenth of a degree off
  auto setup = vehicle_with<double>(satellite_inertia<double>(), D, infinity, 0.01);
  Inputs<double> in(setup);
  in.demand.tau_B = {0.1, -0.05, 0.1};
  const Allocation<double> out = alone<PseudoInverse<double>>(setup).step(in.demand, in.x, in.det);
  EXPECT_TRUE(out.status.has(Flag::rank_lost));
  EXPECT_TRUE(out.status.has(Flag::demand_not_met));
  EXPECT_LT(out.u.norm(), 0.2) << "no gain of a thousand for the sake of the third axis";
  EXPECT_LT((out.achieved_B - in.demand.tau_B).head<2>().norm(), 1e-3);
}

TEST(PseudoInverse, SurvivesTheLossOfEverything) {
  auto setup = ftc_4rw<double>();
  auto allocator = alone<PseudoInverse<double>>(setup);
  Inputs<double> in(setup);
  in.demand.tau_B = {0.1, 0, 0};
  for (int lost = 0; lost < 4; ++lost) {
    in.det.failed.set(lost);
    const Allocation<double> out = allocator.step(in.demand, in.x, in.det);
    EXPECT_TRUE(out.u.allFinite());
    EXPECT_EQ(out.status.has(Flag::rank_lost), lost > 0) << lost;  // three axes of a pyramid still span space
  }
}

TEST(PseudoInverse, RankTestFindsTheSingularValue) {
  // The third axis has the singular value s; the largest one is 1.
  for (const double s : {0.002, 0.0099, 0.0101, 0.05, 1.0}) {
    const Mat3N<double> D = Vec3<double>(1, 1, s).asDiagonal().toDenseMatrix();
    auto setup = vehicle_with<double>(satellite_inertia<double>(), D, infinity, 0.01);
    Inputs<double> in(setup);
    in.demand.tau_B = {0, 0, s};
    const Allocation<double> out = alone<PseudoInverse<double>>(setup).step(in.demand, in.x, in.det);
    EXPECT_EQ(out.status.has(Flag::rank_lost), s < 0.01) << s;
    EXPECT_NEAR(out.u[2], s < 0.01 ? 0 : 1, 1e-12) << s;
  }
}

TEST(PseudoInverseCheck, RefusesAVehicleWithoutActuators) {
  auto setup = unlimited();
  setup.vehicle.D_B.resize(3, 0);
  EXPECT_FALSE(PseudoInverse<double>::check(setup, PseudoInverse<double>::Params(setup)).ok());
}

TEST(PseudoInverse, WhatIsUnknownCountsAsHealthyWhereThatIsAskedFor) {
  auto setup = unlimited();
  Inputs<double> in(setup);
  in.demand.tau_B = {0.01, -0.02, 0.03};
  in.x.effectiveness << 0.5, 0.6, 0.7, 0.8;
  in.x.effectiveness_bound << 0.1, infinity, 0.2, infinity;
  PseudoInverse<double>::Params p(setup);
  const VecN<double> as_estimated = Alone<PseudoInverse<double>>(unchecked, setup, p).step(in.demand, in.x, in.det).u;
  p.unknown = PseudoInverse<double>::Unknown::nominal;
  const VecN<double> nominal = Alone<PseudoInverse<double>>(unchecked, setup, p).step(in.demand, in.x, in.det).u;
  Inputs<double> healthy = in;
  healthy.x.effectiveness << 0.5, 1, 0.7, 1;
  EXPECT_EQ(nominal, alone<PseudoInverse<double>>(setup).step(healthy.demand, healthy.x, healthy.det).u);
  EXPECT_GT((nominal - as_estimated).norm(), 1e-3);
}

TEST(PseudoInverse, MovesNoFasterThanItsRateEitherWay) {
  auto setup = ftc_4rw<double>();
  setup.vehicle.u_rate << 1, 2, 3, 4;  // 0.01 ... 0.04 N m a sample
  const VecN<double> step = setup.vehicle.u_rate * 0.01;
  auto allocator = alone<PseudoInverse<double>>(setup);
  Inputs<double> in(setup);
  VecN<double> u = VecN<double>::Zero(4);
  for (int k = 0; k < 40; ++k) {
    in.demand.tau_B = Vec3<double>(0.15, -0.1, 0.12) * (k / 10 % 2 == 0 ? 1 : -1);
    const VecN<double> wish = setup.vehicle.D_B.transpose() * (0.75 * in.demand.tau_B);
    for (int i = 0; i < 4; ++i) u[i] = std::clamp(wish[i], u[i] - step[i], u[i] + step[i]);
    const Allocation<double> out = allocator.step(in.demand, in.x, in.det);
    EXPECT_LT((out.u - u).cwiseAbs().maxCoeff(), 1e-15) << k;
    u = out.u;
  }
  ASSERT_GT(u.cwiseAbs().maxCoeff(), 0.05);
  allocator.reset();
  const VecN<double> first = allocator.step(in.demand, in.x, in.det).u;
  for (int i = 0; i < 4; ++i) EXPECT_LE(std::abs(first[i]), step[i]) << "from zero again";
}

TEST(PseudoInverse, DoesNotPreferWhatItMayNotUse) {
  auto setup = unlimited();
  Inputs<double> in(setup);
  in.demand.u_pref = VecN<double>::Constant(4, 0.1);
  in.det.failed.set(2);
  const Allocation<double> out = alone<PseudoInverse<double>>(setup).step(in.demand, in.x, in.det);
  EXPECT_EQ(out.u[2], 0);
  EXPECT_LT(out.achieved_B.norm(), 1e-15) << "no torque was asked for";
}

}  // namespace
}  // namespace gyrostat::test::test_pseudo_inverse
