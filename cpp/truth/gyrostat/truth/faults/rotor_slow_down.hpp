// SPDX-License-Identifier: MIT
#pragma once
#include "gyrostat/truth/faults/fault.hpp"

namespace gyrostat::truth {

/// The rotor of a control moment gyro loses momentum at this rate, down to rest, and keeps what is left: the command still turns
/// the gimbal, which moves less momentum, and what the rotor gives away pushes the body along its spin axis.
struct RotorSlowDown {
  static constexpr const char* name = "rotor_slow_down";
  static constexpr bool decides_output = false;
  static constexpr int degree = 0;
  Window window;
  double rate = 0;

  static constexpr void describe(auto& p, auto&& field) {
    Window::describe(p.window, field);
    field(p.rate, Field{"rate", "N m", 0, infinity, "momentum that the rotor loses a second, > 0"});
  }

  void waveforms(auto&&) const noexcept {}
  void apply(Effect&, const At&) const noexcept {}  // nothing of the drive: effectors/control_moment_gyro.hpp
  std::string check(const Limits&) const { return rate > 0 ? "" : "rate must be positive"; }
};

}  // namespace gyrostat::truth
