// SPDX-License-Identifier: MIT
/// @file  Reading a component's `telemetry(log)` on the host: names once, then values into a preallocated row.
#pragma once
#include <string>
#include <type_traits>
#include <vector>

#include "gyrostat/core/params.hpp"

namespace gyrostat::host {

/// One inner signal of a component.
struct TelemetryEntry {
  std::string name;
  int width = 1;
  bool counter = false;
  const char* dimension = "";  ///< what its columns are, as in ChannelInfo
};

/// What the host asks of every erased component beside its role.
class Reporting {
 public:
  virtual ~Reporting() = default;
  virtual void entries(std::vector<TelemetryEntry>& out) const = 0;
  /// Values in the order of `entries`; returns the end of the row.
  virtual double* values(double* row) const = 0;
};

namespace detail {

struct NameLog {
  std::vector<TelemetryEntry>& out;

  template <class V>
  void operator()(const char* name, const V& value) const {
    if constexpr (std::is_arithmetic_v<V>) {
      out.push_back({name});
    } else {  // a vector is in body axes, what has its length at run time has one number an actuator
      const char* dimension = V::RowsAtCompileTime == 3                ? "axis"
                              : V::RowsAtCompileTime == Eigen::Dynamic ? "actuator"
                                                                       : "";
      out.push_back({name, static_cast<int>(value.size()), false, dimension});
    }
  }
  template <class V>
  void operator()(Counter c, const V&) const {
    out.push_back({c.name, 1, true});
  }
};

struct ValueLog {
  double*& row;

  template <class V>
  void operator()(const char*, const V& value) const {
    if constexpr (std::is_arithmetic_v<V>) {
      *row++ = static_cast<double>(value);
    } else {
      for (Eigen::Index i = 0; i < value.size(); ++i) *row++ = static_cast<double>(value[i]);
    }
  }
  template <class V>
  void operator()(Counter, const V& value) const {
    *row++ = static_cast<double>(value);
  }
};

}  // namespace detail

template <class T>
void telemetry_entries(const T& component, std::vector<TelemetryEntry>& out) {
  if constexpr (requires { component.telemetry(detail::NameLog{out}); }) component.telemetry(detail::NameLog{out});
}

template <class T>
double* telemetry_values(const T& component, double* row) {
  if constexpr (requires { component.telemetry(detail::ValueLog{row}); }) component.telemetry(detail::ValueLog{row});
  return row;
}

}  // namespace gyrostat::host
