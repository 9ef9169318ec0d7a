// SPDX-License-Identifier: MIT
#pragma once
#include "gyrostat/truth/faults/fault.hpp"

namespace gyrostat::truth {

/// Floats: delivers nothing at all, biases included. A dead wheel keeps its momentum (but for friction).
struct Dead {
  static constexpr const char* name = "dead";
  static constexpr bool decides_output = true;
  static constexpr int degree = 0;
  Window window;

  static constexpr void describe(auto& p, auto&& field) { Window::describe(p.window, field); }

  void waveforms(auto&&) const noexcept {}
  void apply(Effect& e, const At&) const noexcept { e = {0, 0, 0}; }
  std::string check(const Limits&) const { return {}; }
};

}  // namespace gyrostat::truth
