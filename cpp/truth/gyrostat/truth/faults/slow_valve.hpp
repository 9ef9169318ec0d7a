// SPDX-License-Identifier: MIT
#pragma once
#include "gyrostat/truth/faults/fault.hpp"

namespace gyrostat::truth {

/// A valve that opens and closes later than it is driven; a pulse that is over before it opens delivers nothing. An edge is
/// late when the fault is active where the drive has it.
struct SlowValve {
  static constexpr const char* name = "slow_valve";
  static constexpr bool decides_output = false;
  static constexpr int degree = 0;
  Window window;
  double delay_open = 0.02, delay_close = 0;

  static constexpr void describe(auto& p, auto&& field) {
    Window::describe(p.window, field);
    field(p.delay_open, Field{"delay_open", "s", 0, 1e3, "from the drive to the opening"});
    field(p.delay_close, Field{"delay_close", "s", 0, 1e3, "from the end of the drive to the closing"});
  }

  void waveforms(auto&&) const noexcept {}
  void apply(Effect&, const At&) const noexcept {}
  std::string check(const Limits& limits) const {
    return limits.valve ? "" : "actuator " + std::to_string(window.actuator) + " has no valve; it is for thrusters";
  }
};

}  // namespace gyrostat::truth
