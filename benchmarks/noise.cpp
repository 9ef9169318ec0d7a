// SPDX-License-Identifier: MIT
// Three normal deviates, and a sample of noisy sensors, against the same through Random123's Box-Muller form and libm.
#include "gyrostat/truth/noise.hpp"

#include <benchmark/benchmark.h>
#include <Random123/boxmuller.hpp>

#include "gyrostat/truth/sensors.hpp"

namespace gyrostat::bench {
namespace {

Vec3<double> by_library(std::uint64_t seed, std::uint64_t run, std::uint64_t stream, Tick tick) {
  const r123::Philox4x64::ctr_type w = r123::Philox4x64()({{tick, stream, 0, 0}}, {{seed, run}});
  const r123::double2 a = r123::boxmuller(w[0], w[1]), b = r123::boxmuller(w[2], w[3]);
  return {a.x, a.y, b.x};
}

void normals_by_library(benchmark::State& state) {
  Tick k = 0;
  for (auto _ : state) benchmark::DoNotOptimize(by_library(7, 0, 1, ++k));
}

void normals(benchmark::State& state) {
  Tick k = 0;
  for (auto _ : state) benchmark::DoNotOptimize(truth::standard_normals(7, 0, 1, ++k));
}

/// What a gyro and an attitude sensor add to a sample: noise of both, the small rotation, the product.
void sensors_by_library(benchmark::State& state) {
  Tick k = 0;
  const Quat<double> q_NB = Quat<double>(0.5, 0.5, -0.5, 0.5);
  for (auto _ : state) {
    benchmark::DoNotOptimize(Vec3<double>(1e-5 * by_library(7, 0, 1, ++k)));
    benchmark::DoNotOptimize(Quat<double>(q_NB * quat_exp(Vec3<double>(1e-5 * by_library(7, 0, 2, k)))));
  }
}

void sensors(benchmark::State& state) {
  Tick k = 0;
  const Quat<double> q_NB = Quat<double>(0.5, 0.5, -0.5, 0.5);
  for (auto _ : state) {
    benchmark::DoNotOptimize(Vec3<double>(1e-5 * truth::standard_normals(7, 0, 1, ++k)));
    benchmark::DoNotOptimize(
        Quat<double>(q_NB * truth::small_rotation(Vec3<double>(1e-5 * truth::standard_normals(7, 0, 2, k)))));
  }
}

BENCHMARK(normals_by_library);
BENCHMARK(normals);
BENCHMARK(sensors_by_library);
BENCHMARK(sensors);

}  // namespace
}  // namespace gyrostat::bench

BENCHMARK_MAIN();
