// SPDX-License-Identifier: MIT
#pragma once
#include "gyrostat/truth/faults/fault.hpp"

namespace gyrostat::truth {

/// Commands smaller than a width give nothing; larger ones are delivered whole (a threshold, not an offset).
struct DeadZone {
  static constexpr const char* name = "dead_zone";
  static constexpr bool decides_output = false;
  static constexpr int degree = 0;
  Window window;
  double width = 0;

  static constexpr void describe(auto& p, auto&& field) {
    Window::describe(p.window, field);
    field(p.width, Field{"width", "N m", 0, infinity, "smallest command that is delivered"});
  }

  void waveforms(auto&&) const noexcept {}
  void apply(Effect& e, const At&) const noexcept { e.dead_zone = std::max(e.dead_zone, width); }
  std::string check(const Limits& limits) const {
    return limits.valve
               ? "not of a thruster, a valve has a shortest pulse (min_on of the thrusters): slow_valve or dead"
               : "";
  }
};

}  // namespace gyrostat::truth
