// SPDX-License-Identifier: MIT
// The printed Euler-angle model as truth: against the flight side's formula, and as a plant.
#include <gtest/gtest.h>

#include "gyrostat/truth/euler_plant.hpp"
#include "random.hpp"

namespace gyrostat::truth::test_euler_plant {
namespace {

PlantModel printed() {
  PlantModel model;
  model.J_B = Vec3<double>(200, 400, 300).asDiagonal();
  model.D_B = Mat3<double>::Identity();
  model.actuators = Actuators::ideal(3);
  model.orbit_rate = 0.1;
  model.integrator = Rk4{4};
  return model;
}

InitialState at(const Vec3<double>& angles, const Vec3<double>& rates) {
  InitialState s;
  s.euler = angles;
  s.omega_BN_B = rates;
  return s;
}

/// First row of the published model, term by term as it is printed; it is the one without misprints.
double printed_g1(const Vec3<double>& a, const Vec3<double>& v, double w0, double share) {
  const double sf = std::sin(a[0]), cf = std::cos(a[0]), st = std::sin(a[1]), ct = std::cos(a[1]);
  const double sp = std::sin(a[2]), cp = std::cos(a[2]);
  return w0 * v[2] * cp * ct - w0 * v[1] * sp * st +
         share * (v[1] * v[2] + w0 * v[1] * cf * st * sp + w0 * v[1] * sf * cp + w0 * v[2] * cf * cp -
                  w0 * v[2] * sf * st * sp + w0 * w0 * (cf * cp - sf * st * sp) * (cf * st * sp + sf * cp) -
                  3 * w0 * w0 * ct * ct * sf * cf);
}

TEST(EulerPlant, HasThePrintedFirstRow) {
  gyrostat::test::Random random(1);
  const PlantModel model = printed();
  const EulerBody body(model.J_B, 0.1);
  for (int k = 0; k < 100; ++k) {
    const Vec3<double> a = random.vector<double>(3), v = random.vector<double>(2);
    EXPECT_NEAR(body.acceleration(a, v)[0], printed_g1(a, v, 0.1, (400.0 - 300.0) / 200.0), 1e-14);
  }
}

TEST(EulerPlant, IsCyclicWithoutOrbit) {  // Euler's equations of the rates, axis by axis
  const PlantModel model = printed();
  const EulerBody body(model.J_B, 0);
  const Vec3<double> v(0.3, -0.2, 0.5), expected(0.5 * v[1] * v[2], 0.25 * v[2] * v[0], -2.0 / 3 * v[0] * v[1]);
  EXPECT_LT((body.acceleration({1, 2, 3}, v) - expected).norm(), 1e-15);
}

TEST(EulerPlant, FliesThroughPitch90WithConstantRateWhenNothingActs) {
  PlantModel model = printed();
  model.orbit_rate = 0;
  EulerPlant plant(model, at({0, 1.5, 0}, {0, 0.4, 0}), 0.01);
  for (int k = 0; k < 300; ++k) plant.advance(VecN<double>::Zero(3));
  EXPECT_NEAR(plant.euler().angles[1], 1.5 + 0.4 * 3, 1e-12);
  EXPECT_NEAR(plant.euler().rates[1], 0.4, 1e-15);
  EXPECT_EQ(plant.state().angles, plant.euler().angles);
}

TEST(EulerPlant, BothIntegratorsAgreeAndTheSampleSaysItsAcceleration) {
  PlantModel model = printed();
  model.disturbances = {PeriodicTorque{{Waveform(SineWave{.amplitude = 40, .omega = 1}), 0.0, 10.0}}};
  const InitialState start = at({-0.7, -0.07, 1.5}, {0.5, 1.3, -0.2});
  EulerPlant rk4(model, start, 0.01);
  model.integrator = Cvode{};
  EulerPlant cvode(model, start, 0.01);
  VecN<double> u(3);
  u << 20, -30, 10;
  Vec3<double> before = rk4.omega_BN_B();
  TruthSample middle;
  for (int k = 0; k < 500; ++k) {
    if (k == 499) before = rk4.omega_BN_B();
    rk4.advance(u);
    cvode.advance(u);
    if (k == 498) middle = rk4.sample();
  }
  // CVODE holds 1e-9 a step on a motion that doubles errors every few seconds.
  EXPECT_LT((rk4.euler().angles - cvode.euler().angles).norm(), 1e-6);
  // Mean acceleration over an interval against the trapezoid of its ends: second order in 10 ms.
  const Vec3<double> mean = (rk4.omega_BN_B() - before) / 0.01;
  EXPECT_LT((0.5 * (middle.omegadot_BN_B + rk4.sample().omegadot_BN_B) - mean).norm(), 1e-4);
}

TEST(EulerPlant, RefusesWheelsAndProductsOfInertia) {
  PlantModel model = printed();
  model.J_B(0, 1) = model.J_B(1, 0) = 1;
  EXPECT_THROW(EulerPlant(model, {}, 0.01), std::invalid_argument);
  model = printed();
  model.actuators.wheel_inertia[1] = 0.1;
  EXPECT_THROW(EulerPlant(model, {}, 0.01), std::invalid_argument);
}

TEST(RateSensorFaults, ScaleThenBiasThenFreezeInTheirWindows) {
  Sensors sensors({RateScale{0.02, 0.05, {2, 1, 1}}, RateBias{0.03, 0.05, {0, 0.1, 0}}, RateFreeze{0.06, 0.08}}, 1, 0,
                  false, 0.01);
  const Vec3<double> shown[] = {{0, 1, 2}, {1, 1, 2}, {4, 1, 2}, {6, 1.1, 2}, {8, 1.1, 2},
                                {5, 1, 2}, {5, 1, 2}, {5, 1, 2}, {8, 1, 2}};
  for (Tick k = 0; k < 9; ++k) {
    const Vec3<double> omega(static_cast<double>(k), 1, 2);
    EXPECT_EQ(sensors.measure(k, Quat<double>::Identity(), omega, {}).omega_BN_B, shown[k]) << k;
  }
}

TEST(RateSensorFaults, ActOnEulerRatesToo) {
  Sensors sensors({RateBias{0, 1, {0.1, 0, 0}}}, 1, 0, false, 0.01);
  const Measurement<double> y = EulerPlant(printed(), at({1, 2, 3}, {0.5, 0, 0}), 0.01).measure(sensors);
  EXPECT_EQ(y.omega_BN_B[0], 0.6);
  EXPECT_EQ(y.euler.rates, y.omega_BN_B);
  EXPECT_EQ(y.euler.angles, Vec3<double>(1, 2, 3));
}

TEST(RateSensorFaults, AreRefusedWithoutWindowOrPeriod) {
  EXPECT_THROW(Sensors({RateFreeze{2, 1}}, 1, 0, false, 0.01), std::invalid_argument);
  EXPECT_THROW(Sensors({RateFreeze{0, 1}}, 1, 0), std::invalid_argument);
}

}  // namespace
}  // namespace gyrostat::truth::test_euler_plant
