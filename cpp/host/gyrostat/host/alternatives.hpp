// SPDX-License-Identifier: MIT
/// @file  Closed sets of described structs (faults, waveforms, disturbances, ...): a std::variant by name.
#pragma once
#include <string>
#include <variant>
#include <vector>

#include "gyrostat/host/parameters.hpp"

namespace gyrostat::host {

template <class Variant>
struct Alternatives;

template <class... T>
struct Alternatives<std::variant<T...>> {
  using Variant = std::variant<T...>;

  static std::vector<std::string> names() { return {T::name...}; }

  static std::vector<ParamInfo> describe(const std::string& family, const std::string& name) {
    std::vector<ParamInfo> out;
    const bool found = ((name == T::name && (out = describe_params(T{}), true)) || ...);
    if (!found) refuse_name(family, family, name, names());
    return out;
  }

  static Variant read(const std::string& family, const std::string& name, const Table& table, const Place& place) {
    Variant out;
    const bool found = ((name == T::name && (out = read_params(T{}, table, place), true)) || ...);
    if (!found) refuse_name(place.where, family, name, names());
    return out;
  }
};

}  // namespace gyrostat::host
