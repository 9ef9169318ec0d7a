// SPDX-License-Identifier: MIT
#pragma once
#include "gyrostat/truth/faults/fault.hpp"

namespace gyrostat::truth {

/// Comes and goes: from t_on, the first `duty` of each period is faulty, the rest healthy.
struct Intermittent {
  static constexpr const char* name = "intermittent";
  static constexpr bool decides_output = false;
  static constexpr int degree = 0;
  Window window;
  double period = 1, duty = 0.5, remaining = 0, torque = 0;

  static constexpr void describe(auto& p, auto&& field) {
    Window::describe(p.window, field);
    field(p.period, Field{"period", "s", 1e-6, infinity, "of the faulty and healthy parts together"});
    field(p.duty, Field{"duty", "", 0, 1, "fraction of a period that is faulty"});
    field(p.remaining, Field{"remaining", "", -2, 2, "delivered / commanded while faulty", "per cent"});
    field(p.torque, Field{"torque", "N m", -infinity, infinity, "added to what is delivered while faulty"});
  }

  /// 1 while faulty.
  SquareWave gate() const noexcept {
    return {.low = 0, .high = 1, .period = period, .duty = duty, .phase = window.t_on == infinity ? 0 : -window.t_on};
  }
  void waveforms(auto&& see) const { see(Waveform(gate())); }
  void apply(Effect& e, const At& at) const noexcept {
    if (!gate().is_high(at.branch)) return;
    e.effectiveness *= remaining;
    e.bias += torque;
  }
  std::string check(const Limits& limits) const {
    if (!limits.valve) return {};
    if (torque != 0) return "a thruster has no torque beside its valve: leak, stuck or hard_over";
    return remaining < 0 ? "remaining must not be negative: a thruster pushes one way" : "";
  }
};

}  // namespace gyrostat::truth
