// SPDX-License-Identifier: MIT
/// @file  Seeded random inputs of tests.
#pragma once
#include <random>

#include "gyrostat/core/types.hpp"

namespace gyrostat::test {

class Random {
 public:
  explicit Random(unsigned seed) : engine_(seed) {}

  double uniform(double lo, double hi) { return std::uniform_real_distribution<double>(lo, hi)(engine_); }
  double log_uniform(double lo, double hi) { return std::exp(uniform(std::log(lo), std::log(hi))); }

  template <class S>
  Vec3<S> vector(double size) {
    const double x = uniform(-size, size), y = uniform(-size, size), z = uniform(-size, size);
    return {static_cast<S>(x), static_cast<S>(y), static_cast<S>(z)};
  }

  template <class S>
  Quat<S> attitude() {
    std::normal_distribution<double> normal;
    const double w = normal(engine_), x = normal(engine_), y = normal(engine_), z = normal(engine_);
    return Quat<S>(static_cast<S>(w), static_cast<S>(x), static_cast<S>(y), static_cast<S>(z)).normalized();
  }

 private:
  std::mt19937_64 engine_;
};

}  // namespace gyrostat::test
