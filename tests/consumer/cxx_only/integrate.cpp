// SPDX-License-Identifier: MIT
/// @file  CVODE of an installed gyrostat: y' = -y from 1.
#include <cmath>
#include <cstdio>

#include "gyrostat/truth/integrator.hpp"

int main() {
  double y = 1;
  gyrostat::truth::CvodeSolver solver(gyrostat::truth::Cvode{}, 1);
  solver.restart(0, &y);
  solver.advance([](double, const double* now, double* rate, const void*) noexcept { *rate = -*now; }, nullptr, 1, &y);
  std::printf("exp(-1) is wrong by %.1e\n", std::abs(y - std::exp(-1.0)));
  return std::abs(y - std::exp(-1.0)) < 1e-8 ? 0 : 1;  // its default tolerance is far below
}
