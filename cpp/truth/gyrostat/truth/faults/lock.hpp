// SPDX-License-Identifier: MIT
#pragma once
#include "gyrostat/truth/faults/fault.hpp"

namespace gyrostat::truth {

/// Goes on delivering what it delivered at the onset, nothing if that is before the first command. It is the torque
/// that is locked: a wheel with a locked torque goes on changing its speed. A wheel that seizes is not this.
struct Lock {
  static constexpr const char* name = "lock";
  static constexpr bool decides_output = true;
  static constexpr int degree = 0;
  Window window;

  static constexpr void describe(auto& p, auto&& field) { Window::describe(p.window, field); }

  void waveforms(auto&&) const noexcept {}
  void apply(Effect& e, const At& at) const noexcept { e = {0, at.at_onset, 0}; }
  std::string check(const Limits&) const { return {}; }
};

}  // namespace gyrostat::truth
