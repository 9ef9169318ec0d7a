// SPDX-License-Identifier: MIT
// Wheels that are full, or stand still in their bearings: what they do, when that ends, and what it costs.
#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>
#include <numbers>

#include "gyrostat/truth/standstill.hpp"
#include "random.hpp"
#include "support.hpp"

namespace gyrostat::truth::test_wheels {
namespace {

using namespace test;
using gyrostat::test::Random;

const Integrator all[] = {Cvode{.rtol = 1e-12, .atol = 1e-14}, Rk4{}, Auto{}};

constexpr double J = 10, Js = 0.05;

/// One wheel along x on a body of 10 kg m^2: everything has a closed form.
PlantModel one_wheel(const Integrator& integrator) {
  PlantModel m;
  m.J_B = Vec3<double>{J, 12, 9}.asDiagonal();
  m.D_B = Vec3<double>{1, 0, 0};
  m.actuators = Actuators::ideal(1);
  m.actuators.wheel_inertia[0] = Js;
  m.integrator = integrator;
  return m;
}

double speed(const RigidPlant& plant) { return plant.h_w()[0] / Js - plant.omega_BN_B()[0]; }
double momentum(const RigidPlant& plant) { return J * plant.omega_BN_B()[0] + plant.h_w()[0]; }

void hold(RigidPlant& plant, double u, int samples) {
  for (int k = 0; k < samples; ++k) plant.advance(VecN<double>::Constant(plant.h_w().size(), u));
}

// ---- the momentum limit ------------------------------------------------------------------------------------------------

TEST(FullWheels, RestAtTheirLimitAgainstFrictionForOnePieceASample) {
  for (const Integrator& integrator : all) {
    PlantModel m = wheels(integrator);
    m.actuators.momentum_max.setConstant(0.2);
    m.actuators.viscous_friction.setConstant(1e-3);
    m.actuators.coulomb_friction = vec({0, 1e-3, 0, 1e-3});
    RigidPlant plant(m, free_start(), 0.01);
    hold(plant, 0.05, 1000);  // full after about 4.5 s
    const IntegratorStatistics before = plant.statistics();
    hold(plant, 0.05, 1000);
    for (int i = 0; i < 4; ++i) {
      EXPECT_EQ(plant.h_w()[i], -0.2);
      EXPECT_EQ(plant.sample().delivered[i], 0);
    }
    EXPECT_EQ(plant.statistics().pieces - before.pieces, 1000u);
    EXPECT_LE(plant.statistics().steps - before.steps, 1500u);  // CVODE takes one a sample and some more at 1e-12
    EXPECT_LE(plant.statistics().restarts, 1u);
  }
}

// Against friction c s the wheel leaves its limit for the momentum at which both cancel: exponentially, at c (1/Js + 1/J).
TEST(FullWheels, ComeOffWhenFrictionWinsAndFollowTheClosedForm) {
  const double limit = 0.5, c = 1e-3, rate = c * (1 / Js + 1 / J);
  for (const Integrator& integrator : all) {
    PlantModel m = one_wheel(integrator);
    m.actuators.momentum_max[0] = limit;
    m.actuators.viscous_friction[0] = c;
    RigidPlant plant(m, {.h_w = vec({limit})}, 0.01);
    const double s0 = limit / Js;
    const auto u_of = [&](double balance) { return vec({-c * balance}); };  // holds the speed `balance`
    for (int k = 0; k < 500; ++k) plant.advance(u_of(s0 * 1.1));            // outward of what friction takes
    EXPECT_EQ(plant.h_w()[0], limit);
    EXPECT_EQ(plant.omega_BN_B()[0], 0);
    for (int k = 0; k < 500; ++k) plant.advance(u_of(s0 * 0.8));
    EXPECT_NEAR(speed(plant), s0 * (0.8 + 0.2 * std::exp(-rate * 5)),
                1e-9);  // cvode: rtol 1e-12 of 10 rad/s, 500 steps
    EXPECT_NEAR(momentum(plant), limit, 1e-15);
  }
}

TEST(FullWheels, AreClippedFromOneLimitToTheOtherHoweverOftenAndWithinASample) {
  for (const Integrator& integrator : all) {
    for (const double limit : {0.5, 0.01, 1e-5, 0.0}) {
      PlantModel m = one_wheel(integrator);
      m.actuators.momentum_max[0] = limit;
      RigidPlant plant(m, {.h_w = vec({limit})}, 0.01);
      Random random(1);
      double expected = limit;
      for (int k = 0; k < 2000; ++k) {
        const double u = random.uniform(-20, 20);  // 0.2 N m s a sample at most
        plant.advance(vec({u}));
        expected = std::clamp(expected - 0.01 * u, -limit, limit);
        ASSERT_NEAR(plant.h_w()[0], expected, 1e-11);  // 20 N m, the limit is met to 1e-12 s
        ASSERT_LE(std::abs(plant.h_w()[0]), limit);
        ASSERT_NEAR(momentum(plant), limit, 1e-14 * (1 + limit));
      }
      EXPECT_LE(plant.statistics().pieces, 4000u);  // a limit is met once a sample at most
    }
  }
}

TEST(FullWheels, WithALimitOfZeroGiveNothing) {
  for (const Integrator& integrator : all) {
    for (const double friction : {0.0, 1e-3}) {
      PlantModel m = one_wheel(integrator);
      m.actuators.momentum_max[0] = 0;
      m.actuators.viscous_friction[0] = m.actuators.coulomb_friction[0] = friction;
      for (const double u : {-1.0, 1.0}) {
        RigidPlant plant(m, {Quat<double>::Identity(), {0.1, 0, 0}, {}}, 0.01);
        hold(plant, u, 1);
        hold(plant, -u, 1);
        hold(plant, u, 10);
        EXPECT_EQ(plant.h_w()[0], 0);
        EXPECT_EQ(plant.omega_BN_B()[0], 0.1);
        EXPECT_EQ(plant.sample().delivered[0], 0);
      }
    }
  }
}

// ---- dry friction ------------------------------------------------------------------------------------------------------

TEST(StandingWheels, StayUntilTheDriveExceedsDryFriction) {
  const double dry = 0.02, dt = 0.1, samples = 50;
  for (const Integrator& integrator : all) {
    PlantModel m = one_wheel(integrator);
    m.actuators.coulomb_friction[0] = dry;
    for (const double sign : {-1.0, 1.0}) {
      RigidPlant plant(m, {}, dt);
      hold(plant, sign * 0.999 * dry, 50);
      EXPECT_EQ(plant.h_w()[0], 0);
      EXPECT_EQ(plant.omega_BN_B()[0], 0);
      EXPECT_EQ(plant.sample().delivered[0], 0);
      hold(plant, sign * 1.5 * dry, 50);
      EXPECT_NEAR(plant.h_w()[0], -sign * 0.5 * dry * samples * dt, 1e-15);
      EXPECT_DOUBLE_EQ(plant.sample().delivered[0], sign * 0.5 * dry);
      hold(plant, 0, 50);  // runs out after 2.5 s, half way
      EXPECT_NEAR(speed(plant), 0, 1e-15);
      EXPECT_NEAR(plant.omega_BN_B()[0], 0, 1e-15);  // all of it is back
    }
  }
}

// A body that is accelerated takes a standing wheel along: the wheel's inertia is the body's, its momentum Js w.
TEST(StandingWheels, TurnWithTheBodyUntilItIsAcceleratedTooMuch) {
  const double dry = 0.01, slow = 0.9 * dry * (J + Js) / Js, quick = 2 * slow;  // N m, from outside
  for (const Integrator& integrator : all) {
    PlantModel m = one_wheel(integrator);
    m.actuators.coulomb_friction[0] = dry;
    m.disturbances = {PeriodicTorque{{StepsWave{{0, 1.005}, {slow, quick}}, 0.0, 0.0}}};
    RigidPlant plant(m, {}, 0.01);
    hold(plant, 0, 100);
    EXPECT_NEAR(plant.omega_BN_B()[0], slow / (J + Js), 1e-14);
    EXPECT_NEAR(plant.h_w()[0], Js * slow / (J + Js), 1e-15);
    EXPECT_NEAR(plant.sample().delivered[0], -0.9 * dry, 1e-15);
    hold(plant, 0, 100);
    const double at_jump = slow * 1.005 / (J + Js), after = 0.995;
    EXPECT_NEAR(plant.omega_BN_B()[0], at_jump + (quick - dry) / J * after, 1e-13);
    EXPECT_NEAR(plant.h_w()[0], Js * at_jump + dry * after, 1e-14);
    EXPECT_NEAR(plant.sample().delivered[0], -dry, 1e-15);
  }
}

// Drive a sin t against dry friction: loose at asin(dry / a), at rest where the integral of the difference vanishes, loose
// again half a turn later.
TEST(StandingWheels, SlipAndStickUnderASineAtTheTimesOfTheClosedForm) {
  const double a = 0.05, dry = 0.03, loose = std::asin(dry / a);
  const auto given = [&](double t) { return a * (std::cos(loose) - std::cos(t)) - dry * (t - loose); };
  const double stop = bisect(2, std::numbers::pi + loose, 1e-15, [&](double t) { return given(t) < 0; });
  ASSERT_LT(stop, std::numbers::pi + loose - 0.1);  // it stands for a while
  for (const Integrator& integrator : all) {
    PlantModel m = one_wheel(integrator);
    m.actuators.coulomb_friction[0] = dry;
    m.faults = {Bias{.window = {.actuator = 0}, .torque = SineWave{0, a, 1, 0}}};
    RigidPlant plant(m, {}, 0.01);
    const auto at = [&](double t) {
      plant.advance_to(vec({0}), t);
      return plant.h_w()[0];
    };
    EXPECT_EQ(at(loose - 1e-6), 0);
    EXPECT_NEAR(at(2.0), -given(2), 1e-10);  // the sine is fitted to 4e-9 of its amplitude, so is the time it lets go
    EXPECT_NEAR(at(stop - 1e-3), -given(stop - 1e-3), 1e-10);
    EXPECT_NEAR(at(stop + 1e-6), 0, 1e-10);
    EXPECT_NEAR(at(std::numbers::pi + loose - 1e-6), 0, 1e-10);
    EXPECT_NEAR(at(std::numbers::pi + 2.0), given(2), 1e-10);
    EXPECT_NEAR(momentum(plant), 0, 1e-15);
  }
}

TEST(StandingWheels, OfASmallVehicleComeToRestAtTenHertz) {
  const double small = 4.2e-6, dry = 2e-5;  // dry friction stops 0.5 rad/s in a sample
  for (const Integrator& integrator : {Integrator(Cvode{}), Integrator(Rk4{}), Integrator(Auto{})}) {
    PlantModel m = wheels(integrator);
    m.J_B = Vec3<double>{0.02, 0.018, 0.015}.asDiagonal();
    m.actuators.wheel_inertia.setConstant(small);
    m.actuators.coulomb_friction.setConstant(dry);
    RigidPlant plant(m, {.h_w = small * vec({10, -7, 3, 0.2})}, 0.1);
    hold(plant, 0, 100);
    const VecN<double> turn = plant.h_w() / small - project(pyramid(), plant.omega_BN_B());
    EXPECT_LE(turn.norm(), 1e-17 / small);  // rounding of h_w
    EXPECT_EQ(plant.sample().delivered.norm() > dry, false);
  }
}

/// Every combination of directions, by the definition: the one that is right.
std::vector<int> by_enumeration(const std::vector<StandingWheel>& wheels, const Mat3<double>& J_B,
                                const Vec3<double>& torque_B) {
  const std::size_t n = wheels.size();
  std::size_t combinations = 1;
  for (std::size_t i = 0; i < n; ++i) combinations *= 3;
  for (std::size_t c = 0; c < combinations; ++c) {
    std::vector<int> direction(n);
    std::size_t rest = c;
    for (std::size_t i = 0; i < n; ++i, rest /= 3) direction[i] = static_cast<int>(rest % 3) - 1;
    // Unknown: body acceleration and the friction of each wheel that stays.
    const auto size = static_cast<Eigen::Index>(3 + n);
    Eigen::MatrixXd A = Eigen::MatrixXd::Zero(size, size);
    Eigen::VectorXd b = Eigen::VectorXd::Zero(size);
    A.topLeftCorner(3, 3) = J_B;
    b.head(3) = torque_B;
    for (std::size_t i = 0; i < n; ++i) {
      const auto row = static_cast<Eigen::Index>(3 + i);
      const StandingWheel& w = wheels[i];
      A.block(0, row, 3, 1) = -w.axis_B;
      b.head(3) += w.drive * w.axis_B;
      A(row, row) = 1;
      b[row] = direction[i] * w.dry;
      if (direction[i] == 0) {  // -(u + r) / Js = g . w'
        A.block(row, 0, 1, 3) = w.inertia * w.axis_B.transpose();
        b[row] = -w.drive;
      }
    }
    const Eigen::VectorXd x = A.partialPivLu().solve(b);
    bool right = true;
    for (std::size_t i = 0; i < n && right; ++i) {
      const StandingWheel& w = wheels[i];
      const double friction = x[static_cast<Eigen::Index>(3 + i)];
      const double slip = -(w.drive + friction) / w.inertia - w.axis_B.dot(x.head(3));
      right = direction[i] == 0 ? std::abs(friction) <= w.dry : direction[i] * slip >= 0;
    }
    if (right) return direction;
  }
  return {};
}

TEST(StandingWheels, BreakLooseTogetherAsEnumerationFinds) {
  Random random(7);
  int loose = 0, standing = 0;
  for (int k = 0; k < 300; ++k) {
    const Mat3<double> turn = random.attitude<double>().toRotationMatrix();
    const Mat3<double> J_B = turn * Vec3<double>{1, 0.8, 0.6}.asDiagonal() * turn.transpose();
    const Vec3<double> torque_B = random.vector<double>(2);
    Standstill found;
    std::vector<StandingWheel> wheels;
    for (int i = 0, n = 1 + k % 5; i < n; ++i) {  // heavy wheels, whose freedom depends on the others'
      wheels.push_back({i, random.vector<double>(1).normalized(), random.log_uniform(0.01, 1), random.uniform(-1, 1),
                        random.log_uniform(0.01, 1)});
      found.add(wheels.back());
    }
    found.settle(J_B, torque_B);
    const std::vector<int> expected = by_enumeration(wheels, J_B, torque_B);
    ASSERT_EQ(expected.size(), wheels.size());
    for (std::size_t i = 0; i < wheels.size(); ++i) {
      ASSERT_EQ(found.wheels[i].direction, expected[i]) << k;
      (expected[i] == 0 ? standing : loose) += 1;
    }
  }
  EXPECT_GT(loose, 100);
  EXPECT_GT(standing, 100);
}

// ---- work and accuracy -------------------------------------------------------------------------------------------------

TEST(InnerTime, QuickViscousFrictionIsFollowedByEveryIntegratorOrRefused) {
  const double dt = 0.1, J_eff = 1 / (1 / Js + 1 / J);
  for (const double constants : {0.3, 3.0, 50.0, 900.0}) {  // of the friction's time constants in a sample
    const double c = constants * J_eff / dt;
    for (const Integrator& integrator : all) {
      PlantModel m = one_wheel(integrator);
      m.actuators.viscous_friction[0] = c;
      RigidPlant plant(m, {.h_w = vec({Js * 10})}, dt);
      hold(plant, 0, 1);
      // rk4 takes steps of half a time constant: 4e-4 of the speed at their end, less of it as it dies out; the others'
      // tolerance is of a momentum of 0.5 N m s, 1e-9 of which are 1e-8 rad/s
      const double tolerance = std::holds_alternative<Rk4>(integrator) ? 4e-3 * std::exp(-0.5 * constants) : 0;
      EXPECT_NEAR(speed(plant), 10 * std::exp(-constants), tolerance + 1e-7) << constants;
      const double now = speed(plant), died = std::exp(-5 * constants);
      hold(plant, 0.1, 5);
      EXPECT_NEAR(speed(plant), now * died - 0.1 / c * (1 - died), 4e-3 * (0.1 / c + now * died)) << constants;
      EXPECT_LE(plant.statistics().steps, 6 * (3 + 40 * constants));
    }
  }
  PlantModel m = one_wheel(Rk4{});
  m.actuators.viscous_friction[0] = 1001 * J_eff / dt;
  try {
    const RigidPlant plant(m, {}, dt);
    FAIL() << "not refused";
  } catch (const std::invalid_argument& error) {
    EXPECT_NE(std::string(error.what()).find("actuator 0 (0.05 kg m^2) in 9.99e-05 s"), std::string::npos)
        << error.what();
  }
}

// A momentum wheel of 0.02 N m s in a body of 2e-3 kg m^2 precesses at 10 rad/s; rk4 would need 3.5 rad a step to blow up.
TEST(InnerTime, QuickPrecessionAtTwoHertzIsFollowedByEveryIntegrator) {
  for (const Integrator& integrator : all) {
    PlantModel m = wheels(integrator);
    m.J_B = Vec3<double>{2e-3, 1.8e-3, 1.5e-3}.asDiagonal();
    m.actuators.wheel_inertia.setConstant(1e-5);
    RigidPlant plant(m, {quat_from_mrp(sigma_0), {0.05, 0.02, 0}, vec({0.01, 0.01, 0.01, 0.01})}, 0.5);
    const auto energy = [&] { return plant.omega_BN_B().dot(m.J_B * plant.omega_BN_B()); };
    const double before = energy();
    hold(plant, 0, 200);
    // The body has 1e-4 of 0.02 N m s. Error controlled: 1e-9 of those a step, some 4000 steps. Half a radian a step
    // costs rk4 at most 1e-4 of the amplitude (z^6 / 144 of its square), 20 steps a sample.
    EXPECT_NEAR(energy() / before, 1, std::holds_alternative<Rk4>(integrator) ? 0.5 : 1e-3);
  }
}

TEST(InnerTime, AStateThatTurnsAThousandTimesInASampleEndsTheRunWithItsTime) {
  for (const Integrator& integrator : all) {
    PlantModel m = one_wheel(integrator);
    m.disturbances = {ConstantTorque{{1e6, 0, 0}}};  // 1e4 rad/s more each 0.1 s
    RigidPlant plant(m, {}, 0.1);
    try {
      hold(plant, 0, 10);
      FAIL() << "no error";
    } catch (const IntegrationError& error) {
      EXPECT_NEAR(error.time, 0.1, 1e-12);  // at 1e4 rad/s
      EXPECT_NE(std::string(error.what()).find("more than 1000 times in a sample"), std::string::npos);
    }
  }
}

TEST(InnerTime, ASampleOfTooManyPiecesEndsTheRunWithItsTime) {
  for (const Integrator& integrator : {Integrator(Rk4{}), Integrator(Auto{})}) {
    PlantModel m = one_wheel(integrator);
    m.faults = {Intermittent{
        .window = {.actuator = 0, .t_on = 1.5}, .period = 1e-6, .torque = 0.1}};  // a million switches a second
    RigidPlant plant(m, {}, 1.0);
    hold(plant, 0, 1);
    try {
      hold(plant, 0, 1);
      FAIL() << "no error";
    } catch (const IntegrationError& error) {
      EXPECT_NEAR(error.time, 1.6, 1e-3);
      EXPECT_NE(std::string(error.what()).find("more than 200000 steps"), std::string::npos);
    }
  }
}

TEST(Auto, MeetsTheIndependentEndState) {
  const auto error = [](const Integrator& integrator, double dt) {
    return (run_driven(integrator, dt).omega_BN_B() - driven_omega).norm();
  };
  EXPECT_LE(error(Auto{}, 0.01), 1e-11);  // order 5 at 10 ms: below what its tolerance would allow
  EXPECT_LE(error(Auto{}, 1), 2e-8);      // 1e-9 a step, 200 samples
  EXPECT_LE(error(Auto{.rtol = 1e-13}, 1), 2e-12);
  EXPECT_GE(error(Auto{.rtol = 1e-5}, 1), error(Auto{}, 1));
}

/// Steps a sample under a law on a noisy rate: each command changes.
double steps_under_noise(const Integrator& integrator) {
  PlantModel m = wheels(integrator);
  m.J_B = Vec3<double>{0.02, 0.018, 0.015}.asDiagonal();
  m.actuators.wheel_inertia.setConstant(4.2e-6);
  m.actuators.viscous_friction.setConstant(1e-7);
  m.actuators.coulomb_friction.setConstant(2e-6);
  RigidPlant plant(m, free_start(), 0.1);
  Random random(3);
  for (int k = 0; k < 500; ++k) {
    const Vec3<double> rate = plant.omega_BN_B() + random.vector<double>(1e-3);
    plant.advance(-1.2e-3 * project(m.D_B, small_mrp(plant.q_NB())) - 9e-3 * project(m.D_B, rate));
  }
  return static_cast<double>(plant.statistics().steps) / 500;
}

TEST(Auto, DoesNotPayForCommandsThatChangeAtEverySampleAsAMethodWithHistoryDoes) {
  EXPECT_LE(steps_under_noise(Auto{}), 1.2);
  EXPECT_GE(steps_under_noise(Cvode{}), 4);
}

TEST(Plant, CvodeKeepsItsHistoryWhenWheelsFillStopAndTurn) {
  PlantModel m = wheels(Cvode{});
  m.actuators.momentum_max.setConstant(0.05);
  m.actuators.coulomb_friction.setConstant(2e-3);
  m.actuators.viscous_friction.setConstant(1e-4);
  RigidPlant plant(m, {quat_from_mrp(sigma_0), {0.02, -0.01, 0.02}, {}}, 0.01);
  for (int k = 0; k < 2000; ++k) plant.advance(0.01 * std::sin(0.02 * k) * vec({1, -0.7, 0.4, 0.2}));
  EXPECT_EQ(plant.statistics().restarts, 1u);
  EXPECT_GT(plant.statistics().pieces, 2010u);  // something happened
}

/// A vehicle with wheels of any kind of limit and friction, driven so that they meet them. No switch but the samples.
struct RandomFlight {
  PlantModel model;
  InitialState initial;
  double dt;
  std::vector<VecN<double>> commands;

  explicit RandomFlight(unsigned seed) {
    Random random(seed);
    const auto chance = [&](double p) { return random.uniform(0, 1) < p; };
    const double size = random.log_uniform(1e-4, 1e3);
    const int n = 1 + static_cast<int>(seed % 5), samples = 60;
    dt = std::array<double, 4>{0.5, 0.1, 0.01, 0.001}[seed % 4];
    const Mat3<double> turn = random.attitude<double>().toRotationMatrix();
    const Vec3<double> principal{random.uniform(0.6, 1), random.uniform(0.6, 1), random.uniform(0.6, 1)};
    model.J_B = size * turn * principal.asDiagonal() * turn.transpose();
    model.J_B = (0.5 * (model.J_B + model.J_B.transpose())).eval();
    model.D_B.resize(3, n);
    model.actuators = Actuators::ideal(n);
    Actuators& a = model.actuators;
    const double inertia = size * random.log_uniform(1e-4, 0.1);
    const double torque = inertia * random.log_uniform(0.01, 0.3) / dt, filled = 20 * torque * dt;
    initial.q_NB = random.attitude<double>();
    initial.omega_BN_B = random.vector<double>(std::min(0.2, 0.02 / dt));
    initial.h_w = VecN<double>::Zero(n);
    const bool dry = chance(0.6), viscous = chance(0.6), limited = chance(0.7);
    for (int i = 0; i < n; ++i) {
      model.D_B.col(i) = random.vector<double>(1).normalized();
      a.wheel_inertia[i] = inertia * random.uniform(0.5, 1.5);
      if (dry) a.coulomb_friction[i] = torque * random.log_uniform(1e-3, 2);
      if (viscous) a.viscous_friction[i] = inertia / dt * random.log_uniform(1e-4, 0.1);
      if (limited) a.momentum_max[i] = filled * random.uniform(0.2, 1);
      const double turned = a.wheel_inertia[i] * model.D_B.col(i).dot(initial.omega_BN_B);
      const double start = chance(0.3) ? turned : (chance(0.3) ? a.momentum_max[i] : filled * random.uniform(-1, 1));
      initial.h_w[i] = std::isfinite(start) ? std::clamp(start, -a.momentum_max[i], a.momentum_max[i]) : 0.0;
    }
    const VecN<double> amplitude = torque * VecN<double>::NullaryExpr(n, [&] { return random.uniform(-1, 1); });
    for (int k = 0; k < samples; ++k) {
      const double shape = seed % 3 == 0 ? 1 : (seed % 3 == 1 ? random.uniform(-1, 1) : ((k / 9) % 2 == 0 ? 1 : -1));
      commands.push_back(shape * amplitude);
    }
  }
};

struct Flown {
  Vec3<double> rate;
  VecN<double> h;
};

/// Flies it and holds what must hold under every integrator.
Flown fly(const RandomFlight& flight, const Integrator& integrator, double drift) {
  PlantModel m = flight.model;
  m.integrator = integrator;
  RigidPlant plant(m, flight.initial, flight.dt);
  const auto n = static_cast<std::uint64_t>(m.D_B.cols());
  const auto momentum_N = [&] {
    return Vec3<double>(plant.q_NB() * (m.J_B * plant.omega_BN_B() + torque<double>(m.D_B, plant.h_w())));
  };
  const Vec3<double> H0 = momentum_N();
  double largest = 0;
  for (const VecN<double>& u : flight.commands) {
    const std::uint64_t before = plant.statistics().pieces;
    plant.advance(u);
    if (std::holds_alternative<Rk4>(integrator)) {
      EXPECT_LE(plant.statistics().pieces - before, 1 + 2 * n);
    }
    largest = std::max(largest, plant.h_w().norm() + (m.J_B * plant.omega_BN_B()).norm());
    EXPECT_TRUE((plant.h_w().array().abs() <= m.actuators.momentum_max.array() * (1 + 2e-11)).all());  // met to 1e-11
  }
  EXPECT_LE((momentum_N() - H0).norm(), drift * largest);
  return {plant.omega_BN_B(), plant.h_w()};
}

// Three methods, one of them without error control, and CVODE with a history across all that happens.
TEST(Plant, RandomFlightsOfWheelsWithLimitsAndFrictionAgreeKeepMomentumAndAreBoundedInWork) {
  for (unsigned seed = 1; seed <= 240; ++seed) {
    const RandomFlight flight(seed);
    const double scale = flight.initial.h_w.norm() + flight.model.J_B.norm() * flight.initial.omega_BN_B.norm();
    const Flown a = fly(flight, Auto{.rtol = 1e-12}, 1e-9);
    // Error controlled: 1e-11 a step, hundreds of steps, wheels of 1e-4 of the body's momentum. rk4: up to half a radian
    // or half a time constant a step, 3e-4 each of what changes in it.
    for (const auto& [other, tolerance] : {std::pair<Integrator, double>{Cvode{.rtol = 1e-11, .atol = 1e-17}, 1e-7},
                                           std::pair<Integrator, double>{Rk4{}, 1e-3}}) {
      const Flown b = fly(flight, other, 1e-4);
      EXPECT_LE((flight.model.J_B * (a.rate - b.rate)).norm(), tolerance * scale) << seed;
      EXPECT_LE((a.h - b.h).norm(), tolerance * scale) << seed;
    }
  }
}

}  // namespace
}  // namespace gyrostat::truth::test_wheels
