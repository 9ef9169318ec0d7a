// SPDX-License-Identifier: MIT
#include "gyrostat/core/params.hpp"

#include <gtest/gtest.h>

#include <string>

namespace gyrostat::test {
namespace {

using St = Status<double>;

TEST(Status, TheFirstRefusalIsReportedWithItsNumber) {
  const St fine = St::require(1 < 2, "a", 1, 2);
  const St first = St::require(false, "gain * dt", 3, 2, "<", St::Code::unstable);
  const St second = St::require(false, "b", 5, 4);
  EXPECT_TRUE(fine.ok());
  const St all = fine && first && second;
  EXPECT_FALSE(all.ok());
  EXPECT_EQ(all.code, St::Code::unstable);
  EXPECT_EQ(std::string(all.quantity), "gain * dt");
  EXPECT_EQ(all.value, 3);
  EXPECT_EQ(all.limit, 2);
}

struct WithDefaults {
  struct Params {
    double gain = 1;
    static Params defaults(const Setup<double>& setup) { return {setup.dt}; }
  };
};
struct Without {
  static constexpr bool switching = true;
  static constexpr Estimates estimates{.d_B = true};
  struct Params {
    double gain = 1;
  };
  static constexpr Estimates uses(const Params& p) noexcept { return {.effectiveness = p.gain > 0}; }
};

TEST(Params, DefaultsComeFromTheVehicleWhereTheComponentSaysSo) {
  gyrostat::Setup<double> setup;
  setup.dt = 0.25;
  EXPECT_EQ((default_params<WithDefaults, double>(setup).gain), 0.25);
  EXPECT_EQ((default_params<Without, double>(setup).gain), 1);
}

TEST(Traits, AbsentMeansFalse) {
  EXPECT_TRUE(traits_of<Without>().switching);
  EXPECT_FALSE(traits_of<Without>().regulates);
  EXPECT_FALSE(traits_of<WithDefaults>().switching);
  EXPECT_EQ(traits_of<WithDefaults>().estimates, Estimates{});
  EXPECT_EQ(traits_of<Without>().estimates, (Estimates{.d_B = true, .effectiveness = false}));
  EXPECT_EQ(uses_of<WithDefaults>({.gain = 1}), Estimates{});
  EXPECT_TRUE(uses_of<Without>({.gain = 1}).effectiveness);
  EXPECT_FALSE(uses_of<Without>({.gain = 0}).effectiveness);
}

}  // namespace
}  // namespace gyrostat::test
