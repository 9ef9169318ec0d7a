// SPDX-License-Identifier: MIT
// What a trait claims is a law, and every component of the catalogue that claims it is held to it.
#include <gtest/gtest.h>

#include "../../../benchmarks/scenarios.hpp"
#include "../flight/closed_loop.hpp"
#include "gyrostat/host/assembly.hpp"

namespace gyrostat::test::test_traits {
namespace {

/// The rotations that rename the axes and turn some of them round, but for the one that does nothing.
std::vector<Mat3<double>> renamings() {
  std::vector<Mat3<double>> out;
  for (int first = 0; first < 3; ++first) {
    for (int second = 0; second < 3; ++second) {
      for (int signs = 0; signs < 4; ++signs) {
        if (second == first) continue;
        Mat3<double> R = Mat3<double>::Zero();
        R(first, 0) = (signs & 1) != 0 ? -1 : 1;
        R(second, 1) = (signs & 2) != 0 ? -1 : 1;
        R.col(2) = R.col(0).cross(R.col(1));
        if (!R.isIdentity()) out.push_back(R);
      }
    }
  }
  return out;
}

/// The same vehicle in renamed axes.
host::Assembly renamed(host::Assembly a, const Mat3<double>& R) {
  a.setup.vehicle.J_B = R * a.setup.vehicle.J_B * R.transpose();
  a.setup.vehicle.D_B = R * a.setup.vehicle.D_B;
  return a;
}

Quat<double> renamed(const Quat<double>& q, const Mat3<double>& R) {
  const Vec3<double> v = R * q.vec();
  return {q.w(), v[0], v[1], v[2]};
}

/// A slew under a moving reference with a constant torque and, from half of the time on, a weak actuator; the second stack is
/// fed with the same motion in renamed axes. Largest difference between the commands, over the largest command, or between what the
/// observers find.
double difference(const host::Assembly& a, const Mat3<double>& R) {
  host::Stack one = host::make_stack(a, {}), other = host::make_stack(renamed(a, R), {});
  Body body(a.setup.vehicle);
  body.q_NB = quat_from_mrp<double>({0.1, 0.2, -0.3});
  body.omega_BN_B = {0.01, -0.02, 0.03};
  body.d_B = {2e-3, -3e-3, 1e-3};
  double worst = 0, largest = 0, found = 0;
  for (Tick k = 0; k < 400; ++k) {
    if (k == 200) body.effectiveness[1] = 0.5;
    Measurement<double> y = body.measured<double>(k), z = y;
    const double t = 0.01 * static_cast<double>(k);
    Reference<double> ref;
    ref.q_NR = quat_exp<double>({0.002 * t, 0.004 * t, -0.001 * t});
    ref.omega_RN_R = {0.002, 0.004, -0.001};
    Reference<double> moved = ref;
    moved.q_NR = renamed(ref.q_NR, R);
    moved.omega_RN_R = R * ref.omega_RN_R;
    z.q_NB = renamed(y.q_NB, R);
    z.omega_BN_B = R * y.omega_BN_B;
    const VecN<double>& u = one.step(y, ref).u;
    worst = std::max(worst, (u - other.step(z, moved).u).cwiseAbs().maxCoeff());
    largest = std::max(largest, u.cwiseAbs().maxCoeff());
    const Vec3<double>& d_B = one.estimate().d_B;
    found = std::max(found, (R * d_B - other.estimate().d_B).norm() / (1 + d_B.norm()));
    body.advance(u, 0.01);
  }
  return std::max(worst / std::max(largest, 1e-3), found);
}

TEST(Traits, AnAxiswiseComponentDoesNotKnowTheNamesOfTheBodyAxes) {
  const std::vector<Mat3<double>> ways = renamings();
  ASSERT_EQ(ways.size(), 23u);
  int held = 0;
  std::size_t turn = 0;
  for (const auto& [role, names] : host::families()) {
    if (role != "observer" && role != "detector" && role != "controller" && role != "allocator") continue;
    for (const std::string& name : names) {
      if (!host::describe(role, name).traits.axiswise) continue;
      host::Table s = bench::ftc_4rw("rk4");
      s.set("allow_unstable", true);
      s.set("observer", host::Table{{"type", "iterative_learning"}});  // something to divide by and to detect
      s.set(role, host::Table{{"type", name}});
      const host::Assembly a = host::assemble(s);
      for (int i = 0; i < 4; ++i, turn += 5)  // 5: no common factor with 23
        EXPECT_LT(difference(a, ways[turn % ways.size()]), 1e-9) << role << " " << name;
      ++held;
    }
  }
  EXPECT_GE(held, 4) << "one of each role at least";
}

/// The test above can fail: a law that treats one axis in a way of its own.
TEST(Traits, AComponentThatKnowsAnAxisIsNotAxiswise) {
  host::Table s = bench::ftc_4rw("rk4");
  s.set("allow_unstable", true);
  s.set("observer", host::Table{{"type", "adaptive_sliding_mode_effectiveness"}, {"L", bench::row({10, 20, 40})}});
  EXPECT_GT(difference(host::assemble(s), renamings()[7]), 1e-6);
}

}  // namespace
}  // namespace gyrostat::test::test_traits
