// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <stdexcept>

#include "support.hpp"

namespace gyrostat::truth::test_disturbances {
namespace {

constexpr double half_pi = std::numbers::pi / 2;
const Vec3<double> omega{0.02, -0.03, 0.01};
const Quat<double> attitude = quat_from_euler<double>({0.2, -0.4, 1.1});

Vec3<double> torque_at(const Disturbance& d, double t, double orbit_rate = 0, const Quat<double>& q_NB = attitude) {
  Disturbances all({d}, test::total_inertia(), orbit_rate);
  all.enter(t);
  return all.torque_B(t, q_NB, omega);
}

void expect_near(const Vec3<double>& a, const Vec3<double>& b, double tolerance) {
  EXPECT_LE((a - b).cwiseAbs().maxCoeff(), tolerance) << a.transpose() << " against " << b.transpose();
}

TEST(Disturbances, Add) {
  Disturbances all({ConstantTorque{{1, 2, 3}}, PeriodicTorque{{SineWave{}, 0.5, StepsWave{{0, 10}, {0, 7}}}}},
                   test::total_inertia(), 0);
  all.enter(11);
  expect_near(all.torque_B(12, attitude, omega), {1 + std::sin(12.0), 2.5, 10}, 1e-15);
  EXPECT_TRUE(all.varies());
  EXPECT_EQ(all.next_switch(0), 10);
}

TEST(Disturbances, WithoutTimeOrStateInThemAreConstant) {
  Disturbances all({ConstantTorque{{1, 2, 3}}, PeriodicTorque{{1.0, 0.0, StepsWave{{0, 10}, {0, 7}}}}},
                   test::total_inertia(), 0);
  all.enter(5);
  EXPECT_FALSE(all.varies());
  EXPECT_EQ(all.constant_B(), Vec3<double>(2, 2, 3));
  all.enter(15);
  EXPECT_EQ(all.constant_B(), Vec3<double>(2, 2, 10));
}

// Li et al. 2018, section 5, with varsigma = 10 |omega|: the formula as printed.
TEST(Disturbances, RatePhaseIsLi2018) {
  const double a = 0.25e-3;
  const RatePhaseTorque d{.gain = 10,
                          .offset_B = a * Vec3<double>{-8, 12, 9},
                          .axis = {0, 0, 1, 1, 2, 2},
                          .amplitude = {2 * a, 3 * a, -1.5 * a, 3 * a, 3 * a, -6 * a},
                          .multiple = {10, 3, 2, 5, 10, 4},
                          .phase = {half_pi, 0, 0, half_pi, 0, 0}};
  const double t = 37.3, s = 10 * std::sqrt(0.02 * 0.02 + 0.03 * 0.03 + 0.01 * 0.01) * t;
  const Vec3<double> expected = a * Vec3<double>{2 * std::cos(10 * s) + 3 * std::sin(3 * s) - 8,
                                                 -1.5 * std::sin(2 * s) + 3 * std::cos(5 * s) + 12,
                                                 3 * std::sin(10 * s) - 6 * std::sin(4 * s) + 9};
  expect_near(torque_at(d, t), expected, 1e-16);
}

// Cao et al. 2022: 0.01 (|omega|^2 + 0.05) [sin 0.8 t; cos 0.5 t; cos 0.3 t].
TEST(Disturbances, RateScaledIsCao2022) {
  const RateScaledTorque d{.at_rest = 5e-4,
                           .growth = 0.01,
                           .wave_B = {SineWave{.omega = 0.8}, SineWave{.omega = 0.5, .phase = half_pi},
                                      SineWave{.omega = 0.3, .phase = half_pi}}};
  const double t = 12.0, k = 0.01 * (0.0014 + 0.05);
  expect_near(torque_at(d, t), k * Vec3<double>{std::sin(9.6), std::cos(6.0), std::cos(3.6)}, 1e-18);
}

// By hand for a body turned by angles about y alone, J diagonal: r = (-sin a, 0, cos a), torque_y = 3 n^2 (J_x - J_z) r_z r_x
// with a the pitch relative to the orbital frame, which itself has turned by -n t.
TEST(Disturbances, GravityGradientPullsTheLongAxisToNadir) {
  const double n = 1.1e-3, t = 500, pitch = 0.3;
  Disturbances all({GravityGradient{}}, Vec3<double>{20, 17, 15}.asDiagonal().toDenseMatrix(), n);
  all.enter(1);
  const Vec3<double> torque_B = all.torque_B(t, quat_from_euler<double>({0, pitch, 0}), omega);
  const double a = pitch + n * t;  // from the local vertical
  expect_near(torque_B, {0, 3 * n * n * (20 - 15) * -std::sin(a) * std::cos(a), 0}, 1e-20);
}

TEST(Disturbances, GravityGradientVanishesInTheOrbitalFrame) {
  const double n = 1.1e-3, t = 777;
  Disturbances all({GravityGradient{}}, Vec3<double>{20, 17, 15}.asDiagonal().toDenseMatrix(), n);
  all.enter(1);
  const Vec3<double> torque_B = all.torque_B(t, quat_from_euler<double>({0, -n * t, 0}), omega);  // B = O
  EXPECT_LE(torque_B.norm(), 1e-20);  // rounding of 3 n^2 J = 7e-5
}

TEST(Disturbances, RefuseWhatIsIncomplete) {
  EXPECT_THROW(torque_at(GravityGradient{}, 1), std::invalid_argument);  // no orbit
  EXPECT_THROW(torque_at(PeriodicTorque{{1.0, 2.0}}, 1), std::invalid_argument);
  EXPECT_THROW(torque_at(RatePhaseTorque{.axis = {0}, .amplitude = {1}, .multiple = {}, .phase = {0}}, 1),
               std::invalid_argument);
  EXPECT_THROW(torque_at(RatePhaseTorque{.axis = {3}, .amplitude = {1}, .multiple = {1}, .phase = {0}}, 1),
               std::invalid_argument);
}

}  // namespace
}  // namespace gyrostat::truth::test_disturbances
