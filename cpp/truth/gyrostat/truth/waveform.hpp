// SPDX-License-Identifier: MIT
/// @file  A number that is a known function of time: one type for faults, disturbances, references and open-loop commands.
///
/// Evaluated as `w(t, branch)`: at a switch the two one-sided values differ, and `branch`, any time strictly inside the
/// smooth piece in question, says which one is meant. Between two consecutive switches a waveform is analytic.
#pragma once
#include <limits>
#include <string>
#include <type_traits>
#include <variant>
#include <vector>

#include "gyrostat/core/params.hpp"

namespace gyrostat::truth {

inline constexpr double infinity = std::numeric_limits<double>::infinity();

class Waveform;

/// value
struct ConstantWave {
  static constexpr const char* name = "constant";
  double value = 0;

  static constexpr void describe(auto& p, auto&& field) {
    field(p.value, Field{"value", "", -infinity, infinity, "the value at all times"});
  }
  std::string check() const { return {}; }
};

/// offset + amplitude sin(omega t + phase)
struct SineWave {
  static constexpr const char* name = "sine";
  double offset = 0, amplitude = 1, omega = 1, phase = 0;

  static constexpr void describe(auto& p, auto&& field) {
    field(p.offset, Field{"offset", "", -infinity, infinity, "mean value"});
    field(p.amplitude, Field{"amplitude", "", -infinity, infinity, "of the sine"});
    field(p.omega, Field{"omega", "rad/s", -infinity, infinity, "angular frequency"});
    field(p.phase, Field{"phase", "rad", -infinity, infinity, "angle at t = 0; pi/2 makes a cosine"});
  }
  std::string check() const { return {}; }
};

/// high during the first `duty` of each period, low during the rest
struct SquareWave {
  static constexpr const char* name = "square";
  double low = 0, high = 1, period = 1, duty = 0.5, phase = 0;

  static constexpr void describe(auto& p, auto&& field) {
    field(p.low, Field{"low", "", -infinity, infinity, "value in the second part of a period"});
    field(p.high, Field{"high", "", -infinity, infinity, "value in the first part of a period"});
    field(p.period, Field{"period", "s", 1e-6, infinity, "of the wave"});
    field(p.duty, Field{"duty", "", 0, 1, "fraction of the period that is high"});
    field(p.phase, Field{"phase", "s", -infinity, infinity, "how far into a period the wave is at t = 0"});
  }
  std::string check() const;
  double next_switch(double t) const noexcept;
  bool is_high(double t) const noexcept;
};

/// values[i] from times[i] on; values[0] before
struct StepsWave {
  static constexpr const char* name = "steps";
  std::vector<double> times{0.0}, values{0.0};

  static constexpr void describe(auto& p, auto&& field) {
    field(p.times, Field{"times", "s", -infinity, infinity, "increasing; when each value begins"});
    field(p.values, Field{"values", "", -infinity, infinity, "one a time; the first also holds before its time"});
  }
  std::string check() const;
};

/// Linear between (times[i], values[i]), constant outside
struct TableWave {
  static constexpr const char* name = "table";
  std::vector<double> times{0.0}, values{0.0};

  static constexpr void describe(auto& p, auto&& field) {
    field(p.times, Field{"times", "s", -infinity, infinity, "increasing; where the values are given"});
    field(p.values, Field{"values", "", -infinity, infinity, "one a time; linear between, constant outside"});
  }
  std::string check() const;
};

/// Sum of other waveforms
struct SumWave {
  static constexpr const char* name = "sum";
  std::vector<Waveform> terms;

  static constexpr void describe(auto& p, auto&& field) {
    field(p.terms, Field{"terms", "", -infinity, infinity, "waveforms that are added"});
  }
  std::string check() const;
};

/// Whether a variant has K among its alternatives; asked without making one, which a recursive variant cannot answer.
template <class K, class Variant>
inline constexpr bool is_alternative = false;
template <class K, class... Kinds>
inline constexpr bool is_alternative<K, std::variant<Kinds...>> = (std::is_same_v<K, Kinds> || ...);

class Waveform {
 public:
  using Kind = std::variant<ConstantWave, SineWave, SquareWave, StepsWave, TableWave, SumWave>;

  Waveform(double value = 0) : kind_(ConstantWave{value}) {}
  Waveform(Kind kind) : kind_(std::move(kind)) {}
  /// Any of the kinds, so that `Waveform w = SineWave{...}` reads as it is.
  template <class K>
    requires is_alternative<K, Kind>
  Waveform(K kind) : kind_(std::in_place_type<K>, std::move(kind)) {}

  // Defined in the source file: a variant of vectors inlined into every user is slow to compile.
  Waveform(const Waveform&);
  Waveform(Waveform&&) noexcept;
  Waveform& operator=(const Waveform&);
  Waveform& operator=(Waveform&&) noexcept;
  ~Waveform();

  /// Value at t on the piece that contains `branch`.
  double operator()(double t, double branch) const noexcept;
  double operator()(double t) const noexcept { return (*this)(t, t); }

  /// First time after t at which value or slope jumps; infinity when there is none.
  double next_switch(double t) const noexcept;
  /// Constant between switches.
  bool piecewise_constant() const noexcept;
  /// Largest angular frequency between switches (rad/s); zero when polynomial there.
  double fastest() const noexcept;
  /// What is wrong with the parameters; empty when nothing is.
  std::string check() const;

  const Kind& kind() const noexcept { return kind_; }

 private:
  Kind kind_;
};

}  // namespace gyrostat::truth
