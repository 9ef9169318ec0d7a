// SPDX-License-Identifier: MIT
/// @file  Parameters by the name they have in the catalogue: what exported code, the FMU and an uploaded table of gains use.
///
///     Observer::Params p(setup);
///     const bool taken = set_parameter(p, "lambda1", 2.0) && set_parameter(p, "method", 1);
///
/// It finds the member through the component's `describe`, so there is no second list of names. No heap, no text is kept.
#pragma once
#include <cmath>
#include <limits>
#include <type_traits>

#include "gyrostat/core/params.hpp"

namespace gyrostat {

namespace detail {

inline bool same_text(const char* a, const char* b) noexcept {
  for (; *a != '\0' && *a == *b; ++a, ++b) continue;
  return *a == *b;
}

inline bool is_whole(double x, double lo, double hi) noexcept { return x >= lo && x <= hi && x == std::floor(x); }

template <class S>
  requires std::is_floating_point_v<S>
bool assign(S& member, const double* value, int count) noexcept {
  if (count != 1) return false;
  member = static_cast<S>(value[0]);
  return true;
}
template <class I>
  requires std::is_integral_v<I>
bool assign(I& member, const double* value, int count) noexcept {
  // 2^53: every whole number up to there is a double.
  if (count != 1 || !is_whole(value[0], 0, std::fmin(9007199254740992.0, double(std::numeric_limits<I>::max()))))
    return false;
  member = static_cast<I>(value[0]);
  return true;
}
/// Row by row; a dynamic size is taken from the count.
template <class S, int R, int C, int O, int MR, int MC>
bool assign(Eigen::Matrix<S, R, C, O, MR, MC>& member, const double* value, int count) noexcept {
  const int rows = R == Eigen::Dynamic ? count : R;
  const int cols = C == Eigen::Dynamic ? count / rows : C;
  if (rows < 1 || cols < 1 || rows > MR || cols > MC || rows * cols != count) return false;
  member.resize(rows, cols);
  for (int r = 0; r < rows; ++r)
    for (int c = 0; c < cols; ++c) member(r, c) = static_cast<S>(value[r * cols + c]);
  return true;
}
/// Scalar first.
template <class S>
bool assign(Quat<S>& member, const double* value, int count) noexcept {
  if (count != 4) return false;
  member =
      Quat<S>(static_cast<S>(value[0]), static_cast<S>(value[1]), static_cast<S>(value[2]), static_cast<S>(value[3]));
  return true;
}
/// The numbers of its actuators.
inline bool assign(Mask& member, const double* value, int count) noexcept {
  Mask mask;
  for (int i = 0; i < count; ++i) {
    if (!is_whole(value[i], 0, max_actuators - 1)) return false;
    mask.set(static_cast<int>(value[i]));
  }
  member = mask;
  return true;
}

/// Visits a description, and fills the member of one name.
struct ParameterSetter {
  const char* name;
  const double* value;
  int count;
  bool taken = false;

  template <class M>
  void operator()(M& member, const Field& f) noexcept {
    if (!same_text(f.name, name)) return;
    for (int i = 0; i < count; ++i)
      if (!(value[i] >= f.lo && value[i] <= f.hi)) return;
    taken = assign(member, value, count);
  }
  template <class E>
  void operator()(E& member, const Choice& c) noexcept {
    if (!same_text(c.name, name)) return;
    int last = 0;
    for (const char* letter = c.options; *letter != '\0'; ++letter) last += *letter == '|' ? 1 : 0;
    if (count != 1 || !is_whole(value[0], 0, last)) return;
    member = static_cast<E>(static_cast<int>(value[0]));
    taken = true;
  }
  void operator()(bool& member, const Switch& s) noexcept {
    if (!same_text(s.name, name) || count != 1 || (value[0] != 0.0 && value[0] != 1.0)) return;
    member = value[0] != 0.0;
    taken = true;
  }
};

}  // namespace detail

/// Sets one parameter.
/// @param value  numbers in the order of a row-major reading; of a Choice the position of the option, of a Switch 0 or 1
/// @return false, and nothing changed: no parameter of that name, another number of values, or one out of its range
template <class Params>
bool set_parameter(Params& params, const char* name, const double* value, int count) noexcept {
  detail::ParameterSetter setter{name, value, count};
  Params::describe(params, setter);
  return setter.taken;
}

template <class Params, class... Numbers>
  requires(sizeof...(Numbers) > 0 && (std::is_arithmetic_v<Numbers> && ...))
bool set_parameter(Params& params, const char* name, Numbers... numbers) noexcept {
  const double value[] = {static_cast<double>(numbers)...};
  return set_parameter(params, name, value, static_cast<int>(sizeof...(Numbers)));
}

}  // namespace gyrostat
