// SPDX-License-Identifier: MIT
#include "gyrostat/core/set_parameter.hpp"

#include <gtest/gtest.h>

namespace gyrostat::test::test_set_parameter {
namespace {

enum class Method : std::uint8_t { first, second, third };

template <class S>
struct Inner {
  S gain = S(1);
  static constexpr void describe(auto& p, auto&& field) { field(p.gain, Field{"gain", "", 0, 2, ""}); }
};

template <class S>
struct Everything {
  Inner<S> inner;
  int count = 1;
  Vec3<S> axis = Vec3<S>::Zero();
  Mat3<S> J = Mat3<S>::Zero();
  VecN<S> each;
  Mat3N<S> D{3, 0};
  Quat<S> q = Quat<S>::Identity();
  Mask mask;
  Method method = Method::first;
  bool on = false;

  static constexpr void describe(auto& p, auto&& field) {
    Inner<S>::describe(p.inner, field);
    field(p.count, Field{"count", "", 1, 5, ""});
    field(p.axis, Field{"axis", "", -10, 10, ""});
    field(p.J, Field{"J", "", -100, 100, ""});
    field(p.each, Field{"each", "", 0, std::numeric_limits<double>::infinity(), ""});
    field(p.D, Field{"D", "", -10, 10, ""});
    field(p.q, Field{"q", "", -1, 1, ""});
    field(p.mask, Field{"mask", "", 0, 15, ""});
    field(p.method, Choice{"method", "first|second|third", ""});
    field(p.on, Switch{"on", ""});
  }
};

template <class S>
class SetParameter : public testing::Test {};
using Scalars = testing::Types<float, double>;
TYPED_TEST_SUITE(SetParameter, Scalars);

TYPED_TEST(SetParameter, FindsEveryKindOfMember) {
  using S = TypeParam;
  Everything<S> p;
  EXPECT_TRUE(set_parameter(p, "gain", 0.1));  // of a nested description
  EXPECT_EQ(p.inner.gain, S(0.1));
  EXPECT_TRUE(set_parameter(p, "count", 5));
  EXPECT_EQ(p.count, 5);
  EXPECT_TRUE(set_parameter(p, "axis", 1, 2, 3));
  EXPECT_EQ(p.axis, Vec3<S>(1, 2, 3));
  EXPECT_TRUE(set_parameter(p, "J", 1, 2, 3, 4, 5, 6, 7, 8, 9));
  EXPECT_EQ(p.J(0, 2), S(3));  // row by row
  EXPECT_EQ(p.J(2, 0), S(7));
  EXPECT_TRUE(set_parameter(p, "each", 1, 2, std::numeric_limits<double>::infinity(), 4, 5));
  ASSERT_EQ(p.each.size(), 5);
  EXPECT_EQ(p.each[4], S(5));
  EXPECT_TRUE(set_parameter(p, "q", 0.5, -0.5, 0.5, -0.5));
  EXPECT_EQ(p.q.w(), S(0.5));
  EXPECT_EQ(p.q.x(), S(-0.5));
  EXPECT_TRUE(set_parameter(p, "mask", 0, 3));
  EXPECT_EQ(p.mask.bits(), 9);
  EXPECT_TRUE(set_parameter(p, "method", 2));
  EXPECT_EQ(p.method, Method::third);
  EXPECT_TRUE(set_parameter(p, "on", 1));
  EXPECT_TRUE(p.on);
}

TYPED_TEST(SetParameter, ChangesNothingThatDoesNotFit) {
  using S = TypeParam;
  Everything<S> p;
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(set_parameter(p, "gai", 1));
  EXPECT_FALSE(set_parameter(p, "gains", 1));
  EXPECT_FALSE(set_parameter(p, "", 1));
  EXPECT_FALSE(set_parameter(p, "gain", 2.0000001));  // the range is that of the number as given, not rounded to float
  EXPECT_FALSE(set_parameter(p, "gain", nan));
  EXPECT_FALSE(set_parameter(p, "gain", 1, 1));
  EXPECT_FALSE(set_parameter(p, "count", 2.5));
  EXPECT_FALSE(set_parameter(p, "axis", 1, 2));
  EXPECT_FALSE(set_parameter(p, "axis", 1, 2, 11));
  EXPECT_FALSE(set_parameter(p, "J", 1, 2, 3));
  EXPECT_FALSE(set_parameter(p, "each", 1, -1));
  EXPECT_FALSE(set_parameter(p, "each", 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0));  // 17 actuators
  EXPECT_FALSE(set_parameter(p, "q", 1, 0, 0));
  EXPECT_FALSE(set_parameter(p, "mask", 0.5));
  EXPECT_FALSE(set_parameter(p, "method", 3));
  EXPECT_FALSE(set_parameter(p, "method", -1));
  EXPECT_FALSE(set_parameter(p, "on", 2));
  const Everything<S> fresh;
  EXPECT_EQ(p.inner.gain, fresh.inner.gain);
  EXPECT_EQ(p.count, fresh.count);
  EXPECT_EQ(p.axis, fresh.axis);
  EXPECT_EQ(p.J, fresh.J);
  EXPECT_EQ(p.each.size(), 0);
  EXPECT_EQ(p.mask, fresh.mask);
  EXPECT_EQ(p.method, fresh.method);
  EXPECT_FALSE(p.on);
}

TYPED_TEST(SetParameter, TakesColumnsRowByRow) {
  // Rows of a 3 x n matrix: n is what the count leaves.
  using S = TypeParam;
  Everything<S> p;
  EXPECT_TRUE(set_parameter(p, "D", 1, 2, 3, 4, 5, 6));
  ASSERT_EQ(p.D.cols(), 2);
  EXPECT_EQ(p.D(0, 1), S(2));
  EXPECT_EQ(p.D(2, 0), S(5));
  EXPECT_FALSE(set_parameter(p, "D", 1, 2, 3, 4));
}

}  // namespace
}  // namespace gyrostat::test::test_set_parameter
