// SPDX-License-Identifier: MIT
#include "gyrostat/host/metrics.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>
#include <vector>

namespace gyrostat::host {
namespace {

std::vector<double> every_second(std::size_t n) {
  std::vector<double> t(n);
  for (std::size_t k = 0; k < n; ++k) t[k] = static_cast<double>(k);
  return t;
}

TEST(SettlingTime, EndsAtTheFirstSampleAfterTheLastExcursion) {
  const std::vector<double> t = every_second(6), x{5, 0.1, 3, 0.2, 0.1, 0.3};
  EXPECT_EQ(settling_time({t, x}, 0.5), 3.0);
}

TEST(SettlingTime, IsNeverWhenTheLastSampleIsOutside) {
  const std::vector<double> t = every_second(3), x{0, 0, 1};
  EXPECT_TRUE(std::isnan(settling_time({t, x}, 0.5)));
}

TEST(SettlingTime, IsCountedFromAGivenInstantAndJudgesEveryColumn) {
  const std::vector<double> t = every_second(4);
  const std::vector<double> x{0, 0, 0, -2, 0, 0, 0.1, -0.1};  // 4 samples of 2
  EXPECT_EQ(settling_time({t, x}, 0.5), 2.0);
  EXPECT_EQ(settling_time({t, x}, 0.5, 1.0), 1.0);
  EXPECT_EQ(settling_time({t, x}, 0.5, 3.0), 0.0);
}

TEST(SettlingTime, IsNeverWithANaN) {
  const std::vector<double> t = every_second(3), x{0, 0, std::nan("")};
  EXPECT_TRUE(std::isnan(settling_time({t, x}, 0.5)));
}

TEST(Windows, AreClosedAtBothEnds) {
  const std::vector<double> t = every_second(5), x{9, -2, 1, 3, 9};
  EXPECT_EQ(window_max({t, x}, 1, 3), 3.0);
  EXPECT_EQ(window_lowest({t, x}, 1, 3), -2.0);
  EXPECT_EQ(window_highest({t, x}, 1, 3), 3.0);
  EXPECT_DOUBLE_EQ(window_rms({t, x}, 1, 3), std::sqrt((4.0 + 1.0 + 9.0) / 3));
  const std::vector<double> spoilt{0, std::nan(""), 0, 0, 0};
  for (const auto metric : {window_max, window_norm, window_rms, window_lowest, window_highest}) {
    EXPECT_TRUE(std::isnan(metric({t, spoilt}, 0, 4)));
  }
  EXPECT_THROW((void)window_max({t, x}, 10, 12), std::invalid_argument);
}

TEST(Windows, NormTakesAllColumns) {
  const std::vector<double> t = every_second(2), x{3, 4, 1, 1};
  EXPECT_DOUBLE_EQ(window_norm({t, x}, 0, 1), 5.0);
  EXPECT_DOUBLE_EQ(window_max({t, x}, 0, 1), 4.0);
}

TEST(Energy, HoldsEachCommandToTheNextSample) {
  const std::vector<double> t{0, 1, 3}, u{2, 3, 100};
  EXPECT_DOUBLE_EQ(energy({t, u}), 4.0 * 1 + 9.0 * 2);
}

TEST(TotalVariation, IsPerSecondAndSumsColumns) {
  const std::vector<double> t{0, 1, 2}, u{0, 0, 1, -1, 0, 0};
  EXPECT_DOUBLE_EQ(total_variation({t, u}, 0, 2), (2.0 + 2.0) / 2);
}

TEST(Fractions, CountSamplesAtALevel) {
  const std::vector<double> t = every_second(4), u{0.25, -0.25, 0.1, 0.25};
  EXPECT_DOUBLE_EQ(fraction_at_least({t, u}, 0.25, 0, 3), 0.75);
  EXPECT_EQ(first_reach({t, u}, 0.25, 0.5), 1.0);
  EXPECT_TRUE(std::isnan(first_reach({t, u}, 0.3)));
}

TEST(Series, RefusesLengthsThatDoNotFit) {
  const std::vector<double> t = every_second(3), x{1, 2, 3, 4};
  EXPECT_THROW((void)settling_time({t, x}, 1), std::invalid_argument);
}

}  // namespace
}  // namespace gyrostat::host
