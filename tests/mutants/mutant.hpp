// SPDX-License-Identifier: MIT
/// @file  The switch of the mutants. scripts/mutants copies this header beside the copy of core that it changes.
#pragma once
#include <array>
#include <cstdio>
#include <cstdlib>
#include <type_traits>

namespace gyrostat::mutant {

/// Which mutant runs, read once from GYROSTAT_MUTANT (absent: none), and which ones were come by: their numbers are written to
/// the file GYROSTAT_MUTANTS_REACHED at the end, so that only tests that can notice a mutant are run with it.
class Switchboard {
 public:
  Switchboard() noexcept {
    const char* number = std::getenv("GYROSTAT_MUTANT");
    if (number != nullptr) active_ = std::atoi(number);
  }
  ~Switchboard() {
    const char* file = std::getenv("GYROSTAT_MUTANTS_REACHED");
    std::FILE* out = file != nullptr ? std::fopen(file, "w") : nullptr;
    if (out == nullptr) return;
    for (std::size_t i = 0; i < reached_.size(); ++i)
      if (reached_[i]) std::fprintf(out, "%d\n", static_cast<int>(i));
    std::fclose(out);
  }
  bool is(int number) noexcept {
    reached_[static_cast<std::size_t>(number)] = true;
    return number == active_;
  }

 private:
  int active_ = -1;
  std::array<bool, 100 * 100> reached_{};  // a hundred headers, a hundred mutants each
};
inline Switchboard switchboard;

constexpr bool is(int number) noexcept { return !std::is_constant_evaluated() && switchboard.is(number); }

/// The value, not an expression of Eigen's that refers to what is gone.
template <class T>
constexpr auto plain(const T& x) noexcept {
  if constexpr (requires { typename T::PlainObject; }) {
    return typename T::PlainObject(x);
  } else {
    return x;
  }
}

/// The value of one of two expressions, in the type of the first.
template <class Original, class Mutated>
constexpr auto either(int number, Original original, Mutated mutated) noexcept {
  using Value = decltype(original());
  if (is(number)) return static_cast<Value>(mutated());
  return original();
}

}  // namespace gyrostat::mutant
