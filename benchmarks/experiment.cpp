// SPDX-License-Identifier: MIT
// Flights of an experiment against the bare loop around the same objects: what reading, varying and measuring cost.
#include "gyrostat/host/experiment.hpp"

#include <benchmark/benchmark.h>
#include <sys/resource.h>

#include "gyrostat/host/run_parts.hpp"
#include "scenarios.hpp"

namespace gyrostat::bench {
namespace {

Table scenario(const char* stack, double dt) {
  Table s = ftc_4rw("rk4");
  s.set("dt", dt);
  s.set("faults", List{Table{{"type", "loss_of_effectiveness"}, {"actuator", 2}, {"t_on", 20.0}, {"remaining", 0.4}}});
  if (std::string(stack) == "learning") {
    s.set("observer", Table{{"type", "learning_effectiveness"}});
    s.set("controller", Table{{"type", "integral_sliding_mode"}});
    s.set("allocator", Table{{"type", "lexicographic"}});
  }
  if (std::string(stack) == "campaign") {  // as in campaign.py
    s.set("observer", Table{{"type", "finite_time_disturbance"}});
    s.set("controller", Table{{"type", "integral_sliding_mode"}});
    s.set("sensors", List{Table{{"type", "gyro"}, {"noise", 1e-6}}, Table{{"type", "attitude"}, {"noise", 1e-5}}});
    s.find("faults")->as<List>()->push_back(
        Table{{"type", "loss_of_effectiveness"}, {"actuator", 1}, {"t_on", 70.0}, {"remaining", 0.5}});
  }
  return s;
}

Table measures(const char* stack) {
  const auto of = [](const char* metric, const char* signal) { return Table{{"metric", metric}, {"signal", signal}}; };
  Table settling = of("settling_time", "error.angle"), rms = of("window_rms", "error.angle"),
        peak = of("window_max", "error.angle"), full = of("fraction_at_least", "allocation.u");
  settling.set("band", 1e-3);
  rms.set("last", 20.0);
  peak.set("t0", "last_fault");
  full.set("level", 0.2);
  if (std::string(stack) == "campaign") {
    Table final = of("window_max", "error.angle");
    settling.set("after", "last_fault");
    final.set("last", 5.0);
    return {{"settling", settling}, {"final", final}, {"peak", peak}, {"energy", of("energy", "allocation.u")}};
  }
  return {
      {"settling", settling}, {"rms", rms}, {"peak", peak}, {"energy", of("energy", "allocation.u")}, {"full", full}};
}

void bare(benchmark::State& state, const char* stack, double dt) {
  const host::Assembly a = host::assemble(scenario(stack, dt));
  for (auto _ : state) {
    truth::RigidPlant plant(a.plant, a.initial, a.setup.dt);
    truth::Sensors sensors(a.sensors, a.run.seed, 0, false, a.setup.dt);
    host::ReferencePath reference(a.reference, a.setup.dt);
    host::Stack loop = host::make_stack(a, {});
    benchmark::DoNotOptimize(host::fly(plant, sensors, reference, loop, a.ticks));
  }
  state.SetItemsProcessed(state.iterations());
}

void flights(benchmark::State& state, const char* stack, double dt, bool measured, unsigned threads) {
  const host::Experiment e(scenario(stack, dt), {"faults.0.remaining", "initial.omega_BN_B"},
                           measured ? measures(stack) : Table{});
  constexpr std::size_t n = 32;
  std::vector<double> values;
  for (std::size_t i = 0; i < n; ++i) {
    const double x = static_cast<double>(i) / n;
    values.insert(values.end(), {0.2 + 0.6 * x, 0.01 * x, -0.01 * x, 0.02});
  }
  for (auto _ : state) benchmark::DoNotOptimize(e.fly(0, n, values, {.threads = threads, .progress = {}}));
  state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(n));
}

/// A flight of one sample: what a flight costs beside flying.
void reading(benchmark::State& state, const char* stack) {
  Table s = scenario(stack, 0.01);
  s.set("duration", 0.01);
  const host::Experiment e(s, {"faults.0.remaining"}, Table{});
  const std::vector<double> values(1000, 0.4);
  for (auto _ : state) benchmark::DoNotOptimize(e.fly(0, values.size(), values));
  state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(values.size()));
}

/// Highest memory of the process after so many flights, MB.
void memory(benchmark::State& state) {
  Table s = scenario("ftc", 0.1);
  s.set("duration", 10.0);
  Table m = measures("ftc");
  m.find("rms")->as<Table>()->set("last", 2.0);
  const host::Experiment e(s, {"faults.0.remaining"}, m);
  const std::vector<double> values(static_cast<std::size_t>(state.range(0)), 0.4);
  for (auto _ : state) benchmark::DoNotOptimize(e.fly(0, values.size(), values));
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  state.counters["MB"] = static_cast<double>(usage.ru_maxrss) / 1024;
}

BENCHMARK(memory)->Arg(1000)->Arg(10000)->Iterations(1)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(bare, ftc_100_hz, "ftc", 0.01)->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(flights, ftc_100_hz_unmeasured, "ftc", 0.01, false, 1)
    ->Unit(benchmark::kMicrosecond)
    ->MeasureProcessCPUTime();
BENCHMARK_CAPTURE(flights, ftc_100_hz, "ftc", 0.01, true, 1)->Unit(benchmark::kMicrosecond)->MeasureProcessCPUTime();
BENCHMARK_CAPTURE(flights, ftc_100_hz_two_threads, "ftc", 0.01, true, 2)->Unit(benchmark::kMicrosecond)->UseRealTime();
BENCHMARK_CAPTURE(bare, campaign, "campaign", 0.01)->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(flights, campaign, "campaign", 0.01, true, 1)->Unit(benchmark::kMicrosecond)->MeasureProcessCPUTime();
BENCHMARK_CAPTURE(bare, ftc_10_hz, "ftc", 0.1)->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(flights, ftc_10_hz, "ftc", 0.1, true, 1)->Unit(benchmark::kMicrosecond)->MeasureProcessCPUTime();
BENCHMARK_CAPTURE(bare, learning_100_hz, "learning", 0.01)->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(flights, learning_100_hz, "learning", 0.01, true, 1)
    ->Unit(benchmark::kMicrosecond)
    ->MeasureProcessCPUTime();
BENCHMARK_CAPTURE(reading, ftc, "ftc")->Unit(benchmark::kMicrosecond)->MeasureProcessCPUTime();
BENCHMARK_CAPTURE(reading, learning, "learning")->Unit(benchmark::kMicrosecond)->MeasureProcessCPUTime();

}  // namespace
}  // namespace gyrostat::bench

BENCHMARK_MAIN();
