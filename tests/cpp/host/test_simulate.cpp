// SPDX-License-Identifier: MIT
// Closed loops from scenario tables: what must agree to the last bit, what to an integrator's tolerance, how runs end.
#include "gyrostat/host/simulate.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <stdexcept>

#include "../../../benchmarks/scenarios.hpp"
#include "gyrostat/flight/allocators/pseudo_inverse.hpp"
#include "gyrostat/flight/controllers/mrp_feedback.hpp"
#include "gyrostat/flight/detectors/none.hpp"
#include "gyrostat/flight/observers/passthrough.hpp"
#include "gyrostat/host/assembly.hpp"

namespace gyrostat::host::test_simulate {
namespace {

using bench::ftc_4rw;

/// FTC-4RW for 30 s with noise and a fault between samples.
Table noisy(const char* integrator) {
  Table s = ftc_4rw(integrator);
  s.set("duration", 30.0);
  s.set("seed", 7);
  s.set("sensors", List{Table{{"type", "gyro"}, {"noise", 1e-5}}});
  s.set("faults",
        List{Table{{"type", "loss_of_effectiveness"}, {"actuator", 2}, {"t_on", 10.0037}, {"remaining", 0.4}}});
  return s;
}

const std::vector<double>& channel(const RunResult& r, const std::string& name) {
  for (const Recorder::Channel& c : r.channels) {
    if (c.info.name == name) return c.data;
  }
  throw std::invalid_argument("no channel " + name);
}

RunOptions only(std::vector<std::string> names, std::size_t every = 1) {
  return {.channels = std::move(names), .record = true, .every = every, .progress = {}, .memory = unbounded};
}

TEST(ClosedLoop, GivesTheSameBitsTwice) {
  const RunResult a = simulate(noisy("cvode")), b = simulate(noisy("cvode"));
  ASSERT_EQ(a.channels.size(), b.channels.size());
  for (std::size_t i = 0; i < a.channels.size(); ++i) {
    const std::vector<double>&x = a.channels[i].data, &y = b.channels[i].data;
    EXPECT_EQ(std::memcmp(x.data(), y.data(), x.size() * sizeof(double)), 0) << a.channels[i].info.name;
  }
}

TEST(ClosedLoop, IsNotChangedByRecordingOrShadows) {
  const RunOptions last_rate = only({"truth.omega_BN_B"}, 1000000);
  Table watched = noisy("cvode");
  watched.set("shadows", List{Table{{"observer", Table{{"type", "finite_time_disturbance"}}}}});
  const RunResult all = simulate(watched, {}, only({"truth.*", "measurement.*", "estimate.*", "shadow0.*", "error.*"}));
  const RunResult few = simulate(noisy("cvode"), {}, last_rate);
  const std::vector<double>&a = channel(all, "truth.omega_BN_B"), &b = channel(few, "truth.omega_BN_B");
  for (std::size_t i = 1; i <= 3; ++i) EXPECT_EQ(a[a.size() - i], b[b.size() - i]);
}

TEST(ClosedLoop, DependsOnItsSeed) {
  Table other = noisy("rk4");
  other.set("seed", 8);
  EXPECT_NE(channel(simulate(noisy("rk4")), "truth.omega_BN_B"), channel(simulate(other), "truth.omega_BN_B"));
}

TEST(ClosedLoop, IsTheSameForAStaticStack) {
  const Assembly a = assemble(ftc_4rw("rk4"));
  const auto end_of = [&](auto& stack) {
    truth::RigidPlant plant(a.plant, a.initial, a.setup.dt);
    truth::Sensors sensors(a.sensors, a.run.seed, 0);
    ReferencePath reference(a.reference, a.setup.dt);
    EXPECT_EQ(fly(plant, sensors, reference, stack, 3000).code, RunEnd::Code::completed);
    return plant.omega_BN_B();
  };
  using Fixed =
      FlightStack<PassthroughObserver<double>, NoDetector<double>, MrpFeedback<double>, PseudoInverse<double>>;
  Fixed::Params p(a.setup);
  p.controller = read_params(p.controller, a.controller.params, Place{"here", 4});
  Fixed fixed(unchecked, a.setup, p);
  Stack erased = make_stack(a, {});
  EXPECT_EQ(end_of(fixed), end_of(erased));
}

/// A plant of one's own: a turntable, free about z alone.
class Turntable {
 public:
  Turntable(const Assembly& a, double angle) : a_(a), angle_(angle) { state_.q_NB = quat_exp<double>({0, 0, angle}); }

  double time() const noexcept { return state_.t; }
  Measurement<double> measure(truth::Sensors& sensors) const {
    return sensors.measure(tick_, state_.q_NB, state_.omega_BN_B, VecN<double>::Zero(4));
  }
  void advance(const VecN<double>& u) {
    const double dt = a_.setup.dt, turn = a_.setup.vehicle.D_B.row(2).dot(u) / a_.setup.vehicle.J_B(2, 2);
    angle_ += dt * (state_.omega_BN_B[2] + 0.5 * dt * turn);
    state_.omega_BN_B[2] += dt * turn;
    state_.q_NB = quat_exp<double>({0, 0, angle_});
    state_.t = static_cast<double>(++tick_) * dt;
  }
  const truth::TruthState& state() const noexcept { return state_; }
  truth::TruthSample sample() const { return {state_, {}, {}, {}, {}, {}}; }
  EulerState<double> euler() const { return {{0, 0, angle_}, state_.omega_BN_B}; }
  truth::IntegratorStatistics statistics() const { return {}; }
  truth::InnerRates inner_rates() const { return {}; }
  static Vec3<double> angle_difference(const Vec3<double>& a, const Vec3<double>& b) { return a - b; }

 private:
  const Assembly& a_;
  double angle_;
  Tick tick_ = 0;
  truth::TruthState state_;
};

TEST(ClosedLoop, FliesAPlantOfOnesOwn) {
  const Assembly a = assemble(ftc_4rw("rk4"));
  Turntable plant(a, 0.3);
  truth::Sensors sensors({}, 1, 0);
  ReferencePath reference(a.reference, a.setup.dt);
  Stack stack = make_stack(a, {});
  EXPECT_EQ(fly(plant, sensors, reference, stack, a.ticks).code, RunEnd::Code::completed);
  EXPECT_LT(rotation_angle(plant.state().q_NB), 1e-3);  // there is no disturbance about z; the law regulates
}

// Faults that switch between samples: RK4 in 2.5 ms steps errs by less than 1e-12 here and CVODE at rtol 1e-12 by less
// than 1e-10 a free run; the closed loop contracts, so it does not amplify either.
TEST(ClosedLoop, IsTheSameUnderBothIntegratorsWhenFaultsSwitchBetweenSamples) {
  Table s = ftc_4rw("rk4");
  s.set("duration", 30.0);
  s.set("faults",
        List{Table{{"type", "loss_of_effectiveness"}, {"actuator", 2}, {"t_on", 5.0037}, {"remaining", 0.4}},
             Table{{"type", "bias"}, {"actuator", 1}, {"t_on", 3.3333}, {"t_off", 11.11111}, {"torque", 0.05}},
             Table{{"type", "intermittent"}, {"actuator", 0}, {"t_on", 2.0}, {"period", 0.7153}, {"duty", 0.3}}});
  s.set("integrator", Table{{"type", "rk4"}, {"substeps", 4}});
  const RunResult rk4 = simulate(s, {}, only({"truth.q_NB", "truth.omega_BN_B"}));
  s.set("integrator", Table{{"type", "cvode"}, {"rtol", 1e-12}, {"atol", 1e-14}});
  const RunResult cvode = simulate(s, {}, only({"truth.q_NB", "truth.omega_BN_B"}));
  for (const char* name : {"truth.q_NB", "truth.omega_BN_B"}) {
    const std::vector<double>&a = channel(rk4, name), &b = channel(cvode, name);
    double largest = 0;
    for (std::size_t i = 0; i < a.size(); ++i) largest = std::max(largest, std::abs(a[i] - b[i]));
    EXPECT_LT(largest, 1e-9) << name;
  }
}

TEST(ClosedLoop, RecordsTheLastSampleWhateverTheDecimation) {
  Table s = ftc_4rw("rk4");
  s.set("duration", 1.0);
  const RunResult r = simulate(s, {}, only({"error.angle"}, 30));
  EXPECT_EQ(r.t.size(), 5u);  // 0, 0.3, 0.6, 0.9 and 1.0 s
  EXPECT_DOUBLE_EQ(r.t.back(), 1.0);
  EXPECT_EQ(channel(r, "error.angle").size(), 5u);
}

TEST(ClosedLoop, RecordsAsOftenAsItsTableSaysUnlessTheCallerDoes) {
  Table s = ftc_4rw("rk4");
  s.set("duration", 1.0);
  s.set("record", Table{{"every", 50}});
  EXPECT_EQ(simulate(s, {}, only({"error.angle"}, 0)).t.size(), 3u);
  EXPECT_EQ(simulate(s, {}, only({"error.angle"}, 1)).t.size(), 101u);
}

TEST(ClosedLoop, ARecordThatTheMemoryCannotHoldIsRefusedBeforeItFlies) {
  Table s = ftc_4rw("rk4");
  s.set("duration", 1.0);
  RunOptions options = only({"error.angle"});
  options.memory = 8.0 * 2 * 102;  // rows of the time and the angle; one more than there are samples
  EXPECT_EQ(simulate(s, {}, options).t.size(), 101u);
  options.memory -= 1;
  EXPECT_THROW((void)simulate(s, {}, options), std::invalid_argument);
  options.every = 2;
  EXPECT_EQ(simulate(s, {}, options).t.size(), 51u);
}

TEST(ClosedLoop, EndsWhenItsProgressThrows) {
  Table s = ftc_4rw("rk4");
  s.set("duration", 1e6);  // hours of computing
  RunOptions options = only({"error.angle"}, 1000000);
  struct Enough {};
  options.progress = [](double) { throw Enough{}; };
  EXPECT_THROW((void)simulate(s, {}, options), Enough);
}

TEST(ClosedLoop, LumpedTorqueIsWhatFaultAndDisturbanceAmountTo) {
  Table s = ftc_4rw("rk4");
  s.set("duration", 20.0);
  s.set("faults", List{Table{{"type", "loss_of_effectiveness"}, {"actuator", 2}, {"t_on", 5.0}, {"remaining", 0.4}}});
  const RunResult r =
      simulate(s, {}, only({"truth.lumped_B", "truth.fault_B", "truth.external_B", "truth.lumped_mean_B"}));
  const std::vector<double>&lumped = channel(r, "truth.lumped_B"), &mean = channel(r, "truth.lumped_mean_B");
  const std::vector<double>&fault = channel(r, "truth.fault_B"), &external = channel(r, "truth.external_B");
  for (std::size_t i = 3; i < lumped.size(); ++i) {
    EXPECT_NEAR(lumped[i], fault[i] + external[i], 1e-14);  // the true inertia is the nominal one here
    EXPECT_NEAR(mean[i], lumped[i], 1e-6);                  // trapezoid: dt^2 / 12 of the gyroscopic torque's curvature
  }
}

TEST(RunEnds, NonFiniteStateKeepsWhatCameBefore) {
  Table s = ftc_4rw("rk4");
  s.set("disturbances",
        List{Table{{"type", "periodic"},
                   {"torque_B", List{Table{{"type", "steps"}, {"times", List{0.0, 1.0}}, {"values", List{0.0, 1e200}}},
                                     0.0, 0.0}}}});
  const RunResult r = simulate(s);
  EXPECT_EQ(r.end.code, RunEnd::Code::non_finite);
  EXPECT_GE(r.end.time, 1.0);
  EXPECT_GE(r.t.size(), 100u);
  EXPECT_LT(r.t.size(), 20001u);
  EXPECT_EQ(channel(r, "error.angle").size(), r.t.size());
}

struct Bad {
  const char* why;
  const char* key;
  Value value;
  const char* message;
};

class BadScenario : public testing::TestWithParam<Bad> {};
INSTANTIATE_TEST_SUITE_P(
    All, BadScenario,
    testing::Values(
        Bad{"unknown_key", "durration", 3.0, "scenario: no parameter 'durration', did you mean 'duration'?"},
        Bad{"duration", "duration", 1.005,
            "scenario: duration = 1.005 s is not a whole number of periods dt = 0.01 s; nearest are 1 and 1.01 s"},
        Bad{"zero_dt", "dt", 0.0, "scenario: dt = 0 is outside [1e-06, 1000]"},
        Bad{"component", "controller", Table{{"type", "mrp_feedbak"}},
            "controller 'mrp_feedbak': no controller 'mrp_feedbak', did you mean 'mrp_feedback'?"},
        Bad{"fault_elsewhere", "faults", List{Table{{"type", "bias"}, {"actuator", 7}, {"torque", 0.1}}},
            "faults[0] 'bias': actuator = 7 is not there; the vehicle has 4 (0 to 3)"},
        Bad{"channel", "record", Table{{"channels", List{"error.angel"}}},
            "record: no channel 'error.angel', did you mean 'error.angle'?"}),
    [](const auto& bad) { return bad.param.why; });

TEST_P(BadScenario, IsRefusedInOneLine) {
  Table s = ftc_4rw("rk4");
  s.set(GetParam().key, GetParam().value);
  try {
    (void)simulate(s);
    FAIL() << "accepted";
  } catch (const std::invalid_argument& e) {
    EXPECT_STREQ(e.what(), GetParam().message);
  }
}

TEST(Together, AnObserverBelowTheAllocatorsFloorIsRefused) {
  Table s = ftc_4rw("rk4");
  s.set("observer", Table{{"type", "iterative_learning"}, {"e_min", 0.02}});
  const std::vector<CheckRow> rows = check(assemble(s));
  ASSERT_EQ(rows.size(), 6u);
  EXPECT_EQ(rows.back().where, "observer and allocator");
  EXPECT_FALSE(rows.back().status.ok());
  EXPECT_THROW(simulate(s), std::invalid_argument);
  s.set("allocator", Table{{"type", "pseudo_inverse"}, {"e_min", 0.02}});
  EXPECT_EQ(check(assemble(s)).size(), 5u);
}

TEST(Together, EstimatesAreToldByRole) {
  Table s = ftc_4rw("rk4");
  s.set("observer", Table{{"type", "finite_time_disturbance"}});
  s.set("controller", Table{{"type", "mrp_feedback"}, {"compensate", false}});
  const auto flow = estimate_flow(assemble(s));
  ASSERT_EQ(flow.size(), 4u);
  EXPECT_EQ(flow[0], (std::pair<std::string, Estimates>{"observer", {.d_B = true, .effectiveness = false}}));
  EXPECT_EQ(flow[2], (std::pair<std::string, Estimates>{"controller", {}}));
  s.set("controller", Table{{"type", "mrp_feedback"}});
  EXPECT_TRUE(estimate_flow(assemble(s))[2].second.d_B);
}

TEST(BadVehicle, InertiaIsJudged) {
  const auto message = [](const Value& J) {
    Table s = ftc_4rw("rk4");
    Table vehicle = *s.find("vehicle")->as<Table>();
    vehicle.set("J_B", J);
    s.set("vehicle", vehicle);
    try {
      (void)simulate(s);
    } catch (const std::invalid_argument& e) {
      return std::string(e.what());
    }
    return std::string("accepted");
  };
  EXPECT_EQ(message(List{List{20, 1, 0}, List{0, 17, 0}, List{0, 0, 15}}),
            "vehicle: J_B is not symmetric: entry [0][1] = 1 and [1][0] = 0");
  EXPECT_EQ(message(List{20, 17, -1}),
            "vehicle: J_B is not positive definite: smallest principal moment -1 kg m^2, must be > 0");
  EXPECT_EQ(message(List{20, 5, 5}),
            "vehicle: J_B is no inertia of a body: principal moments 5 + 5 < 20 kg m^2 (triangle inequality)");
}

}  // namespace
}  // namespace gyrostat::host::test_simulate
