// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <stdexcept>
#include <string>
#include <vector>

#include "gyrostat/core/attitude.hpp"
#include "gyrostat/truth/noise.hpp"
#include "gyrostat/truth/sensors.hpp"

namespace gyrostat::truth::test_sensors {
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

TEST(Sensors, NoiseOfAVersionIsThatOfItsCounterSecondBySecond) {
  const auto noise = [](std::uint64_t run, std::vector<double> versions, Tick k) -> Vec3<double> {
    Sensors sensors({Gyro{.noise = 1}}, 7, run, false, 0.5, Mask::all(max_actuators), {}, std::move(versions));
    return sensors.measure(k, q_0, Vec3<double>::Zero(), no_wheels).omega_BN_B;
  };
  for (const Tick k : {0u, 1u, 2u, 3u}) {  // two samples a second
    EXPECT_EQ(noise(3, {5, 0}, k), k < 2 ? standard_normals(7, 0, 1, k, 5) : standard_normals(7, 3, 1, k));
    EXPECT_EQ(noise(3, {5, 6}, k), noise(4, {5, 6}, k));
    EXPECT_NE(noise(3, {5, 6}, k), noise(3, {6, 5}, k));
  }
  EXPECT_EQ(noise(3, {5, 6}, 4), standard_normals(7, 3, 1, 4));  // after the last: the run's own
  EXPECT_THROW(noise(3, {1.5}, 0), std::invalid_argument);
  EXPECT_THROW(Sensors({}, 7, 0, false, 0, Mask::all(max_actuators), {}, {1}), std::invalid_argument);
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

TEST(Sensors, DelayShowsOldValuesAndNothingIsMeasuredUntilItHasFilled) {
  Sensors sensors({Gyro{.delay = 2}, AttitudeSensor{.delay = 1}}, 7, 0);
  for (Tick k = 0; k < 6; ++k) {
    const double now = static_cast<double>(k);
    const Measurement<double> y = sensors.measure(k, quat_exp<double>({0.1 * now, 0, 0}), {now, 0, 0}, no_wheels);
    EXPECT_EQ(y.omega_BN_B[0], std::max(0.0, now - 2)) << k;
    EXPECT_NEAR(quat_log(y.q_NB)[0], 0.1 * std::max(0.0, now - 1), 1e-15) << k;
    EXPECT_EQ(y.rate_valid, k >= 2) << k;
    EXPECT_EQ(y.attitude_valid, k >= 1) << k;
  }
  Sensors slower({Gyro{.delay = 3, .every = 2}}, 7, 0);
  for (Tick k = 0; k < 8; ++k)
    EXPECT_EQ(slower.measure(k, q_0, omega_0, no_wheels).rate_valid, k >= 3 && k % 2 == 0) << k;
  Sensors angles({AttitudeSensor{.delay = 2}}, 7, 0, /*euler=*/true);
  for (Tick k = 0; k < 4; ++k) {
    Measurement<double> y;
    y.tick = k;
    y.h_w = no_wheels;
    (void)angles.rate(k, omega_0);
    (void)angles.angles(k, {0, 0, 0});
    angles.drop_out(y);
    EXPECT_EQ(y.attitude_valid, k >= 2) << "of a plant of angles";
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

// What a sensor shows, tick after tick, of a body that turns with `omega(t)` about x, at 100 Hz.
struct Shown {
  std::vector<Measurement<double>> y;
  std::vector<Quat<double>> q;
  std::vector<Vec3<double>> omega;
};

Shown watch(const std::vector<Sensor>& which, int ticks, const std::function<Vec3<double>(double)>& rate,
            std::uint64_t run = 0) {
  Sensors sensors(which, 7, run, false, 0.01);
  Shown out;
  Quat<double> q = q_0;
  for (int k = 0; k < ticks; ++k) {
    const double t = 0.01 * k;
    out.q.push_back(q);
    out.omega.push_back(rate(t));
    out.y.push_back(sensors.measure(static_cast<Tick>(k), q, rate(t), no_wheels));
    q = (q * quat_exp<double>(0.01 * rate(t))).normalized();
  }
  return out;
}

Vec3<double> turning(double t) { return {0.02 * std::sin(t), -0.01, 0.03 * std::cos(2 * t)}; }

TEST(Gyro, ShowsScaleMisalignmentBiasRangeAndSteps) {
  Mat3<double> crossed = Mat3<double>::Zero();
  crossed(0, 1) = 1e-3;
  crossed(2, 0) = -2e-3;
  const Gyro gyro{.bias = {1e-4, 0, 0}, .scale_factor = {1e-2, 0, -1e-2}, .misalignment = crossed};
  const Vec3<double> y = Sensors({gyro}, 7, 0, false, 0.01).measure(0, q_0, {0.1, 0.2, 0.3}, no_wheels).omega_BN_B;
  EXPECT_LE((y - Vec3<double>(0.1 * 1.01 + 0.2e-3 + 1e-4, 0.2, 0.3 * 0.99 - 0.2e-3)).norm(), 1e-16);
  Sensors narrow({Gyro{.bias = {0.05, 0, 0}, .quantisation = 0.04, .range = 0.25}}, 7, 0);
  const Measurement<double> clipped = narrow.measure(0, q_0, {0.21, -0.1, 0.3}, no_wheels);
  EXPECT_LE((clipped.omega_BN_B - Vec3<double>(0.24, -0.12, 0.24)).norm(), 1e-15) << "clipped, then in steps";
  EXPECT_FALSE(clipped.rate_valid);
  EXPECT_TRUE(clipped.attitude_valid);
  EXPECT_TRUE(narrow.measure(1, q_0, {0.19, -0.24, 0.2}, no_wheels).rate_valid);
}

TEST(Gyro, HasNewRatesAtItsTicksOutsideItsDropouts) {
  const Shown s = watch({Gyro{.every = 4, .phase = 2, .dropouts = {{0.30, 0.40}, {0.10, 0.15}}}}, 60, turning);
  for (std::size_t k = 0; k < 60; ++k) {
    const bool fresh = k >= 2 && (k - 2) % 4 == 0 && !(k >= 10 && k < 15) && !(k >= 30 && k < 40);
    EXPECT_EQ(s.y[k].rate_valid, fresh) << k;
    EXPECT_TRUE(s.y[k].attitude_valid);
    EXPECT_EQ(s.y[k].omega_BN_B, fresh || k == 0 ? s.omega[k] : s.y[k - 1].omega_BN_B) << k;
  }
}

TEST(Gyro, AngleRandomWalkIsNoiseOfItsSamples) {
  // 1e-4 rad/sqrt(s) in samples of 0.04 s: 5e-4 rad/s.
  Sensors sensors({Gyro{.angle_random_walk = 1e-4, .every = 4}}, 7, 0, false, 0.01);
  expect_standard_normal(draw([&](Tick k) {
    Vec3<double> shown;
    for (Tick j = 0; j < 4; ++j) {
      const Vec3<double> y = sensors.measure(4 * k + j, q_0, omega_0, no_wheels).omega_BN_B;
      if (j == 0) shown = y;
    }
    return Vec3<double>((shown - omega_0) / 5e-4);
  }));
}

TEST(Gyro, BiasWalksEachTickWhateverTheSampleRate) {
  // Increments a tick of s_u sqrt(dt) = 1e-4; over n ticks their sum has sqrt(n) of that.
  const auto walked = [](int every) {
    Sensors sensors({Gyro{.rate_random_walk = 1e-3, .every = every}}, 7, 0, false, 0.01);
    std::vector<Vec3<double>> out;
    for (int k = 0; k < samples; ++k)
      out.push_back(sensors.measure(static_cast<Tick>(k), q_0, omega_0, no_wheels).omega_BN_B - omega_0);
    return out;
  };
  const std::vector<Vec3<double>> one = walked(1), ten = walked(10);
  EXPECT_LE(one[0].norm(), 1e-17) << "the bias at the start is the given one";
  std::vector<double> increments;
  for (std::size_t k = 1; k < one.size(); ++k)
    for (int i = 0; i < 3; ++i) increments.push_back((one[k][i] - one[k - 1][i]) / 1e-4);
  expect_standard_normal(increments);
  for (std::size_t k = 0; k < one.size(); k += 10) EXPECT_EQ(one[k], ten[k]);
  // Own stream: the noise of a sample is what it was.
  Sensors noisy({Gyro{.noise = 1e-4}}, 7, 0, false, 0.01),
      both({Gyro{.noise = 1e-4, .rate_random_walk = 1e-3}}, 7, 0, false, 0.01);
  for (Tick k = 0; k < 50; ++k) {
    const Vec3<double> more =
        both.measure(k, q_0, omega_0, no_wheels).omega_BN_B - noisy.measure(k, q_0, omega_0, no_wheels).omega_BN_B;
    EXPECT_LE((more - one[k]).norm(), 1e-16);
  }
}

TEST(StarTracker, NoiseIsGivenInItsOwnAxes) {
  const Quat<double> q_BS = quat_from_euler<double>({0.4, -1.1, 2.0});
  const Vec3<double> sigma{1e-3, 2e-3, 2e-2};
  Sensors sensors({StarTracker{.noise = sigma, .q_BS = q_BS}}, 7, 0, false, 0.01);
  expect_standard_normal(draw([&](Tick k) {
    const Quat<double> q = sensors.measure(k, q_0, omega_0, no_wheels).q_NB;
    const Vec3<double> error_S = q_BS.conjugate() * quat_log<double>(q_0.conjugate() * q);
    return Vec3<double>(error_S.cwiseQuotient(sigma));
  }));
}

TEST(StarTracker, ShowsWhatWasWhenTheStarsWereSeen) {
  const StarTracker tracker{.latency = 7, .every = 5, .phase = 3, .blind = {{0.30, 0.40}}, .rate_max = 0.0305};
  const Shown s = watch({tracker}, 200, turning);
  int fixes = 0;
  for (std::size_t k = 0; k < 200; ++k) {
    const bool scheduled = k >= 3 && (k - 3) % 5 == 0;
    const bool fix = scheduled && k >= 7 && !(k - 7 >= 30 && k - 7 < 40) && s.omega[k - 7].norm() <= 0.0305;
    fixes += fix ? 1 : 0;
    EXPECT_EQ(s.y[k].attitude_valid, fix) << k;
    EXPECT_TRUE(s.y[k].rate_valid);
    if (fix) {
      EXPECT_LE(rotation_angle<double>(s.q[k - 7].conjugate() * s.y[k].q_NB), 1e-15) << k;
    } else if (k > 0) {
      EXPECT_EQ(s.y[k].q_NB.coeffs(), s.y[k - 1].q_NB.coeffs()) << k;
    }
  }
  EXPECT_GT(fixes, 15);
  EXPECT_LT(fixes, 36) << "of 39 that are scheduled: two when it was blind, others when the body turned too fast";
}

TEST(StarTracker, OutliersAreValidFarOffAndAsFrequentAsAsked) {
  Sensors sensors({StarTracker{.outlier_probability = 0.05, .outlier_angle = 0.3, .flip_sign = true}}, 7, 0, false,
                  0.01);
  const double n = samples;
  double outliers = 0, flipped = 0;
  Vec3<double> axes = Vec3<double>::Zero(), squares = Vec3<double>::Zero();
  for (Tick k = 0; k < samples; ++k) {
    const Measurement<double> y = sensors.measure(k, q_0, omega_0, no_wheels);
    EXPECT_TRUE(y.attitude_valid);
    flipped += y.q_NB.dot(q_0) < 0 ? 1 : 0;
    const Vec3<double> turn = quat_log<double>(q_0.conjugate() * y.q_NB);
    if (turn.norm() < 1e-12) continue;
    EXPECT_NEAR(turn.norm(), 0.3, 1e-12);
    ++outliers;
    axes += turn / 0.3;
    squares += (turn / 0.3).cwiseAbs2();
  }
  EXPECT_LE(std::abs(outliers / n - 0.05), significance * std::sqrt(0.05 * 0.95 / n));
  EXPECT_LE(std::abs(flipped / n - 0.5), significance * std::sqrt(0.25 / n));
  for (int i = 0; i < 3;
       ++i) {  // a direction uniform on the sphere: mean 0, mean square 1/3, variance of a square 4/45
    EXPECT_LE(std::abs(axes[i] / outliers), significance * std::sqrt(1 / (3 * outliers)));
    EXPECT_LE(std::abs(squares[i] / outliers - 1.0 / 3), significance * std::sqrt(4 / (45 * outliers)));
  }
}

TEST(StarTracker, HasDeviatesOfItsOwn) {
  const auto x = [](Sensor sensor) {
    return draw([s = Sensors({sensor}, 7, 0, false, 0.01)](Tick k) mutable {
      return Vec3<double>(quat_log<double>(q_0.conjugate() * s.measure(k, q_0, omega_0, no_wheels).q_NB) / 1e-3);
    });
  };
  const std::vector<double> tracker = x(StarTracker{.noise = {1e-3, 1e-3, 1e-3}}),
                            old = x(AttitudeSensor{.noise = 1e-3});
  EXPECT_LE(std::abs(mean_product(tracker, old)), significance / std::sqrt(static_cast<double>(old.size())));
}

TEST(Sensors, RefuseInOneLineWhatCannotBe) {
  const auto refusal = [](const std::vector<Sensor>& sensors, double dt = 0.01) -> std::string {
    try {
      Sensors(sensors, 7, 0, false, dt);
    } catch (const std::invalid_argument& error) {
      return error.what();
    }
    return "accepted";
  };
  const auto expect = [&](const std::string& part, const std::vector<Sensor>& sensors, double dt = 0.01) {
    const std::string what = refusal(sensors, dt);
    EXPECT_NE(what.find(part), std::string::npos) << what;
    EXPECT_EQ(what.find('\n'), std::string::npos);
  };
  expect("gyro: give one of noise and angle_random_walk", {Gyro{.noise = 1e-5, .angle_random_walk = 1e-6}});
  expect("gyro: every must be at least 1", {Gyro{.every = 0}});
  expect("star_tracker: every must be at least 1", {StarTracker{.every = 0}});
  expect("gyro: misalignment has a diagonal", {Gyro{.misalignment = Mat3<double>::Identity()}});
  expect("gyro: dropouts: t_off must be after t_on", {Gyro{.dropouts = {{2, 2}}}});
  expect("gyro: dropouts: windows overlap", {Gyro{.dropouts = {{5, 8}, {1, 5.5}}}});
  expect("star_tracker: blind: a row has 3 numbers", {StarTracker{.blind = {{1, 2, 3}}}});
  expect("star_tracker: blind: t_off must be after t_on", {StarTracker{.blind = {{3, 1}}}});
  expect("gyro: needs the sample period", {Gyro{.angle_random_walk = 1e-6}}, 0);
  expect("star_tracker: needs the sample period", {StarTracker{.blind = {{1, 2}}}}, 0);
  expect("outlier_probability needs an outlier_angle", {StarTracker{.outlier_probability = 0.1}});
  expect("one attitude sensor (attitude or star_tracker)", {StarTracker{}, AttitudeSensor{}});
  expect("accepted", {Gyro{.dropouts = {{5, 8}, {1, 5}}}, StarTracker{}});
}

TEST(Sensors, RefuseTwoOfAKindAndNegativeNumbers) {
  EXPECT_THROW(Sensors({Gyro{}, Gyro{}}, 0, 0), std::invalid_argument);
  EXPECT_THROW(Sensors({Gyro{.noise = -1}}, 0, 0), std::invalid_argument);
  EXPECT_THROW(Sensors({AttitudeSensor{.delay = -1}}, 0, 0), std::invalid_argument);
}

}  // namespace
}  // namespace gyrostat::truth::test_sensors
