// SPDX-License-Identifier: MIT
#pragma once
#include "gyrostat/truth/faults/fault.hpp"

namespace gyrostat::truth {

/// A torque is added to what is delivered. Several add.
struct Bias {
  static constexpr const char* name = "bias";
  static constexpr bool decides_output = false;
  static constexpr int degree = 0;
  Window window;
  Waveform torque = 0.0;

  static constexpr void describe(auto& p, auto&& field) {
    Window::describe(p.window, field);
    field(p.torque, Field{"torque", "N m", -infinity, infinity, "added to what is delivered"});
  }

  void waveforms(auto&& see) const { see(torque); }
  void apply(Effect& e, const At& at) const noexcept { e.bias += torque(at.t, at.branch); }
  std::string check(const Limits& limits) const {
    return limits.valve ? "not of a thruster, a valve adds no torque of its own: leak, stuck or hard_over" : "";
  }
};

}  // namespace gyrostat::truth
