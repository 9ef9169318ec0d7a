// SPDX-License-Identifier: MIT
// The first samples of the published stacks against an independent implementation: the exact discrete forms, the order inside
// one sample and the rules of the first one.
#include <gtest/gtest.h>

#include "../golden.hpp"
#include "gyrostat/core/attitude.hpp"
#include "gyrostat/flight/allocators/pseudo_inverse.hpp"
#include "gyrostat/flight/controllers/fast_terminal_sliding_mode.hpp"
#include "gyrostat/flight/controllers/prescribed_performance.hpp"
#include "gyrostat/flight/detectors/threshold.hpp"
#include "gyrostat/flight/observers/adaptive_iterative_learning.hpp"
#include "gyrostat/flight/stack.hpp"
#include "telemetry_log.hpp"
#include "vehicles.hpp"

namespace gyrostat::test::test_yang2023_golden {
namespace {

using Observer = AdaptiveIterativeLearningObserver<double>;
using Detector = ThresholdDetector<double>;

constexpr double h = 0.01;
constexpr double degree = 0.017453292519943295;

/// Three axes and a skew spare; 0.25 N m, 10 ms.
Setup<double> paper_setup() {
  Mat3<double> J;
  J << 43, 0.3, 1.2, 0.3, 52, -0.5, 1.2, -0.5, 40;
  Mat3N<double> D(3, 4);
  const double s = 1 / std::sqrt(3.0);
  D << 1, 0, 0, s, 0, 1, 0, s, 0, 0, 1, s;
  Setup<double> setup = vehicle_with<double>(J, D, 0.25, h);
  setup.vehicle.spare.set(3);
  return setup;
}

Observer::Params published_observer() {
  Observer::Params p(paper_setup());
  p.hand_on = false;  // as printed: clipped, and the rest is lost
  p.k1_0 = 14, p.k1_max = 40, p.mu1 = 1e6;
  p.k4_0 = 0.49, p.k4_max = 4, p.mu4 = 1.35e5;
  p.deadzone = 7e-5, p.leak = 3;
  p.k2_0 = 2e-4, p.k2_max = 2e-3, p.mu2 = 1, p.chi = p.layer = 1e-4, p.gamma = 1e-3;
  p.u_gate = 0.05, p.u_reg = 0.02;
  return p;
}

Detector::Params published_detector() {
  Detector::Params p(paper_setup());
  p.persistence = 0.2, p.hold_off = 4, p.settle = 0, p.u_gate = 0.05;
  return p;
}

template <class Controller>
auto stack_with(const typename Controller::Params& law) {
  using Stack = FlightStack<Observer, Detector, Controller, PseudoInverse<double>>;
  typename Stack::Params p(paper_setup());
  p.observer = published_observer();
  p.detector = published_detector();
  p.controller = law;
  return Stack(unchecked, paper_setup(), p);
}

Measurement<double> recorded(const Golden& golden, std::size_t k) {
  const std::vector<double> q = golden.vector("q", k), w = golden.vector("w", k);
  Measurement<double> y;
  y.tick = k;
  y.q_NB = Quat<double>(q[0], q[1], q[2], q[3]);
  y.omega_BN_B = {w[0], w[1], w[2]};
  y.h_w = VecN<double>::Zero(4);
  return y;
}

/// Flies the recorded measurements; `reference(k)` in order.
template <class Stack, class Path>
void expect_rows(const char* file, Stack stack, Path reference) {
  const Golden golden(file);
  for (std::size_t k = 0; k < golden_rows; ++k) {
    stack.step(recorded(golden, k), reference(k));
    const auto controller = telemetry_of(stack.controller);
    expect_row(golden, "e", k, values(stack.estimate().effectiveness));
    expect_row(golden, "k", k, telemetry_of(stack.estimator.observer).at("gains"));
    expect_row(golden, "s", k, controller.at("s"));
    expect_row(golden, "uc", k, values(stack.demand().tau_B));
    expect_row(golden, "tau", k, values(stack.last().u));
    if (!golden.has("z_0")) continue;
    expect_row(golden, "r1", k, controller.at("lower"));
    expect_row(golden, "r2", k, controller.at("upper"));
    expect_row(golden, "z", k, controller.at("z"));
  }
}

Reference<double> slew(std::size_t) {
  Reference<double> ref;
  ref.q_NR = quat_from_euler<double>({20 * degree, -15 * degree, 0});
  return ref;
}

PrescribedPerformance<double>::Params funnel() {
  PrescribedPerformance<double>::Params p(paper_setup());
  p.b1 = 0.015, p.b2 = 0.005, p.b3 = 40, p.b4 = 0.05, p.s_core = 1e-3;
  p.rho_inf = 0.005, p.tf_min = 8, p.z_max = 0.99;
  return p;
}

FastTerminalSlidingMode<double>::Params terminal() {
  FastTerminalSlidingMode<double>::Params p(paper_setup());
  p.b1 = 0.2, p.b2 = 0.01, p.b3 = 40, p.b4 = 0.05, p.s_core = 1e-3;
  return p;
}

TEST(Yang2023Golden, AdaptiveFunnel) {
  expect_rows("yang2023_afppc_noise_free.csv", stack_with<PrescribedPerformance<double>>(funnel()), slew);
}

TEST(Yang2023Golden, FastTerminalSlidingMode) {
  expect_rows("yang2023_ftsmc_noise_free.csv", stack_with<FastTerminalSlidingMode<double>>(terminal()), slew);
}

TEST(Yang2023Golden, MovingReference) {
  // The rows were made with a reference turned by its rate in the middle of each interval; the library's own reference is
  // exact to fifth order and leaves it by 2e-10 in these 0.6 s.
  Reference<double> ref;
  ref.q_NR = quat_from_euler<double>({5 * degree, -5 * degree, 5 * degree});
  const auto rate = [](double t, double d) {  // d = 1: derivative
    const double n = 0.08, quarter = d * 1.5707963267948966;
    const double scale = 0.02 * (d > 0 ? n : 1);
    return Vec3<double>(scale * std::sin(n * t + quarter), scale * std::cos(n * t + quarter),
                        scale * std::sin(n * t + 1 + quarter));
  };
  expect_rows("yang2023_moving_noise_free.csv", stack_with<PrescribedPerformance<double>>(funnel()),
              [&](std::size_t k) {
                const double t = h * static_cast<double>(k);
                if (k > 0) ref.q_NR = ref.q_NR * quat_exp<double>(h * rate(t - h / 2, 0));
                ref.omega_RN_R = rate(t, 0);
                ref.omegadot_RN_R = rate(t, 1);
                return ref;
              });
}

}  // namespace
}  // namespace gyrostat::test::test_yang2023_golden
