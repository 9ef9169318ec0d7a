// SPDX-License-Identifier: MIT
// Axes are a signal: where a stack has moving ones, every component takes them from there and none from the vehicle.
#include "contract/counted_eigen.hpp"  // first

#include <gtest/gtest.h>

#include "../flight/closed_loop.hpp"
#include "any_components.hpp"

namespace gyrostat::test::test_axes {
namespace {

/// Axes that turn about body z, from those of `ftc_4rw` on, whatever the vehicle says.
struct Turning {
  double rate = 0;  ///< rad a sample
  Axes<double> operator()(const Vehicle<double>&, const Measurement<double>& y) noexcept {
    Axes<double> axes;
    axes.D_B = at(pyramid<double>(), static_cast<double>(y.tick));
    axes.h_B = torque<double>(axes.D_B, y.h_w);
    axes.revision = rate == 0 ? 1 : static_cast<std::uint32_t>(y.tick);
    return axes;
  }
  Mat3N<double> at(const Mat3N<double>& D_B, double samples) const noexcept {
    const Mat3<double> turn = Eigen::AngleAxisd(rate * samples, Vec3<double>::UnitZ()).toRotationMatrix();
    return turn * D_B;
  }
};

using Pointing = AnyStack<double, NoNavigator<double>, Turning>;

/// Another vehicle's axes by a quarter turn: norms and limits are the same, so that what is decided once, with the vehicle, is.
Setup<double> turned(Setup<double> setup) {
  setup.vehicle.D_B = Turning{1.5707963267948966}.at(setup.vehicle.D_B, 1);
  return setup;
}

TEST(Axes, WhereTheyStandEveryStackIsAsItWasToTheLastBit) {
  const gyrostat::Setup<double> setup = ftc_4rw<double>();
  const Parts<double> parts;
  for (std::size_t i = 0; i < parts.stacks(); ++i) {
    AnyStack<double> fixed = parts.stack(i, setup);
    Pointing told = parts.stack(i, setup, setup, no_navigator(setup), Turning{});
    for (Tick k = 1; k < 200; ++k) {
      Measurement<double> y = wobble<double>(k, 4);
      y.h_w << 0.1, -0.2, 0.05, 0.3;
      if (k % 41 == 7) y.rate_valid = false;
      ASSERT_EQ(fixed.step(y).u, told.step(y).u) << k;
      ASSERT_EQ(fixed.estimate().d_B, told.estimate().d_B) << k;
      ASSERT_EQ(fixed.last().achieved_B, told.last().achieved_B) << k;
    }
  }
}

TEST(Axes, NoComponentTakesThemFromTheVehicle) {
  const gyrostat::Setup<double> right = ftc_4rw<double>(), wrong = turned(right);
  const Parts<double> parts;
  for (std::size_t i = 0; i < parts.stacks(); ++i) {
    AnyStack<double> fixed = parts.stack(i, right);
    Pointing told = parts.stack(i, wrong, right, no_navigator(right), Turning{});
    for (Tick k = 1; k < 200; ++k) {
      Measurement<double> y = wobble<double>(k, 4);
      y.h_w << 0.1, -0.2, 0.05, 0.3;
      ASSERT_LT((fixed.step(y).u - told.step(y).u).norm(), 1e-12) << k;
      ASSERT_LT((fixed.estimate().d_B - told.estimate().d_B).norm(), 1e-12) << k;
    }
  }
}

/// A set of torquers that turns under the vehicle, 6 deg/s: pointing, under an actuator at a third, as if it stood.
TEST(Axes, StacksPointWithAxesThatMove) {
  const gyrostat::Setup<double> setup = ftc_4rw<double>();
  std::size_t stacks = 0;
  const auto final_error = [&](auto& stack, const Turning& turning) {
    Body body(setup.vehicle);
    body.q_NB = quat_exp<double>({0.3, -0.2, 0.2});
    body.d_B = {2e-3, -1e-3, 1e-3};
    double worst = 0;
    for (Tick k = 1; k <= 12000; ++k) {
      if (k == 4000) body.effectiveness[1] = 0.35;
      stack.step(body.measured<double>(k));
      body.D_B = turning.at(setup.vehicle.D_B, static_cast<double>(k) + 0.5);  // the middle of the interval
      body.advance(stack.last().u, setup.dt);
      if (k > 11000) worst = std::max(worst, 2 * body.q_NB.vec().norm());
    }
    return worst;
  };
  const std::array observing{Making<FiniteTimeDisturbanceObserver<double>>::maker(),
                             Making<LearningEffectivenessObserver<double>>::maker()};
  const std::array detector{Making<NoDetector<double>>::maker()};
  const std::array laws{Making<IntegralSlidingMode<double>>::maker(), Making<PredefinedTime<double>>::maker()};
  const Parts<double> parts{.observers = observing, .detectors = detector, .controllers = laws};
  for (; stacks < parts.stacks(); ++stacks) {
    const Turning turning{1e-3};
    Pointing seeing = parts.stack(stacks, setup, setup, no_navigator(setup), turning);
    AnyStack<double> blind = parts.stack(stacks, setup);
    EXPECT_LT(final_error(seeing, turning), 5e-3) << stacks;
    EXPECT_GT(final_error(blind, turning), 0.1) << stacks << ": the test sees what it is for";
  }
  EXPECT_EQ(stacks, Allocators::count);
}

}  // namespace
}  // namespace gyrostat::test::test_axes
