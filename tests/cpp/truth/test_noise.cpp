// SPDX-License-Identifier: MIT
#include "gyrostat/truth/noise.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <vector>

namespace gyrostat::truth::test_noise {
namespace {

TEST(Noise, PhiloxIsThePublishedOne) {
  // Known answers of philox4x64-10: counter and key all zero.
  const auto zero = r123::Philox4x64()({{0, 0, 0, 0}}, {{0, 0}});
  EXPECT_EQ(zero[0], 0x16554d9eca36314cU);
  EXPECT_EQ(zero[3], 0x7e68b68aec7ba23bU);
}

TEST(Noise, LogarithmIsThatOfTheLibrary) {
  std::mt19937_64 random(1);
  for (int i = 0; i < 300000; ++i) {
    const double u = i % 3 == 0 ? std::ldexp(1.0, -static_cast<int>(random() % 53)) * (1 + 1e-12 * (i % 7))
                                : (static_cast<double>(random() >> 12) + 0.5) * 0x1p-52;
    if (u >= 1) continue;
    const long double exact = std::log(static_cast<long double>(u));
    // Two roundings of the largest part, and one of the sum.
    EXPECT_LE(std::abs(static_cast<double>(detail::logarithm(u) - exact)), 3e-16 * std::max(1.0L, -exact)) << u;
  }
}

TEST(Noise, CircleIsThatOfTheLibrary) {
  std::mt19937_64 random(2);
  for (int i = 0; i < 300000; ++i) {
    const double v = i < 64 ? i / 64.0 : static_cast<double>(random() >> 12) * 0x1p-52;
    const detail::OnCircle at = detail::circle(v);
    const long double angle = 2 * std::numbers::pi_v<long double> * v;
    EXPECT_LE(std::abs(static_cast<double>(at.cosine - std::cos(angle))), 3e-16) << v;
    EXPECT_LE(std::abs(static_cast<double>(at.sine - std::sin(angle))), 3e-16) << v;
  }
}

TEST(Noise, TheEndsOfAWordGiveFiniteNumbers) {
  EXPECT_NEAR(detail::radius(0), std::sqrt(106 * std::numbers::ln2), 1e-14);  // u = 2^-53
  EXPECT_NEAR(detail::radius(~std::uint64_t{0}), 0x1p-26, 1e-14);             // u = 1 - 2^-53
  EXPECT_TRUE(std::isfinite(detail::radius(std::uint64_t{1} << 63)));
}

// Kolmogorov and Smirnov's largest distance from the normal distribution: beyond 2.4 / sqrt(n) with a probability of 2e-5.
TEST(Noise, IsNormallyDistributed) {
  constexpr int n = 200000;
  for (int axis = 0; axis < 3; ++axis) {
    std::vector<double> x;
    for (Tick k = 0; k < n; ++k) x.push_back(standard_normals(11, 3, 2, k)[axis]);
    std::sort(x.begin(), x.end());
    double distance = 0;
    for (int i = 0; i < n; ++i) {
      const double F = 0.5 * std::erfc(-x[static_cast<std::size_t>(i)] / std::numbers::sqrt2);
      distance = std::max({distance, std::abs(F - static_cast<double>(i) / n), std::abs(F - (i + 1.0) / n)});
    }
    EXPECT_LE(distance, 2.4 / std::sqrt(n)) << axis;
    EXPECT_GT(x.back(), 3.8);
    EXPECT_LT(x.front(), -3.8);
  }
}

TEST(Noise, ASmallRotationIsTheExponential) {
  std::mt19937_64 random(3);
  std::uniform_real_distribution<double> uniform(-1, 1);
  for (int i = 0; i < 20000; ++i) {
    const double size = std::pow(10.0, -9 + 8 * (uniform(random) + 1) / 2);
    const Vec3<double> phi = size * Vec3<double>(uniform(random), uniform(random), uniform(random));
    const Quat<double> a = small_rotation(phi), b = quat_exp(phi);
    EXPECT_LE((a.coeffs() - b.coeffs()).cwiseAbs().maxCoeff(), 2.3e-16) << phi.transpose();
    EXPECT_LE((a.vec() - b.vec()).norm(), 4e-16 * phi.norm());
  }
}

}  // namespace
}  // namespace gyrostat::truth::test_noise
