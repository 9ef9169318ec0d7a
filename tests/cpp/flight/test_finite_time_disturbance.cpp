// SPDX-License-Identifier: MIT
#include "gyrostat/flight/observers/finite_time_disturbance.hpp"

#include <gtest/gtest.h>

#include "../algebra.hpp"
#include "../random.hpp"
#include "alone.hpp"
#include "closed_loop.hpp"
#include "li2018.hpp"
#include "telemetry_log.hpp"

namespace gyrostat::test::test_finite_time_disturbance {
namespace {

template <class S>
using Observer = FiniteTimeDisturbanceObserver<S>;

/// Steps `observer` along `body` under the constant command u, and returns the estimate of the last sample.
template <class S>
Estimate<S> watch(Alone<Observer<S>>& observer, Body& body, const VecN<S>& u, double dt, int samples) {
  Allocation<S> last = Allocation<S>::idle(static_cast<int>(u.size()));
  last.u = u;
  Estimate<S> x = observer.start(body.measured<S>(0));
  for (int k = 1; k <= samples; ++k) {
    body.advance(u.template cast<double>(), dt);
    x = observer.step(body.measured<S>(static_cast<Tick>(k)), last);
  }
  return x;
}

VecN<double> some_command() {
  VecN<double> u(4);
  u << 0.01, -0.02, 0.015, 0.005;
  return u;
}

template <class S>
class FiniteTimeDisturbance : public testing::Test {};
using Scalars = testing::Types<float, double>;
TYPED_TEST_SUITE(FiniteTimeDisturbance, Scalars);

TYPED_TEST(FiniteTimeDisturbance, FindsFaultAndDisturbanceTogetherInFiniteTime) {
  using S = TypeParam;
  const gyrostat::Setup<S> setup = ftc_4rw<S>();
  Body body(setup.vehicle);
  body.d_B = {1e-3, -2e-3, 1.5e-3};
  body.effectiveness[2] = 0.4;
  body.omega_BN_B = {0.01, -0.02, 0.03};
  Alone<Observer<S>> observer(unchecked, setup, li2018::observer<S>());
  const Estimate<S> x = watch<S>(observer, body, some_command().cast<S>(), 0.01, 300);
  const Vec3<double> lumped_B = body.d_B + body.fault_B(some_command());
  // What stays is the error of the trapezoid in double. Float resolves a rate of 0.03 rad/s to 2e-9, hence an
  // acceleration to 2e-7 over a period, and the observer passes that on.
  EXPECT_LT((x.d_B.template cast<double>() - lumped_B).norm(), sizeof(S) == 8 ? 1e-8 : 2e-5);
  EXPECT_EQ(x.effectiveness, VecN<S>::Ones(4)) << "the fault is in d_B already";
}

TYPED_TEST(FiniteTimeDisturbance, StartsAtTheMeasuredRateWithNoTorque) {
  using S = TypeParam;
  const gyrostat::Setup<S> setup = ftc_4rw<S>();
  Body body(setup.vehicle);
  body.omega_BN_B = {0.3, -0.2, 0.1};
  Alone<Observer<S>> observer(unchecked, setup, li2018::observer<S>());
  (void)watch<S>(observer, body, VecN<S>::Constant(4, S(0.1)), 0.01, 5);
  EXPECT_EQ(observer.start(body.measured<S>(0)).d_B, Vec3<S>(Vec3<S>::Zero()));
  for (const auto& [signal, values] : telemetry_of(observer))
    for (const double v : values) EXPECT_EQ(v, 0) << signal;
}

TEST(FiniteTimeDisturbanceDouble, NominalPlantGivesNoTorque) {
  const auto setup = ftc_4rw<double>();
  Body body(setup.vehicle);
  body.omega_BN_B = {0.1, -0.2, 0.3};
  for (const double dt : {0.001, 0.01}) {
    auto s = setup;
    s.dt = dt;
    Alone<Observer<double>> observer(unchecked, s, li2018::observer<double>());
    // The gyroscopic torque (up to 0.3 N m) enters by the trapezoid: h^2 / 12 times its curvature (below 1 /s^2).
    EXPECT_LT(watch<double>(observer, body, some_command(), dt, 500).d_B.norm(), dt * dt / 12 * 0.3) << dt;
  }
}

TEST(FiniteTimeDisturbanceDouble, WheelMomentumBelongsToTheModel) {
  auto setup = ftc_4rw<double>();
  Alone<Observer<double>> observer(unchecked, setup, li2018::observer<double>());
  VecN<double> h_w(4);
  h_w << 5, -2.5, 1.25, 0.5;
  const VecN<double> u = some_command();
  const Mat3<double>& J = setup.vehicle.J_B;
  Measurement<double> y;
  y.h_w = h_w;
  y.omega_BN_B = {0.01, -0.02, 0.03};
  Allocation<double> last = Allocation<double>::idle(4);
  last.u = u;
  Estimate<double> x = observer.start(y);
  for (int k = 1; k <= 300; ++k) {  // J w' = D u - w x (J w + D h_w), h_w' = -u, midpoint rule with 20 steps a period
    for (int j = 0; j < 20; ++j) {
      const double h = setup.dt / 20;
      const auto rate = [&](const Vec3<double>& w, const VecN<double>& hw) {
        return Vec3<double>(J.inverse() * (setup.vehicle.D_B * u - w.cross(J * w + setup.vehicle.D_B * hw)));
      };
      const Vec3<double> middle = y.omega_BN_B + h / 2 * rate(y.omega_BN_B, y.h_w);
      y.omega_BN_B += h * rate(middle, y.h_w - h / 2 * u);
      y.h_w -= h * u;
    }
    x = observer.step(y, last);
  }
  EXPECT_LT(x.d_B.norm(), 1e-6);  // without h_w it would be w x D h_w, 0.1 N m
}

TEST(FiniteTimeDisturbanceDouble, ExplicitEulerChattersAndSubstepsQuietIt) {
  const auto floor_of = [](Observer<double>::Params p) {
    const auto setup = ftc_4rw<double>();
    Body body(setup.vehicle);
    body.d_B = {1e-3, -2e-3, 1.5e-3};
    Alone<Observer<double>> observer(unchecked, setup, p);
    (void)watch<double>(observer, body, VecN<double>::Zero(4), setup.dt, 2000);
    double floor = 0;  // over some more samples, since a limit cycle passes through zero
    Allocation<double> idle = Allocation<double>::idle(4);
    for (int k = 0; k < 50; ++k) {
      body.advance(idle.u, setup.dt);
      (void)observer.step(body.measured<double>(0), idle);
      const std::vector<double> z1 = telemetry_of(observer).at("z1");
      for (const double z : z1) floor = std::max(floor, std::abs(z));
    }
    return floor;
  };
  auto p = li2018::observer<double>();
  EXPECT_LT(floor_of(p), 1e-10);
  p.method = Observer<double>::Method::explicit_euler;
  const double once = floor_of(p);
  const double expected = std::pow(0.6 * 1e-4, 1.25);  // (lambda2 h^2)^(1 / (1 - alpha2)): order of magnitude
  EXPECT_GT(once, 0.1 * expected);
  EXPECT_LT(once, 20 * expected);
  p.substeps = 10;
  EXPECT_LT(floor_of(p), 0.05 * once);
}

TEST(FiniteTimeDisturbanceDouble, ExplicitEulerOfManyStepsAgreesWithItself) {
  const auto setup = ftc_4rw<double>();
  auto p = li2018::observer<double>();
  p.method = Observer<double>::Method::explicit_euler;
  const auto transient = [&](int substeps) {
    p.substeps = substeps;
    Body body(setup.vehicle);
    body.d_B = {0.05, -0.02, 0.03};
    Alone<Observer<double>> observer(unchecked, setup, p);
    return Vec3<double>(watch<double>(observer, body, some_command(), setup.dt, 10).d_B);
  };
  const double coarse = (transient(50) - transient(800)).norm(), fine = (transient(100) - transient(800)).norm();
  EXPECT_GT(coarse / fine, 1.6);  // first order: halving the step halves the error
  EXPECT_LT(coarse / fine, 2.8);
}

/// P, Q of V = eps' P eps, eps = (sig^alpha1(z1), z2), V' = -|z1|^(alpha1-1) eps' Q eps (Li et al. 2018, eq. (12), (14)).
struct Lyapunov {
  Eigen::Matrix2d P, Q, A;
  Lyapunov(double a1, double l1, double l2) {
    P << 2 * l2 + a1 * l1 * l1, -a1 * l1, -a1 * l1, 2 * a1;
    P /= 2 * a1;
    Q << l2 + a1 * l1 * l1, -a1 * l1, -a1 * l1, a1;
    Q *= l1;
    A << -a1 * l1, a1, -l2, 0;
  }
};

TEST(FiniteTimeDisturbanceDouble, PublishedLyapunovFunctionSolvesItsEquation) {
  Random random(5);
  for (int trial = 0; trial < 500; ++trial) {
    const double a1 = random.uniform(0.51, 0.99), l1 = random.log_uniform(0.01, 100),
                 l2 = random.log_uniform(0.01, 100);
    const Lyapunov L(a1, l1, l2);
    const double scale = L.A.norm() * L.P.norm();
    EXPECT_LT((L.A.transpose() * L.P + L.P * L.A + L.Q).norm(), 1e-14 * scale);
    EXPECT_GT(L.P.determinant(), 0);
    EXPECT_GT(L.Q.determinant(), 0);
  }
  const Lyapunov published(0.6, 1, 0.6);
  EXPECT_NEAR(symmetric_eigenvalues(published.P)[0], 0.691, 5e-4);
  EXPECT_NEAR(symmetric_eigenvalues(published.Q)[0], 0.229, 5e-4);
}

TEST(FiniteTimeDisturbanceDouble, ErrorsFallAlongThePublishedLyapunovFunction) {
  auto setup = ftc_4rw<double>();
  setup.dt = 0.001;
  const auto p = li2018::observer<double>();
  const Lyapunov L(p.alpha1, p.lambda1, p.lambda2);
  Body body(setup.vehicle);
  body.d_B = {0.05, -0.03, 0.02};
  Alone<Observer<double>> observer(unchecked, setup, p);
  (void)observer.start(body.measured<double>(0));
  const Vec3<double> acceleration = setup.vehicle.J_B.inverse() * body.d_B;
  Vec3<double> before = Vec3<double>::Constant(std::numeric_limits<double>::infinity());
  for (int k = 1; k < 1000; ++k) {
    body.advance(VecN<double>::Zero(4), setup.dt);
    (void)observer.step(body.measured<double>(0), Allocation<double>::idle(4));
    const auto log = telemetry_of(observer);
    for (std::size_t i = 0; i < 3; ++i) {
      const Eigen::Vector2d eps(sig(log.at("z1")[i], p.alpha1), acceleration[static_cast<int>(i)] - log.at("eta")[i]);
      const double V = eps.dot(L.P * eps);
      const double floor = 1e-14;  // (1e-7)^2: the gyroscopic torque makes z2 a moving target of that size
      EXPECT_LE(V, before[static_cast<int>(i)] + floor) << "axis " << i << ", sample " << k;
      before[static_cast<int>(i)] = V;
    }
  }
  EXPECT_LT(before.maxCoeff(), 1e-13);  // arrived
}

TEST(FiniteTimeDisturbanceDouble, DefaultsCatchAStepOfAllTorqueInFiftyPeriodsOnAnyVehicle) {
  struct {
    double J, u_max, dt;
  } const vehicles[] = {{20, 0.2, 0.01},    {20, 0.2, 0.001}, {1, 1e-3, 0.1},
                        {0.01, 1e-3, 0.05}, {2000, 5, 0.1},   {2000, 5, 1}};
  for (const auto& v : vehicles) {
    const auto setup = vehicle_with<double>(v.J * Mat3<double>::Identity(), pyramid<double>(), v.u_max, v.dt);
    const Observer<double>::Params p(setup);
    ASSERT_TRUE(Observer<double>::check(setup, p).ok());
    Body body(setup.vehicle);
    body.d_B.setConstant(usable_torque(setup.vehicle));
    Alone<Observer<double>> observer(unchecked, setup, p);
    const Estimate<double> x = watch<double>(observer, body, VecN<double>::Zero(4), v.dt, 50);
    EXPECT_LT((x.d_B - body.d_B).norm(), 0.01 * body.d_B.norm()) << v.J << " " << v.dt;
  }
}

TEST(FiniteTimeDisturbanceCheck, RefusesWhatCannotWorkWithItsNumber) {
  const auto setup = ftc_4rw<double>();
  auto p = li2018::observer<double>();
  EXPECT_TRUE(Observer<double>::check(setup, p).ok());
  for (const double alpha1 : {0.5, 1.0, 0.3}) {
    p.alpha1 = alpha1;
    EXPECT_EQ(Observer<double>::check(setup, p).value, alpha1);
    EXPECT_EQ(Observer<double>::check(setup, p).code, Status<double>::Code::refused);
  }
  p = li2018::observer<double>();
  p.lambda1 = 250;  // 250 * 0.01 > 2
  EXPECT_TRUE(Observer<double>::check(setup, p).ok()) << "the implicit step is stable at every gain";
  p.method = Observer<double>::Method::explicit_euler;
  EXPECT_EQ(Observer<double>::check(setup, p).code, Status<double>::Code::unstable);
  p.substeps = 10;
  EXPECT_TRUE(Observer<double>::check(setup, p).ok());
  auto euler = setup;
  euler.vehicle.coordinates = Coordinates::euler_angles;
  EXPECT_EQ(Observer<double>::check(euler, li2018::observer<double>()).code, Status<double>::Code::wrong_chart);
}

TEST(FiniteTimeDisturbanceCheck, ExplicitLimitIsTheSpectralRadius) {
  Random random(6);
  auto p = li2018::observer<double>();
  p.method = Observer<double>::Method::explicit_euler;
  for (int trial = 0; trial < 1000; ++trial) {
    auto setup = ftc_4rw<double>();
    setup.dt = random.log_uniform(0.001, 10);
    p.lambda1 = random.log_uniform(0.1, 10);
    p.lambda2 = random.log_uniform(0.1, 10);
    Eigen::Matrix2d M;
    M << 1 - setup.dt * p.lambda1, setup.dt, -setup.dt * p.lambda2, 1;
    const double radius = eigenvalues(M).cwiseAbs().maxCoeff();
    if (std::abs(radius - 1) < 1e-9) continue;
    EXPECT_EQ(Observer<double>::check(setup, p).ok(), radius < 1) << setup.dt << " " << p.lambda1 << " " << p.lambda2;
  }
}

TEST(FiniteTimeDisturbanceDouble, ExplicitSubstepsAreTheEulerStepsOfTheirPage) {
  auto setup = ftc_4rw<double>();
  auto p = li2018::observer<double>();
  p.method = Observer<double>::Method::explicit_euler;
  p.substeps = 4;
  Alone<Observer<double>> observer(unchecked, setup, p);
  const Mat3<double>& J = setup.vehicle.J_B;
  const Mat3N<double>& D = setup.vehicle.D_B;
  Random random(7);
  const auto measured = [&] {
    Measurement<double> y;
    y.omega_BN_B = random.vector<double>(0.3);
    y.h_w = VecN<double>(4);
    for (int i = 0; i < 4; ++i) y.h_w[i] = random.uniform(-5, 5);
    return y;
  };
  for (int start = 0; start < 2; ++start) {
    Measurement<double> before = measured();
    EXPECT_EQ(observer.start(before).d_B, Vec3<double>(Vec3<double>::Zero()));
    Vec3<double> what = before.omega_BN_B, eta = Vec3<double>::Zero();
    for (int k = 0; k < 20; ++k) {
      const Measurement<double> y = measured();
      Allocation<double> last = Allocation<double>::idle(4);
      for (int i = 0; i < 4; ++i) last.u[i] = random.uniform(-0.2, 0.2);
      const double h = setup.dt / 4;
      for (int j = 0; j < 4; ++j) {  // the rate and the wheels on a line between the samples
        const Vec3<double> w = before.omega_BN_B + j / 4.0 * (y.omega_BN_B - before.omega_BN_B);
        const VecN<double> h_w = before.h_w + j / 4.0 * (y.h_w - before.h_w);
        const Vec3<double> z1 = w - what;
        Vec3<double> correction;
        for (int i = 0; i < 3; ++i) correction[i] = std::copysign(std::pow(std::abs(z1[i]), 0.6), z1[i]) + eta[i];
        what += h * (J.inverse() * (D * last.u - w.cross(J * w + D * h_w)) + correction);
        for (int i = 0; i < 3; ++i) eta[i] += h * 0.6 * std::copysign(std::pow(std::abs(z1[i]), 0.2), z1[i]);
      }
      const Vec3<double> z1 = y.omega_BN_B - what;
      Vec3<double> theta = eta;
      for (int i = 0; i < 3; ++i) theta[i] += std::copysign(std::pow(std::abs(z1[i]), 0.6), z1[i]);
      const Vec3<double> d_B = observer.step(y, last).d_B;
      EXPECT_LT((d_B - J * theta).norm(), 1e-11) << k;  // rounding of z1, which sig^0.6 enlarges where z1 is small
      before = y;
    }
  }
}

TEST(FiniteTimeDisturbanceDouble, AStartForgetsTheIntegral) {
  const auto setup = ftc_4rw<double>();
  Alone<Observer<double>> fresh(unchecked, setup, li2018::observer<double>()), used = fresh;
  Body body(setup.vehicle);
  body.d_B = {0.05, -0.02, 0.03};
  (void)watch<double>(used, body, some_command(), setup.dt, 50);
  Body other(setup.vehicle);
  const Estimate<double> expected = watch<double>(fresh, other, some_command(), setup.dt, 3);
  Body again(setup.vehicle);
  EXPECT_EQ(watch<double>(used, again, some_command(), setup.dt, 3).d_B, expected.d_B);
}

}  // namespace
}  // namespace gyrostat::test::test_finite_time_disturbance
