// SPDX-License-Identifier: MIT
/// @file  Values of a fixed number of samples ago, for laws that learn from the past. Storage inline.
#pragma once
#include <array>
#include <cassert>

namespace gyrostat {

/// Longest delay of a learning law, in samples.
inline constexpr int max_delay = 64;

/// Remembers the last `delay` values that were pushed, 1 <= delay <= most; before that many, the initial one.
template <class T, int most = max_delay>
class DelayLine {
 public:
  DelayLine(int delay, const T& initial) noexcept : delay_(delay) {
    assert(delay >= 1 && delay <= most);
    fill(initial);
  }

  /// All of the past is this value.
  void fill(const T& value) noexcept {
    values_.fill(value);
    at_ = 0;
  }
  /// What was pushed `delay` pushes ago; read it before this sample's push.
  const T& oldest() const noexcept { return values_[static_cast<std::size_t>(at_)]; }
  void push(const T& value) noexcept {
    values_[static_cast<std::size_t>(at_)] = value;
    if (++at_ == delay_) at_ = 0;
  }

 private:
  int delay_;
  int at_ = 0;
  std::array<T, static_cast<std::size_t>(most)> values_;
};

}  // namespace gyrostat
