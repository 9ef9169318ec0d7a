// SPDX-License-Identifier: MIT
#pragma once
#include "gyrostat/truth/faults/fault.hpp"

namespace gyrostat::truth {

/// A bias that starts at zero and grows: rate (t - t_on).
struct Drift {
  static constexpr const char* name = "drift";
  static constexpr bool decides_output = false;
  static constexpr int degree = 1;
  Window window;
  double rate = 0;

  static constexpr void describe(auto& p, auto&& field) {
    Window::describe(p.window, field);
    field(p.rate, Field{"rate", "N m/s", -infinity, infinity, "growth of the bias"});
  }

  void waveforms(auto&&) const noexcept {}
  void apply(Effect& e, const At& at) const noexcept { e.bias += rate * (at.t - window.t_on); }
  std::string check(const Limits& limits) const {
    return limits.valve ? "not of a thruster, a valve adds no torque that grows: leak, stuck or hard_over" : "";
  }
};

}  // namespace gyrostat::truth
