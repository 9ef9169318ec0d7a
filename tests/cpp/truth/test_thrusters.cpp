// SPDX-License-Identifier: MIT
#include "gyrostat/truth/thrusters.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "gyrostat/truth/rigid_plant.hpp"

namespace gyrostat::truth::test_thrusters {
namespace {

const auto punctual = [](double) { return Span{0, 0}; };

Thrusters pulsed(double period, double tick, int min_on = 1, int min_off = 1) {
  Thrusters how;
  how.each.resize(1);
  how.period = period;
  how.tick = tick;
  how.min_on = min_on;
  how.min_off = min_off;
  return how;
}

/// s that a valve is open in [a, b], from edge to edge.
double open_time(const Valve& valve, double a, double b) {
  double sum = 0;
  for (double t = a; t < b;) {
    const double stop = std::min(valve.next_edge(t), b);
    if (valve.open(0.5 * (t + stop))) sum += stop - t;
    t = stop;
  }
  return sum;
}

TEST(Thrusters, APulseOfEveryLevelIsTheNearestNumberOfTicks) {
  for (const double period : {0.5, 0.1}) {
    for (const double tick : {period / 32, period / 100}) {
      const Thrusters how = pulsed(period, tick);
      const double N = how.ticks();
      for (int k = 0; k <= 1000; ++k) {
        const double level = k / 1000.0, fraction = level * N - std::floor(level * N);
        if (std::abs(fraction - 0.5) < 1e-9) continue;  // a tie is rounded as it comes
        Valve valve;
        valve.command(how, level, 3 * period, 4 * period, punctual);
        const double wanted = std::round(level * N) * tick;
        ASSERT_NEAR(open_time(valve, 3 * period, 4 * period), wanted, 1e-15) << level;
      }
    }
  }
}

TEST(Thrusters, ShortPulsesAndShortPausesAreNone) {
  const Thrusters how = pulsed(0.5, 1.0 / 64, 3, 4);
  for (int n = 0; n <= 32; ++n) EXPECT_EQ(how.open_ticks(n / 32.0), n < 3 ? 0 : n > 28 ? 32 : n) << n;
}

TEST(Thrusters, EdgesAreWholeTicksFromTheSample) {
  const Thrusters how = pulsed(0.1, 0.001);
  for (int k = 0; k < 1000; ++k) {
    Valve valve;
    const double t0 = k * 0.1;
    valve.command(how, 0.37, t0, (k + 1) * 0.1, punctual);
    EXPECT_EQ(valve.next_edge(t0), t0 + 37 * 0.001);
    EXPECT_TRUE(valve.open(t0));
    EXPECT_FALSE(valve.open(t0 + 37 * 0.001));
  }
}

TEST(Thrusters, CentredPulsesLieInTheMiddle) {
  Thrusters how = pulsed(0.5, 1.0 / 64);
  how.align = Thrusters::Align::centre;
  for (int n = 1; n < 32; ++n) {
    Valve valve;
    valve.command(how, n / 32.0, 1, 1.5, punctual);
    const double from = valve.next_edge(1), to = valve.next_edge(from);
    EXPECT_DOUBLE_EQ(0.5 * (from + to), 1.25);
    EXPECT_DOUBLE_EQ(to - from, n / 64.0);
  }
}

TEST(Thrusters, AValveSlowerThanThePulseDoesNotOpen) {
  const Thrusters how = pulsed(0.5, 1.0 / 64);
  Valve valve;
  valve.command(how, 8 / 32.0, 0, 0.5, [](double) { return Span{0.2, 0}; });  // 0.125 s
  EXPECT_EQ(open_time(valve, 0, 2), 0);
  valve.command(how, 16 / 32.0, 0.5, 1, [](double) { return Span{0.2, 0}; });  // 0.25 s
  EXPECT_NEAR(open_time(valve, 0.5, 2), 0.05, 1e-15);
  EXPECT_TRUE(valve.open(0.72));
}

TEST(Thrusters, APulseMayEndInTheNextPeriodAndTheUnionCounts) {
  const Thrusters how = pulsed(0.5, 1.0 / 64);
  Valve valve;
  const auto late = [](double) { return Span{0.1, 0.4}; };
  valve.command(how, 24 / 32.0, 0, 0.5, late);  // open from 0.1 to 0.775
  EXPECT_NEAR(open_time(valve, 0, 0.5), 0.4, 1e-15);
  valve.command(how, 8 / 32.0, 0.5, 1, late);  // open from 0.6 to 1.025
  EXPECT_NEAR(open_time(valve, 0.5, 1), 0.5, 1e-15);
  valve.command(how, 0, 1, 1.5, late);
  EXPECT_NEAR(open_time(valve, 1, 1.5), 0.025, 1e-15);
}

TEST(Thrusters, ADriveThatStaysOnOverASampleIsOnePulse) {
  const Thrusters how = pulsed(0.5, 1.0 / 64);
  const auto late = [](double) { return Span{0.7, 0}; };  // longer than the period
  Valve valve;
  double open = 0;
  for (int k = 0; k < 4; ++k) {
    valve.command(how, k < 3 ? 1 : 0, 0.5 * k, 0.5 * (k + 1), late);
    open += open_time(valve, 0.5 * k, 0.5 * (k + 1));
  }
  EXPECT_NEAR(open, 1.5 - 0.7, 1e-15);
}

// ---- pulse width and pulse frequency ---------------------------------------------------------------------------------

Thrusters frequent(double period) {
  Thrusters how = pulsed(period, 1);
  how.modulator = Thrusters::Modulator::pwpf;
  return how;
}

TEST(Pwpf, SwitchesAsTheClosedFormsSay) {
  const Pwpf m;
  const double K = m.gain, T = m.time_constant;
  struct {
    double r, on, off;
  } stated[] = {{0.3, 0.0130517, 0.0431523}, {0.7, 0.0273482, 0.0158041}};
  for (const auto& s : stated) {
    const double on = -T * std::log((m.off - K * (s.r - 1)) / (m.on - K * (s.r - 1)));
    const double off = -T * std::log((K * s.r - m.on) / (K * s.r - m.off));
    EXPECT_NEAR(on, s.on, 1e-7);
    EXPECT_NEAR(off, s.off, 1e-7);
    Valve valve;  // one long command; the first cycle starts from rest
    valve.command(frequent(10), s.r, 0, 10, punctual);
    double t = valve.next_edge(valve.next_edge(0));
    for (int cycle = 0; cycle < 20; ++cycle) {
      const double opens = valve.next_edge(t), closes = valve.next_edge(opens);
      EXPECT_NEAR(opens - t, off, 1e-12);
      EXPECT_NEAR(closes - opens, on, 1e-12);
      t = closes;
    }
  }
}

TEST(Pwpf, IsSilentInItsDeadBandAndStaysOpenBeyondSaturation) {
  const Pwpf m;
  Valve small, large;
  small.command(frequent(100), 0.999 * m.on / m.gain, 0, 100, punctual);
  EXPECT_EQ(open_time(small, 0, 100), 0);
  large.command(frequent(100), 1.001 + m.off / m.gain, 0, 100, punctual);
  EXPECT_EQ(large.next_edge(large.next_edge(0)), 100);
}

TEST(Pwpf, TheFilterGoesOnOverSamples) {
  Valve one, many;
  one.command(frequent(2), 0.4, 0, 2, punctual);
  double open = 0;
  for (int k = 0; k < 20; ++k) {
    many.command(frequent(0.1), 0.4, 0.1 * k, 0.1 * (k + 1), punctual);
    open += open_time(many, 0.1 * k, 0.1 * (k + 1));
  }
  EXPECT_NEAR(open, open_time(one, 0, 2), 1e-12);
}

TEST(Pwpf, FollowsAFinelySteppedSimulationUnderChangingLevels) {
  const Pwpf m;
  Valve valve;
  double f = 0, brute = 0, open = 0;
  bool y = false;
  constexpr double h = 1e-5;
  for (int k = 0; k < 50; ++k) {
    const double level = 0.5 + 0.5 * std::sin(0.7 * k), t0 = 0.1 * k, t1 = 0.1 * (k + 1);
    valve.command(frequent(0.1), level, t0, t1, punctual);
    open += open_time(valve, t0, t1);
    for (int j = 0; j < 10000; ++j) {
      f += h / m.time_constant * (m.gain * (level - y) - f);
      y = y ? f > m.off : f >= m.on;
      brute += y * h;
    }
  }
  EXPECT_NEAR(open, brute, 5e-3);  // some 200 edges of 1e-5 s each
}

// ---- faults ----------------------------------------------------------------------------------------------------------

Actuators one_thruster(double torque = 0.8) {
  Actuators a = Actuators::ideal(1);
  a.u_lo[0] = 0;
  a.u_up[0] = torque;
  a.thrusters = pulsed(0.5, 1.0 / 64);
  return a;
}

/// N m s, delivered in [0, t_end] under a level held from sample to sample.
double impulse(const std::vector<Fault>& faults, double level, double t_end) {
  FaultyActuators bank(one_thruster(), faults);
  double sum = 0;
  for (int k = 0; 0.5 * k < t_end; ++k) {
    const double t0 = 0.5 * k, t1 = 0.5 * (k + 1);
    bank.command(VecN<double>::Constant(1, level * 0.8), t0, t1);
    for (double t = t0; t < t1;) {
      const double stop = std::min(bank.next_switch(t + 1e-9), t1);
      bank.enter(t, 0.5 * (t + stop));
      sum += bank.constant_delivered(0) * (stop - t);
      t = stop;
    }
  }
  return sum;
}

constexpr Window from_the_start{.actuator = 0};

TEST(ThrusterFaults, DeliverWhatTheyLeaveOfAPulse) {
  const double healthy = 0.8 * 0.25;  // of half a period
  EXPECT_NEAR(impulse({}, 0.5, 0.5), healthy, 1e-15);
  EXPECT_NEAR(impulse({LossOfEffectiveness{from_the_start, 0.7}}, 0.5, 0.5), 0.7 * healthy, 1e-15);
  EXPECT_EQ(impulse({Dead{from_the_start}}, 0.5, 0.5), 0);
  EXPECT_NEAR(impulse({HardOver{from_the_start, 1}}, 0.5, 0.5), 0.8 * 0.5, 1e-15);
  EXPECT_EQ(impulse({HardOver{from_the_start, -1}}, 0.5, 0.5), 0);
  EXPECT_NEAR(impulse({Leak{from_the_start, 0.1}}, 0.5, 0.5), healthy + 0.1 * 0.8 * 0.25, 1e-15);
  EXPECT_NEAR(impulse({Leak{from_the_start, 0.1}}, 1, 0.5), 0.8 * 0.5, 1e-15);  // silent while open
  EXPECT_NEAR(impulse({SlowValve{from_the_start, 0.1, 0.05}}, 0.5, 0.5), 0.8 * 0.2, 1e-15);
  EXPECT_EQ(impulse({SlowValve{from_the_start, 0.3, 0}}, 0.5, 5), 0);
  EXPECT_NEAR(impulse({StuckOutput{from_the_start, 0.3}}, 0.5, 0.5), 0.15, 1e-15);  // a valve half open
}

TEST(ThrusterFaults, InsideAPulseSplitIt) {
  const Window inside{.actuator = 0, .t_on = 0.1, .t_off = 0.15};
  EXPECT_NEAR(impulse({Dead{inside}}, 0.5, 0.5), 0.8 * 0.2, 1e-15);
  EXPECT_NEAR(impulse({LossOfEffectiveness{inside, 0.5}}, 0.5, 0.5), 0.8 * (0.2 + 0.025), 1e-15);
  EXPECT_NEAR(impulse({Lock{{.actuator = 0, .t_on = 0.1}}}, 0.5, 1), 0.8, 1e-15);  // locked open
  EXPECT_NEAR(impulse({Lock{{.actuator = 0, .t_on = 0.3}}}, 0.5, 1), 0.2, 1e-15);  // locked closed
  EXPECT_NEAR(impulse({Leak{inside, 0.5}}, 0, 0.5), 0.5 * 0.8 * 0.05, 1e-15);
}

TEST(ThrusterFaults, ASlowValveIsLateWhereTheFaultIsActiveAtTheEdgeOfTheDrive) {
  EXPECT_NEAR(impulse({SlowValve{{.actuator = 0, .t_on = 0.1}, 0.1, 0.05}}, 0.5, 0.5), 0.8 * 0.3, 1e-15);
  EXPECT_NEAR(impulse({SlowValve{{.actuator = 0, .t_on = 0, .t_off = 0.1}, 0.1, 0.05}}, 0.5, 0.5), 0.8 * 0.15, 1e-15);
}

std::string refusal(const Fault& fault, const Actuators& actuators = one_thruster()) {
  try {
    FaultyActuators bank(actuators, {fault});
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "";
}

TEST(ThrusterFaults, ThatNoValveHasAreRefusedWithThoseThatItHas) {
  EXPECT_NE(refusal(Bias{from_the_start}).find("bias: not of a thruster, a valve adds no torque"), std::string::npos);
  EXPECT_NE(refusal(Drift{from_the_start}).find("leak, stuck or hard_over"), std::string::npos);
  EXPECT_NE(refusal(DeadZone{from_the_start}).find("slow_valve"), std::string::npos);
  EXPECT_NE(refusal(Intermittent{.window = from_the_start, .torque = 0.1}).find("leak"), std::string::npos);
  EXPECT_NE(refusal(StuckOutput{from_the_start, -0.1}).find("between closed and open"), std::string::npos);
  EXPECT_NE(refusal(LossOfEffectiveness{from_the_start, -0.1}).find("pushes one way"), std::string::npos);
  EXPECT_EQ(refusal(Intermittent{.window = from_the_start}), "");
  const Actuators torquer = Actuators::ideal(1);
  EXPECT_NE(refusal(Leak{from_the_start}, torquer).find("has no valve"), std::string::npos);
  EXPECT_NE(refusal(SlowValve{from_the_start}, torquer).find("has no valve"), std::string::npos);
}

TEST(Thrusters, SayWhatIsWrong) {
  const auto wrong = [](auto&& change) {
    Thrusters how = pulsed(0.5, 1.0 / 64);
    change(how);
    return how.check();
  };
  EXPECT_EQ(wrong([](Thrusters&) {}), "");
  EXPECT_NE(wrong([](Thrusters& t) { t.tick = 0.3; }).find("not a whole number of ticks"), std::string::npos);
  EXPECT_EQ(wrong([](Thrusters& t) { t.period = 0.1, t.tick = 0.001; }), "");
  EXPECT_NE(wrong([](Thrusters& t) { t.min_on = 33; }).find("must not exceed the 32 ticks"), std::string::npos);
  EXPECT_NE(wrong([](Thrusters& t) { t.each[0].Isp = 0; }).find("Isp must be positive"), std::string::npos);
  EXPECT_NE(wrong([](Thrusters& t) { t.propellant_mass = 0; }).find("propellant_mass"), std::string::npos);
  const auto pwpf = [&](Pwpf p) {
    return wrong([&](Thrusters& t) { t.modulator = Thrusters::Modulator::pwpf, t.pwpf = p; });
  };
  EXPECT_EQ(pwpf({}), "");
  EXPECT_NE(pwpf({.on = 0.1, .off = 0.2}).find("pwpf_off < pwpf_on"), std::string::npos);
  EXPECT_NE(pwpf({.gain = 0.2}).find("no level opens"), std::string::npos);
  EXPECT_NE(pwpf({.time_constant = 1e-5}).find("1000 times"), std::string::npos);
}

// ---- propellant ------------------------------------------------------------------------------------------------------

PlantModel small_plant(double propellant_mass, Integrator integrator) {
  PlantModel model;
  model.J_B = Vec3<double>(10, 12, 9).asDiagonal();
  model.D_B = Mat3N<double>(Mat3<double>::Identity());
  model.actuators = Actuators::ideal(3);
  model.actuators.u_lo.setZero();
  model.actuators.u_up.setConstant(0.8);
  model.actuators.thrusters = pulsed(0.5, 1.0 / 64);
  model.actuators.thrusters.each = {Thruster{Vec3<double>::UnitZ(), 0.8, 220},
                                    Thruster{Vec3<double>::UnitX(), 0.8, 220},
                                    Thruster{Vec3<double>::UnitY(), 0.8, 220}};
  model.actuators.thrusters.propellant_mass = propellant_mass;
  model.integrator = integrator;
  return model;
}

TEST(Propellant, RunsOutAtItsTime) {
  const double burn = 1 / (220 * Thrusters::g0);  // kg/s of one open valve of 1 N
  for (const Integrator& integrator : {Integrator(Rk4{}), Integrator(Cvode{}), Integrator(Auto{})}) {
    RigidPlant plant(small_plant(2.3 * burn, integrator), {}, 0.5);
    VecN<double> u(3);
    u << 0.8, 0.4, 0;  // 0.75 s of thrust a sample: empty in the fourth, in its pulse
    for (int k = 0; k < 8; ++k) plant.advance(u);
    EXPECT_NEAR(plant.state().propellant, 2.3 * burn, 1e-15);
    // 0.05 s are left for two valves in the fourth period: 0.025 s each
    EXPECT_NEAR(plant.state().thruster_impulse_B[2], 1.525, 1e-12);
    EXPECT_NEAR(plant.state().thruster_impulse_B[0], 0.775, 1e-12);
    EXPECT_EQ(plant.sample().delivered.norm(), 0);
  }
}

TEST(Propellant, RunsOutUnderAThrustThatVaries) {
  const double burn = 1 / (220 * Thrusters::g0);
  PlantModel model = small_plant(1.0 * burn, Rk4{});
  model.faults = {LossOfEffectiveness{{.actuator = 0}, SineWave{0.5, 0.3, 2, 0}}};
  RigidPlant plant(model, {}, 0.5);
  VecN<double> u(3);
  u << 0.8, 0, 0;
  for (int k = 0; k < 10; ++k) plant.advance(u);
  EXPECT_NEAR(plant.state().propellant, 1.0 * burn, 1e-14);
  EXPECT_NEAR(plant.state().thruster_impulse_B[2], 1.0, 1e-11);
}

TEST(Thrusters, CvodeIsNotRestartedAtTheEdgesOfValves) {
  RigidPlant plant(small_plant(infinity, Cvode{}), {}, 0.5);
  VecN<double> u(3);
  for (int k = 0; k < 100; ++k) {
    u << 0.8 * std::abs(std::sin(k)), 0.8 * std::abs(std::cos(k)), 0.3;
    plant.advance(u);
  }
  EXPECT_EQ(plant.statistics().restarts, 1u);
}

}  // namespace
}  // namespace gyrostat::truth::test_thrusters
