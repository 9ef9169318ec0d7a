// SPDX-License-Identifier: MIT
// The evidence detector: what it says of wheels whose momentum is made here, by h' = -delivered and nothing else.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <numbers>
#include <random>

#include "alone.hpp"
#include "gyrostat/flight/detectors/evidence.hpp"
#include "telemetry_log.hpp"
#include "vehicles.hpp"

namespace gyrostat::test::test_evidence {
namespace {

template <class S>
Setup<S> wheels(S dt = S(0.1)) {
  gyrostat::Setup<S> setup = ftc_4rw<S>();
  setup.vehicle.wheels = Mask::all(4);
  setup.dt = dt;
  return setup;
}

/// A few wheels, their commands and what they deliver, seen through tachometers.
template <class S>
class Bench {
 public:
  using Detector = EvidenceDetector<S>;
  using Law = std::function<S(int actuator, S t, S u)>;  ///< of the command to what is delivered, N m

  explicit Bench(const Setup<S>& setup) : Bench(setup, typename Detector::Params(setup)) {}
  Bench(const Setup<S>& setup, const typename Detector::Params& params)
      : setup_(setup), detector_(unchecked, setup, params), h(VecN<S>::Zero(setup.vehicle.actuators())) {
    det = detector_.start(estimate());
  }

  /// Slow and out of phase, 0.06 N m about a mean of 0.02 N m.
  static S command(int i, S t) {
    return S(0.02) + S(0.06) * std::sin(S(0.3) * t * (S(1) + S(0.1) * static_cast<S>(i)) + static_cast<S>(i));
  }

  void fly(S seconds, const Law& law) {
    const auto samples = static_cast<long>(std::round(seconds / setup_.dt));
    for (long k = 0; k < samples; ++k) {
      const S t = static_cast<S>(++tick_) * setup_.dt;
      Allocation<S> last = Allocation<S>::idle(setup_.vehicle.actuators());
      for (int i = 0; i < last.u.size(); ++i) {
        last.u[i] = det.failed.test(i) ? S(0) : commands(i, t);
        h[i] -= setup_.dt * law(i, t, last.u[i]);
        if (limit > S(0)) h[i] = std::clamp(h[i], -limit, limit);
      }
      const std::uint32_t before = det.event;
      det = detector_.step(estimate(), last);
      if (det.event != before && first_event < S(0)) first_event = t;
    }
  }

  FaultClass fault(int i) const { return det.classes[static_cast<std::size_t>(i)]; }
  S time() const { return static_cast<S>(tick_) * setup_.dt; }

 private:
  Estimate<S> estimate() {
    Measurement<S> y;
    y.tick = tick_;
    y.h_w = h;
    for (auto& x : y.h_w) {
      x += noise * static_cast<S>(normal_(random_));
      if (step > S(0)) x = step * std::round(x / step);
    }
    Estimate<S> x = Estimate<S>::healthy(y);
    x.momentum_valid = measured;
    return x;
  }

  Setup<S> setup_;
  Alone<Detector> detector_;
  std::mt19937 random_{1};
  std::normal_distribution<double> normal_;
  Tick tick_ = 0;

 public:
  VecN<S> h;
  Detection<S> det;
  S noise = S(0), step = S(0), limit = S(0);  ///< N m s
  bool measured = true;
  S first_event = S(-1);
  std::function<S(int, S)> commands = command;
  const Detector& detector() const { return detector_; }
};

template <class S>
S as_told(int, S, S u) {
  return u;
}

template <class S>
class Evidence : public testing::Test {};
using Scalars = testing::Types<double, float>;
TYPED_TEST_SUITE(Evidence, Scalars);

TYPED_TEST(Evidence, TellsEveryClassOfFaultByItsWheelAlone) {
  using S = TypeParam;
  struct Case {
    FaultClass fault;
    S gain, bias;
    typename Bench<S>::Law law;
  };
  const Case cases[] = {
      {FaultClass::gain, S(0.4), S(0), [](int, S, S u) { return S(0.4) * u; }},
      {FaultClass::additive, S(1), S(0.03), [](int, S, S u) { return u + S(0.03); }},
      {FaultClass::stuck, S(0), S(-0.07), [](int, S, S) { return S(-0.07); }},
      {FaultClass::stuck, S(0), S(0), [](int, S, S) { return S(0); }},
  };
  for (const S dt : {S(0.1), S(0.01), S(0.001)}) {
    for (const Case& c : cases) {
      Bench<S> bench(wheels<S>(dt));
      bench.fly(S(10), as_told<S>);
      ASSERT_EQ(bench.det.event, 0u);
      bench.fly(S(5), [&](int i, S t, S u) { return i == 2 ? c.law(i, t, u) : u; });
      EXPECT_EQ(bench.det.changed.bits(), 0b0100) << dt;
      EXPECT_EQ(bench.det.event, 1u);
      EXPECT_LT(bench.first_event, S(12.5)) << dt;
      EXPECT_EQ(bench.fault(2), c.fault) << "dt " << dt << " bias " << c.bias;
      EXPECT_NEAR(bench.det.gain[2], c.gain, 0.02);
      EXPECT_NEAR(bench.det.bias[2], c.bias, 0.002);
      for (const int other : {0, 1, 3}) {
        EXPECT_EQ(bench.fault(other), FaultClass::healthy);
        EXPECT_EQ(bench.det.gain[other], S(1));
        EXPECT_EQ(bench.det.bias[other], S(0));
      }
    }
  }
}

TYPED_TEST(Evidence, AWeakWheelWhoseCommandHardlyMovesIsNeverStuck) {
  using S = TypeParam;
  for (int onset = 0; onset < 8; ++onset) {  // anywhere in a block
    Bench<S> bench(wheels<S>(S(0.05)));
    std::mt19937 random(static_cast<unsigned>(onset));
    std::normal_distribution<double> normal;
    const S from = S(10) + S(0.05) * static_cast<S>(onset);
    bench.commands = [&](int, S t) {  // jumps to where it makes up for the loss, and stays near
      return (t < from ? S(-0.022) : S(-0.035)) + S(0.0015) * static_cast<S>(normal(random));
    };
    for (int k = 0; k < 600; ++k) {
      bench.fly(S(0.05), [&](int i, S t, S u) { return i == 2 && t >= from ? S(0.55) * u : u; });
      ASSERT_NE(bench.fault(2), FaultClass::stuck) << bench.time();
    }
    EXPECT_EQ(bench.det.changed.bits(), 0b0100);
    EXPECT_FALSE(bench.det.failed.any());
  }
}

TYPED_TEST(Evidence, AFaultThatComesAndGoesIsIntermittentOnceItHasRecoveredTwice) {
  using S = TypeParam;
  Bench<S> bench(wheels<S>());
  bench.fly(S(10), as_told<S>);
  int recoveries = 0;
  for (int turn = 0; turn < 3; ++turn) {
    bench.fly(S(5), [](int i, S, S u) { return i == 1 ? S(0.1) * u : u; });
    EXPECT_TRUE(bench.det.changed.test(1)) << turn;
    if (turn == 2) break;
    const std::uint32_t before = bench.det.event;
    bench.fly(S(40), as_told<S>);
    recoveries += bench.det.event == before + 1 ? 1 : 0;
    EXPECT_FALSE(bench.det.changed.any()) << turn;
    EXPECT_EQ(bench.fault(1), FaultClass::healthy);
    EXPECT_EQ(bench.det.gain[1], S(1));
  }
  EXPECT_EQ(recoveries, 2);
  EXPECT_EQ(bench.fault(1), FaultClass::intermittent);
}

TYPED_TEST(Evidence, WheelsThatChangePlacesChangeTheirVerdicts) {
  using S = TypeParam;
  const int order[] = {2, 0, 3, 1};  // where each wheel goes
  const gyrostat::Setup<S> setup = wheels<S>();
  gyrostat::Setup<S> permuted = setup;
  for (int i = 0; i < 4; ++i) permuted.vehicle.D_B.col(order[i]) = setup.vehicle.D_B.col(i);
  Bench<S> bench(setup), other(permuted);
  const typename Bench<S>::Law law = [](int i, S t, S u) {
    if (i == 1 && t > S(8)) return S(0.3) * u;
    if (i == 3 && t > S(12)) return S(0.09);
    return u;
  };
  int back[4];
  for (int i = 0; i < 4; ++i) back[order[i]] = i;
  other.commands = [&](int i, S t) { return Bench<S>::command(back[i], t); };
  bench.fly(S(60), law);
  other.fly(S(60), [&](int i, S t, S u) { return law(back[i], t, u); });
  EXPECT_EQ(bench.det.changed.bits(), 0b1010);
  EXPECT_EQ(bench.det.event, other.det.event);
  for (int i = 0; i < 4; ++i) {
    EXPECT_EQ(bench.det.changed.test(i), other.det.changed.test(order[i]));
    EXPECT_EQ(bench.det.failed.test(i), other.det.failed.test(order[i]));
    EXPECT_EQ(bench.fault(i), other.fault(order[i]));
    EXPECT_EQ(bench.det.gain[i], other.det.gain[order[i]]);
    EXPECT_EQ(bench.det.bias[i], other.det.bias[order[i]]);
  }
}

/// Stuck wheels that are commanded both ways.
template <class S>
Detection<S> with_stuck(const Setup<S>& setup, Mask stuck, S torque, S seconds = S(60), bool drop = true) {
  typename EvidenceDetector<S>::Params p(setup);
  p.drop = drop;
  p.retry = S(1000);
  Bench<S> bench(setup, p);
  bench.commands = [](int i, S t) { return S(0.15) * std::sin(S(0.4) * t + static_cast<S>(i)); };
  bench.fly(S(10), as_told<S>);
  bench.fly(seconds, [&](int i, S, S u) { return stuck.test(i) ? torque : u; });
  for (int i = 0; i < setup.vehicle.actuators(); ++i) EXPECT_TRUE(bench.det.changed.test(i) || !stuck.test(i)) << i;
  return bench.det;
}

Mask of(std::initializer_list<int> members) {
  Mask mask;
  for (const int i : members) mask.set(i);
  return mask;
}

TYPED_TEST(Evidence, DropsAStuckWheelWhereTheOthersSufficeAndOnlyWhenAskedTo) {
  using S = TypeParam;
  const gyrostat::Setup<S> setup = wheels<S>();
  EXPECT_EQ(with_stuck(setup, of({2}), S(-0.05)).failed.bits(), 0b0100);
  EXPECT_EQ(with_stuck(setup, of({2}), S(-0.05), S(60), false).failed.bits(), 0);
  EXPECT_EQ(with_stuck(setup, of({2}), S(-0.05), S(4)).failed.bits(), 0) << "not yet confirmed";
  EXPECT_EQ(with_stuck(setup, of({2}), S(-0.17)).failed.bits(), 0) << "the others cannot hold what it pushes";
}

TYPED_TEST(Evidence, NeverDropsTwoOfFourWheels) {
  using S = TypeParam;
  const gyrostat::Setup<S> setup = wheels<S>();
  typename EvidenceDetector<S>::Params p(setup);
  p.retry = S(1000);
  for (int a = 0; a < 4; ++a)
    for (int b = 0; b < 4; ++b) {
      if (a == b) continue;
      Bench<S> bench(setup, p);
      bench.commands = [](int i, S t) { return S(0.15) * std::sin(S(0.4) * t + static_cast<S>(i)); };
      bench.fly(S(10), as_told<S>);
      bench.fly(S(60), [&](int i, S, S u) { return i == a ? S(0.01) : u; });
      EXPECT_EQ(bench.det.failed.bits(), of({a}).bits());
      bench.fly(S(60), [&](int i, S, S u) { return i == a || i == b ? S(0.01) : u; });
      EXPECT_FALSE(bench.det.failed.any()) << "with the second one gone the first is needed, and taken back";
      EXPECT_EQ(bench.fault(b), FaultClass::stuck);
      EXPECT_FALSE(with_stuck(setup, of({a, b}), S(0.01)).failed.any())
          << "both at once: none of them matters any more";
    }
}

TYPED_TEST(Evidence, DropsAsManyOfSixteenAsTheRestCanSpare) {
  using S = TypeParam;
  Mat3N<S> D(3, 16);
  for (int i = 0; i < 16; ++i) {
    const S angle = S(2.399963) * static_cast<S>(i), z = S(2 * i + 1) / S(16) - S(1);
    D.col(i) = Vec3<S>(std::sqrt(S(1) - z * z) * std::cos(angle), std::sqrt(S(1) - z * z) * std::sin(angle), z);
  }
  gyrostat::Setup<S> setup = vehicle_with<S>(satellite_inertia<S>(), D, S(0.2), S(0.1));
  setup.vehicle.wheels = Mask::all(16);
  EXPECT_EQ(with_stuck(setup, of({0, 5, 15}), S(0.03)).failed.bits(), of({0, 5, 15}).bits());
  const Mask failed = with_stuck(setup, Mask::all(16), S(0.03)).failed;
  ActuatorsInUse<S> left = ActuatorsInUse<S>::all(setup.vehicle);
  left.used = Mask::all(16).without(failed);
  EXPECT_GT(torque_authority(setup.vehicle, left), S(0));
}

TYPED_TEST(Evidence, ASingleWheelIsJudgedAndNeverDropped) {
  using S = TypeParam;
  Mat3N<S> D(3, 1);
  D << S(0), S(0), S(1);
  gyrostat::Setup<S> setup = vehicle_with<S>(satellite_inertia<S>(), D, S(0.2), S(0.1));
  setup.vehicle.wheels = Mask::all(1);
  const Detection<S> det = with_stuck(setup, of({0}), S(0.02));
  EXPECT_EQ(det.classes[0], FaultClass::stuck);
  EXPECT_FALSE(det.failed.any());
}

TYPED_TEST(Evidence, TriesADroppedWheelAgainLaterAndLater) {
  using S = TypeParam;
  const gyrostat::Setup<S> setup = wheels<S>();
  typename EvidenceDetector<S>::Params p(setup);
  p.retry = S(20);
  Bench<S> bench(setup, p);
  bench.commands = [](int i, S t) { return S(0.15) * std::sin(S(0.8) * t + static_cast<S>(i)); };
  bench.fly(S(10), as_told<S>);
  std::vector<S> spells;  // s, without the wheel
  S since = S(0);
  while (bench.time() < S(300)) {
    const bool out = bench.det.failed.test(2);
    bench.fly(setup.dt, [](int i, S, S u) { return i == 2 ? S(0.05) : u; });
    if (!out && bench.det.failed.test(2)) since = bench.time();
    if (out && !bench.det.failed.test(2)) spells.push_back(bench.time() - since);
  }
  ASSERT_GE(spells.size(), 3u);
  for (std::size_t k = 0; k < 3; ++k) EXPECT_NEAR(spells[k], 20 << k, 0.3);
  EXPECT_TRUE(bench.det.changed.test(2));
}

TYPED_TEST(Evidence, AnHourWithoutAFaultHasNoEvent) {
  using S = TypeParam;
  for (const S noise : {S(0), S(2e-4), S(5e-3)}) {  // N m s
    for (const S step : {S(0), S(2e-3)}) {
      Bench<S> bench(wheels<S>());
      bench.noise = noise;
      bench.step = step;
      bench.fly(S(3600), as_told<S>);
      EXPECT_EQ(bench.det.event, 0u) << "noise " << noise << " step " << step << " at " << bench.first_event;
    }
  }
}

TYPED_TEST(Evidence, AnHourOfChatteringCommandsHasNoEvent) {
  using S = TypeParam;
  for (const S noise : {S(0), S(1e-3)}) {
    std::mt19937 random(5);
    Bench<S> bench(wheels<S>());
    bench.noise = noise;
    bench.commands = [&](int, S) { return random() % 2 == 0 ? S(0.2) : S(-0.2); };
    bench.fly(S(3600), as_told<S>);
    EXPECT_EQ(bench.det.event, 0u) << noise << " at " << bench.first_event;
  }
}

TYPED_TEST(Evidence, ATachometerThatIsASampleLateIsNoFault) {
  using S = TypeParam;
  for (const bool chatters : {false, true}) {
    std::mt19937 random(5);
    Bench<S> bench(wheels<S>());
    if (chatters) bench.commands = [&](int, S) { return random() % 2 == 0 ? S(0.2) : S(-0.2); };
    VecN<S> before = VecN<S>::Zero(4);
    bench.fly(S(600), [&](int i, S, S u) { return std::exchange(before[i], u); });
    EXPECT_EQ(bench.det.event, 0u) << chatters << " at " << bench.first_event;
  }
}

TYPED_TEST(Evidence, AWheelAtAMomentumThatFlightKnowsIsNotFaulty) {
  using S = TypeParam;
  for (const bool known : {true, false}) {
    gyrostat::Setup<S> setup = wheels<S>();
    if (known) setup.vehicle.h_max = VecN<S>::Constant(4, S(0.5));
    Bench<S> bench(setup);
    bench.limit = S(0.5);
    bench.commands = [](int i, S t) { return i == 0 ? S(0.05) : Bench<S>::command(i, t); };
    bench.fly(S(60), as_told<S>);
    if (known) {
      EXPECT_FALSE(bench.det.changed.any());
    }
    EXPECT_EQ(bench.det.changed.test(0), !known) << "it did stop giving";
  }
}

TYPED_TEST(Evidence, WhatWasNotMeasuredSaysNothing) {
  using S = TypeParam;
  Bench<S> bench(wheels<S>());
  bench.fly(S(10), as_told<S>);
  bench.measured = false;  // the tachometers show what they showed: as if all wheels had stopped
  bench.fly(S(60), [](int, S, S) { return S(0); });
  EXPECT_EQ(bench.det.event, 0u);
  bench.measured = true;
  bench.fly(S(60), as_told<S>);
  EXPECT_EQ(bench.det.event, 0u);
  bench.fly(S(10), [](int i, S, S u) { return i == 3 ? S(0.5) * u : u; });
  EXPECT_EQ(bench.det.changed.bits(), 0b1000);
}

TYPED_TEST(Evidence, SparesAreEnabledAtTheFirstDeclaration) {
  using S = TypeParam;
  gyrostat::Setup<S> setup = wheels<S>();
  setup.vehicle.spare = of({3});
  Bench<S> bench(setup);
  bench.commands = [](int i, S t) { return i == 3 ? S(0) : Bench<S>::command(i, t); };
  bench.fly(S(20), as_told<S>);
  EXPECT_EQ(bench.det.enabled.bits(), 0b0111);
  bench.fly(S(10), [](int i, S, S u) { return i == 0 ? S(0.5) * u : u; });
  EXPECT_EQ(bench.det.enabled.bits(), 0b1111);
}

TYPED_TEST(Evidence, FrictionBelowTheToleranceIsNoFault) {
  using S = TypeParam;
  Bench<S> bench(wheels<S>());
  bench.fly(S(600), [](int i, S, S u) { return u + (i % 2 == 0 ? S(0.0019) : S(-0.0019)); });  // tolerance 0.002
  EXPECT_EQ(bench.det.event, 0u);
}

/// Actuators without momentum, judged by the torque of a perfect observer of d_B.
template <class S>
class TorqueBench {
 public:
  explicit TorqueBench(const Setup<S>& setup)
      : setup_(setup), detector_(unchecked, setup, typename EvidenceDetector<S>::Params(setup)) {
    (void)detector_.start(estimate(Vec3<S>::Zero()));
  }

  Detection<S> fly(S seconds, const VecN<S>& gain, S disturbance = S(0)) {
    for (long k = 0; k < static_cast<long>(seconds / setup_.dt); ++k) {
      const S t = static_cast<S>(++tick_) * setup_.dt;
      Allocation<S> last = Allocation<S>::idle(setup_.vehicle.actuators());
      for (int i = 0; i < last.u.size(); ++i)
        last.u[i] = S(0.15) * std::sin(t * (S(0.5) + S(0.17) * static_cast<S>(i)) + static_cast<S>(i));
      const VecN<S> missing = (gain.array() - S(1)).matrix().cwiseProduct(last.u);
      const Vec3<S> other = disturbance * Vec3<S>(std::sin(S(0.3) * t), std::cos(S(0.2) * t), std::sin(S(0.11) * t));
      det = detector_.step(estimate(torque<S>(setup_.vehicle.D_B, missing) + other), last);
    }
    return det;
  }
  Detection<S> det;

 private:
  Estimate<S> estimate(const Vec3<S>& d_B) const {
    Measurement<S> y;
    y.h_w = VecN<S>::Zero(setup_.vehicle.actuators());
    Estimate<S> x = Estimate<S>::healthy(y);
    x.d_B = d_B;
    return x;
  }
  Setup<S> setup_;
  Alone<EvidenceDetector<S>> detector_;
  Tick tick_ = 0;
};

TYPED_TEST(Evidence, OfTorquersItFindsTheGainInTheTorqueThatIsNotExplained) {
  using S = TypeParam;
  gyrostat::Setup<S> setup = wheels<S>();
  setup.vehicle.wheels = {};
  TorqueBench<S> bench(setup);
  VecN<S> gain = VecN<S>::Ones(4);
  bench.fly(S(60), gain, S(0.01));
  EXPECT_FALSE(bench.det.changed.any());
  gain[1] = S(0.3);
  bench.fly(S(30), gain, S(0.01));
  EXPECT_EQ(bench.det.changed.bits(), 0b0010);
  EXPECT_EQ(bench.det.classes[1], FaultClass::gain);
  bench.fly(S(600), gain, S(0.01));
  EXPECT_NEAR(bench.det.gain[1], 0.3, 0.06);
  EXPECT_EQ(bench.det.changed.bits(), 0b0010) << "what is along a declared axis is nobody else's";
  EXPECT_FALSE(bench.det.failed.any());
}

TYPED_TEST(Evidence, ADisturbanceAloneIsNoTorquersFault) {
  using S = TypeParam;
  gyrostat::Setup<S> setup = wheels<S>();
  setup.vehicle.wheels = {};
  TorqueBench<S> bench(setup);
  bench.fly(S(3600), VecN<S>::Ones(4), S(0.03));
  EXPECT_FALSE(bench.det.changed.any());
}

TEST(EvidenceFit, RestingPairsOfACleanFaultAreUnclear) {
  MomentumPairs<double> pairs;
  for (int k = 0; k < 8; ++k) pairs.push({0.02, 0.05, 0.002});
  EXPECT_EQ(fit_fault(pairs, 8, 0.06).fault, FaultClass::unclear) << "gain, bias and stuck all explain it";
}

TEST(EvidenceGuard, TorqueLeftIsWhatTheTorqueSetHasBeyondThePush) {
  // Three orthogonal axes of 0.2 N m: a push of 0.05 along one of them leaves 0.15 there.
  gyrostat::Setup<double> setup = vehicle_with<double>(satellite_inertia<double>(), Mat3<double>::Identity(), 0.2, 0.1);
  ActuatorsInUse<double> in_use = ActuatorsInUse<double>::all(setup.vehicle);
  EXPECT_NEAR(torque_authority(setup.vehicle, in_use), 0.2, 1e-15);
  in_use.against = Vec3<double>(0, 0.05, 0);
  EXPECT_NEAR(torque_authority(setup.vehicle, in_use), 0.15, 1e-15);
  in_use.gain[2] = 0.5;
  EXPECT_NEAR(torque_authority(setup.vehicle, in_use), 0.1, 1e-15);
  in_use.used.set(0, false);
  EXPECT_EQ(torque_authority(setup.vehicle, in_use), 0.0);
}

}  // namespace
}  // namespace gyrostat::test::test_evidence
