// SPDX-License-Identifier: MIT
#include "gyrostat/flight/parts/delay_line.hpp"

#include <gtest/gtest.h>

namespace gyrostat::test::test_delay_line {
namespace {

TEST(DelayLine, GivesBackWhatWasPushedThatManyPushesAgo) {
  for (const int delay : {1, 2, 10, max_delay}) {
    DelayLine<int> line(delay, -1);
    for (int k = 0; k < 3 * max_delay; ++k) {
      EXPECT_EQ(line.oldest(), k < delay ? -1 : k - delay) << "delay " << delay << ", push " << k;
      line.push(k);
    }
  }
}

TEST(DelayLine, ForgetsWhenFilled) {
  DelayLine<int> line(3, 0);
  line.push(1);
  line.fill(7);
  for (int k = 0; k < 3; ++k) {
    EXPECT_EQ(line.oldest(), 7);
    line.push(9);
  }
  EXPECT_EQ(line.oldest(), 9);
}

}  // namespace
}  // namespace gyrostat::test::test_delay_line
