// SPDX-License-Identifier: MIT
// Cost of one flight step and of whole closed loops, erased (as under Python) and static (as embedded).
#include <benchmark/benchmark.h>

#include <utility>
#include <vector>

#include "gyrostat/flight/allocators/lexicographic.hpp"
#include "gyrostat/flight/allocators/pseudo_inverse.hpp"
#include "gyrostat/flight/allocators/robust_socp.hpp"
#include "gyrostat/flight/controllers/integral_sliding_mode.hpp"
#include "gyrostat/flight/controllers/mixed_learning_sliding_mode.hpp"
#include "gyrostat/flight/controllers/mrp_feedback.hpp"
#include "gyrostat/flight/controllers/preassigned_time_sliding_mode.hpp"
#include "gyrostat/flight/controllers/predefined_time.hpp"
#include "gyrostat/flight/controllers/prescribed_performance.hpp"
#include "gyrostat/flight/detectors/evidence.hpp"
#include "gyrostat/flight/detectors/none.hpp"
#include "gyrostat/flight/detectors/threshold.hpp"
#include "gyrostat/flight/observers/adaptive_iterative_learning.hpp"
#include "gyrostat/flight/observers/finite_time_disturbance.hpp"
#include "gyrostat/flight/observers/joint_kalman.hpp"
#include "gyrostat/flight/observers/learning_disturbance.hpp"
#include "gyrostat/flight/observers/learning_effectiveness.hpp"
#include "gyrostat/flight/observers/mixed_learning_disturbance.hpp"
#include "gyrostat/flight/observers/passthrough.hpp"
#include "gyrostat/host/assembly.hpp"
#include "gyrostat/host/loop.hpp"
#include "scenarios.hpp"

namespace gyrostat::bench {
namespace {

using host::Assembly;

/// A static stack with the parameters of a scenario.
template <class O, class D, class C, class A>
auto static_stack(const Assembly& a) {
  using Stack = FlightStack<O, D, C, A>;
  const auto set = [&](auto& params, const host::ComponentSpec& spec) {
    params = host::read_params(params, spec.params, host::Place{"benchmark", a.setup.vehicle.actuators()});
  };
  typename Stack::Params p(a.setup);
  set(p.observer, a.observer);
  set(p.detector, a.detector);
  set(p.controller, a.controller);
  set(p.allocator, a.allocator);
  return Stack(unchecked, a.setup, p);
}

auto static_ftc(const Assembly& a) {
  return static_stack<PassthroughObserver<double>, NoDetector<double>, MrpFeedback<double>, PseudoInverse<double>>(a);
}
auto static_li2018(const Assembly& a) {
  return static_stack<FiniteTimeDisturbanceObserver<double>, NoDetector<double>, IntegralSlidingMode<double>,
                      PseudoInverse<double>>(a);
}
auto static_cao2022(const Assembly& a) {
  return static_stack<LearningEffectivenessObserver<double>, NoDetector<double>, PredefinedTime<double>,
                      PseudoInverse<double>>(a);
}
auto static_wang2023(const Assembly& a) {
  return static_stack<MixedLearningDisturbanceObserver<double>, NoDetector<double>, MixedLearningSlidingMode<double>,
                      PseudoInverse<double>>(a);
}
auto static_cao2023(const Assembly& a) {
  return static_stack<LearningDisturbanceObserver<double>, NoDetector<double>, PreassignedTimeSlidingMode<double>,
                      PseudoInverse<double>>(a);
}
auto static_joint(const Assembly& a) {
  return static_stack<JointKalmanObserver<double>, NoDetector<double>, IntegralSlidingMode<double>,
                      PseudoInverse<double>>(a);
}
auto static_recommended(const Assembly& a) {
  return static_stack<JointKalmanObserver<double>, EvidenceDetector<double>, IntegralSlidingMode<double>,
                      Lexicographic<double>>(a);
}
auto static_yang2023(const Assembly& a) {
  return static_stack<AdaptiveIterativeLearningObserver<double>, ThresholdDetector<double>,
                      PrescribedPerformance<double>, RobustSocp<double>>(a);
}
auto erased(const Assembly& a) { return host::make_stack(a, {}); }

template <class Stack, class Watcher = host::NobodyWatches>
host::RunEnd run(const Assembly& a, Stack& stack, Watcher&& watcher = Watcher{}) {
  host::AnyPlant any = host::make_plant(a);
  truth::Sensors sensors(a.sensors, a.run.seed, 0);
  host::ReferencePath reference(a.reference, a.setup.dt);
  return std::visit([&](auto& plant) { return host::fly(plant, sensors, reference, stack, a.ticks, watcher); }, any);
}

/// Every input of the stack in a closed loop.
struct Tape {
  std::vector<std::pair<Measurement<double>, Reference<double>>> inputs;
  void before(const Measurement<double>&, const Allocation<double>&) {}
  void after(Tick, const Measurement<double>& y, const Reference<double>& ref) { inputs.emplace_back(y, ref); }
};

/// ns a flight step: the stack alone, fed with the inputs of its own closed loop.
template <class Make>
void flight_step(benchmark::State& state, const Table& scenario, Make make) {
  const Assembly a = host::assemble(scenario);
  auto stack = make(a);
  Tape tape;
  run(a, stack, tape);
  for (auto _ : state) {
    stack.reset();
    for (const auto& [y, ref] : tape.inputs) benchmark::DoNotOptimize(stack.step(y, ref).u.data());
  }
  state.counters["per_step"] =
      benchmark::Counter(static_cast<double>(tape.inputs.size()),
                         benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
}

/// Simulated seconds a CPU second: the whole loop, nothing recorded.
template <class Make>
void closed_loop(benchmark::State& state, const Table& scenario, Make make) {
  const Assembly a = host::assemble(scenario);
  for (auto _ : state) {
    auto stack = make(a);
    if (run(a, stack).code != host::RunEnd::Code::completed) state.SkipWithError("the run did not complete");
  }
  state.counters["simulated_s_per_s"] =
      benchmark::Counter(a.run.duration, benchmark::Counter::kIsIterationInvariantRate);
}

const auto make_erased = [](const Assembly& a) { return erased(a); };
const auto make_static_ftc = [](const Assembly& a) { return static_ftc(a); };
const auto make_static_li2018 = [](const Assembly& a) { return static_li2018(a); };
const auto make_static_cao2022 = [](const Assembly& a) { return static_cao2022(a); };
const auto make_static_wang2023 = [](const Assembly& a) { return static_wang2023(a); };
const auto make_static_cao2023 = [](const Assembly& a) { return static_cao2023(a); };
const auto make_static_joint = [](const Assembly& a) { return static_joint(a); };
const auto make_static_recommended = [](const Assembly& a) { return static_recommended(a); };
const auto make_static_yang2023 = [](const Assembly& a) { return static_yang2023(a); };

BENCHMARK_CAPTURE(flight_step, ftc_4rw / erased, ftc_4rw("rk4"), make_erased)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(flight_step, ftc_4rw / static, ftc_4rw("rk4"), make_static_ftc)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(flight_step, li2018 / erased, li2018_table1(20), make_erased)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(flight_step, li2018 / static, li2018_table1(20), make_static_li2018)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(flight_step, cao2022 / erased, cao2022(40), make_erased)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(flight_step, cao2022 / static, cao2022(40), make_static_cao2022)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(flight_step, wang2023 / erased, wang2023(20), make_erased)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(flight_step, wang2023 / static, wang2023(20), make_static_wang2023)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(flight_step, cao2023_printed / erased, cao2023("euler_angles"), make_erased)
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(flight_step, cao2023_printed / static, cao2023("euler_angles"), make_static_cao2023)
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(flight_step, cao2023_body / erased, cao2023("body"), make_erased)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(flight_step, cao2023_body / static, cao2023("body"), make_static_cao2023)
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(flight_step, yang2023 / erased, yang2023_slew(40), make_erased)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(flight_step, yang2023 / static, yang2023_slew(40), make_static_yang2023)
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(flight_step, joint / erased, joint(), make_erased)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(flight_step, joint / static, joint(), make_static_joint)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(flight_step, recommended / erased, recommended(), make_erased)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(flight_step, recommended / static, recommended(), make_static_recommended)
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(closed_loop, ftc_4rw_rk4 / erased, ftc_4rw("rk4"), make_erased)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(closed_loop, ftc_4rw_rk4 / static, ftc_4rw("rk4"), make_static_ftc)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(closed_loop, ftc_4rw_cvode / erased, ftc_4rw("cvode"), make_erased)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(closed_loop, li2018_rk4 / erased, li2018_table1(60), make_erased)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace gyrostat::bench

BENCHMARK_MAIN();
