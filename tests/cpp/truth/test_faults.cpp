// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include "gyrostat/truth/faults.hpp"

namespace gyrostat::truth {
namespace {

TEST(Faults, SwitchAtOnsetAtTheirLawsJumpsAndAtTheirEnd) {
  const Fault fault =
      LossOfEffectiveness{.actuator = 1, .t_on = 10, .t_off = 200, .remaining = StepsWave{{0, 50, 300}, {1, 2, 3}}};
  EXPECT_EQ(next_switch(fault, 0), 10);
  EXPECT_EQ(next_switch(fault, 10), 50);
  EXPECT_EQ(next_switch(fault, 50), 200);  // the law's next jump comes after the end
  EXPECT_EQ(next_switch(fault, 200), infinity);
}

TEST(Faults, IntermittentCountsItsPeriodsFromTheOnset) {
  const Fault fault = Intermittent{.actuator = 0, .t_on = 10, .period = 4, .duty = 0.25};
  EXPECT_EQ(next_switch(fault, 0), 10);
  EXPECT_EQ(next_switch(fault, 10), 11);
  EXPECT_EQ(next_switch(fault, 11), 14);
  EXPECT_TRUE(std::get<Intermittent>(fault).gate().is_high(10.5));
  EXPECT_FALSE(std::get<Intermittent>(fault).gate().is_high(11.5));
}

TEST(Faults, ThatDecideOneOutputAtTheSameTimeContradict) {
  const std::vector<Fault> faults{Bias{.actuator = 2}, StuckOutput{.actuator = 2, .t_on = 5, .t_off = 20},
                                  LossOfEffectiveness{.actuator = 2}, Dead{.actuator = 2, .t_on = 15}};
  EXPECT_EQ(contradiction(faults), "faults of actuator 2 contradict: stuck (from 5 s to 20 s) and dead (from 15 s)");
}

TEST(Faults, DoNotContradictOneAfterTheOtherOrOnOtherActuators) {
  EXPECT_EQ(contradiction({StuckOutput{.actuator = 2, .t_on = 5, .t_off = 15}, Dead{.actuator = 2, .t_on = 15}}), "");
  EXPECT_EQ(contradiction({Lock{.actuator = 1}, HardOver{.actuator = 0}}), "");
  EXPECT_EQ(contradiction({LossOfEffectiveness{}, Bias{}, Dead{}, Drift{}, Intermittent{}, DeadZone{}}), "");
}

TEST(Faults, SayWhatIsWrong) {
  EXPECT_EQ(check(Dead{.actuator = 3}, 4), "");
  EXPECT_NE(check(Dead{.actuator = 4}, 4).find("actuator 4 does not exist"), std::string::npos);
  EXPECT_EQ(check(Dead{}, 4), "fault dead: needs its actuator");
  EXPECT_NE(check(Dead{.actuator = 0, .t_on = 5, .t_off = 5}, 4).find("t_on"), std::string::npos);
  EXPECT_NE(check(HardOver{.actuator = 0, .sign = 0}, 4).find("sign"), std::string::npos);
  EXPECT_NE(check(Bias{.actuator = 0, .torque = SquareWave{.period = 0}}, 4).find("fault bias: period"),
            std::string::npos);
}

}  // namespace
}  // namespace gyrostat::truth
