// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <stdexcept>

#include "support.hpp"

namespace gyrostat::truth::test_momentum_form {
namespace {

using namespace test;

/// Two wheels, one with friction, and two torquers; gravity gradient; a varying bias.
PlantModel mixed_vehicle() {
  PlantModel m = torquers(Rk4{});
  m.actuators.wheel_inertia = vec({0.05, 0, 0.08, 0});
  m.actuators.viscous_friction = vec({0, 0, 1e-3, 0});
  m.actuators.coulomb_friction = vec({0, 0, 2e-3, 0});
  m.faults = {LossOfEffectiveness{.window = {.actuator = 1}, .remaining = 0.5},
              Bias{.window = {.actuator = 3}, .torque = SineWave{0.1, 0.05, 2, 0}}};
  m.disturbances = {GravityGradient{}, ConstantTorque{{0.01, 0, -0.02}}};
  m.orbit_rate = 0.05;
  return m;
}

InitialState moving() { return {quat_from_mrp(sigma_0), {0.2, -0.3, 0.4}, vec({3, 0, -2, 0})}; }

// Newton and Euler in the rate form J w' = D delivered + d - w x (J w + D h_w), against the momentum form that is integrated.
TEST(MomentumForm, MomentumFormGivesTheRateOfTheRateForm) {
  const double h = 1e-3;
  RigidPlant plant(mixed_vehicle(), moving(), h);
  const VecN<double> u = vec({0.3, -0.2, 0.1, 0.4});
  const Vec3<double> w0 = plant.omega_BN_B();
  const VecN<double> h0 = plant.h_w();
  plant.advance(u);
  const TruthSample mid = plant.sample();
  plant.advance(u);
  const Vec3<double> slope = (plant.omega_BN_B() - w0) / (2 * h);
  EXPECT_LE((slope - mid.omegadot_BN_B).norm(), 1e-7);  // h^2 / 6 times w''' of order 0.1
  EXPECT_GT(mid.omegadot_BN_B.norm(), 1e-2);
  const VecN<double> wheel_slope = (plant.h_w() - h0) / (2 * h);
  EXPECT_NEAR(wheel_slope[0], -mid.delivered[0], 1e-9);
  EXPECT_NEAR(wheel_slope[2], -mid.delivered[2], 1e-9);  // friction is in `delivered`
  EXPECT_GT(std::abs(mid.delivered[2] - 0.1), 1e-3);     // and it is not small here
  EXPECT_EQ(plant.h_w()[1], 0);
}

TEST(MomentumForm, TotalMomentumInInertialSpaceChangesByTheExternalTorqueAlone) {
  PlantModel m = wheels(Rk4{});
  m.actuators.viscous_friction.setConstant(1e-3);
  m.faults = {Bias{.window = {.actuator = 3}, .torque = SineWave{0.1, 0.05, 2, 0}},
              StuckOutput{.window = {.actuator = 0, .t_on = 1.2345}, .torque = 0.1}};
  RigidPlant plant(m, driven_start(), 1e-2);
  const auto momentum_N = [&] {
    return Vec3<double>(plant.q_NB() * (m.J_B * plant.omega_BN_B() + torque<double>(m.D_B, plant.h_w())));
  };
  const Vec3<double> H0 = momentum_N();
  for (int k = 0; k < 2000; ++k) plant.advance(vec({0.02, -0.01, 0.03, 0.01}));
  EXPECT_LE((momentum_N() - H0).norm(), 1e-10 * H0.norm());  // rk4 at 10 ms: 2e-12 in attitude over 200 s
}

TEST(MomentumForm, RefusesWhatIsNoInertia) {
  PlantModel m = torquers();
  m.J_B(0, 1) = 1;  // not symmetric
  EXPECT_THROW(RigidPlant(m, free_start(), 0.01), std::invalid_argument);
  m.J_B = Vec3<double>{1, 1, -1}.asDiagonal();
  EXPECT_THROW(RigidPlant(m, free_start(), 0.01), std::invalid_argument);
  m = torquers();
  m.D_B.resize(3, 3);
  m.D_B.setIdentity();
  EXPECT_THROW(RigidPlant(m, free_start(), 0.01), std::invalid_argument);  // four actuators
}

}  // namespace
}  // namespace gyrostat::truth::test_momentum_form
