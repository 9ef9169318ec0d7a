// SPDX-License-Identifier: MIT
// What stands before the observer: a navigator sees each sensor alone, its knowledge is no torque, and no navigator is none.
#include "contract/counted_eigen.hpp"  // first

#include <gtest/gtest.h>

#include "../flight/closed_loop.hpp"
#include "any_components.hpp"

namespace gyrostat::test::test_navigation {
namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

using Navigated = AnyStack<double, AnyNavigator<double>>;

template <class N>
AnyNavigator<double> navigator(const gyrostat::Setup<double>& setup) {
  return {Making<N>::maker(), setup, setup};
}

template <class N>
Navigated with(const gyrostat::Setup<double>& setup,
               Maker<ObserverRole<double>> observer = Making<PassthroughObserver<double>>::maker()) {
  const std::array observers{observer};
  const std::array detectors{Making<NoDetector<double>>::maker()};
  const std::array controllers{Making<MrpFeedback<double>>::maker()};
  const std::array allocators{Making<PseudoInverse<double>>::maker()};
  return Parts<double>{observers, detectors, controllers, allocators}.stack(0, setup, setup, navigator<N>(setup));
}

/// What every navigator of a test has.
struct TestNavigator {
  using Scalar = double;
  struct Params {
    explicit Params(const Setup<double>&) noexcept {}
    static constexpr void describe(auto&, auto&&) {}
  };
  static Status<double> check(const Setup<double>&, const Params&) noexcept { return {}; }
  TestNavigator(Unchecked, const Setup<double>&, const Params&) noexcept {}
  void telemetry(auto&&) const {}
};

/// Copies, and says what it saw.
struct Copying : TestNavigator {
  static constexpr const char* name = "copying";
  using TestNavigator::TestNavigator;
  Measurement<double> start(const Vehicle<double>& vehicle, const Measurement<double>& y) noexcept {
    ++starts;
    return step(vehicle, y);
  }
  Measurement<double> step(const Vehicle<double>&, const Measurement<double>& y) noexcept { return seen = y; }
  Measurement<double> seen;
  int starts = 0;
};

/// An attitude of its own from the gyro alone.
struct DeadReckoning : TestNavigator {
  static constexpr const char* name = "dead_reckoning";
  DeadReckoning(Unchecked, const Setup<double>& setup, const Params& p) noexcept
      : TestNavigator(unchecked, setup, p), dt(setup.dt) {}
  Measurement<double> start(const Vehicle<double>&, const Measurement<double>& y) noexcept { return before = y; }
  Measurement<double> step(const Vehicle<double>&, Measurement<double> y) noexcept {
    if (!y.attitude_valid && y.rate_valid) {
      y.q_NB = (before.q_NB * quat_exp<double>(dt / 2 * (before.omega_BN_B + y.omega_BN_B))).normalized();
      y.attitude_valid = true;
    }
    return before = y;
  }
  double dt;
  Measurement<double> before;
};

/// Fails at sample 20, and with `twice` when it is started again as well.
template <bool twice>
struct Failing : TestNavigator {
  static constexpr const char* name = "failing";
  using TestNavigator::TestNavigator;
  Measurement<double> start(const Vehicle<double>& vehicle, const Measurement<double>& y) noexcept {
    return twice ? step(vehicle, y) : y;
  }
  Measurement<double> step(const Vehicle<double>&, Measurement<double> y) noexcept {
    if (y.tick == 20) y.omega_BN_B[1] = nan;
    return y;
  }
};

/// Subtracts a bias that it comes to know at sample 300.
struct Learning : TestNavigator {
  static constexpr const char* name = "learning";
  using TestNavigator::TestNavigator;
  Measurement<double> start(const Vehicle<double>& vehicle, const Measurement<double>& y) noexcept {
    return step(vehicle, y);
  }
  Measurement<double> step(const Vehicle<double>&, Measurement<double> y) noexcept {
    if (y.tick < 300) return y;
    y.omega_BN_B -= bias;
    if (y.tick == 300 && says_so) y.rate_step = -bias;
    return y;
  }
  static inline Vec3<double> bias = Vec3<double>::Zero();
  static inline bool says_so = true;
};

static_assert(
    sizeof(FlightStack<PassthroughObserver<double>, NoDetector<double>, MrpFeedback<double>, PseudoInverse<double>,
                       NoNavigator<double>>) ==
    sizeof(FlightStack<PassthroughObserver<double>, NoDetector<double>, MrpFeedback<double>, PseudoInverse<double>>));

TEST(Navigation, NoneIsEveryStackAsItWasToTheLastBit) {
  const gyrostat::Setup<double> setup = ftc_4rw<double>();
  const std::array laws{Making<MrpFeedback<double>>::maker(), Making<IntegralSlidingMode<double>>::maker()};
  const std::array allocator{Making<PseudoInverse<double>>::maker()};
  const Parts<double> parts{.controllers = laws, .allocators = allocator};
  for (std::size_t i = 0; i < parts.stacks(); ++i) {
    AnyStack<double> plain = parts.stack(i, setup);
    Navigated copying = parts.stack(i, setup, setup, navigator<Copying>(setup));
    for (Tick k = 0; k < 200; ++k) {
      Measurement<double> y = wobble<double>(k, 4);
      if (k % 37 == 5) y.omega_BN_B[0] = nan;
      if (k % 41 == 7) y.attitude_valid = false;
      if (k % 50 == 9) y.tick = k - 1;
      ASSERT_EQ(plain.step(y).u, copying.step(y).u) << k;
      ASSERT_EQ(plain.estimate().d_B, copying.estimate().d_B) << k;
      ASSERT_EQ(plain.last().status, copying.last().status) << k;
    }
    EXPECT_EQ(copying.navigation.navigator.as<Copying>().starts, 1);
  }
  EXPECT_EQ(parts.stacks(), Observers::count);
}

TEST(Navigation, ToldOfEachSensorAloneWhatWasNotMeasured) {
  auto stack = with<Copying>(ftc_4rw<double>());
  const Measurement<double>& seen = stack.navigation.navigator.as<Copying>().seen;
  for (Tick k = 0; k < 10; ++k) stack.step(wobble<double>(k, 4), {});
  EXPECT_TRUE(seen.attitude_valid && seen.rate_valid && seen.momentum_valid);
  Measurement<double> y = wobble<double>(10, 4);
  y.q_NB.x() = nan;
  stack.step(y, {});
  EXPECT_FALSE(seen.attitude_valid);
  EXPECT_TRUE(seen.rate_valid && seen.momentum_valid);
  y = wobble<double>(11, 4);
  y.omega_BN_B[2] = 1e9;
  y.h_w.resize(2);
  stack.step(y, {});
  EXPECT_TRUE(seen.attitude_valid);
  EXPECT_FALSE(seen.rate_valid || seen.momentum_valid);
  stack.step(wobble<double>(11, 4), {});
  EXPECT_FALSE(seen.attitude_valid || seen.rate_valid || seen.momentum_valid) << "not renewed";
  stack.step(wobble<double>(12, 4), {});
  EXPECT_TRUE(seen.attitude_valid && seen.rate_valid && seen.momentum_valid);
}

/// A star tracker that is blind for three seconds of a slew: on the gyro alone the vehicle points as before.
TEST(Navigation, OneSensorWithoutAWordDoesNotStopTheOthers) {
  const gyrostat::Setup<double> setup = ftc_4rw<double>();
  auto stack = with<DeadReckoning>(setup);
  Body body(setup.vehicle);
  body.q_NB = quat_exp<double>({0.5, -0.3, 0.2});
  int held = 0;
  for (Tick k = 1; k < 6000; ++k) {
    Measurement<double> y = body.measured<double>(k);
    if (k >= 300 && k < 600) y.q_NB.coeffs().setConstant(nan);
    held += stack.step(y, {}).status.has(Flag::input_held) ? 1 : 0;
    body.advance(stack.last().u, setup.dt);
  }
  EXPECT_EQ(held, 0);
  EXPECT_LT(2 * body.q_NB.vec().norm(), 1e-3);
}

TEST(Navigation, AnImpossibleOutputStartsItAgain) {
  auto stack = with<Failing<false>>(ftc_4rw<double>());
  auto plain = with<NoNavigator<double>>(ftc_4rw<double>());
  for (Tick k = 0; k < 60; ++k) {
    stack.step(wobble<double>(k, 4), {});
    plain.step(wobble<double>(k, 4), {});
    EXPECT_EQ(stack.actions().navigator, k == 20);
    EXPECT_EQ(stack.last().status.has(Flag::component_reset), k == 20);
    EXPECT_EQ(stack.last().u, plain.last().u) << k;
  }
}

TEST(Navigation, ThatFailsTwiceLeavesTheSensorsAsTheyAre) {
  auto stack = with<Failing<true>>(ftc_4rw<double>());
  auto plain = with<NoNavigator<double>>(ftc_4rw<double>());
  for (Tick k = 0; k < 60; ++k) {
    stack.step(wobble<double>(k, 4), {});
    plain.step(wobble<double>(k, 4), {});
    EXPECT_EQ(stack.actions().navigator, k == 20);
    EXPECT_EQ(stack.last().u, plain.last().u) << k;
  }
}

TEST(Navigation, StartsAgainWithTheStack) {
  auto stack = with<Copying>(ftc_4rw<double>());
  stack.step(wobble<double>(0, 4), {});
  stack.step(wobble<double>(1, 4), {});
  EXPECT_EQ(stack.navigation.navigator.as<Copying>().starts, 1);
  stack.reset();
  stack.step(wobble<double>(2, 4), {});
  EXPECT_EQ(stack.navigation.navigator.as<Copying>().starts, 2);
}

/// A gyro bias of 5 mrad/s that becomes known at once is J db / dt = 10 N m to who differentiates the rate: five times what
/// the actuators could do together. Told of it, no observer sees more than the gyroscopic torque that the bias had feigned.
TEST(Navigation, KnowledgeIsNoTorqueToAnyObserver) {
  const gyrostat::Setup<double> setup = ftc_4rw<double>();
  int observers = 0, deceived = 0;
  for (const auto& observer : makers<ObserverRole<double>>()) {
    double moved[2] = {0, 0};
    const char* name = "";
    for (const bool says_so : {true, false}) {
      Learning::bias = {5e-3, -5e-3, 5e-3};
      Learning::says_so = says_so;
      Navigated stack = with<Learning>(setup, observer);
      name = stack.estimator.observer.name();
      Body body(setup.vehicle);
      body.d_B = {2e-3, -1e-3, 1e-3};
      const auto one = [&](Tick k) {
        Measurement<double> y = body.measured<double>(k);
        y.omega_BN_B += Learning::bias;
        stack.step(y, {});
        body.advance(stack.last().u, setup.dt);
      };
      for (Tick k = 1; k < 300; ++k) one(k);
      const Vec3<double> before_B = stack.estimate().d_B;
      const VecN<double> e = stack.estimate().effectiveness;
      for (Tick k = 300; k < 310; ++k) {
        one(k);
        const double change = (stack.estimate().d_B - before_B).norm() + (stack.estimate().effectiveness - e).norm();
        moved[says_so ? 0 : 1] = std::max(moved[says_so ? 0 : 1], change);
      }
    }
    EXPECT_LT(moved[0], 0.1) << name << ": no more than what the law's own reaction to the better rate teaches";
    EXPECT_LE(moved[0], moved[1]) << name;
    deceived += moved[1] > 0.2 ? 1 : 0;
    ++observers;
  }
  EXPECT_EQ(observers, static_cast<int>(Observers::count));
  EXPECT_GE(deceived, 3) << "without a word the bias is a torque: the test sees what it is for";
}

}  // namespace
}  // namespace gyrostat::test::test_navigation
