// SPDX-License-Identifier: MIT
// Compiled once for each capacity, see CMakeLists.txt: GYROSTAT_PART_SIZES is the function to define.
#include "gyrostat/host/stack_sizes.hpp"

#include <array>

#include "gyrostat/flight/allocators.hpp"
#include "gyrostat/flight/controllers.hpp"
#include "gyrostat/flight/desaturation.hpp"
#include "gyrostat/flight/detectors.hpp"
#include "gyrostat/flight/moving_axes.hpp"
#include "gyrostat/flight/navigators.hpp"
#include "gyrostat/flight/observers.hpp"
#include "gyrostat/flight/stack.hpp"

namespace {
using namespace gyrostat;

/// Each member on a boundary of 16 of its own: no less than what the compiler lays out.
constexpr std::size_t padded(std::size_t bytes) { return (bytes + 15) / 16 * 16; }

/// Members of FlightStack and Estimator beside the components.
template <class S>
constexpr std::size_t frame() {
  return padded(sizeof(Guard<S>)) + padded(sizeof(Estimate<S>)) + padded(sizeof(Detection<S>)) +
         padded(sizeof(VecN<S>)) + padded(sizeof(bool)) + padded(sizeof(Inputs<S>)) + padded(sizeof(Demand<S>)) +
         padded(sizeof(Allocation<S>)) + 2 * padded(sizeof(GuardActions) + 4 * sizeof(bool));
}

template <template <class> class... T>
constexpr std::array<GyrostatPartSize, sizeof...(T)> sizes(const char* role, Components<T...>) {
  return {GyrostatPartSize{role, T<double>::name, padded(sizeof(T<double>)), padded(sizeof(T<float>))}...};
}

template <std::size_t... n>
constexpr auto joined(const std::array<GyrostatPartSize, n>&... lists) {
  std::array<GyrostatPartSize, (n + ...)> out{};
  std::size_t at = 0;
  const auto append = [&](const auto& list) {
    for (const GyrostatPartSize& part : list) out[at++] = part;
  };
  (append(lists), ...);
  return out;
}

/// A navigator's: what it was given, and what it made of it.
template <class S>
constexpr std::size_t navigation() {
  return 2 * padded(sizeof(Measurement<S>)) + padded(2 * sizeof(bool));
}
constexpr std::array frames{
    GyrostatPartSize{nullptr, "frame", frame<double>(), frame<float>()},
    GyrostatPartSize{nullptr, "navigation", navigation<double>(), navigation<float>()},
    GyrostatPartSize{nullptr, "moving_axes", padded(sizeof(MovingAxes<double>)), padded(sizeof(MovingAxes<float>))}};
constexpr auto parts =
    joined(frames, sizes("navigator", Navigators{}), sizes("observer", Observers{}), sizes("detector", Detectors{}),
           sizes("controller", Controllers{}), sizes("allocator", Allocators{}),
           sizes("desaturation", Components<CrossProductDesaturation>{}));
}  // namespace

GyrostatPartSizes GYROSTAT_PART_SIZES() { return {max_actuators, parts.data(), parts.size()}; }
