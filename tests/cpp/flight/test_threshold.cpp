// SPDX-License-Identifier: MIT
// The threshold detector, sample by sample: what it declares, when, of whom, and where its probe goes.
#include <gtest/gtest.h>

#include <numbers>

#include "alone.hpp"
#include "gyrostat/flight/detectors/threshold.hpp"
#include "telemetry_log.hpp"
#include "vehicles.hpp"

namespace gyrostat::test::test_threshold {
namespace {

using Detector = ThresholdDetector<double>;

/// Two actuators an axis; the last one is a spare.
gyrostat::Setup<double> pairs() {
  Mat3N<double> D(3, 6);
  D << Mat3<double>::Identity(), Mat3<double>::Identity();
  gyrostat::Setup<double> setup = vehicle_with<double>(satellite_inertia<double>(), D, 0.2, 0.01);
  setup.vehicle.spare.set(5);
  return setup;
}

/// Persistence of two samples, hold-off of five, all of them watched from 0.02 N m on.
Detector::Params quick() {
  Detector::Params p(pairs());
  p.unwatched = {};
  p.persistence = 0.02;
  p.hold_off = 0.05;
  p.settle = 0;
  p.u_gate = 0.02;
  return p;
}

Allocation<double> pushing(std::initializer_list<double> u) {
  Allocation<double> a = Allocation<double>::idle(static_cast<int>(u.size()));
  Eigen::Index i = 0;
  for (const double x : u) a.u[i++] = x;
  return a;
}

const Allocation<double> all_push = pushing({0.1, -0.1, 0.1, 0.1, 0.1, 0.1});

Estimate<double> estimate(std::initializer_list<double> e) {
  Measurement<double> y;
  y.h_w = VecN<double>::Zero(static_cast<Eigen::Index>(e.size()));
  Estimate<double> x = Estimate<double>::healthy(y);
  Eigen::Index i = 0;
  for (const double v : e) x.effectiveness[i++] = v;
  return x;
}

const Estimate<double> healthy = estimate({1, 1, 1, 1, 1, 1});

/// Samples until the next declaration, at most 200.
int samples_to_next(Alone<Detector>& detector, const Estimate<double>& x, Detection<double>& det) {
  const std::uint32_t before = det.event;
  for (int k = 1; k <= 200; ++k) {
    det = detector.step(x, all_push);
    if (det.event != before) return k;
  }
  return 0;
}

TEST(Threshold, DeclaresEachActuatorOnceAndRemembersThemAll) {
  Alone<Detector> detector(unchecked, pairs(), quick());
  Detection<double> det = detector.start(healthy);
  EXPECT_EQ(det.enabled.bits(), 0b011111) << "the spare is off";
  EXPECT_EQ(samples_to_next(detector, estimate({0.7, 1, 1, 1, 1, 1}), det), 2);
  EXPECT_EQ(det.changed.bits(), 0b000001);
  EXPECT_EQ(det.enabled, Mask::all(6)) << "the spare is on";
  EXPECT_EQ(samples_to_next(detector, estimate({0.7, 1, 0.7, 0.7, 1, 1}), det), 2);
  EXPECT_EQ(det.changed.bits(), 0b001101);
  EXPECT_EQ(det.event, 2u) << "two actuators at one sample are one declaration";
  EXPECT_EQ(samples_to_next(detector, estimate({0.7, 1, 0.7, 0.7, 1, 1}), det), 0);
  EXPECT_FALSE(det.failed.any());
}

TEST(Threshold, GettingBetterIsAChangeToo) {
  Alone<Detector> detector(unchecked, pairs(), quick());
  Detection<double> det = detector.start(healthy);
  EXPECT_EQ(samples_to_next(detector, estimate({0.5, 1, 1, 1, 1, 1}), det), 2);
  EXPECT_EQ(samples_to_next(detector, healthy, det), 5 + 2) << "after the hold-off";
  EXPECT_EQ(samples_to_next(detector, healthy, det), 0);
}

TEST(Threshold, OnlyAnEffectivenessBelowTheLimitCountsAsFailed) {
  for (const double e : {0.0599, 0.0601, 0.5}) {
    Alone<Detector> detector(unchecked, pairs(), quick());
    Detection<double> det = detector.start(healthy);
    EXPECT_EQ(samples_to_next(detector, estimate({1, 1, 1, 1, e, 1}), det), 2);
    EXPECT_EQ(det.failed.bits(), e < 0.06 ? 0b010000 : 0) << e;
    EXPECT_EQ(det.changed.bits(), 0b010000) << e;
  }
}

TEST(Threshold, AnActuatorThatIsNotWatchedIsNeverDeclaredNorBlamedForATorque) {
  Detector::Params p = quick();
  p.unwatched.set(1);
  Alone<Detector> detector(unchecked, pairs(), p);
  Detection<double> det = detector.start(healthy);
  EXPECT_EQ(samples_to_next(detector, estimate({1, 0.1, 1, 1, 1, 1}), det), 0);
  Estimate<double> torque = healthy;
  torque.d_B = {0, -0.05, 0};  // all of it reads as a loss of half of actuator 4, the other one of that axis
  EXPECT_EQ(samples_to_next(detector, torque, det), 2);
  EXPECT_EQ(det.changed.bits(), 0b010000);
  const std::vector<double> seen = telemetry_of(detector).at("effectiveness");
  EXPECT_EQ(seen[1], 1.0);
  EXPECT_NEAR(seen[4], 0.5, 1e-6);  // but for the regularisation, (2e-5 / 0.1)^2
}

TEST(Threshold, ALumpedTorqueIsMappedOnlyWhereThatIsAskedFor) {
  Detector::Params p = quick();
  p.use_torque = false;
  Alone<Detector> detector(unchecked, pairs(), p);
  Detection<double> det = detector.start(healthy);
  Estimate<double> x = healthy;
  x.d_B = {-0.15, 0, 0};
  EXPECT_EQ(samples_to_next(detector, x, det), 0);
}

TEST(Threshold, HoldOffAndPersistenceAreCountedToTheSample) {
  Detector::Params p = quick();
  p.persistence = 0.29;  // 0.29 / 0.01 is below 29 in binary
  p.hold_off = 0.57;
  Alone<Detector> detector(unchecked, pairs(), p);
  Detection<double> det = detector.start(healthy);
  EXPECT_EQ(samples_to_next(detector, estimate({0.7, 1, 1, 1, 1, 1}), det), 29);
  EXPECT_EQ(samples_to_next(detector, estimate({0.4, 1, 1, 1, 1, 1}), det), 57 + 29);
}

TEST(Threshold, TheReferenceFollowsAnEstimateThatStillSettlesAndNoLonger) {
  for (const int late : {2, 3}) {  // the sample of the hold-off at which the estimate arrives
    Detector::Params p = quick();
    p.settle = 0.02;
    Alone<Detector> detector(unchecked, pairs(), p);
    Detection<double> det = detector.start(healthy);
    ASSERT_EQ(samples_to_next(detector, estimate({0.7, 1, 1, 1, 1, 1}), det), 2);
    for (int k = 1; k < late; ++k) det = detector.step(estimate({0.7, 1, 1, 1, 1, 1}), all_push);
    const int found = samples_to_next(detector, estimate({0.4, 1, 1, 1, 1, 1}), det);
    EXPECT_EQ(found, late == 2 ? 0 : 3 + 2) << "within settle: the same change; after it: another one";
  }
}

TEST(Threshold, AGapOfOneSampleBeginsThePersistenceAnew) {
  Detector::Params p = quick();
  p.persistence = 0.03;
  Alone<Detector> detector(unchecked, pairs(), p);
  const Estimate<double> weak = estimate({1, 1, 1, 0.5, 1, 1});
  Detection<double> det = detector.start(healthy);
  for (int k = 0; k < 60; ++k) det = detector.step(k % 3 == 2 ? healthy : weak, all_push);
  EXPECT_EQ(det.event, 0u);
  EXPECT_EQ(samples_to_next(detector, weak, det), 3);
}

TEST(Threshold, TheProbeIsASineThatVisitsTheActuatorsInTurn) {
  Detector::Params p = quick();
  p.dither = 0.1;
  p.dither_period = 0.12;
  Alone<Detector> detector(unchecked, pairs(), p);
  Detection<double> det = detector.start(healthy);
  EXPECT_EQ(det.enabled, Mask::all(6)) << "a probe takes all of the redundancy";
  for (int restart = 0; restart < 2; ++restart) {
    for (int k = 0; k < 6 * 12 + 5; ++k) {
      const int actuator = k / 12 % 6, partner = (actuator + 3) % 6;
      VecN<double> expected = VecN<double>::Zero(6);
      expected[actuator] = 0.1 * std::sin(2 * std::numbers::pi * (k % 12) / 12);
      expected[partner] = -expected[actuator];
      EXPECT_LT((det.u_probe - expected).cwiseAbs().maxCoeff(), 1e-15) << k;
      det = detector.step(healthy, all_push);
    }
    det = detector.start(healthy);
  }
}

TEST(ThresholdCheck, RefusesAProbeThatFillsTheLimitsOrIsTooFast) {
  const gyrostat::Setup<double> setup = pairs();
  Detector::Params p(setup);
  EXPECT_EQ(p.unwatched, setup.vehicle.spare);
  EXPECT_TRUE(Detector::check(setup, p).ok());
  p.settle = p.hold_off * 1.01;
  EXPECT_EQ(std::string(Detector::check(setup, p).quantity), "settle");
  p = Detector::Params(setup);
  p.dither = 0.2;
  EXPECT_EQ(std::string(Detector::check(setup, p).quantity), "dither");
  p.dither = 0.199;
  EXPECT_TRUE(Detector::check(setup, p).ok());
  p.dither_period = 0.039;
  EXPECT_EQ(std::string(Detector::check(setup, p).quantity), "dither_period");
  p.dither_period = 0.041;
  EXPECT_TRUE(Detector::check(setup, p).ok());
}

}  // namespace
}  // namespace gyrostat::test::test_threshold
