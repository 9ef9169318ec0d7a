// SPDX-License-Identifier: MIT
#pragma once
#include "gyrostat/truth/faults/fault.hpp"

namespace gyrostat::truth {

/// Delivers a constant torque whatever is commanded.
struct StuckOutput {
  static constexpr const char* name = "stuck";
  static constexpr bool decides_output = true;
  static constexpr int degree = 0;
  Window window;
  double torque = 0;

  static constexpr void describe(auto& p, auto&& field) {
    Window::describe(p.window, field);
    field(p.torque, Field{"torque", "N m", -infinity, infinity, "delivered whatever is commanded"});
  }

  void waveforms(auto&&) const noexcept {}
  void apply(Effect& e, const At&) const noexcept { e = {0, torque, 0}; }
  std::string check(const Limits& limits) const {
    const bool within = torque >= limits.lo && torque <= limits.up;
    return !limits.valve || within ? "" : "torque must be between closed and open, 0 and the limit of the thruster";
  }
};

}  // namespace gyrostat::truth
