// SPDX-License-Identifier: MIT
/// What is not an allocation problem is refused without a trace, and whatever the input, the command stays in its box.
#include <gtest/gtest.h>

#include <functional>

#include "flight/allocators/any_solver.hpp"

namespace gyrostat::test::test_bad_input {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();
const double not_a_number = std::numeric_limits<double>::quiet_NaN();

class BadInput : public testing::TestWithParam<Kind> {
 protected:
  std::unique_ptr<AnySolver> solver = GetParam().solver();
  Random random{17};
  std::size_t rows() const { return static_cast<std::size_t>(GetParam().rows); }
};
INSTANTIATE_TEST_SUITE_P(, BadInput, testing::ValuesIn(all_kinds()),
                         [](const auto& kind) { return name_of(kind.param); });

struct Spoiler {
  const char* what;
  std::function<void(Posed&)> spoil;
};

std::vector<Spoiler> spoilers_outside_the_box() {
  std::vector<Spoiler> out;
  for (const double bad : {not_a_number, infinity, -infinity}) {
    out.push_back({"demand", [bad](Posed& p) { p.demand[1] = bad; }});
    out.push_back({"effectiveness", [bad](Posed& p) { p.effectiveness[2] = bad; }});
    out.push_back({"preferred", [bad](Posed& p) { p.preferred[2] = bad; }});
    out.push_back({"effort_weight", [bad](Posed& p) { p.effort_weight[0] = bad; }});
    out.push_back({"bound", [bad](Posed& p) { p.bound[4] = bad; }});
    out.push_back({"residual_weight", [bad](Posed& p) { p.residual_weight = bad; }});
    out.push_back({"margin", [bad](Posed& p) { p.margin = bad; }});
  }
  for (const double bad : {0.0, -1.0}) {
    out.push_back({"effort_weight <= 0", [bad](Posed& p) { p.effort_weight[1] = bad; }});
    out.push_back({"residual_weight <= 0", [bad](Posed& p) { p.residual_weight = bad; }});
  }
  out.push_back({"bound < 0", [](Posed& p) { p.bound[0] = -0.1; }});
  out.push_back({"effectiveness < 0", [](Posed& p) { p.effectiveness[0] = -0.1; }});
  out.push_back({"margin < 0", [](Posed& p) { p.margin = -1; }});
  return out;
}

TEST_P(BadInput, IsRefusedWithThePreviousCommandAndAnUntouchedState) {
  for (const AllocationMode mode : {AllocationMode::lexicographic, AllocationMode::lexicographic_scaled,
                                    AllocationMode::weighted_least_squares, AllocationMode::robust_socp}) {
    Posed good = random_problem(random, rows(), 6);
    good.mode = mode;
    good.effectiveness.assign(6, 0.9);
    const Outcome before = solver->solve(good);
    const Numbers state = solver->state();
    for (const Spoiler& spoiler : spoilers_outside_the_box()) {
      Posed bad = good;
      spoiler.spoil(bad);
      bad.up[3] = 0.01;  // the box moved meanwhile: the previous command is clipped to the new one
      bad.lo[3] = -0.01;
      const Outcome s = solver->solve(bad);
      EXPECT_EQ(s.status, AllocationStatus::bad_input) << spoiler.what;
      for (std::size_t i = 0; i < 6; ++i)
        EXPECT_EQ(s.command[i], std::clamp(before.command[i], s.q.lo[i], s.q.up[i])) << spoiler.what;
      EXPECT_EQ(solver->state(), state) << spoiler.what;
    }
  }
}

TEST_P(BadInput, InTheBoxItselfGivesZero) {
  const Posed good = random_problem(random, rows(), 6);
  solver->solve(good);
  const Numbers state = solver->state();
  const std::vector<Spoiler> spoilers{{"lo > up", [](Posed& p) { p.lo[2] = p.up[2] + 1; }},
                                      {"lo = nan", [](Posed& p) { p.lo[2] = not_a_number; }},
                                      {"up = nan", [](Posed& p) { p.up[0] = not_a_number; }},
                                      {"up = -infinity", [](Posed& p) { p.up[0] = p.lo[0] = -infinity; }},
                                      {"lo = infinity", [](Posed& p) { p.up[0] = p.lo[0] = infinity; }}};
  for (const Spoiler& spoiler : spoilers) {
    Posed bad = good;
    spoiler.spoil(bad);
    const Outcome s = solver->solve(bad);
    EXPECT_EQ(s.status, AllocationStatus::bad_input) << spoiler.what;
    for (const certificate::Real t : s.command) EXPECT_EQ(t, 0) << spoiler.what;
    EXPECT_EQ(solver->state(), state) << spoiler.what;
  }
}

TEST_P(BadInput, ExcessiveEffectivenessIsClampedWithAWarning) {
  Posed p = random_problem(random, rows(), 6);
  p.effectiveness.assign(6, 1);
  const Outcome expected = solver->solve(p);
  p.effectiveness[1] = 1.2;
  solver->reset();
  const Outcome s = solver->solve(p);
  EXPECT_EQ(s.warnings, AllocationWarning::effectiveness_clamped);
  EXPECT_EQ(s.command, expected.command);
}

TEST_P(BadInput, OfAnySizeLeavesTheCommandInTheBox) {
  for (const AllocationMode mode : {AllocationMode::lexicographic, AllocationMode::lexicographic_scaled,
                                    AllocationMode::weighted_least_squares, AllocationMode::robust_socp})
    for (int k = 0; k < 300; ++k) {
      Posed p = random_problem(random, rows(), 6);
      p.mode = mode;
      p.worst_case = WorstCase(k % 3);
      const auto wild = [&] { return random.log_uniform(1e-30, 1e30) * (random.uniform(0, 1) < 0.5 ? -1 : 1); };
      for (double& x : p.demand) x = wild();
      for (double& x : p.preferred) x = wild();
      for (double& x : p.effort_weight) x = std::abs(wild());
      for (double& x : p.bound) x = std::abs(wild());
      p.residual_weight = std::abs(wild());
      p.margin = std::abs(wild());
      if (k % 2 == 0)
        for (std::size_t i = 0; i < 6; ++i) {
          const double a = wild(), b = wild();
          p.lo[i] = std::min(a, b);
          p.up[i] = std::max(a, b);
        }
      if (k % 5 == 0) p.lo[1] = -infinity;
      const Outcome s = solver->solve(p);  // warm from the one before
      EXPECT_EQ(certificate::box_violation(s.q, s.command), 0) << int(mode) << ' ' << k;
      for (const certificate::Real t : s.command) EXPECT_TRUE(std::isfinite(t)) << int(mode) << ' ' << k;
      EXPECT_LE(s.newton, 200);
    }
}

TEST_P(BadInput, AnActuatorBelowTheLeastEffectivenessIsLeftWhereItIsPreferred) {
  Posed p = random_problem(random, rows(), 8);
  p.effectiveness.assign(8, 0.8);
  p.effectiveness[3] = GetParam().single ? 0.009 : 0.0009;
  p.preferred.assign(8, 0);
  for (double& u : p.demand) u *= 3;  // out of reach: a weak actuator would be driven to its limit for nothing
  const Outcome s = solver->solve(p);
  EXPECT_EQ(s.command[3], 0);
  p.effectiveness[3] *= 1.2;
  solver->reset();
  EXPECT_NE(solver->solve(p).command[3], 0);
}

TEST_P(BadInput, ADemandBeyondTheScalarIsClampedWithAWarning) {
  Posed p = random_problem(random, rows(), 8);
  EXPECT_EQ(solver->solve(p).warnings & AllocationWarning::demand_clamped, 0);
  p.demand[0] = 1e20;
  solver->reset();
  EXPECT_NE(solver->solve(p).warnings & AllocationWarning::demand_clamped, 0);
}

TEST_P(BadInput, ADirectionOfWhichNothingCanBeHadIsSaid) {
  Posed p = random_problem(random, rows(), 8);
  p.mode = AllocationMode::lexicographic_scaled;
  p.effectiveness.assign(8, 0.8);
  for (std::size_t i = 0; i < 8; ++i) p.lo[i] = p.up[i] = 0.1;  // nothing to choose, and not zero
  const Outcome s = solver->solve(p);
  EXPECT_NE(s.warnings & AllocationWarning::direction_lost, 0);
  EXPECT_EQ(s.scale, 0);
  EXPECT_EQ(certificate::box_violation(s.q, s.command), 0);
}

}  // namespace
}  // namespace gyrostat::test::test_bad_input
