// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>

#include "support.hpp"

namespace gyrostat::truth::test_actuators {
namespace {

using test::vec;

Actuators limited(LimitOn limit_on = LimitOn::command) {
  Actuators a = Actuators::ideal(4);
  a.u_lo.setConstant(-0.2);
  a.u_up.setConstant(0.25);
  a.limit_on = limit_on;
  return a;
}

/// What actuator i delivers at t, when each piece is entered in turn under one command.
double delivered(FaultyActuators bank, int i, const VecN<double>& u, double t) {
  double from = 0;
  for (;;) {
    const double next = bank.next_switch(from);
    const double branch = std::isfinite(next) ? 0.5 * (from + next) : from + 1;
    bank.enter(from, branch);
    bank.command(u);
    if (t < next) return bank.delivered(i, t);
    from = next;
  }
}

const VecN<double> u = vec({0.1, -0.1, 0.05, 0.15});

TEST(Actuators, HealthyOnesDeliverTheCommandUpToTheirLimits) {
  EXPECT_EQ(delivered({limited(), {}}, 1, u, 3), -0.1);
  EXPECT_EQ(delivered({limited(), {}}, 1, vec({0, -7, 0, 0}), 3), -0.2);
  EXPECT_EQ(delivered({limited(), {}}, 1, vec({0, 7, 0, 0}), 3), 0.25);
  EXPECT_EQ(delivered({Actuators::ideal(4), {}}, 1, vec({0, 7, 0, 0}), 3), 7);
}

TEST(Actuators, LossesMultiplyAndBiasesAdd) {
  const FaultyActuators bank(limited(), {LossOfEffectiveness{.window = {.actuator = 0, .t_on = 10}, .remaining = 0.5},
                                         LossOfEffectiveness{.window = {.actuator = 0, .t_on = 20}, .remaining = 0.2},
                                         Bias{.window = {.actuator = 0, .t_on = 30}, .torque = 0.01},
                                         Bias{.window = {.actuator = 0, .t_on = 30}, .torque = 0.02}});
  EXPECT_DOUBLE_EQ(delivered(bank, 0, u, 9), 0.1);
  EXPECT_DOUBLE_EQ(delivered(bank, 0, u, 11), 0.05);
  EXPECT_DOUBLE_EQ(delivered(bank, 0, u, 21), 0.01);
  EXPECT_DOUBLE_EQ(delivered(bank, 0, u, 31), 0.04);
  EXPECT_EQ(delivered(bank, 1, u, 31), -0.1);  // the others are not touched
}

// Li et al. 2018, section 5: effectiveness 0.9 + 0.07 sin(0.2 t) and bias 0.05 sin t on wheel 2.
TEST(Actuators, LawsVaryWithTime) {
  const FaultyActuators bank(limited(),
                             {LossOfEffectiveness{.window = {.actuator = 2}, .remaining = SineWave{0.9, 0.07, 0.2, 0}},
                              Bias{.window = {.actuator = 2}, .torque = SineWave{0, 0.05, 1, 0}}});
  EXPECT_DOUBLE_EQ(delivered(bank, 2, u, 7), (0.9 + 0.07 * std::sin(1.4)) * 0.05 + 0.05 * std::sin(7.0));
}

TEST(Actuators, AnEffectivenessOfZeroStillAddsItsBiasButADeadOneDoesNot) {
  const Bias bias{.window = {.actuator = 3}, .torque = 0.005};
  EXPECT_EQ(delivered({limited(), {bias, LossOfEffectiveness{.window = {.actuator = 3}, .remaining = 0.0}}}, 3, u, 1),
            0.005);
  EXPECT_EQ(delivered({limited(), {bias, Dead{.window = {.actuator = 3}}}}, 3, u, 1), 0);
}

TEST(Actuators, StuckAndHardOverIgnoreTheCommand) {
  EXPECT_EQ(delivered({limited(), {StuckOutput{.window = {.actuator = 1}, .torque = 0.07}}}, 1, u, 1), 0.07);
  EXPECT_EQ(delivered({limited(), {HardOver{.window = {.actuator = 1}, .sign = 1}}}, 1, u, 1), 0.25);
  EXPECT_EQ(delivered({limited(), {HardOver{.window = {.actuator = 1}, .sign = -1}}}, 1, u, 1), -0.2);
  EXPECT_THROW(FaultyActuators(Actuators::ideal(4), {HardOver{.window = {.actuator = 1}}}), std::invalid_argument);
}

TEST(Actuators, LockKeepsWhatWasDeliveredAtItsOnset) {
  FaultyActuators bank(limited(), {LossOfEffectiveness{.window = {.actuator = 0}, .remaining = 0.5},
                                   Lock{.window = {.actuator = 0, .t_on = 10}}});
  bank.enter(0, 5);
  bank.command(u);
  bank.enter(10, 11);
  bank.command(-u);
  EXPECT_DOUBLE_EQ(bank.delivered(0, 12), 0.05);
  EXPECT_EQ(bank.effect(0, 12).effectiveness, 0);
  EXPECT_DOUBLE_EQ(bank.effect(0, 12).bias, 0.05);
}

TEST(Actuators, LockFromTheBeginningDeliversNothing) {
  EXPECT_EQ(delivered({limited(), {Lock{.window = {.actuator = 0}}}}, 0, u, 1), 0);
}

TEST(Actuators, DriftGrowsFromItsOnsetAndEnds) {
  const FaultyActuators bank(limited(), {Drift{.window = {.actuator = 0, .t_on = 10, .t_off = 30}, .rate = 1e-3}});
  EXPECT_DOUBLE_EQ(delivered(bank, 0, u, 15), 0.1 + 5e-3);
  EXPECT_EQ(delivered(bank, 0, u, 31), 0.1);
}

TEST(Actuators, IntermittentComesAndGoes) {
  const FaultyActuators bank(
      limited(),
      {Intermittent{
          .window = {.actuator = 0, .t_on = 10}, .period = 4, .duty = 0.25, .remaining = 0.3, .torque = 0.02}});
  EXPECT_EQ(delivered(bank, 0, u, 9.9), 0.1);
  EXPECT_DOUBLE_EQ(delivered(bank, 0, u, 10.5), 0.05);
  EXPECT_EQ(delivered(bank, 0, u, 11.5), 0.1);
  EXPECT_DOUBLE_EQ(delivered(bank, 0, u, 14.5), 0.05);
}

TEST(Actuators, DeadZoneSwallowsSmallCommandsAndPassesLargeOnesWhole) {
  const FaultyActuators bank(limited(), {DeadZone{.window = {.actuator = 1}, .width = 0.08}});
  EXPECT_EQ(delivered(bank, 1, vec({0, 0.079, 0, 0}), 1), 0);
  EXPECT_EQ(delivered(bank, 1, vec({0, -0.079, 0, 0}), 1), 0);
  EXPECT_EQ(delivered(bank, 1, vec({0, -0.081, 0, 0}), 1), -0.081);
}

TEST(Actuators, LimitOnTheCommandComesBeforeTheFaultsLimitOnTheOutputAfter) {
  const std::vector<Fault> faults{LossOfEffectiveness{.window = {.actuator = 0}, .remaining = 0.5},
                                  Bias{.window = {.actuator = 0}, .torque = 0.2}};
  EXPECT_DOUBLE_EQ(delivered({limited(LimitOn::command), faults}, 0, vec({1, 0, 0, 0}), 1), 0.5 * 0.25 + 0.2);
  EXPECT_DOUBLE_EQ(delivered({limited(LimitOn::output), faults}, 0, vec({1, 0, 0, 0}), 1), 0.25);
  EXPECT_DOUBLE_EQ(delivered({limited(LimitOn::output), faults}, 0, vec({-0.4, 0, 0, 0}), 1), 0.0);
}

TEST(Actuators, RefuseWhatDoesNotFitTogether) {
  Actuators a = limited();
  a.viscous_friction[2] = 1e-4;
  EXPECT_NE(a.check().find("actuator 2: friction needs a wheel_inertia"), std::string::npos);
  a = limited();
  a.momentum_max[1] = 1;
  EXPECT_NE(a.check().find("actuator 1: momentum_max"), std::string::npos);
  a = limited();
  a.u_lo[0] = 1;
  EXPECT_NE(a.check().find("actuator 0"), std::string::npos);
  a = limited();
  a.u_up.resize(3);
  EXPECT_NE(a.check().find("u_up has 3 elements, need 4"), std::string::npos);
  EXPECT_THROW(FaultyActuators(limited(), {Dead{.window = {.actuator = 9}}}), std::invalid_argument);
  EXPECT_THROW(FaultyActuators(limited(), {Dead{.window = {.actuator = 0}}, StuckOutput{.window = {.actuator = 0}}}),
               std::invalid_argument);
}

}  // namespace
}  // namespace gyrostat::truth::test_actuators
