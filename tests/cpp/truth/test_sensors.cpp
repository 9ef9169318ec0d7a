// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <stdexcept>

#include "gyrostat/core/attitude.hpp"
#include "gyrostat/truth/noise.hpp"
#include "gyrostat/truth/sensors.hpp"

namespace gyrostat::truth {
namespace {

// Statistical bounds are 4.9 standard errors: a correct generator fails one with probability 1e-6. Seeds are fixed.
constexpr double significance = 4.9;
constexpr int samples = 20000;

const Quat<double> q_0 = quat_from_euler<double>({0.1, -0.2, 0.3});
const Vec3<double> omega_0{0.01, -0.02, 0.03};
const VecN<double> no_wheels;

std::vector<double> draw(const std::function<Vec3<double>(Tick)>& normals) {
  std::vector<double> x;
  for (Tick k = 0; k < samples; ++k) {
    for (const double z : normals(k)) x.push_back(z);
  }
  return x;
}

double mean_product(const std::vector<double>& a, const std::vector<double>& b) {
  double sum = 0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += a[i] * b[i];
  return sum / static_cast<double>(a.size());
}

void expect_standard_normal(const std::vector<double>& x) {
  const double n = static_cast<double>(x.size());
  double sum = 0, squares = 0, beyond = 0;
  for (const double z : x) {
    sum += z;
    squares += z * z;
    beyond += std::abs(z) > 1.959963984540054 ? 1 : 0;
  }
  EXPECT_LE(std::abs(sum / n), significance / std::sqrt(n));
  EXPECT_LE(std::abs(squares / n - 1), significance * std::sqrt(2 / n));
  EXPECT_LE(std::abs(beyond / n - 0.05), significance * std::sqrt(0.05 * 0.95 / n));
}

TEST(Sensors, NoiseIsStandardNormal) {
  expect_standard_normal(draw([](Tick k) { return standard_normals(7, 0, 1, k); }));
}

TEST(Sensors, StreamsRunsSeedsTicksAndAxesAreUncorrelated) {
  const std::vector<double> x = draw([](Tick k) { return standard_normals(7, 0, 1, k); });
  const double bound = significance / std::sqrt(static_cast<double>(x.size()));
  EXPECT_LE(std::abs(mean_product(x, draw([](Tick k) { return standard_normals(7, 0, 2, k); }))), bound);
  EXPECT_LE(std::abs(mean_product(x, draw([](Tick k) { return standard_normals(7, 1, 1, k); }))), bound);
  EXPECT_LE(std::abs(mean_product(x, draw([](Tick k) { return standard_normals(8, 0, 1, k); }))), bound);
  EXPECT_LE(std::abs(mean_product(x, draw([](Tick k) { return standard_normals(7, 0, 1, k + 1); }))), bound);
  const auto turned = [](Tick k) {
    const Vec3<double> z = standard_normals(7, 0, 1, k);
    return Vec3<double>(z[1], z[2], z[0]);
  };
  EXPECT_LE(std::abs(mean_product(x, draw(turned))), bound);
}

TEST(Sensors, PerfectOnesShowTheTruth) {
  Sensors sensors({}, 7, 0);
  const VecN<double> h_w = VecN<double>::Constant(4, 0.5);
  const Measurement<double> y = sensors.measure(3, q_0, omega_0, h_w);
  EXPECT_EQ(y.tick, 3u);
  EXPECT_EQ(y.q_NB.coeffs(), q_0.coeffs());
  EXPECT_EQ(y.omega_BN_B, omega_0);
  EXPECT_EQ(y.h_w, h_w);
  EXPECT_EQ(y.euler.angles, Vec3<double>::Zero());  // only when asked
}

TEST(Sensors, GyroNoiseHasItsSigmaAroundTheBiasedRate) {
  const Vec3<double> bias{1e-3, -2e-3, 0};
  Sensors sensors({Gyro{.noise = 1e-4, .bias = bias}}, 7, 0);
  expect_standard_normal(draw([&](Tick k) {
    return Vec3<double>((sensors.measure(k, q_0, omega_0, no_wheels).omega_BN_B - omega_0 - bias) / 1e-4);
  }));
}

TEST(Sensors, AttitudeNoiseIsARotationWithItsSigmaAnAxis) {
  Sensors sensors({AttitudeSensor{.noise = 1e-3}}, 7, 0);
  expect_standard_normal(draw([&](Tick k) {
    const Quat<double> q = sensors.measure(k, q_0, omega_0, no_wheels).q_NB;
    return Vec3<double>(quat_log<double>(q_0.conjugate() * q) / 1e-3);
  }));
}

TEST(Sensors, AreTheSameWhoeverElseDraws) {
  Sensors alone({Gyro{.noise = 1e-4}}, 7, 3), with_attitude({Gyro{.noise = 1e-4}, AttitudeSensor{.noise = 1e-3}}, 7, 3);
  for (Tick k = 0; k < 10; ++k) {
    EXPECT_EQ(alone.measure(k, q_0, omega_0, no_wheels).omega_BN_B,
              with_attitude.measure(k, q_0, omega_0, no_wheels).omega_BN_B);
  }
  Sensors later({Gyro{.noise = 1e-4}}, 7, 3);
  EXPECT_EQ(alone.measure(42, q_0, omega_0, no_wheels).omega_BN_B,
            later.measure(42, q_0, omega_0, no_wheels).omega_BN_B);
}

TEST(Sensors, DelayShowsOldValuesAndTheFirstUntilItHasFilled) {
  Sensors sensors({Gyro{.delay = 2}, AttitudeSensor{.delay = 1}}, 7, 0);
  for (Tick k = 0; k < 6; ++k) {
    const double now = static_cast<double>(k);
    const Measurement<double> y = sensors.measure(k, quat_exp<double>({0.1 * now, 0, 0}), {now, 0, 0}, no_wheels);
    EXPECT_EQ(y.omega_BN_B[0], std::max(0.0, now - 2)) << k;
    EXPECT_NEAR(quat_log(y.q_NB)[0], 0.1 * std::max(0.0, now - 1), 1e-15) << k;
  }
}

TEST(Sensors, QuantisationRoundsToItsSteps) {
  Sensors sensors({Gyro{.quantisation = 0.004}, AttitudeSensor{.quantisation = 0.01}}, 7, 0);
  const Measurement<double> y = sensors.measure(0, quat_exp<double>({0.033, 0, 0}), {0.0101, -0.0101, 0}, no_wheels);
  EXPECT_DOUBLE_EQ(y.omega_BN_B[0], 0.012);
  EXPECT_DOUBLE_EQ(y.omega_BN_B[1], -0.012);
  EXPECT_NEAR(quat_log(y.q_NB)[0], 0.03, 1e-5);  // 2 asin(0.015) less normalisation
  EXPECT_NEAR(y.q_NB.norm(), 1, 1e-15);
}

TEST(Sensors, TachometersShowWheelsWithNoiseStepsAndAge) {
  VecN<double> h(16);
  for (int i = 0; i < 16; ++i) h[i] = 0.1 * i;
  const auto shown = [&](const std::vector<Sensor>& sensors, Tick k, Mask wheels = Mask::all(16)) {
    return Sensors(sensors, 7, 0, false, 0.1, wheels).measure(k, q_0, omega_0, h).h_w;
  };
  EXPECT_EQ(shown({}, 3), h);
  EXPECT_EQ(shown({Tachometer{}}, 3), h);
  // Each wheel has deviates of its own, and none depends on the other sensors.
  for (const int first : {0, 6, 13}) {
    expect_standard_normal(draw(
        [&](Tick k) { return Vec3<double>((shown({Tachometer{.noise = 1e-3}}, k) - h).segment<3>(first) / 1e-3); }));
  }
  EXPECT_EQ(shown({Tachometer{.noise = 1e-3}}, 5), shown({Gyro{.noise = 1}, Tachometer{.noise = 1e-3}}, 5));
  const VecN<double> noisy = shown({Tachometer{.noise = 1e-3}}, 5);
  for (int i = 0; i < 16; ++i)
    for (int k = 0; k < i; ++k) EXPECT_NE(noisy[i] - h[i], noisy[k] - h[k]);
  Mask wheels;
  wheels.set(1);
  const VecN<double> one = shown({Tachometer{.noise = 1e-3, .quantisation = 0.03}}, 5, wheels);
  EXPECT_NEAR(one[1], 0.09, 1e-15) << "0.1 and a little, in steps of 0.03";
  for (int i = 0; i < 16; ++i) EXPECT_TRUE(i == 1 || one[i] == h[i]) << "no wheel, no tachometer";
  Sensors late({Tachometer{.delay = 2}}, 7, 0);
  for (Tick k = 0; k < 6; ++k) {
    const double now = static_cast<double>(k);
    EXPECT_EQ(late.measure(k, q_0, omega_0, VecN<double>::Constant(4, now)).h_w[3], std::max(0.0, now - 2));
  }
  EXPECT_THROW(Sensors({Tachometer{}, Tachometer{}}, 0, 0), std::invalid_argument);
  EXPECT_THROW(Sensors({Tachometer{.noise = -1}}, 0, 0), std::invalid_argument);
}

TEST(Sensors, FillEulerAnglesAndRatesOfWhatWasMeasured) {
  Sensors sensors({Gyro{.bias = {1e-3, 0, 0}}}, 7, 0, /*euler=*/true);
  const Measurement<double> y = sensors.measure(0, q_0, omega_0, no_wheels);
  EXPECT_LE((y.euler.angles - Vec3<double>(0.1, -0.2, 0.3)).norm(), 1e-15);
  EXPECT_LE((euler_rate_matrix(y.euler.angles) * y.euler.rates - y.omega_BN_B).norm(), 1e-16);
}

TEST(Sensors, AreSilentInTheirWindowsAndGoOnShowingWhatTheyShowedLast) {
  const std::vector<Sensor> windows{RateDropout{0.02, 0.04}, RateDropout{0.07, 0.08}, AttitudeDropout{0.03, 0.05},
                                    MomentumDropout{0.05, 0.07}, MomentumDropout{}};
  for (const bool forever : {false, true}) {
    Sensors sensors({windows.begin(), windows.end() - (forever ? 0 : 1)}, 7, 0, /*euler=*/true, 0.01);
    Measurement<double> before;
    for (Tick k = 0; k < 10; ++k) {
      const double now = 0.1 * static_cast<double>(k);
      const VecN<double> h_w = VecN<double>::Constant(4, now);
      const Quat<double> q = quat_from_euler<double>({0.1 + now, 0, 0});
      const Measurement<double> y = sensors.measure(k, q, {now, 0, 0}, h_w);
      EXPECT_EQ(y.rate_valid, !(k == 2 || k == 3 || k == 7)) << k;
      EXPECT_EQ(y.attitude_valid, !(k == 3 || k == 4)) << k;
      EXPECT_EQ(y.momentum_valid, !(forever || k == 5 || k == 6)) << k;
      const bool first = k == 0;  // nothing was shown before
      EXPECT_EQ(y.omega_BN_B[0], y.rate_valid || first ? now : before.omega_BN_B[0]) << k;
      EXPECT_EQ(y.euler.rates, y.rate_valid || first ? y.euler.rates : before.euler.rates) << k;
      EXPECT_EQ(y.q_NB.coeffs(), (y.attitude_valid || first ? q : before.q_NB).coeffs()) << k;
      EXPECT_EQ(y.h_w, y.momentum_valid || first ? h_w : before.h_w) << k;
      before = y;
    }
  }
  EXPECT_THROW(Sensors({RateDropout{2, 1}}, 1, 0, false, 0.01), std::invalid_argument);
}

TEST(Sensors, RefuseTwoOfAKindAndNegativeNumbers) {
  EXPECT_THROW(Sensors({Gyro{}, Gyro{}}, 0, 0), std::invalid_argument);
  EXPECT_THROW(Sensors({Gyro{.noise = -1}}, 0, 0), std::invalid_argument);
  EXPECT_THROW(Sensors({AttitudeSensor{.delay = -1}}, 0, 0), std::invalid_argument);
}

}  // namespace
}  // namespace gyrostat::truth
