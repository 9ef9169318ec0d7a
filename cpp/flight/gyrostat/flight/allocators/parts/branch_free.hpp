// SPDX-License-Identifier: MIT
/// @file  Logic without branches: every condition is evaluated, and the compiler can do so for several actuators at once.
#pragma once
#include <concepts>

namespace gyrostat {

template <std::same_as<bool>... B>
constexpr bool every(B... conditions) noexcept {
  return (static_cast<unsigned>(conditions) & ...) != 0u;
}

template <std::same_as<bool>... B>
constexpr bool some(B... conditions) noexcept {
  return (static_cast<unsigned>(conditions) | ...) != 0u;
}

}  // namespace gyrostat
