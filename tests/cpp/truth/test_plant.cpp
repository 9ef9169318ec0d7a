// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <new>
#include <numbers>

#include "support.hpp"

namespace {
std::size_t allocations = 0;
}
void* operator new(std::size_t size, const std::nothrow_t&) noexcept {
  ++allocations;
  return std::malloc(size);
}
void* operator new(std::size_t size) {
  if (void* memory = operator new(size, std::nothrow)) return memory;
  throw std::bad_alloc();
}
// Not inlined: free() beside a new-expression looks like a mistake to g++.
[[gnu::noinline]] void operator delete(void* memory) noexcept { std::free(memory); }
[[gnu::noinline]] void operator delete(void* memory, std::size_t) noexcept { std::free(memory); }

namespace gyrostat::truth::test_plant {
namespace {

using namespace test;

const Integrator all[] = {Cvode{.rtol = 1e-12, .atol = 1e-14}, Rk4{}, Auto{.rtol = 1e-12}};

/// One actuator along x on a body of 10 kg m^2: everything has a closed form.
PlantModel one_axis(const Integrator& integrator, double Js = 0) {
  PlantModel m;
  m.J_B = Vec3<double>{10, 12, 9}.asDiagonal();
  m.D_B = Vec3<double>{1, 0, 0};
  m.actuators = Actuators::ideal(1);
  m.actuators.wheel_inertia[0] = Js;
  m.integrator = integrator;
  return m;
}

RigidPlant run(const PlantModel& m, const InitialState& initial, const VecN<double>& u, double duration,
               double dt = 0.01) {
  RigidPlant plant(m, initial, dt);
  const auto samples = std::llround(duration / dt);
  for (long k = 0; k < samples; ++k) plant.advance(u);
  return plant;
}

// ---- time of faults --------------------------------------------------------------------------------------------------

TEST(Plant, AFaultBetweenTwoSamplesActsFromItsTimeToItsTime) {
  for (const Integrator& integrator : all) {
    PlantModel m = one_axis(integrator);
    m.faults = {Bias{.window = {.actuator = 0, .t_on = 10.0037, .t_off = 11.0059}, .torque = 0.2}};
    const RigidPlant plant = run(m, {}, vec({0}), 12);
    EXPECT_NEAR(plant.omega_BN_B()[0], 0.2 * (11.0059 - 10.0037) / 10,
                1e-14);  // impulse / inertia, rounding of times of 10 s
    EXPECT_NEAR(mrp(plant.q_NB())[0], std::tan(0.25 * 0.02 * 1.0022 * (12 - 0.5 * (10.0037 + 11.0059))), 1e-11);
  }
}

TEST(Plant, ADrivenActuatorGivesWhatItIsToldAtItsTimesAndItsFaultsActOnThat) {
  for (const Integrator& integrator : all) {
    PlantModel m = one_axis(integrator, 0.05);
    m.J_B(0, 0) -= 0.05;  // less the wheel
    m.faults = {LossOfEffectiveness{.window = {.actuator = 0, .t_on = 2.01, .t_off = 3.05}, .remaining = 0.5}};
    RigidPlant plant(m, {}, 0.1);
    for (int k = 0; k < 100; ++k) {
      const double t = plant.time();
      plant.drive(0, std::array{DriveStep{t, 1.0}, DriveStep{t + 0.03, -0.5}});
      plant.advance(vec({9}));
    }
    // Of an interval 0.03 - 0.035; the fault takes half of ten intervals, its ends inside one being 0.02 and -0.01 N m s
    const double impulse = 100 * -0.005 - 0.5 * (0.02 - 0.035 + 9 * -0.005 + 0.03 - 0.01);
    EXPECT_NEAR(plant.h_w()[0], -impulse, 1e-13) << "rounding of times of 10 s";
    EXPECT_NEAR(plant.omega_BN_B()[0], impulse / 9.95, 1e-14);
    EXPECT_EQ(plant.sample().delivered[0], -0.5);
    if (std::holds_alternative<Cvode>(integrator)) {
      EXPECT_EQ(plant.statistics().restarts, 1u);
    }
  }
}

TEST(Plant, CvodeNeedsNoRestartForFaultsButForJumpsOfADisturbance) {
  PlantModel m = driven_model(Cvode{});
  m.faults = {Bias{.window = {.actuator = 0}, .torque = SquareWave{.low = -0.01, .high = 0.01, .period = 0.777}}};
  EXPECT_EQ(run(m, driven_start(), driven_command(true), 20).statistics().restarts, 1u);
  m.disturbances = {PeriodicTorque{{StepsWave{{0, 5.005, 10}, {0, 0.01, 0}}, 0.0, 0.0}}};
  EXPECT_EQ(run(m, driven_start(), driven_command(true), 20).statistics().restarts, 3u);
  m.disturbances = {PeriodicTorque{{TableWave{{0, 5.005, 10}, {0, 0.01, 0}}, 0.0, 0.0}}};  // kinks do not jump
  EXPECT_EQ(run(m, driven_start(), driven_command(true), 20).statistics().restarts, 1u);
}

/// All kinds of faults, switching between samples, on four wheels with an output limit.
PlantModel busy(const Integrator& integrator, double D) {
  PlantModel m = driven_model(integrator);
  m.actuators.u_up.setConstant(0.04);
  m.actuators.u_lo.setConstant(-0.04);
  m.actuators.limit_on = LimitOn::output;
  m.faults = {LossOfEffectiveness{.window = {.actuator = 2}, .remaining = SineWave{0.9, 0.07, 0.2, 0}},
              Bias{.window = {.actuator = 2}, .torque = SineWave{0, 0.05, 1, 0}},  // meets the output limit
              Intermittent{.window = {.actuator = 0, .t_on = 1.2345}, .period = 0.777, .duty = 0.4, .torque = 0.01},
              Drift{.window = {.actuator = 1, .t_on = 2.0003}, .rate = 1e-3},
              Lock{.window = {.actuator = 3, .t_on = 7.0071, .t_off = 12.3}},
              LossOfEffectiveness{.window = {.actuator = 3, .t_on = 3.003},
                                  .remaining = SquareWave{.low = 0.2, .high = 0.9, .period = 1.1}}};
  m.disturbances = {PeriodicTorque{{SquareWave{.low = -D, .high = D, .period = 3.33}, SineWave{0, D, 0.7, 0}, D}}};
  return m;
}

TEST(Plant, CvodeAndRk4AgreeWhenFaultsSwitchBetweenSamples) {
  const RigidPlant a = run(busy(all[0], 2e-3), driven_start(), driven_command(true), 20);
  const RigidPlant b = run(busy(Rk4{.substeps = 10}, 2e-3), driven_start(), driven_command(true), 20);
  EXPECT_LE((a.omega_BN_B() - b.omega_BN_B()).norm(), 1e-11);  // rtol 1e-12 over 2000 samples
  EXPECT_LE((a.h_w() - b.h_w()).norm(), 1e-14);                // the same quadrature of the same laws
  EXPECT_LE(rotation_angle<double>(a.q_NB().conjugate() * b.q_NB()), 1e-10);
}

TEST(Plant, SamplingFinerChangesNothingUnderConstantCommands) {
  const RigidPlant coarse = run(busy(all[0], 2e-3), driven_start(), driven_command(true), 20, 1.0);
  const RigidPlant fine = run(busy(all[0], 2e-3), driven_start(), driven_command(true), 20, 0.005);
  EXPECT_LE((coarse.omega_BN_B() - fine.omega_BN_B()).norm(), 1e-10);
  EXPECT_LE((coarse.h_w() - fine.h_w()).norm(),
            1e-10);  // kinks at the output limit are found to 1e-12 s, laws fitted to 4e-9
}

TEST(Plant, SwitchesWithinANanosecondOfASampleAreMovedOntoIt) {
  for (const double t_on : {5 - 4e-10, 5 + 4e-10}) {
    PlantModel m = one_axis(Rk4{});
    m.faults = {Dead{.window = {.actuator = 0, .t_on = t_on}}};
    const RigidPlant plant = run(m, {}, vec({0.1}), 6);
    EXPECT_EQ(plant.statistics().steps, 600u);  // no sample was split
    EXPECT_NEAR(plant.omega_BN_B()[0], 0.1 * 5 / 10, 1e-14);
  }
}

// ---- one-sided samples -----------------------------------------------------------------------------------------------

TEST(Plant, SamplesShowTheIntervalThatJustEnded) {
  PlantModel m = one_axis(Rk4{});
  m.faults = {LossOfEffectiveness{.window = {.actuator = 0, .t_on = 0.5}, .remaining = 0.25},
              Bias{.window = {.actuator = 0, .t_on = 0.5}, .torque = 0.03}};
  m.disturbances = {PeriodicTorque{{StepsWave{{0, 0.5}, {0, 1}}, 0.0, 0.0}}};
  RigidPlant plant(m, {}, 0.01);
  EXPECT_EQ(plant.sample().delivered[0], 0);
  EXPECT_EQ(plant.sample().effectiveness[0], 1);
  for (int k = 0; k < 50; ++k) plant.advance(vec({0.2}));
  EXPECT_EQ(plant.tick(), 50u);
  EXPECT_DOUBLE_EQ(plant.time(), 0.5);
  TruthSample before = plant.sample();
  EXPECT_EQ(before.effectiveness[0], 1);
  EXPECT_EQ(before.delivered[0], 0.2);
  EXPECT_EQ(before.external_B[0], 0);
  EXPECT_DOUBLE_EQ(before.omegadot_BN_B[0], 0.02);
  plant.advance(vec({0.4}));
  const TruthSample after = plant.sample();
  EXPECT_EQ(after.effectiveness[0], 0.25);
  EXPECT_EQ(after.bias[0], 0.03);
  EXPECT_DOUBLE_EQ(after.delivered[0], 0.13);
  EXPECT_EQ(after.external_B[0], 1);
}

TEST(Plant, ALockAtASampleFreezesTheCommandOfTheIntervalBefore) {
  PlantModel m = one_axis(Rk4{});
  m.faults = {Lock{.window = {.actuator = 0, .t_on = 1.0}}};
  RigidPlant plant(m, {}, 0.01);
  for (int k = 0; k < 100; ++k) plant.advance(vec({0.2}));
  for (int k = 0; k < 100; ++k) plant.advance(vec({-0.7}));
  EXPECT_DOUBLE_EQ(plant.sample().delivered[0], 0.2);
  EXPECT_NEAR(plant.omega_BN_B()[0], 0.2 * 2 / 10, 1e-14);
}

// ---- wheels ----------------------------------------------------------------------------------------------------------

// speed' = -c speed (1/Js + 1/J): wheel and body turn against each other.
TEST(Plant, ViscousFrictionSpinsAWheelDownExponentially) {
  const double Js = 0.05, J = 10, c = 0.01, speed = 80, t = 10;
  for (const Integrator& integrator : all) {
    PlantModel m = one_axis(integrator, Js);
    m.actuators.viscous_friction[0] = c;
    const RigidPlant plant = run(m, {.h_w = vec({Js * speed})}, vec({0}), t);
    const double end = speed * std::exp(-c * (1 / Js + 1 / J) * t);
    EXPECT_NEAR(plant.h_w()[0] / Js - plant.omega_BN_B()[0], end, 1e-9);  // cvode: rtol 1e-12 of 80 rad/s, 1000 steps
    EXPECT_NEAR(10 * plant.omega_BN_B()[0] + plant.h_w()[0], Js * speed, 1e-13);
    EXPECT_NEAR(plant.sample().delivered[0], c * end, 1e-10);
  }
}

// Far from standstill dry friction is constant: the speed falls linearly; then the wheel stands.
TEST(Plant, CoulombFrictionSpinsAWheelDownLinearlyAndHoldsIt) {
  const double Js = 0.05, J = 10, Tc = 0.02, rate = Tc * (1 / Js + 1 / J);
  for (const Integrator& integrator : all) {
    PlantModel m = one_axis(integrator, Js);
    m.actuators.coulomb_friction[0] = Tc;
    const RigidPlant moving = run(m, {.h_w = vec({Js * 10})}, vec({0}), 20);
    EXPECT_NEAR(moving.h_w()[0] / Js - moving.omega_BN_B()[0], 10 - rate * 20, 1e-9);
    const RigidPlant standing = run(m, {.h_w = vec({Js * 10})}, vec({0}), 60);
    EXPECT_NEAR(standing.h_w()[0] / Js - standing.omega_BN_B()[0], 0, 1e-9);
  }
}

TEST(Plant, AWheelAtItsMomentumLimitGivesNothingOutwardAndTurnsBackAtOnce) {
  const double limit = 0.5, u = 0.3;  // N m on the body; the limit is met at 1.6667 s, between samples
  for (const Integrator& integrator : all) {
    PlantModel m = one_axis(integrator, 0.05);
    m.actuators.momentum_max[0] = limit;
    RigidPlant plant(m, {}, 0.01);
    for (int k = 0; k < 300; ++k) plant.advance(vec({u}));
    EXPECT_NEAR(plant.h_w()[0], -limit, 1e-14);
    EXPECT_NEAR(plant.omega_BN_B()[0], limit / 10, 1e-14);
    EXPECT_NEAR(mrp(plant.q_NB())[0], std::tan(0.25 * (limit / 10) * (3 - 0.5 * limit / u)), 1e-11);
    EXPECT_EQ(plant.sample().delivered[0], 0);
    EXPECT_EQ(plant.sample().effectiveness[0], 1);  // no fault: the wheel is healthy but full
    for (int k = 0; k < 100; ++k) plant.advance(vec({-u}));
    EXPECT_NEAR(plant.h_w()[0], -limit + u, 1e-14);
  }
}

// Delivered a sin(w t): the wheel fills until 1 - cos(w t1) = w limit / a, waits until the law turns at pi, then empties.
TEST(Plant, AFullWheelWaitsUntilAVaryingTorqueTurns) {
  const double a = 0.1, w = 0.5, limit = 0.3;
  for (const Integrator& integrator : all) {
    PlantModel m = one_axis(integrator, 0.05);
    m.actuators.momentum_max[0] = limit;
    m.faults = {Bias{.window = {.actuator = 0}, .torque = SineWave{0, a, w, 0}}};
    RigidPlant plant(m, {}, 0.01);
    plant.advance_to(vec({0}), 6.0);
    EXPECT_NEAR(plant.h_w()[0], -limit, 1e-12);
    const double later = 9.0;
    plant.advance_to(vec({0}), later);
    EXPECT_NEAR(plant.h_w()[0], -limit - a / w * (std::cos(std::numbers::pi) - std::cos(w * later)), 1e-11);
    EXPECT_NEAR(10 * plant.omega_BN_B()[0] + plant.h_w()[0], 0, 1e-13);
  }
}

// ---- limits ----------------------------------------------------------------------------------------------------------

// e v + bias with |output| <= L: the integral of the clipped sine is known.
TEST(Plant, AnOutputLimitCutsAVaryingTorqueWhereItMeetsIt) {
  const double a = 0.5, w = 1.0, limit = 0.3, t1 = std::asin(limit / a), t = std::numbers::pi;
  for (const Integrator& integrator : all) {
    PlantModel m = one_axis(integrator);
    m.actuators.u_up[0] = limit;
    m.actuators.u_lo[0] = -limit;
    m.actuators.limit_on = LimitOn::output;
    m.faults = {Bias{.window = {.actuator = 0}, .torque = SineWave{0, a, w, 0}}};
    RigidPlant plant(m, {}, 0.01);
    for (int k = 0; k < 314; ++k) plant.advance(vec({0}));
    plant.advance_to(vec({0}), t);
    const double impulse = 2 * a * (1 - std::cos(t1)) + limit * (t - 2 * t1);
    EXPECT_NEAR(10 * plant.omega_BN_B()[0], impulse, 1e-11);
  }
}

// ---- the rest --------------------------------------------------------------------------------------------------------

TEST(Plant, AllocatesNothingFromSampleToSample) {
  for (const Integrator& integrator : all) {
    RigidPlant plant(busy(integrator, 2e-3), driven_start(), 0.01);
    const VecN<double> u = driven_command(true);
    const std::size_t before = allocations;
    for (int k = 0; k < 1500; ++k) plant.advance(u);
    EXPECT_EQ(allocations, before);
    EXPECT_GT(before, 0u);  // the counter works
  }
}

TEST(Plant, IsTheSameToTheBitWhenRunAgain) {
  for (const Integrator& integrator : all) {
    const RigidPlant a = run(busy(integrator, 2e-3), driven_start(), driven_command(true), 5);
    const RigidPlant b = run(busy(integrator, 2e-3), driven_start(), driven_command(true), 5);
    EXPECT_EQ(a.q_NB().coeffs(), b.q_NB().coeffs());
    EXPECT_EQ(a.omega_BN_B(), b.omega_BN_B());
    EXPECT_EQ(a.h_w(), b.h_w());
  }
}

TEST(Plant, MayBeMovedBetweenSamples) {
  RigidPlant a(driven_model(Cvode{}), driven_start(), 0.01);
  a.advance(driven_command(true));
  RigidPlant b = std::move(a);
  b.advance(driven_command(true));
  const RigidPlant c = run(driven_model(Cvode{}), driven_start(), driven_command(true), 0.02);
  EXPECT_EQ(b.omega_BN_B(), c.omega_BN_B());
}

TEST(Plant, TakesIntervalsOfAnyLength) {
  for (const Integrator& integrator : all) {
    RigidPlant plant(driven_model(integrator), driven_start(), 0.01);
    const Vec3<double> before = plant.omega_BN_B();
    plant.advance_to(driven_command(true), 0);
    EXPECT_LE((plant.omega_BN_B() - before).norm(), 1e-16);  // rounding of J^-1 J
    plant.advance_to(driven_command(true), 100);
    plant.advance_to(driven_command(false), 200);
    EXPECT_LE((plant.omega_BN_B() - driven_omega).norm(), 1e-10);
    EXPECT_EQ(plant.tick(), 20000u);
    EXPECT_THROW(plant.advance_to(driven_command(false), 199), std::invalid_argument);
  }
}

TEST(Plant, TorquersGiveWhatWheelsGiveWhenNothingIsStored) {
  // Along a principal axis the wheel's momentum does not turn the body's: only the inertia differs.
  PlantModel torquer = one_axis(Rk4{}), wheel = one_axis(Rk4{}, 0.05);
  const VecN<double> u = vec({0.1});
  EXPECT_NEAR(run(torquer, {}, u, 5).omega_BN_B()[0], run(wheel, {}, u, 5).omega_BN_B()[0], 1e-15);
}

TEST(Plant, SaysWhenTheStateIsNoLongerFinite) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  RigidPlant rk4(one_axis(Rk4{}), {}, 0.01);
  rk4.advance(vec({0}));
  try {
    rk4.advance(vec({nan}));
    FAIL() << "no error";
  } catch (const NonFiniteState& error) {
    EXPECT_DOUBLE_EQ(error.time, 0.02);
  }
  RigidPlant cvode(one_axis(Cvode{}), {}, 0.01);
  cvode.advance(vec({0}));
  EXPECT_THROW(cvode.advance(vec({nan})), std::runtime_error);
}

TEST(Plant, RefusesWhatDoesNotFit) {
  EXPECT_THROW(RigidPlant(one_axis(Rk4{}), {}, 0), std::invalid_argument);
  EXPECT_THROW(RigidPlant(one_axis(Rk4{.substeps = 0}), {}, 0.01), std::invalid_argument);
  EXPECT_THROW(RigidPlant(one_axis(Rk4{}), {.h_w = vec({1})}, 0.01),
               std::invalid_argument);  // a torquer stores nothing
  EXPECT_THROW(RigidPlant(one_axis(Rk4{}), {Quat<double>(0, 0, 0, 0), Vec3<double>::Zero(), {}}, 0.01),
               std::invalid_argument);
  RigidPlant plant(one_axis(Rk4{}), {}, 0.01);
  EXPECT_THROW(plant.advance(vec({1, 2})), std::invalid_argument);
}

}  // namespace
}  // namespace gyrostat::truth::test_plant
