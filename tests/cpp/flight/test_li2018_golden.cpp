// SPDX-License-Identifier: MIT
// The first samples of the published stacks against an independent implementation: the exact discrete forms, the order inside
// one sample and the rules of the first one.
#include <gtest/gtest.h>

#include "../golden.hpp"
#include "gyrostat/core/attitude.hpp"
#include "li2018.hpp"
#include "telemetry_log.hpp"

namespace gyrostat::test::test_li2018_golden {
namespace {

Measurement<double> recorded(const Golden& golden, std::size_t k) {
  const std::vector<double> rho = golden.vector("rho", k), omega = golden.vector("omega", k);
  Measurement<double> y;
  y.tick = k;
  y.q_NB = quat_from_mrp<double>({rho[0], rho[1], rho[2]});
  y.omega_BN_B = {omega[0], omega[1], omega[2]};
  y.h_w = VecN<double>::Zero(4);
  return y;
}

void expect_published_stack(const char* file, double u_max) {
  const Golden golden(file);
  auto stack = li2018::stack(li2018::setup(u_max));
  for (std::size_t k = 0; k < golden_rows; ++k) {
    stack.step(recorded(golden, k), {});
    const auto observer = telemetry_of(stack.estimator.observer), controller = telemetry_of(stack.controller);
    expect_row(golden, "theta", k, observer.at("theta"));
    expect_row(golden, "z1", k, observer.at("z1"));
    expect_row(golden, "s", k, controller.at("s"));
    expect_row(golden, "rho_hat", k, controller.at("gain"));
    expect_row(golden, "v", k, values(stack.last().u));
  }
}

TEST(Li2018Golden, Table1) { expect_published_stack("li2018_table1.csv", 0.25); }
TEST(Li2018Golden, Table2WithTheCommandLimited) { expect_published_stack("li2018_table2_command_limit.csv", 0.25); }
TEST(Li2018Golden, Table2WithTheOutputLimited) {
  expect_published_stack("li2018_table2_output_limit.csv", std::numeric_limits<double>::infinity());
}

TEST(Li2018Golden, SaturatedPdTuned) {
  const Golden golden("li2018_table1_spd_tuned.csv");
  auto stack = li2018::pd_stack(li2018::setup<double>());
  for (std::size_t k = 0; k < golden_rows; ++k) {
    stack.step(recorded(golden, k), {});
    expect_row(golden, "v", k, values(stack.last().u));
  }
}

}  // namespace
}  // namespace gyrostat::test::test_li2018_golden
