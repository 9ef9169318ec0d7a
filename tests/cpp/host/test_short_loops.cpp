// SPDX-License-Identifier: MIT
// One short closed loop for every part of the catalogue, whatever arrives later. Under the sanitizers this is where the
// erased components, their allocators' arithmetic and every fault, disturbance, reference and sensor are looked at.
#include <gtest/gtest.h>

#include <algorithm>

#include "../../../benchmarks/scenarios.hpp"
#include "gyrostat/host/catalogue.hpp"
#include "gyrostat/host/simulate.hpp"

namespace gyrostat::host::test_short_loops {
namespace {

using bench::row;

Table base() {
  Table s = bench::ftc_4rw("rk4");
  Table vehicle = *s.find("vehicle")->as<Table>();
  vehicle.set("orbit_rate", 1e-3);
  s.set("vehicle", vehicle);
  s.set("duration", 1.0);
  s.set("seed", 1);
  s.set("allow_unstable", true);
  s.set("faults",
        List{Table{{"type", "loss_of_effectiveness"}, {"actuator", 2}, {"t_on", 0.5037}, {"remaining", 0.4}}});
  s.set("record", Table{{"channels", List{"truth.*", "measurement.*", "reference.*", "estimate.*", "detection.*",
                                          "demand.*", "allocation.*"}}});
  return s;
}

/// A pair about x, behind the wheels.
Table thrusters() {
  return Table{{"positions", List{row({0, 0.5, 0}), row({0, -0.5, 0})}},
               {"directions", List{row({0, 0, 1}), row({0, 0, -1})}},
               {"thrust", 0.1}};
}

bool of_a_valve(const std::string& fault) { return fault == "leak" || fault == "slow_valve"; }

/// The part by its name, with what it needs beyond its defaults to do something.
Table part(const std::string& family, const std::string& name) {
  Table t{{"type", name}};
  if (family == "fault") {
    t.set("actuator", of_a_valve(name) ? 4 : 1);
    t.set("t_on", 0.2513);
  }
  if (name == "gyro" || name == "attitude") {
    t.set("noise", 1e-4);
    t.set("delay", 3);
    t.set("quantisation", 1e-5);
  }
  if (name == "rotor_slow_down") t.set("rate", 0.1);
  if (name.ends_with("_dropout")) t.set("t_on", 0.2);  // there is nothing to fly on before a first measurement
  if (name == "slew") {
    t.set("to_euler", row({0.3, 0.2, -0.1}));
    t.set("duration", 0.8);
  }
  if (name == "steps" && family == "reference") {
    t.set("times", row({0, 0.5}));
    t.set("euler", List{row({0, 0, 0}), row({0.1, 0, 0})});
  }
  if (name == "table" && family == "reference") {
    t.set("times", row({0, 0.5, 1}));
    t.set("q_NR", List{row({1, 0, 0, 0}), row({0.8, 0.36, 0.48, 0}), row({0.6, 0.48, 0.64, 0})});
  }
  if (name == "bang_bang") {
    t.set("angle", 0.3);
    t.set("rate_max", 0.5);
    t.set("acceleration_max", 2.0);
  }
  if (name == "plates") {
    t.set("area", row({0.5}));
    t.set("normal_B", List{row({0, 0, 1})});
    t.set("centre_B", List{row({0.3, 0, 0})});
  }
  if (name == "residual_dipole") t.set("dipole_B", row({0.1, 0.2, 0}));
  if (name == "target") {
    t.set("latitude", 0.2);
    t.set("longitude", 0.1);
  }
  if (name == "sun_sensor") t.set("noise", 1e-3);
  if (name == "magnetometer") t.set("noise", 1e-7);
  if (name == "sum") t.set("terms", List{Table{{"type", "square"}}, 1e-3});
  return t;
}

/// Four control moment gyros in place of the wheels.
Table on_gyros() {
  Table s = base();
  s.set("vehicle", Table{{"J_B", row({20, 17, 15})}});
  s.set("cmg",
        Table{{"gimbal_axes", List{row({0.8, 0, 0.6}), row({0, 0.8, 0.6}), row({-0.8, 0, 0.6}), row({0, -0.8, 0.6})}},
              {"spin_axes", List{row({0, 1, 0}), row({-1, 0, 0}), row({0, -1, 0}), row({1, 0, 0})}},
              {"rotor_momentum", 2.0},
              {"rate_max", 0.5}});
  return s;
}

Table with(const std::string& family, const std::string& name) {
  Table s = name == "rotor_slow_down" ? on_gyros() : base();
  const Table chosen = part(family, name);
  if (of_a_valve(name)) s.set("thrusters", thrusters());
  static const std::vector<std::string> on_an_orbit = {"plates",     "residual_dipole", "target",      "sun",
                                                       "two_vector", "sun_sensor",      "magnetometer"};
  if (std::find(on_an_orbit.begin(), on_an_orbit.end(), name) != on_an_orbit.end()) {
    s.find("vehicle")->as<Table>()->set("orbit_rate", Value());
    s.set("orbit", Table{{"semi_major_axis", 6.9e6}, {"inclination", 1.2}, {"sun_longitude", 1.0}});
  }
  if (family == "fault" || family == "disturbance" || family == "sensor") {
    s.set(family + "s", List{chosen});
  } else if (family == "waveform") {
    s.set("disturbances", List{Table{{"type", "periodic"}, {"torque_B", List{chosen, 0.0, 0.0}}}});
  } else {
    s.set(family, chosen);
  }
  return s;
}

void expect_completed(const Table& scenario, const std::string& what) {
  const RunResult r = simulate(scenario);
  EXPECT_EQ(r.end.code, RunEnd::Code::completed) << what << ": " << r.end.cause;
  EXPECT_EQ(r.t.size(), 101u) << what;
}

TEST(ShortLoops, EveryPartOfTheCatalogueFlies) {
  int flown = 0;
  for (const auto& [family, names] : families()) {
    if (family == "vehicle" || family == "truth" || family == "flexible" || family == "cmg" || family == "thrusters" ||
        family == "orbit" || family == "desaturation" || family == "initial" || family == "run")
      continue;
    for (const std::string& name : names) {
      expect_completed(with(family, name), family + " " + name);
      ++flown;
    }
  }
  EXPECT_GE(flown, 40);
}

/// Wheels on the body's axes, torquers beside them, a third of a day of torques from outside in a second.
TEST(ShortLoops, MagnetorquersOnAnOrbit) {
  for (const char* momentum : {"wheels", "total"}) {
    Table s = base();
    Table vehicle = *s.find("vehicle")->as<Table>();
    vehicle.set("orbit_rate", Value());
    vehicle.set("D_B", List{row({1, 0, 0, 1, 0, 0}), row({0, 1, 0, 0, 1, 0}), row({0, 0, 1, 0, 0, 1})});
    vehicle.set("magnetorquers", List{3, 4, 5});
    vehicle.set("wheel_inertia", row({0.05, 0.05, 0.05, 0, 0, 0}));
    s.set("vehicle", vehicle);
    s.set("orbit", Table{{"semi_major_axis", 6.9e6}, {"inclination", 1.2}});
    s.set("desaturation", Table{{"momentum", momentum}});
    const Table plates{{"type", "plates"},
                       {"area", row({0.5})},
                       {"normal_B", List{row({0, 0, 1})}},
                       {"centre_B", List{row({0.3, 0, 0})}},
                       {"density", 1e-12}};
    s.set("disturbances", List{Table{{"type", "gravity_gradient"}}, plates,
                               Table{{"type", "residual_dipole"}, {"dipole_B", row({0.1, 0, 0})}}});
    expect_completed(s, momentum);
  }
}

TEST(ShortLoops, FrictionMomentumAndOutputLimits) {
  Table s = base();
  s.set("truth",
        Table{{"viscous_friction", 1e-4}, {"coulomb_friction", 1e-3}, {"momentum_max", 0.05}, {"limit_on", "output"}});
  expect_completed(s, "friction");
}

TEST(ShortLoops, AppendagesThatBend) {
  Table s = base();
  s.set("flexible", Table{{"delta", List{row({0.9, -0.4, 0.3}), row({0.1, 0.5, -0.7})}}, {"omega", row({1.5, 3})}});
  expect_completed(s, "flexible");
}

TEST(ShortLoops, ThrustersBesideWheels) {
  for (const char* modulator : {"pwm", "pwpf", "proportional"}) {
    Table s = base(), t = thrusters();
    t.set("modulator", modulator);
    t.set("propellant_mass", 1e-5);
    s.set("thrusters", t);
    s.set("faults", List{Table{{"type", "hard_over"}, {"actuator", 5}, {"t_on", 0.3337}}});  // runs dry
    s.set("allocator", Table{{"type", "weighted_least_squares"}});
    expect_completed(s, modulator);
  }
}

TEST(ShortLoops, ControlMomentGyros) {
  Table s = on_gyros();
  s.set("allocator", Table{{"type", "singularity_robust"}});
  s.set("detector", Table{{"type", "evidence"}});
  s.set("observer", Table{{"type", "joint_kalman"}});
  expect_completed(s, "cmg");
}

TEST(ShortLoops, EveryObserverAsAShadow) {
  Table s = base();
  List shadows;
  for (const std::string& name : catalogue().observers.names())
    shadows.push_back(Table{{"observer", Table{{"type", name}}}});
  s.set("shadows", shadows);
  expect_completed(s, "shadows");
}

}  // namespace
}  // namespace gyrostat::host::test_short_loops
