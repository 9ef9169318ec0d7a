// SPDX-License-Identifier: MIT
// Spoilt inputs, a short set: every component of the catalogue gives finite commands inside their limits and flies normally
// again within the number of samples that tests/golden/recovery.csv states for it. The long set: benchmarks/abuse.cpp.
#include "abuse.hpp"

#include <gtest/gtest.h>

#include <fstream>
#include <map>
#include <sstream>

#include "gyrostat/host/catalogue.hpp"

namespace gyrostat::test::test_abuse {
namespace {

/// Stated recovery in samples, by "role name".
std::map<std::string, long> stated() {
  std::ifstream in(std::string(GYROSTAT_GOLDEN_DIR) + "/recovery.csv");
  std::map<std::string, long> out;
  for (std::string line; std::getline(in, line);) {
    if (line.empty() || line[0] == '#' || line.starts_with("role")) continue;
    std::stringstream cells(line);
    std::string role, name, samples;
    std::getline(cells, role, ',');
    std::getline(cells, name, ',');
    std::getline(cells, samples, ',');
    out[role + " " + name] = std::stol(samples);
  }
  return out;
}

TEST(Abuse, EveryComponentStaysFiniteInsideItsLimitsAndRecoversAsStated) {
  const std::map<std::string, long> table = stated();
  std::size_t tried = 0;
  for (const auto& [role, names] : host::families()) {
    if (role != "observer" && role != "detector" && role != "controller" && role != "allocator") continue;
    for (const std::string& name : names) {
      const std::string what = role + " " + name;
      ASSERT_TRUE(table.contains(what)) << what << ": state its recovery (bench_abuse) in tests/golden/recovery.csv";
      const bool regulates = role != "controller" || host::describe(role, name).traits.regulates;
      const Outcome o = abuse(loop_with(role, name), regulates, 6000, 7u);
      EXPECT_EQ(o.not_finite, 0) << what;
      EXPECT_EQ(o.outside, 0) << what;
      EXPECT_EQ(o.unrecovered, 0) << what << " after " << name_of(o.slowest_after);
      EXPECT_LE(o.slowest, table.at(what)) << what << " after " << name_of(o.slowest_after);
      EXPECT_GT(o.held, 0) << what << ": no input was spoilt";
      ++tried;
    }
  }
  EXPECT_EQ(tried, table.size()) << "recovery.csv names a component that is not in the catalogue";
}

/// Fifteen vehicles: 3, 4 and 16 actuators with finite, infinite, one-sided, zero and mixed limits. Each component flies five of
/// them. One actuator, and float: tests/cpp/contract/embedded.hpp.
TEST(Abuse, NoVehicleMakesAComponentLatch) {
  int turn = 0;
  for (const auto& [role, names] : host::families()) {
    if (role != "observer" && role != "detector" && role != "controller" && role != "allocator") continue;
    for (const std::string& name : names) {
      const bool regulates = role != "controller" || host::describe(role, name).traits.regulates;
      for (int i = 0; i < 5; ++i, ++turn) {
        const int which = turn * 4 % vehicles;  // no common factor
        const std::string what = role + " " + name + " on vehicle " + std::to_string(which);
        const Outcome o = abuse(loop_on(which, role, name), regulates && can_point(which), 1500, 11u, 20000);
        EXPECT_EQ(o.not_finite, 0) << what;
        EXPECT_EQ(o.outside, 0) << what;
        EXPECT_EQ(o.unrecovered, 0) << what << " after " << name_of(o.slowest_after);
      }
    }
  }
  EXPECT_GE(turn, vehicles) << "every vehicle has flown";
}

}  // namespace
}  // namespace gyrostat::test::test_abuse
