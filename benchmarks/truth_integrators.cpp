// SPDX-License-Identifier: MIT
/// @file  Error and cost of the truth's integrators on end state 2 of tests/cpp/truth/support.hpp (four wheels, 200 s,
///        command held from sample to sample), and the cost of faults and disturbances that vary.
///
/// Cost is the best of several runs, interleaved so that all see the same machine; errors are norms at the end.
#include <chrono>
#include <cstdio>
#include <limits>
#include <numbers>
#include <string>
#include <vector>

#include "../tests/cpp/truth/support.hpp"

namespace {

using namespace gyrostat;
using namespace gyrostat::truth;

/// Faults and disturbance of Li et al. 2018, section 5, on ideal torquers.
RigidPlant run_li2018(const Integrator& integrator, double dt) {
  constexpr double a = 0.25e-3, half_pi = std::numbers::pi / 2;
  PlantModel m = test::torquers(integrator);
  m.actuators.u_lo.setConstant(-0.25);
  m.actuators.u_up.setConstant(0.25);
  m.faults = {
      LossOfEffectiveness{.window = {.actuator = 0, .t_on = 10}, .remaining = 0.5},
      LossOfEffectiveness{.window = {.actuator = 1}, .remaining = SquareWave{.low = 0.6, .high = 0.85, .period = 100}},
      LossOfEffectiveness{.window = {.actuator = 2}, .remaining = SineWave{0.9, 0.07, 0.2, 0}},
      LossOfEffectiveness{.window = {.actuator = 3, .t_on = 10}, .remaining = 0.2},
      Bias{.window = {.actuator = 1}, .torque = 0.008},
      Bias{.window = {.actuator = 2}, .torque = SineWave{0, 0.05, 1, 0}},
      Bias{.window = {.actuator = 3}, .torque = 0.005}};
  m.disturbances = {RatePhaseTorque{.gain = 10,
                                    .offset_B = a * Vec3<double>{-8, 12, 9},
                                    .axis = {0, 0, 1, 1, 2, 2},
                                    .amplitude = {2 * a, 3 * a, -1.5 * a, 3 * a, 3 * a, -6 * a},
                                    .multiple = {10, 3, 2, 5, 10, 4},
                                    .phase = {half_pi, 0, 0, half_pi, 0, 0}}};
  RigidPlant plant(m, {quat_from_mrp<double>({-0.1579, 0.1368, 0.0947}), Vec3<double>::Zero(), {}}, dt);
  const auto samples = static_cast<Tick>(200 / dt);
  for (Tick k = 0; k < samples; ++k)
    plant.advance(-1.2 * project(m.D_B, test::small_mrp(plant.q_NB())) - 4.5 * project(m.D_B, plant.omega_BN_B()));
  return plant;
}

struct Row {
  std::string name;
  Integrator integrator;
  double dt;
  RigidPlant (*run)(const Integrator&, double);
  bool has_end_state;
  double best = std::numeric_limits<double>::infinity();
};

void report(const Row& row, const RigidPlant& plant) {
  const double samples = 200 / row.dt;
  const IntegratorStatistics s = plant.statistics();
  std::printf("%-34s %9.3f us %8.2f rhs", row.name.c_str(), 1e6 * row.best / samples,
              static_cast<double>(s.rhs_evaluations) / samples);
  if (row.has_end_state) {
    const VecN<double> speed = test::wheel_speed(test::pyramid(), plant.h_w(), plant.omega_BN_B());
    std::printf("   MRP %8.1e   rate %8.1e rad/s   wheel speed %8.1e rad/s",
                (test::small_mrp(plant.q_NB()) - test::driven_sigma).norm(),
                (plant.omega_BN_B() - test::driven_omega).norm(), (speed - test::driven_speed).norm());
  }
  std::printf("\n");
}

}  // namespace

int main() {
  const Cvode loose{.rtol = 1e-9, .atol = 1e-12}, tight{.rtol = 1e-12, .atol = 1e-14};
  Cvode loose_restarted = loose, tight_restarted = tight;
  loose_restarted.restart_each_sample = tight_restarted.restart_each_sample = true;
  std::vector<Row> rows{{"rk4, 10 ms", Rk4{}, 1e-2, test::run_driven, true},
                        {"rk4, 1 ms in 10 ms samples", Rk4{10}, 1e-2, test::run_driven, true},
                        {"rk4, 1 ms", Rk4{}, 1e-3, test::run_driven, true},
                        {"cvode 1e-9, history kept", loose, 1e-2, test::run_driven, true},
                        {"cvode 1e-12, history kept", tight, 1e-2, test::run_driven, true},
                        {"cvode 1e-9, restarted each sample", loose_restarted, 1e-2, test::run_driven, true},
                        {"cvode 1e-12, restarted each sample", tight_restarted, 1e-2, test::run_driven, true},
                        {"li2018 truth, rk4, 10 ms", Rk4{}, 1e-2, run_li2018, false},
                        {"li2018 truth, cvode 1e-9", loose, 1e-2, run_li2018, false}};
  for (int repeat = 0; repeat < 5; ++repeat) {
    for (Row& row : rows) {
      const auto start = std::chrono::steady_clock::now();
      (void)row.run(row.integrator, row.dt);
      row.best = std::min(row.best, std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count());
    }
  }
  std::printf("per sample of 100 Hz (1 kHz where it says 1 ms); 200 s; errors at the end\n");
  for (const Row& row : rows) report(row, row.run(row.integrator, row.dt));
}
