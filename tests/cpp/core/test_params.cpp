// SPDX-License-Identifier: MIT
#include "gyrostat/core/params.hpp"

#include <gtest/gtest.h>

#include <string>

namespace gyrostat::test::test_params {
namespace {

using St = Status<double>;

TEST(Status, TheFirstRefusalIsReportedWithItsNumber) {
  const St fine = St::require(1 < 2, "a", 1, 2);
  const St first = St::require(false, "gain * dt", 3, 2, "<", St::Code::unstable);
  const St second = St::require(false, "b", 5, 4, "<", St::Code::unstable);
  EXPECT_TRUE(fine.ok());
  const St all = fine && first && second;
  EXPECT_FALSE(all.ok());
  EXPECT_EQ(all.code, St::Code::unstable);
  EXPECT_EQ(std::string(all.quantity), "gain * dt");
  EXPECT_EQ(all.value, 3);
  EXPECT_EQ(all.limit, 2);
  EXPECT_TRUE(all.ok(true)) << "only unstable, and wanted so";
  const St third = St::require(false, "c", 7, 6), both = all && third && second;
  EXPECT_FALSE(both.ok(true)) << "wanting it does not make it work";
  EXPECT_EQ(std::string(both.quantity), "c");
}

/// A component that keeps its gain; it refuses one above 1 and calls one above 0.5 unstable.
struct Gain {
  using Scalar = double;
  struct Params {
    double gain;
    explicit Params(const Setup<double>& setup) noexcept : gain(setup.dt) {}
  };
  static St check(const Setup<double>&, const Params& p) noexcept {
    return St::require(p.gain < 0.5, "gain", p.gain, 0.5, "<", St::Code::unstable) &&
           St::require(p.gain < 1, "gain", p.gain, 1);
  }
  Gain(Unchecked, const Setup<double>&, const Params& p) noexcept : gain(p.gain) {}
  double gain;
};

gyrostat::Setup<double> period(double dt) {
  gyrostat::Setup<double> setup;
  setup.dt = dt;
  return setup;
}

TEST(Params, ComeFromTheSetupAndFromNothingElse) {
  static_assert(ParamsOf<Gain::Params, double>);
  struct Anything {
    double gain = 1;
  };
  static_assert(!ParamsOf<Anything, double>);
  static_assert(!std::is_constructible_v<Gain, const gyrostat::Setup<double>&, const Gain::Params&>);
  EXPECT_EQ(Gain::Params(period(0.25)).gain, 0.25);
}

TEST(Checked, HoldsAComponentOrTheRefusalOfItsCheck) {
  const Checked<Gain> fine(period(0.25));
  ASSERT_TRUE(fine);
  EXPECT_TRUE(fine.status().ok());
  EXPECT_EQ(fine->gain, 0.25);
  EXPECT_EQ((*fine).gain, 0.25);
  Gain::Params p(period(0.25));
  p.gain = 0.7;
  Checked<Gain> unstable(period(0.25), p);
  EXPECT_FALSE(unstable);
  EXPECT_EQ(unstable.status().value, 0.7);
  Checked<Gain> wanted(period(0.25), p, true);
  ASSERT_TRUE(wanted);
  EXPECT_EQ(wanted.status().code, St::Code::unstable) << "and still says so";
  wanted->gain = 0.1;
  EXPECT_EQ((*wanted).gain, 0.1);
  p.gain = 2;
  const Checked<Gain> refused(period(0.25), p, true);
  EXPECT_FALSE(refused);
  EXPECT_EQ(refused.status().limit, 1);
  EXPECT_FALSE(Checked<Gain>(St::require(false, "another reason", 0, 1)));
  EXPECT_EQ(Gain(unchecked, period(0.25), p).gain, 2) << "who says so gets it all the same";
}

struct Without {
  struct Params {
    double gain = 1;
  };
};
struct With : Without {
  static constexpr bool switching = true;
  static constexpr Estimates estimates{.d_B = true};
  static constexpr Estimates uses(const Params& p) noexcept { return {.effectiveness = p.gain > 0}; }
};

TEST(Traits, AbsentMeansFalse) {
  EXPECT_TRUE(traits_of<With>().switching);
  EXPECT_FALSE(traits_of<With>().regulates);
  EXPECT_FALSE(traits_of<Without>().switching);
  EXPECT_EQ(traits_of<Without>().estimates, Estimates{});
  EXPECT_EQ(traits_of<With>().estimates, (Estimates{.d_B = true, .effectiveness = false}));
  EXPECT_EQ(uses_of<Without>({.gain = 1}), Estimates{});
  EXPECT_TRUE(uses_of<With>({.gain = 1}).effectiveness);
  EXPECT_FALSE(uses_of<With>({.gain = 0}).effectiveness);
}

}  // namespace
}  // namespace gyrostat::test::test_params
