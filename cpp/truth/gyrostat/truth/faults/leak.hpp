// SPDX-License-Identifier: MIT
#pragma once
#include "gyrostat/truth/faults/fault.hpp"

namespace gyrostat::truth {

/// A valve that does not close: a fraction of full thrust while it is closed, nothing while it is open.
struct Leak {
  static constexpr const char* name = "leak";
  static constexpr bool decides_output = false;
  static constexpr int degree = 0;
  Window window;
  double fraction = 0.02;

  static constexpr void describe(auto& p, auto&& field) {
    Window::describe(p.window, field);
    field(p.fraction, Field{"fraction", "", 0, 1, "of full thrust, while the valve is closed"});
  }

  void waveforms(auto&&) const noexcept {}
  void apply(Effect& e, const At& at) const noexcept {
    if (!at.open) e.bias += fraction * at.limits.up;
  }
  std::string check(const Limits& limits) const {
    return limits.valve ? "" : "actuator " + std::to_string(window.actuator) + " has no valve; it is for thrusters";
  }
};

}  // namespace gyrostat::truth
