// SPDX-License-Identifier: MIT
#include "gyrostat/host/reference.hpp"

#include <gtest/gtest.h>

#include <numbers>
#include <stdexcept>
#include <string>
#include <vector>

namespace gyrostat::host::test_reference {
namespace {

using V3 = Vec3<double>;

const ReferenceSpec moving[] = {
    Slew{.from = V3(0.1, -0.2, 0.3), .to = V3(-0.4, 0.5, 1.2), .start = 0.5, .duration = 4},
    MrpSine{.offset = V3(0.1, 0, -0.05),
            .amplitude = V3(0.1, 0.1, 0.1),
            .frequency = V3(0.8, 0.6, 0.7),
            .phase = V3(0, 1, 2)},
    EulerSine{.offset = V3(2, 0, 0),
              .amplitude = V3(0, 0.3, 0.5),
              .frequency = V3(0, 1, 2),
              .phase = V3(0, 0.4, std::numbers::pi / 2)},
    RateSine{.euler = V3(0.1, -0.1, 0.1),
             .amplitude = V3(0.02, 0.02, 0.02),
             .frequency = V3(0.08, 0.08, 0.08),
             .phase = V3(0, std::numbers::pi / 2, 1)},
    AttitudeTable{.times = {0, 2.1005, 4.2005},
                  .q_NR = {{1, 0, 0, 0}, {0.96, 0.28, 0, 0}, {0.936, 0.28, 0.168, -0.1296}}},
};

class MovingReference : public testing::TestWithParam<ReferenceSpec> {};
INSTANTIATE_TEST_SUITE_P(Kinds, MovingReference, testing::ValuesIn(moving));

// Central differences with dt = 1 ms leave dt^2/6 of the third derivative: below 2e-6 for these motions.
TEST_P(MovingReference, RateIsTheDerivativeOfTheAttitude) {
  const double dt = 1e-3;
  ReferencePath path(GetParam(), dt);
  for (Tick k = 1; k < 4000; k += 400) {
    const Quat<double> before = path.at(k - 1).q_NR;
    const Reference<double> now = path.at(k);
    const Quat<double> after = path.at(k + 1).q_NR;
    const V3 rate = quat_log<double>(before.conjugate() * after) / (2 * dt);
    EXPECT_LT((rate - now.omega_RN_R).norm(), 2e-6) << "tick " << k;
  }
}

TEST_P(MovingReference, AccelerationIsTheDerivativeOfTheRate) {
  const double dt = 1e-3;
  ReferencePath path(GetParam(), dt);
  for (Tick k = 1; k < 4000; k += 400) {
    const V3 before = path.at(k - 1).omega_RN_R;
    const V3 now = path.at(k).omegadot_RN_R;
    const V3 after = path.at(k + 1).omega_RN_R;
    EXPECT_LT(((after - before) / (2 * dt) - now).norm(), 5e-6) << "tick " << k;
  }
}

TEST_P(MovingReference, EulerSideFitsTheQuaternionSide) {
  const double dt = 1e-3;
  ReferencePath path(GetParam(), dt);
  for (Tick k = 0; k < 4000; k += 400) {
    const Reference<double> r = path.at(k);
    EXPECT_LT(rotation_angle<double>(quat_from_euler(r.euler.angles).conjugate() * r.q_NR), 1e-12);
    EXPECT_LT((euler_rate_matrix(r.euler.angles) * r.euler.rates - r.omega_RN_R).norm(), 1e-12);
  }
}

Quat<double> exp_of(double x, double y, double z) { return quat_exp<double>(V3(x, y, z)); }

AttitudeTable four_rows() {
  AttitudeTable table{.times = {0, 10, 25, 40}};
  for (const Quat<double>& q : {exp_of(.1, -.2, .3), exp_of(.3, .1, .2), exp_of(.8, .2, -.3), exp_of(.7, .9, -.4)})
    table.q_NR.push_back({q.w(), q.x(), q.y(), q.z()});
  return table;
}

// Rows by 50-digit arithmetic: the attitude alone differentiated, not the closed forms of rate and acceleration.
TEST(AttitudeTable, EqualsARowOfReferenceNumbers) {
  struct Row {
    Tick half_seconds;
    Quat<double> q;
    V3 omega, omegadot;
  };
  const Row rows[] = {{8,
                       {0.98649882543595302, 0.087143030559798954, -0.035458037054963053, 0.13404807811583108},
                       {0.022010395116489147, 0.029330678848280479, -0.010504463613639868},
                       {0.00016189470605941015, -0.00042630314978284563, -0.00033008442093545763}},
                      {35,
                       {0.95667559736102625, 0.28198606255734721, 0.068819799349206234, -0.022792480226217739},
                       {0.042862668021907524, -0.011408979527445321, -0.034679358996409337},
                       {-0.00069421386227426583, 0.00037248116596574665, -0.00019023065231496184}},
                      {66,
                       {0.87058224182608879, 0.37736104495611483, 0.25808351037764693, -0.18187386738572836},
                       {-0.01593023449425738, 0.04214211768587036, -0.025432192983580813},
                       {-0.0012603519267343193, 0.00091678085217936176, -8.7275353179227424e-06}}};
  AttitudeTable flipped = four_rows();
  for (double& element : flipped.q_NR[2]) element = -element;
  for (const AttitudeTable& table : {four_rows(), flipped}) {
    ReferencePath path(table, 0.5);
    for (const Row& row : rows) {
      const Reference<double> r = path.at(row.half_seconds);
      EXPECT_LT((r.q_NR.coeffs() - row.q.coeffs()).norm(), 1e-14);
      EXPECT_LT((r.omega_RN_R - row.omega).norm(), 1e-15);
      EXPECT_LT((r.omegadot_RN_R - row.omegadot).norm(), 1e-15);
    }
  }
}

TEST(AttitudeTable, PassesItsRowsAtTheGivenRatesAndRestsOutside) {
  AttitudeTable table = four_rows();
  for (double& time : table.times) time += 1;
  table.omega_RN_R = {{0, 0, 0}, {0.01, -0.02, 0.03}, {0, 0.01, 0}, {0, 0, 0}};
  ReferencePath path(table, 1);
  for (std::size_t i = 0; i < 4; ++i) {
    const auto knot = static_cast<Tick>(table.times[i]);
    const Reference<double> r = path.at(knot);
    const std::vector<double>&q = table.q_NR[i], &w = table.omega_RN_R[i];
    EXPECT_LT(rotation_angle<double>(Quat<double>(q[0], q[1], q[2], q[3]).conjugate() * r.q_NR), 1e-14);
    EXPECT_LT((r.omega_RN_R - V3(w[0], w[1], w[2])).norm(), 1e-15);
  }
  ReferencePath again(table, 1);
  EXPECT_LT(rotation_angle<double>(exp_of(.1, -.2, .3).conjugate() * again.at(0).q_NR), 1e-15);
  const Reference<double> late = again.at(60);
  EXPECT_LT(rotation_angle<double>(exp_of(.7, .9, -.4).conjugate() * late.q_NR), 1e-15);
  EXPECT_EQ(late.omega_RN_R, V3(0, 0, 0));
  EXPECT_EQ(late.omegadot_RN_R, V3(0, 0, 0));
}

std::string refusal(const ReferenceSpec& spec) {
  try {
    ReferencePath path(spec, 0.1);
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "accepted";
}

TEST(AttitudeTable, RefusesInOneLineWhatIsNoTable) {
  const auto changed = [](auto change) {
    AttitudeTable table = four_rows();
    change(table);
    return refusal(table);
  };
  EXPECT_EQ(refusal(AttitudeTable{}), "reference: 0 times and 0 attitudes; one a time belongs here, at least two");
  EXPECT_EQ(changed([](auto& t) { t.times[2] = 10; }), "reference: times must increase");
  EXPECT_EQ(changed([](auto& t) { t.q_NR[1].pop_back(); }), "reference: row 1 of q_NR has 3 numbers; 4 belong here");
  EXPECT_EQ(changed([](auto& t) { t.q_NR[1] = {1, 1, 0, 0}; }),
            "reference: row 1 of q_NR has norm 1.414214; a unit quaternion belongs here");
  const std::string far = changed([](auto& t) { t.q_NR[1] = {0, 0, 0, 1}; });
  EXPECT_EQ(far.rfind("reference: from row 0 to the next q_NR turns 2.", 0), 0U) << far;
  EXPECT_EQ(changed([](auto& t) { t.omega_RN_R = {{0, 0, 0}}; }),
            "reference: 4 times and 1 rates; one a time belongs here, or none");
}

TEST(BangBang, AcceleratesCoastsAndBrakes) {
  const V3 axis = V3(1, 2, 2) / 3;
  const V3 from(0.1, -0.2, 0.3);
  ReferencePath path(
      BangBang{
          .from = from, .axis = V3(2, 4, 4), .angle = 1.2, .rate_max = 0.02, .acceleration_max = 0.001, .start = 10},
      1);
  struct Row {
    Tick t;
    double angle, rate, acceleration;
  };
  for (const Row& row :
       {Row{9, 0, 0, 0}, Row{10, 0, 0, .001}, Row{15, .0125, .005, .001}, Row{30, .2, .02, 0}, Row{40, .4, .02, 0},
        Row{70, 1, .02, -.001}, Row{85, 1.1875, .005, -.001}, Row{90, 1.2, 0, 0}, Row{200, 1.2, 0, 0}}) {
    const Reference<double> r = path.at(row.t);
    const Quat<double> q = quat_from_euler<double>(from) * quat_exp<double>(row.angle * axis);
    EXPECT_LT(rotation_angle<double>(q.conjugate() * r.q_NR), 1e-14) << row.t;
    EXPECT_LT((r.omega_RN_R - row.rate * axis).norm(), 1e-16) << row.t;
    EXPECT_LT((r.omegadot_RN_R - row.acceleration * axis).norm(), 1e-18) << row.t;
  }
}

TEST(BangBang, TurnsBackBeforeARateThatItDoesNotNeed) {
  ReferencePath path(BangBang{.angle = 0.4, .rate_max = 1, .acceleration_max = 0.001}, 1);
  const Reference<double> middle = path.at(20);  // sqrt(0.4 / 0.001) = 20 s
  EXPECT_NEAR(middle.omega_RN_R.norm(), 0.02, 1e-16);
  EXPECT_NEAR(rotation_angle<double>(middle.q_NR), 0.2, 1e-14);
  EXPECT_NEAR(middle.omegadot_RN_R[2], -0.001, 1e-18);
  EXPECT_NEAR(rotation_angle<double>(path.at(40).q_NR), 0.4, 1e-14);
  EXPECT_EQ(refusal(BangBang{.axis = V3(0, 0, 0), .angle = 1, .rate_max = 1, .acceleration_max = 1}),
            "reference: axis is zero and names no direction");
}

// The Magnus step has local error O(dt^5): halving dt must gain 2^4 over a fixed time.
TEST(RateSine, IsIntegratedToFourthOrder) {
  const RateSine spec{.amplitude = V3(0.9, 0.7, 0.8), .frequency = V3(1.3, 1.7, 0.9), .phase = V3(0, 1, 2)};
  const auto end = [&](int steps) {
    ReferencePath path(spec, 10.0 / steps);
    Quat<double> q;
    for (int k = 0; k <= steps; ++k) q = path.at(static_cast<Tick>(k)).q_NR;
    return q;
  };
  const Quat<double> exact = end(20000);
  const double coarse = rotation_angle<double>(exact.conjugate() * end(50));
  const double fine = rotation_angle<double>(exact.conjugate() * end(100));
  EXPECT_NEAR(std::log2(coarse / fine), 4.0, 0.3);
}

TEST(Slew, EndsAtRestOnItsTarget) {
  ReferencePath path(Slew{.to = V3(0.3, -0.2, 2.0), .start = 1, .duration = 5}, 0.5);
  EXPECT_EQ(path.at(2).omega_RN_R.norm(), 0.0);
  const Reference<double> end = path.at(12);
  EXPECT_LT((end.euler.angles - V3(0.3, -0.2, 2.0)).norm(), 1e-14);
  EXPECT_LT(end.omega_RN_R.norm(), 1e-15);
}

TEST(Steps, JumpAtTheirSampleAndCountEvents) {
  ReferencePath path(Steps{.times = {0, 80}, .euler = {{0.3, 0, 0}, {0, 0.4, 0}}, .mrp = {}}, 0.01);
  EXPECT_EQ(path.at(0).event, 0u);
  EXPECT_EQ(path.at(7999).euler.angles[1], 0.0);
  EXPECT_EQ(path.at(8000).event, 1u);
  EXPECT_NEAR(path.at(8000).euler.angles[1], 0.4, 1e-15);
}

TEST(Hold, TakesOneWayToSayTheAttitude) {
  ReferencePath path(Hold{.mrp = V3(0.1, 0.2, -0.3)}, 0.1);
  EXPECT_LT((mrp(path.at(3).q_NR) - V3(0.1, 0.2, -0.3)).norm(), 1e-15);
  EXPECT_THROW(ReferencePath(Hold{.mrp = V3(0.1, 0, 0), .euler = V3(0.1, 0, 0)}, 0.1), std::invalid_argument);
}

TEST(Steps, RefuseWhatDoesNotFit) {
  EXPECT_THROW(ReferencePath(Steps{.times = {0, 1}, .euler = {{0, 0, 0}}, .mrp = {}}, 0.1), std::invalid_argument);
  EXPECT_THROW(ReferencePath(Steps{.times = {1, 0}, .euler = {{0, 0, 0}, {0, 0, 1}}, .mrp = {}}, 0.1),
               std::invalid_argument);
  EXPECT_THROW(ReferencePath(Steps{.times = {0}, .euler = {{0, 0}}, .mrp = {}}, 0.1), std::invalid_argument);
}

}  // namespace
}  // namespace gyrostat::host::test_reference
