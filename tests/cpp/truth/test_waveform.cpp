// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <cmath>

#include "gyrostat/truth/waveform.hpp"

namespace gyrostat::truth::test_waveform {
namespace {

TEST(Waveform, IsMadeOfANumber) {
  const Waveform w = 0.25;
  EXPECT_EQ(w(-1e6), 0.25);
  EXPECT_EQ(w(1e6), 0.25);
  EXPECT_EQ(w.next_switch(0), infinity);
  EXPECT_TRUE(w.piecewise_constant());
}

TEST(Waveform, SineHasOffsetAmplitudeFrequencyAndPhase) {
  const Waveform w = SineWave{.offset = 2, .amplitude = 3, .omega = 0.2, .phase = 0.5};
  EXPECT_DOUBLE_EQ(w(7.0), 2 + 3 * std::sin(0.2 * 7 + 0.5));
  EXPECT_EQ(w.next_switch(0), infinity);
  EXPECT_FALSE(w.piecewise_constant());
  EXPECT_EQ(w.fastest(), 0.2);
}

// Effectiveness of wheel 2 in Li et al. 2018: 0.85 while mod(t, 100) < 50, else 0.6.
TEST(Waveform, SquareFollowsTheModuloOfTime) {
  const Waveform w = SquareWave{.low = 0.6, .high = 0.85, .period = 100, .duty = 0.5};
  for (const double t : {1.0, 49.0, 51.0, 99.0, 101.0, 149.0, 151.0, 1e4 + 1}) {
    EXPECT_EQ(w(t), std::fmod(t, 100) < 50 ? 0.85 : 0.6) << t;
  }
  EXPECT_EQ(w.next_switch(0), 50);
  EXPECT_EQ(w.next_switch(50), 100);
  EXPECT_EQ(w.next_switch(99.99), 100);
}

TEST(Waveform, BothSidesOfASwitchAreReachedByTheBranch) {
  const Waveform square = SquareWave{.low = -1, .high = 1, .period = 2, .duty = 0.5};
  EXPECT_EQ(square(1.0, 0.5), 1);
  EXPECT_EQ(square(1.0, 1.5), -1);
  const Waveform steps = StepsWave{{0, 84, 164}, {1, 0.6, 0.5}};
  EXPECT_EQ(steps(84, 83.99), 1);
  EXPECT_EQ(steps(84, 84.01), 0.6);
}

TEST(Waveform, SquareFindsEachEdgeOnceWhateverThePeriod) {
  for (const double period : {0.1, 0.3, 1.0 / 3.0, 7.7}) {
    const SquareWave square{.period = period, .duty = 0.3, .phase = 0.01};
    const Waveform w = square;
    double t = 0;
    for (int edge = 0; edge < 2000; ++edge) {
      const double next = w.next_switch(t);
      ASSERT_GT(next, t);
      ASSERT_NE(w(t, 0.5 * (t + next)), w(next, next + 0.1 * period)) << "no jump at " << next;
      t = next;
    }
    EXPECT_NEAR(t, 1000 * period, period);  // two edges a period
  }
}

TEST(Waveform, StepsHoldTheFirstValueBeforeItsTime) {
  const Waveform w = StepsWave{{10, 20}, {0.5, 0.25}};
  EXPECT_EQ(w(0), 0.5);
  EXPECT_EQ(w(15), 0.5);
  EXPECT_EQ(w(20), 0.25);
  EXPECT_EQ(w(1e9), 0.25);
  EXPECT_EQ(w.next_switch(0), 10);
  EXPECT_EQ(w.next_switch(10), 20);
  EXPECT_EQ(w.next_switch(20), infinity);
}

TEST(Waveform, TableIsLinearBetweenAndConstantOutside) {
  const Waveform w = TableWave{{0, 2, 3}, {1, 5, 4}};
  EXPECT_EQ(w(-1), 1);
  EXPECT_DOUBLE_EQ(w(0.5), 2);
  EXPECT_DOUBLE_EQ(w(2.5), 4.5);
  EXPECT_EQ(w(9), 4);
  EXPECT_DOUBLE_EQ(w(2.0, 1.9), w(2.0, 2.1));  // continuous at its points
  EXPECT_EQ(w.next_switch(0.5), 2);
  EXPECT_FALSE(w.piecewise_constant());
}

TEST(Waveform, SumAddsValuesAndSwitches) {
  const Waveform w = SumWave{{1.0, SineWave{.amplitude = 2, .omega = 3}, StepsWave{{0, 4}, {0, 10}}}};
  EXPECT_DOUBLE_EQ(w(5.0), 11 + 2 * std::sin(15));
  EXPECT_EQ(w.next_switch(1), 4);
  EXPECT_EQ(w.fastest(), 3);
  EXPECT_TRUE(Waveform(SumWave{{1.0, SquareWave{}}}).piecewise_constant());
  EXPECT_FALSE(w.piecewise_constant());
}

TEST(Waveform, SaysWhatIsWrong) {
  EXPECT_EQ(Waveform(StepsWave{{0, 1}, {0, 1}}).check(), "");
  EXPECT_NE(Waveform(StepsWave{{0, 1, 1}, {0, 1, 2}}).check().find("times[2]"), std::string::npos);
  EXPECT_NE(Waveform(TableWave{{0, 1}, {0}}).check().find("(2, 1)"), std::string::npos);
  EXPECT_NE(Waveform(TableWave{{}, {}}).check(), "");
  EXPECT_NE(Waveform(SquareWave{.period = 0}).check().find("period"), std::string::npos);
  EXPECT_NE(Waveform(SquareWave{.duty = 1.5}).check().find("duty"), std::string::npos);
  EXPECT_NE(Waveform(SumWave{{1.0, SquareWave{.period = -1}}}).check().find("terms[1]"), std::string::npos);
}

}  // namespace
}  // namespace gyrostat::truth::test_waveform
