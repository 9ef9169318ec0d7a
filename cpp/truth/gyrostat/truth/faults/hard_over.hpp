// SPDX-License-Identifier: MIT
#pragma once
#include <cmath>

#include "gyrostat/truth/faults/fault.hpp"

namespace gyrostat::truth {

/// Delivers its limit whatever is commanded; the actuator needs a finite one.
struct HardOver {
  static constexpr const char* name = "hard_over";
  static constexpr bool decides_output = true;
  static constexpr int degree = 0;
  Window window;
  double sign = 1;

  static constexpr void describe(auto& p, auto&& field) {
    Window::describe(p.window, field);
    field(p.sign, Field{"sign", "", -1, 1, "positive: at the upper limit; negative: at the lower one"});
  }

  void waveforms(auto&&) const noexcept {}
  void apply(Effect& e, const At& at) const noexcept { e = {0, output(at.limits), 0}; }
  std::string check(const Limits& limits) const {
    if (sign == 0) return "sign must not be zero";
    if (std::isfinite(output(limits))) return {};
    return "actuator " + std::to_string(window.actuator) + " has no finite limit to run to";
  }
  double output(const Limits& limits) const noexcept { return sign > 0 ? limits.up : limits.lo; }
};

}  // namespace gyrostat::truth
