// SPDX-License-Identifier: MIT
#pragma once
#include "gyrostat/truth/faults/fault.hpp"

namespace gyrostat::truth {

/// The command is delivered in part: effectiveness = remaining(t). Several multiply.
struct LossOfEffectiveness {
  static constexpr const char* name = "loss_of_effectiveness";
  static constexpr bool decides_output = false;
  static constexpr int degree = 0;
  Window window;
  Waveform remaining = 0.5;

  static constexpr void describe(auto& p, auto&& field) {
    Window::describe(p.window, field);
    field(p.remaining,
          Field{"remaining", "", -2, 2, "delivered / commanded; 1 is healthy, 0 delivers no command", "per cent"});
  }

  void waveforms(auto&& see) const { see(remaining); }
  void apply(Effect& e, const At& at) const noexcept { e.effectiveness *= remaining(at.t, at.branch); }
  std::string check(const Limits& limits) const {
    const bool negative = std::holds_alternative<ConstantWave>(remaining.kind()) && remaining(0) < 0;
    return limits.valve && negative ? "remaining must not be negative: a thruster pushes one way" : "";
  }
};

}  // namespace gyrostat::truth
