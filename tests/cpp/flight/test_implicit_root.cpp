// SPDX-License-Identifier: MIT
#include "gyrostat/flight/observers/parts/implicit_root.hpp"

#include <gtest/gtest.h>

#include "../random.hpp"
#include "gyrostat/core/power.hpp"

namespace gyrostat::test::test_implicit_root {
namespace {

struct Case {
  double a1, lambda1, lambda2, h;
  double c1() const { return h * lambda1; }
  double c2() const { return h * h * lambda2; }
};
// Powers whose exponents are small whole numbers or halves, others, and gains on both sides of lambda2 = lambda1^2.
const Case cases[] = {{0.6, 1, 0.6, 0.001},     {0.6, 1, 0.6, 0.05},  {2.0 / 3, 1, 0.6, 0.01}, {0.75, 2, 0.1, 0.01},
                      {0.7, 1, 0.6, 0.01},      {0.52, 1, 0.6, 0.01}, {0.95, 1, 0.6, 0.1},     {0.6, 0.1, 30, 0.01},
                      {0.83, 50, 0.001, 0.001}, {0.6, 1e-6, 1, 1}};

/// Relative residual, in long double, of the equation in the powers that the solve returns.
double residual(const Case& c, const ImplicitRoot<double>::Root& root, double r) {
  const long double sum =
      root.z + static_cast<long double>(c.c1()) * root.sig_a1 + static_cast<long double>(c.c2()) * root.sig_a2;
  return static_cast<double>(std::abs((sum - r) / r));
}

TEST(ImplicitRoot, SolvesItsEquationFromTinyToLarge) {
  Random random(1);
  for (const Case& c : cases) {
    const ImplicitRoot<double> solve(c.c1(), c.c2(), c.a1);
    for (int trial = 0; trial < 2000; ++trial) {
      const double r = random.log_uniform(1e-30, 10);
      EXPECT_LT(residual(c, solve(r), r), 5e-14)
          << c.a1 << " r = " << r;  // |z| = y^(1/a2): a rounding of y counts up to 25 times
    }
  }
}

TEST(ImplicitRoot, ReturnsThePowersOfItsRoot) {
  Random random(2);
  for (const Case& c : cases) {
    const ImplicitRoot<double> solve(c.c1(), c.c2(), c.a1);
    for (int trial = 0; trial < 500; ++trial) {
      const double r = random.log_uniform(1e-12, 10);
      const ImplicitRoot<double>::Root root = solve(r);
      if (std::abs(root.z) < 1e-290) continue;  // z underflows, its powers do not
      EXPECT_NEAR(root.sig_a1, sig(root.z, c.a1), 1e-11 * root.sig_a1);
      EXPECT_NEAR(root.sig_a2, sig(root.z, 2 * c.a1 - 1),
                  1e-11 * root.sig_a2);  // pow(tiny, small) loses log2(z) digits
    }
  }
}

TEST(ImplicitRoot, AgreesWithBisection) {
  Random random(3);
  for (const Case& c : cases) {
    const ImplicitRoot<double> solve(c.c1(), c.c2(), c.a1);
    for (int trial = 0; trial < 50; ++trial) {
      const double r = random.log_uniform(1e-6, 10);
      long double lo = 0, hi = r;
      for (int i = 0; i < 200; ++i) {
        const long double z = (lo + hi) / 2;
        const long double value = z + c.c1() * std::pow(z, static_cast<long double>(c.a1)) +
                                  c.c2() * std::pow(z, static_cast<long double>(2 * c.a1 - 1));
        (value < r ? lo : hi) = z;
      }
      // |z| = y^(1/a2): an error of y is multiplied by 1/a2, 25 at most here.
      EXPECT_NEAR(solve(r).z, static_cast<double>(lo), 1e-12 * static_cast<double>(lo) + 1e-300) << c.a1 << " " << r;
    }
  }
}

TEST(ImplicitRoot, IsOddAndMonotone) {
  for (const Case& c : cases) {
    const ImplicitRoot<double> solve(c.c1(), c.c2(), c.a1);
    double before = 0;
    for (double r = 1e-30; r < 10; r *= 1.01) {
      const double sig_a2 = solve(r).sig_a2;
      EXPECT_EQ(solve(-r).sig_a2, -sig_a2);
      EXPECT_EQ(solve(-r).z, -solve(r).z);
      EXPECT_GT(sig_a2, before) << c.a1 << " " << r;
      before = sig_a2;
    }
  }
}

TEST(ImplicitRoot, ZeroAndTheSmallestNumbersAreNoTrouble) {
  for (const Case& c : cases) {
    const ImplicitRoot<double> solve(c.c1(), c.c2(), c.a1);
    EXPECT_EQ(solve(0).z, 0);
    EXPECT_EQ(solve(0).sig_a2, 0);
    for (const double r : {1e-300, -1e-300, std::numeric_limits<double>::denorm_min()}) {
      const ImplicitRoot<double>::Root root = solve(r);
      EXPECT_TRUE(std::isfinite(root.z) && std::isfinite(root.sig_a1) && std::isfinite(root.sig_a2));
      EXPECT_LE(std::abs(root.z), std::abs(r));
    }
  }
}

TEST(ImplicitRoot, NeedsFewIterations) {
  for (const Case& c : cases) {
    const ImplicitRoot<double> solve(c.c1(), c.c2(), c.a1);
    for (double r = 1e-30; r < 10; r *= 1.1) EXPECT_LE(solve(r).iterations, 10) << c.a1 << " " << r;
  }
}

TEST(ImplicitRoot, FloatSolvesItToo) {
  Random random(4);
  for (const Case& c : cases) {
    const ImplicitRoot<float> solve(static_cast<float>(c.c1()), static_cast<float>(c.c2()), static_cast<float>(c.a1));
    for (int trial = 0; trial < 500; ++trial) {
      const float r = static_cast<float>(random.log_uniform(1e-12, 10));
      const ImplicitRoot<float>::Root root = solve(r);
      const double sum = double{root.z} + double{static_cast<float>(c.c1())} * double{root.sig_a1} +
                         double{static_cast<float>(c.c2())} * double{root.sig_a2};
      EXPECT_NEAR(sum, double{r}, 1.2e-5 * double{r}) << c.a1 << " " << r;  // as above with float's rounding
    }
  }
}

TEST(HalfPower, UsesProductsWithoutChangingTheResult) {
  for (const double exponent : {0.5, 1.0, 1.5, 2.0, 2.5, 8.0, 0.7142857, 9.0})
    for (const double x : {1e-20, 0.3, 1.0, 7.0})
      EXPECT_NEAR(HalfPower<double>(exponent)(x), std::pow(x, exponent), 1e-14 * std::pow(x, exponent)) << exponent;
}

}  // namespace
}  // namespace gyrostat::test::test_implicit_root
