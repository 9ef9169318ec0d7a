// SPDX-License-Identifier: MIT
// What many laws are made of: the healthy estimate, a moving reference, torque at hand, commands without torque, roots.
#include <gtest/gtest.h>

#include "../algebra.hpp"
#include "../random.hpp"
#include "alone.hpp"
#include "gyrostat/flight/allocators/parts/ldl.hpp"
#include "gyrostat/flight/controllers/mrp_feedback.hpp"
#include "gyrostat/flight/detectors/parts/null_space.hpp"
#include "gyrostat/flight/observers/parts/schur.hpp"
#include "gyrostat/flight/parts/authority.hpp"
#include "gyrostat/flight/parts/effectiveness_regression.hpp"
#include "vehicles.hpp"

namespace gyrostat::test::test_parts {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

TEST(HealthyEstimate, IsTheMeasurementAndNothingElse) {
  Random random(1);
  Measurement<double> y;
  y.tick = 12;
  y.q_NB = random.attitude<double>();
  y.omega_BN_B = random.vector<double>(1);
  y.h_w = VecN<double>::LinSpaced(5, 1, 5);
  y.euler = {random.vector<double>(1), random.vector<double>(1)};
  const auto x = Estimate<double>::healthy(y);
  EXPECT_EQ(x.tick, y.tick);
  EXPECT_EQ(x.q_NB.coeffs(), y.q_NB.coeffs());
  EXPECT_EQ(x.omega_BN_B, y.omega_BN_B);
  EXPECT_EQ(x.h_w, y.h_w);
  EXPECT_EQ(x.euler.angles, y.euler.angles);
  EXPECT_EQ(x.euler.rates, y.euler.rates);
  EXPECT_EQ(x.effectiveness, VecN<double>::Ones(5));
  EXPECT_EQ(x.effectiveness_bound, VecN<double>::Constant(5, infinity));
  EXPECT_EQ(x.d_B, Vec3<double>(Vec3<double>::Zero()));
  EXPECT_EQ(x.status.bits(), 0);
}

/// A body with wheels and a reference at an instant, and both a short while later.
struct Motion {
  gyrostat::Setup<double> setup = ftc_4rw<double>();
  Estimate<double> x;
  Reference<double> ref;

  explicit Motion(Random& random) {
    x.q_NB = random.attitude<double>();
    x.omega_BN_B = random.vector<double>(0.5);
    x.h_w = VecN<double>::Zero(4);
    for (int i = 0; i < 4; ++i) x.h_w[i] = random.uniform(-5, 5);
    x.effectiveness = VecN<double>::Ones(4);
    ref.q_NR = random.attitude<double>();
    ref.omega_RN_R = random.vector<double>(0.5);
    ref.omegadot_RN_R = random.vector<double>(0.2);
  }
  Vec3<double> momentum_B() const {
    return setup.vehicle.J_B * x.omega_BN_B + torque<double>(setup.vehicle.D_B, x.h_w);
  }
  /// Rate error after `t` under a torque, to second order in t.
  Vec3<double> rate_error(const Vec3<double>& tau_B, double t) const {
    const Vec3<double> wdot = setup.vehicle.J_B.inverse() * (tau_B - x.omega_BN_B.cross(momentum_B()));
    const Quat<double> q_NB = x.q_NB * quat_exp<double>(t * x.omega_BN_B);
    const Quat<double> q_NR = ref.q_NR * quat_exp<double>(t * ref.omega_RN_R);
    const Vec3<double> w_R = q_NB.conjugate() * (q_NR * Vec3<double>(ref.omega_RN_R + t * ref.omegadot_RN_R));
    return x.omega_BN_B + t * wdot - w_R;
  }
};

TEST(Tracking, LeavesThePlantAtRestOfTheRateError) {
  Random random(2);
  constexpr double h = 1e-5;  // central difference: h^2 times a third derivative of order one, and rounding over h
  for (int trial = 0; trial < 50; ++trial) {
    const Motion m(random);
    const Vehicle<double>& v = m.setup.vehicle;
    const Tracking<double> t = track(v, m.x, m.ref);
    EXPECT_LT((t.omega_BR_B - m.rate_error(Vec3<double>::Zero(), 0)).norm(), 1e-14);
    EXPECT_LT((t.momentum_B - m.momentum_B()).norm(), 1e-14);
    const Vec3<double> extra = random.vector<double>(1);  // J e' = -e x h + tau - feedforward
    const Vec3<double> tau_B = t.feedforward_B + extra;
    const Vec3<double> rate = (m.rate_error(tau_B, h) - m.rate_error(tau_B, -h)) / (2 * h);
    EXPECT_LT((v.J_B * rate - (extra - t.omega_BR_B.cross(t.momentum_B))).norm(), 1e-7) << trial;
    const Vec3<double> kept = (m.rate_error(t.equivalent_B(), h) - m.rate_error(t.equivalent_B(), -h)) / (2 * h);
    EXPECT_LT((v.J_B * kept).norm(), 1e-7) << "the equivalent torque keeps the error as it is";
  }
}

TEST(Tracking, IsWhatAProportionalLawAddsToItsError) {
  Random random(3);
  const Motion m(random);
  MrpFeedback<double>::Params p(m.setup);
  p.K = 2;
  p.P = 7;
  p.compensate = false;
  Alone<MrpFeedback<double>> law(unchecked, m.setup, p);
  const Tracking<double> t = track(m.setup.vehicle, m.x, m.ref);
  const Vec3<double> expected = t.feedforward_B - 2 * t.sigma_BR - 7 * t.omega_BR_B;
  EXPECT_GT(t.feedforward_B.norm(), 0.1);
  EXPECT_LT((law.start(m.x, {}, m.ref).tau_B - expected).norm(), 1e-14);
}

TEST(Authority, IsTheWeakestDirectionOfLimitsThatAreNotSymmetric) {
  const Mat3N<double> I = Mat3<double>::Identity();
  gyrostat::Setup<double> setup = vehicle_with<double>(satellite_inertia<double>(), I, 1, 0.01);
  for (int axis = 0; axis < 3; ++axis) {
    Vehicle<double> v = setup.vehicle;
    v.u_lo[axis] = -0.3;
    EXPECT_NEAR(torque_authority(v), 0.3, 1e-15);
    v.u_lo[axis] = -1;
    v.u_up[axis] = 0.4;
    EXPECT_NEAR(torque_authority(v), 0.4, 1e-15);
  }
  EXPECT_NEAR(torque_along<double>(setup.vehicle, Vec3<double>(0.6, 0, -0.8)), 1.4, 1e-15);
  setup.vehicle.u_lo[1] = 0.1;  // always pushes: one way cannot be had
  EXPECT_EQ(torque_authority(setup.vehicle), 0);
}

TEST(Authority, IsZeroWhereNoTwoAxesSpanAFace) {
  Mat3N<double> D(3, 3);
  D << 1, -1, 2, 0, 0, 0, 0, 0, 0;
  EXPECT_EQ(torque_authority(vehicle_with<double>(satellite_inertia<double>(), D, 1, 0.01).vehicle), 0);
}

TEST(NullSpace, IsOfItsMembersAlone) {
  const NullSpace<double> three(pyramid<double>(), Mask::all(3));
  EXPECT_EQ(three.dimension(), 0);
  EXPECT_TRUE(three.direction(0).isZero(0)) << "without redundancy there is no command without torque";
  Mat3N<double> D(3, 6);
  D << Mat3<double>::Identity(), Mat3<double>::Identity();
  Mask members = Mask::all(6);
  members.set(4, false);
  const NullSpace<double> five(D, members);
  EXPECT_EQ(five.dimension(), 2);
  const VecN<double> v = five.direction(0);
  EXPECT_LT(torque<double>(D, v).norm(), 1e-15);
  EXPECT_EQ(v.cwiseAbs().maxCoeff(), 1);
  EXPECT_TRUE(five.direction(1).isZero(0)) << "its partner is no member";
  EXPECT_TRUE(five.direction(4).isZero(0));
}

TEST(NullSpace, DoesNotCountAnAxisThatOnlyMisalignmentMakes) {
  Mat3N<double> D(3, 4);
  D << 1, 0, 1, 1, 0, 1, 1, -1, 1, 0, 1, 1 + 1e-5;  // all in a plane but for 1e-5 rad
  const NullSpace<double> plane(D, Mask::all(4));
  EXPECT_EQ(plane.dimension(), 2);
  EXPECT_LT(torque<double>(D, plane.direction(0)).norm(), 3e-5);
}

TEST(Regression, CountsTheTorqueOfAnActuatorNotItsCommand) {
  Mat3N<double> D(3, 3);
  D = Vec3<double>(10, 1, 0.1).asDiagonal();
  VecN<double> u(3);
  u << 0.005, -0.0625, 0.4;
  const Mask heard = excited<double>(D, u, 0.0625);
  EXPECT_FALSE(heard.test(0));  // 0.05 N m
  EXPECT_TRUE(heard.test(1)) << "at the gate";
  EXPECT_FALSE(heard.test(2));  // 0.04 N m of 0.4
  u[0] = -0.00626;
  EXPECT_TRUE(excited<double>(D, u, 0.0625).test(0));
}

TEST(Regression, IsTheRegularisedLeastNormOfTheInformativeColumns) {
  Random random(4);
  for (int trial = 0; trial < 50; ++trial) {
    const Mat3N<double> D = pyramid<double>();
    VecN<double> u(4);
    for (int i = 0; i < 4; ++i) u[i] = random.uniform(-1, 1);
    const Vec3<double> tau = random.vector<double>(1);
    Mask informative = Mask::all(4);
    informative.set(trial % 4, false);
    Eigen::MatrixXd Phi = D * u.asDiagonal();
    Phi.col(trial % 4).setZero();
    const MatrixXd normal = times(Phi, Phi.transpose()) + 0.3 * 0.3 * MatrixXd::Identity(3, 3);
    const VectorXd expected = transpose_applied(Phi, solved(normal, tau));
    EXPECT_LT((explaining_change<double>(D, u, informative, 0.3, tau) - expected).norm(), 1e-12) << trial;
  }
}

TEST(Schur, AgreesWithTheRootsThatThePolynomialWasMadeOf) {
  Random random(5);
  for (int trial = 0; trial < 2000; ++trial) {
    const int pairs = 1 + trial % 3;
    std::array<double, 8> p{1};
    int degree = 0;
    double largest = 0;
    const auto times = [&](double c1, double c0) {  // z^2 + c1 z + c0
      std::array<double, 8> q{};
      for (std::size_t i = 0; i + 2 < 8; ++i) {
        q[i] += c0 * p[i];
        q[i + 1] += c1 * p[i];
        q[i + 2] += p[i];
      }
      p = q;
      degree += 2;
    };
    for (int k = 0; k < pairs; ++k) {
      const double r = random.uniform(0, 1.2), s = random.uniform(-1.2, 1.2), angle = random.uniform(0, 3.14);
      const bool real = random.uniform(0, 1) < 0.5;
      times(real ? -(r + s) : -2 * r * std::cos(angle), real ? r * s : r * r);
      largest = std::max({largest, r, real ? std::abs(s) : 0.0});
    }
    if (std::abs(largest - 1) < 1e-6) continue;
    EXPECT_EQ(roots_inside_unit_circle(p, degree), largest < 1) << trial;
  }
}

TEST(Schur, ARootOnTheCircleIsNotInside) {
  EXPECT_FALSE(roots_inside_unit_circle(std::array{1.0, 0.0, 1.0}, 2));    // +-i
  EXPECT_FALSE(roots_inside_unit_circle(std::array{-1.0, 0.0, 1.0}, 2));   // +-1
  EXPECT_FALSE(roots_inside_unit_circle(std::array{-0.5, -0.5, 1.0}, 2));  // 1, -1/2
  EXPECT_TRUE(roots_inside_unit_circle(std::array{0.25, 0.0, 1.0}, 2));
}

TEST(Ldl, SaysWhenAPivotIsLostToCancellation) {
  Ldl<double, 3> factor;
  Mat3<double> A;
  A << 1, 0.5, 0.2, 0.5, 1, 0.1, 0.2, 0.1, 1;
  ASSERT_TRUE(factor.factor(A, 1e-8));
  EXPECT_LT((A * factor.solve({1, -2, 3}) - Vec3<double>(1, -2, 3)).norm(), 1e-14);
  for (const double left : {1e-7, 1e-9, 0.0, -1e-3}) {
    Mat3<double> B = Mat3<double>::Identity();
    B(1, 0) = B(0, 1) = 1;
    B(1, 1) = 1 + left;
    EXPECT_EQ(factor.factor(B, 1e-8), left > 1e-8) << left;
  }
}

}  // namespace
}  // namespace gyrostat::test::test_parts
