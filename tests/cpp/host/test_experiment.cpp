// SPDX-License-Identifier: MIT
// Many flights of one scenario. tests/python/test_experiment.py has the rest: paths, metrics, refusals, stacks.
#include "gyrostat/host/experiment.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <random>
#include <stdexcept>

#include "../../../benchmarks/scenarios.hpp"
#include "gyrostat/host/simulate.hpp"

namespace gyrostat::host::test_experiment {
namespace {

using bench::row;

Table noisy() {
  Table s = bench::ftc_4rw("rk4");
  s.set("duration", 10.0);
  s.set("dt", 0.1);
  s.set("sensors", List{Table{{"type", "gyro"}, {"noise", 1e-5}}});
  s.set("faults", List{Table{{"type", "loss_of_effectiveness"}, {"actuator", 2}, {"t_on", 3.0}, {"remaining", 0.4}}});
  return s;
}

Table measures() {
  return {{"peak", Table{{"metric", "window_max"}, {"signal", "error.mrp"}, {"t0", "last_fault"}}},
          {"torque", Table{{"metric", "window_norm"}, {"signal", "truth.lumped_mean_B"}}}};
}

Experiment experiment() { return Experiment(noisy(), {"faults.0.remaining", "initial.omega_BN_B"}, measures()); }

std::vector<double> drawn(std::size_t flights) {
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> uniform(0, 1);
  std::vector<double> values;
  for (std::size_t i = 0; i < flights; ++i) {
    values.push_back(uniform(random));
    for (int k = 0; k < 3; ++k) values.push_back(0.02 * (uniform(random) - 0.5));
  }
  return values;
}

bool same_bits(const std::vector<double>& a, const std::vector<double>& b) {
  return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(double)) == 0;
}

TEST(Experiment, GivesTheSameBitsOnAnyNumberOfThreadsAndAlone) {
  const Experiment e = experiment();
  ASSERT_EQ(e.columns().size(), 4U);
  const std::vector<double> values = drawn(12);
  const std::vector<Flight> one = e.fly(7, 12, values), many = e.fly(7, 12, values, {.threads = 3, .progress = {}});
  for (std::size_t i = 0; i < 12; ++i) {
    EXPECT_TRUE(same_bits(one[i].metrics, many[i].metrics)) << i;
    const std::span<const double> mine(values.data() + 4 * i, 4);
    const RunResult alone = simulate(e.scenario(7 + i, mine), {},
                                     {.channels = {"error.mrp", "truth.lumped_mean_B"},
                                      .record = true,
                                      .every = 1,
                                      .progress = {},
                                      .memory = unbounded});
    WindowMax peak;
    peak.t0 = 3.0;
    const std::vector<double> of_record{measured(peak, Series{alone.t, alone.channels[0].data}),
                                        measured(WindowNorm{}, Series{alone.t, alone.channels[1].data})};
    EXPECT_TRUE(same_bits(one[i].metrics, of_record)) << i;
  }
}

TEST(Experiment, EndsAFlightWhoseValuesFitNoVehicle) {
  const Experiment e(noisy(), {"vehicle.J_B.0.0"}, measures());
  const std::vector<double> values{20, 2000};
  const std::vector<Flight> flights = e.fly(0, 2, values);
  EXPECT_EQ(flights[0].end.code, RunEnd::Code::completed);
  EXPECT_EQ(flights[1].end.code, RunEnd::Code::refused);
  EXPECT_NE(flights[1].end.cause.find("triangle"), std::string::npos);
  EXPECT_TRUE(std::isnan(flights[1].metrics[0]));
}

TEST(Experiment, StopsWhenProgressThrows) {
  Table s = noisy();
  s.set("duration", 10000.0);
  const Experiment e(s, {"seed"}, Table{});
  const std::vector<double> values(500, 1.0);
  const auto refuse = [](std::size_t) { throw std::runtime_error("enough"); };
  EXPECT_THROW((void)e.fly(0, 500, values, {.threads = 2, .progress = refuse}), std::runtime_error);
}

TEST(Experiment, WantsOneValueAColumn) {
  const std::vector<double> values(7, 0.1);
  EXPECT_THROW((void)experiment().fly(0, 2, values), std::invalid_argument);
}

}  // namespace
}  // namespace gyrostat::host::test_experiment
