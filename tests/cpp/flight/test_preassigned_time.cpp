// SPDX-License-Identifier: MIT
// The path to rest at a preassigned time, and the law that follows it: end conditions, any start, both coordinates.
#include <gtest/gtest.h>

#include <tuple>

#include "alone.hpp"
#include "gyrostat/flight/controllers/preassigned_time_sliding_mode.hpp"
#include "random.hpp"
#include "telemetry_log.hpp"
#include "vehicles.hpp"

namespace gyrostat::test::test_preassigned_time {
namespace {

TEST(PreassignedPath, StartsAsToldAndEndsAtRest) {
  Random random(1);
  for (int trial = 0; trial < 100; ++trial) {
    const double T = random.log_uniform(0.5, 20);
    const PathPoint<double> start{random.vector<double>(3), random.vector<double>(2), random.vector<double>(1)};
    const PreassignedPath<double> path(start, T);
    const PathPoint<double> first = path.at(0), before = path.at(T * (1 - 1e-15)), after = path.at(T);
    EXPECT_EQ(first.p, start.p);
    EXPECT_LT((first.rate - start.rate).norm(), 1e-15 * (1 + start.rate.norm()));
    EXPECT_LT((first.acceleration - start.acceleration).norm(), 1e-15 * (1 + start.acceleration.norm()));
    // Sums of terms of size d0, T d1 and T^2 d2: held to 1e-12 of it.
    const double size = start.p.norm() + T * start.rate.norm() + T * T * start.acceleration.norm();
    EXPECT_LT(before.p.norm(), 1e-12 * size);
    EXPECT_LT(T * before.rate.norm(), 1e-12 * size);
    EXPECT_LT(T * T * before.acceleration.norm(), 1e-11 * size);  // coefficients of 120
    EXPECT_EQ(after.p.norm() + after.rate.norm() + after.acceleration.norm(), 0);
  }
}

TEST(PreassignedPath, IsItsOwnDerivative) {
  const PreassignedPath<double> path({{1, -2, 0.5}, {0.3, 0.1, -0.4}, {0.2, -0.1, 0.3}}, 4.0);
  constexpr double h = 1e-4;  // central difference: h^2 p''' / 6 and rounding, both below 1e-7
  for (const double t : {0.5, 1.7, 3.3}) {
    const PathPoint<double> lo = path.at(t - h), hi = path.at(t + h), mid = path.at(t);
    EXPECT_LT(((hi.p - lo.p) / (2 * h) - mid.rate).norm(), 1e-7);
    EXPECT_LT(((hi.rate - lo.rate) / (2 * h) - mid.acceleration).norm(), 1e-7);
  }
}

Setup<double> printed(double dt) {
  Mat3N<double> D(3, 3);
  D.setIdentity();
  auto setup =
      vehicle_with<double>(Vec3<double>(200, 400, 200).asDiagonal(), D, std::numeric_limits<double>::infinity(), dt);
  setup.vehicle.coordinates = Coordinates::euler_angles;
  setup.vehicle.orbit_rate = 0.10312;
  return setup;
}

using Law = PreassignedTimeSlidingMode<double>;
Law::Params gains(double T) {
  Law::Params p(printed(0.01));
  p.T = T;
  p.c = 10;
  p.b = 2;
  p.eta = 5.5;
  p.layer = 0.1;
  p.stretch = 0;
  return p;
}

/// Largest error at T and after of the undisturbed printed model from a start, held commands, Runge-Kutta of order 4.
double error_from(const Vec3<double>& angles, const Vec3<double>& rates, double T, double& surface) {
  constexpr double dt = 0.002;
  const auto setup = printed(dt);
  Alone<Law> law(unchecked, setup, gains(T));
  Estimate<double> x;
  x.h_w = VecN<double>::Zero(3);
  x.effectiveness = VecN<double>::Ones(3);
  Vec3<double> a = angles, b = rates;
  const Reference<double> ref;
  const Allocation<double> last = Allocation<double>::idle(3);
  double worst = 0;
  surface = 0;
  for (int k = 0; k * dt < T + 0.5; ++k) {
    x.euler = {a, b};
    x.omega_BN_B = b;
    const Vec3<double> tau = (k == 0 ? law.start(x, {}, ref) : law.step(x, {}, ref, last)).tau_B;
    surface = std::max(surface, telemetry_of(law).at("s")[0]);
    if (k * dt >= T) worst = std::max(worst, a.norm());
    const auto acceleration = [&](const Vec3<double>& q, const Vec3<double>& v) -> Vec3<double> {
      return euler_model_acceleration(setup.vehicle, q, v) + tau.cwiseQuotient(setup.vehicle.J_B.diagonal());
    };
    const Vec3<double> k1 = acceleration(a, b);
    const Vec3<double> b2 = b + dt / 2 * k1, k2 = acceleration(a + dt / 2 * b, b2);
    const Vec3<double> b3 = b + dt / 2 * k2, k3 = acceleration(a + dt / 2 * b2, b3);
    const Vec3<double> b4 = b + dt * k3, k4 = acceleration(a + dt * b3, b4);
    a += dt / 6 * (b + 2 * (b2 + b3) + b4);
    b += dt / 6 * (k1 + 2 * (k2 + k3) + k4);
  }
  return worst;
}

TEST(PreassignedTime, ArrivesAtTFromAHundredStarts) {
  Random random(2);
  for (int trial = 0; trial < 100; ++trial) {
    double surface = 0;
    // What is left is the demand held for 2 ms along the path: 57 /s keeps it below 1e-3 rad for these sizes.
    const double left = error_from(random.vector<double>(2.5), random.vector<double>(1.5), 2.0, surface);
    EXPECT_LT(left, 2e-4) << trial;
    EXPECT_LT(surface, 0.1) << trial;  // the layer is never left
  }
}

TEST(PreassignedTime, AsksForNoTorqueAtTheFirstSampleOnABody) {
  auto setup = ftc_4rw<double>();
  Random random(3);
  for (int trial = 0; trial < 50; ++trial) {
    Alone<Law> law(unchecked, setup, gains(5));
    Estimate<double> x;
    x.h_w = VecN<double>::Constant(4, 0.2);
    x.q_NB = quat_from_euler(random.vector<double>(1.2));
    x.omega_BN_B = random.vector<double>(0.5);
    const Demand<double> demand = law.start(x, {}, {});
    // p''(0) is the acceleration of the free motion, gyroscopic torque of body and wheels included; only rounding is left.
    EXPECT_LT(demand.tau_B.norm(), 1e-11);
    EXPECT_FALSE(demand.status.has(Flag::singular));
  }
}

TEST(PreassignedTime, GivesTheAngularAccelerationThatItAsksForOnABody) {
  auto setup = ftc_4rw<double>();
  auto p = gains(5);
  p.start_acceleration = Law::StartAcceleration::zero;
  Alone<Law> law(unchecked, setup, p);
  Estimate<double> x;
  x.h_w = VecN<double>::Constant(4, -0.3);
  const Vec3<double> angles(0.4, -0.7, 1.1), rates(0.2, 0.3, -0.1);
  x.q_NB = quat_from_euler(angles);
  x.omega_BN_B = euler_rate_matrix(angles) * rates;
  const Vec3<double> tau_B = law.start(x, {}, {}).tau_B;  // s = 0 and p'' = 0: no second derivative of the angles
  const Vehicle<double>& v = setup.vehicle;
  const Vec3<double> wdot =
      v.J_B.inverse() * (tau_B - x.omega_BN_B.cross(v.J_B * x.omega_BN_B + torque<double>(v.D_B, x.h_w)));
  // Move by the truth's kinematics for a short while: the Euler rates must not change to first order.
  constexpr double h = 1e-5;
  const Quat<double> q = x.q_NB * quat_exp<double>(h * x.omega_BN_B + h * h / 2 * wdot);
  const Vec3<double> later = euler_rates<double>(euler(q), x.omega_BN_B + h * wdot);
  EXPECT_LT((later - rates).norm() / h, 1e-4);  // second order: h times the third derivative
}

TEST(PreassignedTime, SaysWhenTheAnglesDoNotExist) {
  auto setup = ftc_4rw<double>();
  Alone<Law> law(unchecked, setup, gains(5));
  Estimate<double> x;
  x.h_w = VecN<double>::Zero(4);
  for (const double pitch : {1.5707963267948966, -1.5707963267948966, 1.57079, 1.5707963267948966 - 0.9 * 0.01 * 0.4}) {
    x.q_NB = quat_from_euler<double>({0.3, pitch, -0.2});
    x.omega_BN_B = euler_rate_matrix<double>({0.3, pitch, -0.2}) * Vec3<double>(0, 0.4, 0);
    const Demand<double> demand = law.start(x, {}, {});
    EXPECT_TRUE(demand.status.has(Flag::singular)) << pitch;
    EXPECT_TRUE(demand.tau_B.allFinite());
  }
}

TEST(PreassignedTime, MovesItsTimeAwayOnlyWhileTheCommandFallsShort) {
  auto setup = ftc_4rw<double>();
  auto p = gains(5);
  p.stretch = 10;
  Alone<Law> law(unchecked, setup, p);
  Estimate<double> x;
  x.h_w = VecN<double>::Zero(4);
  x.q_NB = quat_from_euler<double>({0.5, 0.2, 0.1});
  const Reference<double> ref;
  (void)law.start(x, {}, ref);
  Allocation<double> last = Allocation<double>::idle(4);
  last.demand_B = last.achieved_B = Vec3<double>(0.1, 0, 0);
  (void)law.step(x, {}, ref, last);
  EXPECT_NEAR(telemetry_of(law).at("T_left")[0], 5 - 0.01, 1e-12);
  last.demand_B = Vec3<double>(0.2, 0, 0);
  (void)law.step(x, {}, ref, last);
  EXPECT_NEAR(telemetry_of(law).at("T_left")[0], 5 - 0.02 + 10 * 0.01, 1e-12);
  EXPECT_LT(std::abs(telemetry_of(law).at("s")[0]), 1e-15);  // planned anew from where it is
}

TEST(PreassignedTime, MovesItsTimeAwayAfterItHasPassedToo) {
  auto setup = ftc_4rw<double>();
  auto p = gains(0.05);
  p.stretch = 10;
  Alone<Law> law(unchecked, setup, p);
  Estimate<double> x;
  x.h_w = VecN<double>::Zero(4);
  x.q_NB = quat_from_euler<double>({0.1, 0, 0});
  (void)law.start(x, {}, {});
  Allocation<double> last = Allocation<double>::idle(4);
  for (int k = 0; k < 10; ++k) (void)law.step(x, {}, {}, last);
  EXPECT_EQ(telemetry_of(law).at("T_left")[0], 0);
  last.demand_B = Vec3<double>(1, 0, 0);
  for (int k = 1; k <= 10; ++k) {
    (void)law.step(x, {}, {}, last);
    EXPECT_NEAR(telemetry_of(law).at("T_left")[0], k == 1 ? 0.1 : 0.1 + 0.09 * (k - 1), 1e-12);
  }
}

TEST(PreassignedTime, DampsATumbleThatFallsShortAndPlansAnewAfterIt) {
  auto setup = ftc_4rw<double>();
  auto p = gains(5);
  p.stretch = 10;
  Estimate<double> x;
  x.h_w = VecN<double>::Zero(4);
  x.q_NB = quat_from_euler<double>({0.5, 0.2, 0.1});
  Allocation<double> last = Allocation<double>::idle(4);
  last.demand_B = Vec3<double>(1, 0, 0);  // nothing is achieved
  for (const double stretch : {10.0, 0.0}) {
    p.stretch = stretch;
    Alone<Law> law(unchecked, setup, p);
    x.omega_BN_B.setZero();
    (void)law.start(x, {}, {});
    x.omega_BN_B = Vec3<double>(0.5, -0.3, 0.4);
    const Vec3<double> tau_B = law.step(x, {}, {}, last).tau_B, damping_B = -p.c * (setup.vehicle.J_B * x.omega_BN_B);
    EXPECT_EQ((tau_B - damping_B).norm() == 0, stretch > 0);  // as published without stretch
    if (stretch == 0) continue;
    x.omega_BN_B *= 1e-3;
    last.demand_B.setZero();
    (void)law.step(x, {}, {}, last);
    EXPECT_NEAR(telemetry_of(law).at("T_left")[0], 5, 1e-12);
    const std::vector<double> s = telemetry_of(law).at("s");
    for (const double s_i : s) EXPECT_LT(std::abs(s_i), 1e-15);
  }
}

TEST(PreassignedTime, RefusesWhatIsUnstableWhenHeld) {
  auto setup = printed(0.036);
  EXPECT_EQ(Law::check(setup, gains(5)).code, Status<double>::Code::unstable);  // 57 /s times 36 ms
  setup.dt = 0.034;
  EXPECT_TRUE(Law::check(setup, gains(5)).ok());
  setup.vehicle.J_B(0, 1) = setup.vehicle.J_B(1, 0) = 1;
  EXPECT_EQ(Law::check(setup, gains(5)).code, Status<double>::Code::wrong_chart);
}

// ---- the law written out, and what it plans -----------------------------------------------------------------------

Estimate<double> state(int actuators) {
  Estimate<double> x;
  x.h_w = VecN<double>::Zero(actuators);
  x.effectiveness = VecN<double>::Ones(actuators);
  return x;
}

TEST(PreassignedTime, IsThePrintedLawWithAMovingReferenceAndAnEstimatedTorque) {
  const auto setup = printed(0.02);
  const Vehicle<double>& v = setup.vehicle;
  const Law::Params p = gains(3);
  Random random(11);
  for (int trial = 0; trial < 50; ++trial) {
    Alone<Law> law(unchecked, setup, p);
    Estimate<double> x = state(3);
    Reference<double> ref;
    const auto draw = [&](double angle, double rate) {
      x.euler.angles = random.vector<double>(angle);
      x.omega_BN_B = random.vector<double>(rate);
      x.d_B = random.vector<double>(50);
      ref.euler = {random.vector<double>(angle), random.vector<double>(rate)};
      ref.euler_accelerations = random.vector<double>(1);
    };
    const auto known = [&]() -> Vec3<double> { return euler_model_acceleration(v, x.euler.angles, x.omega_BN_B); };
    draw(0.5, 0.5);
    const Vec3<double> z0 = x.euler.angles - ref.euler.angles, zd0 = x.omega_BN_B - ref.euler.rates;
    const PreassignedPath<double> path({z0, zd0, known() - ref.euler_accelerations}, p.T);
    (void)law.start(x, {}, ref);
    draw(0.5, 0.5);
    const PathPoint<double> at = path.at(setup.dt);
    const Vec3<double> e = x.euler.angles - ref.euler.angles - at.p, ed = x.omega_BN_B - ref.euler.rates - at.rate;
    const Vec3<double> s = p.c * e + ed;
    Vec3<double> expected;
    for (int i = 0; i < 3; ++i) {
      const double switching = std::clamp(s[i] / p.layer, -1.0, 1.0);
      expected[i] = v.J_B(i, i) * (at.acceleration[i] + ref.euler_accelerations[i] - p.c * ed[i] - p.b * s[i] -
                                   p.eta * switching - known()[i]) -
                    x.d_B[i];
    }
    const Vec3<double> tau_B = law.step(x, {}, ref, Allocation<double>::idle(3)).tau_B;
    EXPECT_LT((tau_B - expected).norm(), 1e-12 * expected.norm()) << trial;  // sums in another order
  }
}

TEST(PreassignedTime, TakesTheErrorOfAnglesTheShortWayRound) {
  Alone<Law> law(unchecked, ftc_4rw<double>(), gains(5));
  Estimate<double> x = state(4);
  x.q_NB = quat_from_euler<double>({0.1, 0.2, 3.1});
  Reference<double> ref;
  ref.q_NR = quat_from_euler<double>({0, 0, -3.1});
  (void)law.start(x, {}, ref);
  EXPECT_NEAR(telemetry_of(law).at("p")[2], 6.2 - 2 * 3.14159265358979323846, 1e-12);
}

/// The path goes on from the motion as it is, so the first demand of a new plan is what was achieved before.
TEST(PreassignedTime, APlanAfterAShortfallAsksForWhatWasAchieved) {
  Random random(12);
  auto p = gains(4);
  p.stretch = 10;
  for (const bool body : {true, false}) {
    const gyrostat::Setup<double> setup = body ? ftc_4rw<double>() : printed(0.01);
    const int n = setup.vehicle.actuators();
    for (int trial = 0; trial < 20; ++trial) {
      Alone<Law> law(unchecked, setup, p);
      Estimate<double> x = state(n);
      x.q_NB = quat_from_euler(random.vector<double>(0.5));
      x.euler.angles = random.vector<double>(0.5);
      x.h_w.setConstant(body ? 0.1 : 0);
      Reference<double> ref;
      ref.omegadot_RN_R = random.vector<double>(1e-3);
      ref.euler_accelerations = random.vector<double>(1e-3);
      (void)law.start(x, {}, ref);
      x.omega_BN_B = random.vector<double>(0.02);
      x.d_B = random.vector<double>(0.05);
      Allocation<double> last = Allocation<double>::idle(n);
      last.achieved_B = random.vector<double>(0.1);
      last.demand_B = 2 * last.achieved_B + Vec3<double>(0, 0, 10);
      const Vec3<double> tau_B = law.step(x, {}, ref, last).tau_B;
      EXPECT_NEAR(telemetry_of(law).at("T_left")[0], 4 - 0.01 + 10 * 0.01, 1e-12) << "planned anew";
      EXPECT_LT((tau_B - last.achieved_B).norm(), 1e-12);  // rounding of J times accelerations
    }
  }
}

TEST(PreassignedTime, FallsShortFromAHundredthOfTheDemandOn) {
  auto p = gains(5);
  p.stretch = 10;
  const auto setup = ftc_4rw<double>();
  // A hundredth of the demand, and a thousandth of the usable torque for demands about zero.
  const double torque = usable_torque(setup.vehicle);
  for (const double missing : {0.99, 1.01}) {
    Alone<Law> law(unchecked, setup, p);
    const Estimate<double> x = state(4);
    (void)law.start(x, {}, {});
    Allocation<double> last = Allocation<double>::idle(4);
    last.demand_B = Vec3<double>(0.2, 0, 0);
    last.achieved_B = last.demand_B * (1 - missing * (0.01 + 1e-3 * torque / 0.2));
    (void)law.step(x, {}, {}, last);
    EXPECT_NEAR(telemetry_of(law).at("T_left")[0], missing < 1 ? 4.99 : 5.09, 1e-12);
  }
}

TEST(PreassignedTime, ANewTargetHasAllOfTheTimeAgain) {
  Alone<Law> law(unchecked, ftc_4rw<double>(), gains(5));
  Estimate<double> x = state(4);
  const Allocation<double> last = Allocation<double>::idle(4);
  Reference<double> ref;
  (void)law.start(x, {}, ref);
  for (int k = 0; k < 10; ++k) (void)law.step(x, {}, ref, last);
  EXPECT_NEAR(telemetry_of(law).at("T_left")[0], 4.9, 1e-12);
  ref.event = 1;
  ref.q_NR = quat_from_euler<double>({0.3, 0, 0});
  (void)law.step(x, {}, ref, last);
  EXPECT_NEAR(telemetry_of(law).at("T_left")[0], 5, 1e-12);
  EXPECT_NEAR(telemetry_of(law).at("p")[0], -0.3, 1e-12);
}

/// No motion led there, so no torque has fallen short; a kept T is kept all the same.
TEST(PreassignedTime, AJumpOfTheStateHasAllOfTheTimeAgainUnlessTIsKept) {
  for (const double stretch : {10.0, 0.0}) {
    auto p = gains(5);
    p.stretch = stretch;
    Alone<Law> law(unchecked, ftc_4rw<double>(), p);
    Estimate<double> x = state(4);
    const Allocation<double> last = Allocation<double>::idle(4);
    (void)law.start(x, {}, {});
    for (int k = 0; k < 10; ++k) (void)law.step(x, {}, {}, last);
    x.q_NB = quat_from_euler<double>({0.3, 0, 0});
    ++x.event;
    (void)law.step(x, {}, {}, last);
    EXPECT_NEAR(telemetry_of(law).at("T_left")[0], stretch > 0 ? 5 : 4.89, 1e-12);
    if (stretch == 0) continue;
    EXPECT_NEAR(telemetry_of(law).at("p")[0], 0.3, 1e-12) << "from where it is";
  }
}

/// A body of three equal inertias turns without a torque of its own: only the angle that stopping takes is left.
gyrostat::Setup<double> ball() {
  Mat3N<double> D(3, 3);
  D.setIdentity();
  return vehicle_with<double>(20 * Mat3<double>::Identity(), D, 0.2, 0.01);
}

bool damps(Alone<Law>& law, const Estimate<double>& x, const Allocation<double>& last, double c,
           const Mat3<double>& J) {
  return (law.step(x, {}, {}, last).tau_B + c * (J * x.omega_BN_B)).norm() == 0;
}

TEST(PreassignedTime, ATumbleBeginsWhereStoppingTakesARadianAndEndsAtATenthOfIt) {
  const auto setup = ball();
  auto p = gains(5);
  p.stretch = 10;
  Alone<Law> law(unchecked, setup, p);
  Estimate<double> x = state(3);
  Allocation<double> short_of = Allocation<double>::idle(3);
  short_of.demand_B = Vec3<double>(1, 0, 0);
  const Allocation<double> enough = Allocation<double>::idle(3);
  // w^2 J / (2 torque): the angle, rad, in which all of the torque stops the turn
  const auto turn = [&](double angle) { x.omega_BN_B = Vec3<double>(std::sqrt(angle * 2 * 0.2 / 20), 0, 0); };
  const auto damped = [&](const Allocation<double>& last) { return damps(law, x, last, p.c, setup.vehicle.J_B); };
  (void)law.start(x, {}, {});
  turn(0.99);
  EXPECT_FALSE(damped(short_of));
  turn(1.01);
  EXPECT_FALSE(damped(enough)) << "the command is met: no reason to give the path up";
  EXPECT_TRUE(damped(short_of));
  turn(0.5);
  EXPECT_TRUE(damped(enough)) << "until it is over";
  turn(0.101);
  EXPECT_TRUE(damped(enough));
  turn(0.099);
  EXPECT_FALSE(damped(enough));
  EXPECT_NEAR(telemetry_of(law).at("T_left")[0], 5, 1e-12) << "planned anew";
  turn(0.5);
  EXPECT_FALSE(damped(enough));
  turn(1.01);
  EXPECT_TRUE(damped(short_of));
  turn(0.5);
  (void)law.start(x, {}, {});
  EXPECT_FALSE(damped(enough)) << "a start has no past";
  // Without limits nothing falls short: a demand of more than a hundred times the torque is lost all the same.
  Allocation<double> met = enough;
  turn(1.01);
  met.demand_B = met.achieved_B = Vec3<double>(99 * 0.2, 0, 0);
  EXPECT_FALSE(damped(met));
  met.demand_B = met.achieved_B = Vec3<double>(101 * 0.2, 0, 0);
  EXPECT_TRUE(damped(met));
}

TEST(PreassignedTime, AGyroscopicTorqueBeyondTheActuatorsIsATumbleToo) {
  const auto setup = ball();
  auto p = gains(5);
  p.stretch = 10;
  Allocation<double> last = Allocation<double>::idle(3);
  last.demand_B = Vec3<double>(1, 0, 0);
  for (const double momentum : {1.9, 2.1}) {  // times 0.1 rad/s: 0.2 N m are at hand
    Alone<Law> law(unchecked, setup, p);
    Estimate<double> x = state(3);
    (void)law.start(x, {}, {});
    x.h_w[1] = momentum;
    x.omega_BN_B = Vec3<double>(0.1, 0, 0);  // stopping takes half a radian
    EXPECT_EQ(damps(law, x, last, p.c, setup.vehicle.J_B), momentum > 2);
  }
}

TEST(PreassignedTime, TheAnglesEndATenthOfAMilliradianBeforeThePoleOrAPeriodBeforeIt) {
  const double pole = 1.5707963267948966;
  for (const auto& [distance, rate, singular] : {std::tuple(0.9e-4, 0.0, true), std::tuple(1.1e-4, 0.0, false),
                                                 std::tuple(3.8e-3, 0.4, true), std::tuple(4.2e-3, 0.4, false)}) {
    Alone<Law> law(unchecked, ftc_4rw<double>(), gains(5));
    Estimate<double> x = state(4);
    const Vec3<double> angles(0.3, pole - distance, -0.2);
    x.q_NB = quat_from_euler(angles);
    x.omega_BN_B = euler_rate_matrix(angles) * Vec3<double>(0, rate, 0);
    EXPECT_EQ(law.start(x, {}, {}).status.has(Flag::singular), singular) << distance;
  }
}

}  // namespace
}  // namespace gyrostat::test::test_preassigned_time
