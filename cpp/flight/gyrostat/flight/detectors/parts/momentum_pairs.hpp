// SPDX-License-Identifier: MIT
/// @file  What a wheel was told and what it did, in blocks: mean command, and momentum given over the time it took.
///
/// No differencing noise at small periods, and a command that chatters averages out. Page: docs/components/evidence.md
#pragma once
#include <algorithm>
#include <array>
#include <cmath>

namespace gyrostat {

/// Means over one block, N m.
template <class S>
struct MomentumPair {
  S delivered = S(0), commanded = S(0);
  S tolerance = S(0);  ///< what the difference may be by noise, delay and friction

  S error() const noexcept { return delivered - commanded; }
  bool inside(S share = S(1)) const noexcept { return std::abs(error()) <= share * tolerance; }
};

/// The last pairs of one wheel, the newest first.
template <class S>
class MomentumPairs {
 public:
  static constexpr int capacity = 16;

  void forget() noexcept { size_ = 0; }

  void push(const MomentumPair<S>& pair) noexcept {
    newest_ = (newest_ + capacity - 1) % capacity;
    pairs_[static_cast<std::size_t>(newest_)] = pair;
    size_ = std::min(size_ + 1, capacity);
  }

  int size() const noexcept { return size_; }
  const MomentumPair<S>& operator[](int age) const noexcept {
    return pairs_[static_cast<std::size_t>((newest_ + age) % capacity)];
  }

  /// The last four outside, or six of the last eight: all to one side, or by half as much again. Neighbours share a reading, so
  /// noise goes from side to side, and four of them outside are not as rare as their shares multiplied.
  bool persists() const noexcept {
    const auto persist = [this](auto outside) { return this->count(4, outside) == 4 || this->count(8, outside) >= 6; };
    return persist([](const auto& p) { return p.error() > p.tolerance; }) ||
           persist([](const auto& p) { return p.error() < -p.tolerance; }) ||
           persist([](const auto& p) { return !p.inside(S(1.5)); });
  }

  /// Pairs since the wheel was last well, three in a row; without the oldest of them where enough are left: it is part before
  /// the onset.
  int since_onset() const noexcept {
    int well = 0, age = 0;
    for (; age < size_ && well < 3; ++age) well = (*this)[age].inside() ? well + 1 : 0;
    const int n = age - well;
    return n >= 4 ? n - 1 : n;
  }

 private:
  int count(int last, auto outside) const noexcept {
    int n = 0;
    for (int age = 0; age < std::min(last, size_); ++age) n += outside((*this)[age]) ? 1 : 0;
    return n;
  }

  std::array<MomentumPair<S>, capacity> pairs_{};
  int newest_ = 0, size_ = 0;
};

}  // namespace gyrostat
