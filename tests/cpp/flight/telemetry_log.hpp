// SPDX-License-Identifier: MIT
/// @file  Reads a component's telemetry by name.
#pragma once
#include <gtest/gtest.h>

#include <map>
#include <string>
#include <type_traits>
#include <vector>

#include "gyrostat/core/params.hpp"

namespace gyrostat::test {

template <class Component>
std::map<std::string, std::vector<double>> telemetry_of(const Component& component) {
  std::map<std::string, std::vector<double>> out;
  component.telemetry([&out](auto name, const auto& value) {
    std::vector<double> values;
    if constexpr (std::is_arithmetic_v<std::decay_t<decltype(value)>>) {
      values.push_back(static_cast<double>(value));
    } else {
      for (Eigen::Index i = 0; i < value.size(); ++i) values.push_back(static_cast<double>(value[i]));
    }
    if constexpr (std::is_same_v<decltype(name), Counter>) {
      EXPECT_TRUE(out.emplace(name.name, values).second) << name.name << " is there twice";
    } else {
      EXPECT_TRUE(out.emplace(name, values).second) << name << " is there twice";
    }
  });
  return out;
}

}  // namespace gyrostat::test
