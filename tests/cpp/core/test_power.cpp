// SPDX-License-Identifier: MIT
#include "gyrostat/core/power.hpp"

#include <gtest/gtest.h>

#include <limits>

namespace gyrostat::test::test_power {
namespace {

template <class S>
class Power : public testing::Test {
 protected:
  static constexpr S eps = std::numeric_limits<S>::epsilon();
};
using Scalars = testing::Types<float, double>;
TYPED_TEST_SUITE(Power, Scalars);

TYPED_TEST(Power, SignOfZeroIsZero) {
  using S = TypeParam;
  EXPECT_EQ(sgn(S(0)), S(0));
  EXPECT_EQ(sgn(S(-0.0)), S(0));
  EXPECT_EQ(sgn(std::numeric_limits<S>::denorm_min()), S(1));
  EXPECT_EQ(sgn(S(-3)), S(-1));
}

TYPED_TEST(Power, SigIsOddAndItsPowerZeroIsTheSign) {
  using S = TypeParam;
  for (const S x : {S(1e-30), S(0.3), S(7)}) {
    EXPECT_EQ(sig(-x, S(0.6)), -sig(x, S(0.6)));
    EXPECT_EQ(sig(x, S(0)), S(1));
    EXPECT_EQ(sig(x, S(1)), x);
  }
  EXPECT_EQ(sig(S(0), S(0)), S(0));
  EXPECT_EQ(sig(S(-4), S(0.5)), S(-2));
}

TYPED_TEST(Power, SaturationsMeetAtOne) {
  using S = TypeParam;
  EXPECT_EQ(sat(S(0.25)), S(0.25));
  EXPECT_EQ(sat(S(-3)), S(-1));
  EXPECT_EQ(sat_sig(S(1), S(0.3)), S(1));
  EXPECT_EQ(sat_sig(S(-2), S(0.3)), S(-1));
  EXPECT_EQ(sat_sig(S(0.25), S(0.5)), S(0.5));
}

TYPED_TEST(Power, LayerOfZeroWidthIsTheSign) {
  using S = TypeParam;
  EXPECT_EQ(layer(S(1e-20), S(0)), S(1));
  EXPECT_EQ(layer(S(0), S(0)), S(0));
  EXPECT_EQ(layer(S(0.5), S(2)), S(0.25));
  EXPECT_EQ(layer(S(-5), S(2)), S(-1));
}

TYPED_TEST(Power, CoreJoinsThePowerWithItsSlope) {
  using S = TypeParam;
  const S a = S(0.6), core = S(0.1);
  const S inside = core * (S(1) - S(4) * this->eps), outside = core;
  // One rounding of the argument moves the value by |slope| eps core; the slope is about 1.5.
  EXPECT_NEAR(sig_core(inside, a, core), sig_core(outside, a, core), S(16) * this->eps);
  EXPECT_NEAR(sig_core_slope(inside, a, core), sig_core_slope(outside, a, core), S(64) * this->eps);
  EXPECT_EQ(sig_core(-inside, a, core), -sig_core(inside, a, core));
  EXPECT_EQ(sig_core(S(0), a, core), S(0));
  EXPECT_EQ(sig_core(S(1), a, core), S(1));
}

TYPED_TEST(Power, CoreSlopeIsTheDerivative) {
  using S = TypeParam;
  const S a = S(0.7), core = S(0.5), h = std::cbrt(this->eps);
  for (const S x : {S(-0.3), S(0.05), S(0.2), S(0.8), S(-2)}) {
    const S difference = (sig_core(x + h, a, core) - sig_core(x - h, a, core)) / (S(2) * h);
    EXPECT_NEAR(difference, sig_core_slope(x, a, core), S(20) * h * h)
        << x;  // central difference, third derivative below 50
  }
}

TYPED_TEST(Power, TerminalShapeIsItsFormulaAndMovesAtItsRate) {
  using S = TypeParam;
  const TerminalShape<S> shape{S(0.3), S(0.5), S(0.7), S(0.5)}, line{S(0.3)};
  const Vec3<S> x(S(-0.8), S(0.1), S(2)), xdot(S(1), S(-0.5), S(0.2));
  const S h = std::cbrt(this->eps);
  const Vec3<S> ahead = x + h * xdot, behind = x - h * xdot;
  const Vec3<S> difference = (shape(ahead) - shape(behind)) / (S(2) * h);
  EXPECT_LT((shape.rate(x, xdot) - difference).norm(), S(20) * h * h);  // as above
  for (int i = 0; i < 3; ++i)
    EXPECT_NEAR(shape(x)[i], S(0.3) * x[i] + S(0.5) * sig_core(x[i], S(0.7), S(0.5)), S(4) * this->eps);
  EXPECT_EQ(line(x), Vec3<S>(S(0.3) * x));
  EXPECT_EQ(line.rate(x, xdot), Vec3<S>(S(0.3) * xdot));
}

TYPED_TEST(Power, ClipKeepsWhatIsInsideAndAcceptsInfiniteLimits) {
  using S = TypeParam;
  const S inf = std::numeric_limits<S>::infinity();
  VecN<S> u(3), lo(3), up(3);
  u << S(-5), S(0.5), S(1e6);
  lo << S(-1), S(-1), -inf;
  up << S(1), S(1), inf;
  const VecN<S> out = clip<S>(u, lo, up);
  EXPECT_EQ(out[0], S(-1));
  EXPECT_EQ(out[1], S(0.5));
  EXPECT_EQ(out[2], S(1e6));
}

TYPED_TEST(Power, SaturatedIsAtALimitAndNotAtRest) {
  using S = TypeParam;
  VecN<S> u(6), lo(6), up(6);
  u << S(0.2), S(-0.2), S(0.1), S(0), S(0), S(0.3);
  lo << S(-0.2), S(-0.2), S(-0.2), S(0), S(0), S(0.3);  // the fourth is a closed nozzle, the fifth may not move at all
  up << S(0.2), S(0.2), S(0.2), S(0.2), S(0), S(0.4);
  EXPECT_EQ(saturated(u, lo, up).bits(), 0b100011);
}

}  // namespace
}  // namespace gyrostat::test::test_power
