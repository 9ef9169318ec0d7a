// SPDX-License-Identifier: MIT
// Written by gyrostat @version@ from the scenario '@title@': the variables of modelDescription.xml, by value reference.
#pragma once
#include "@name@.hpp"

namespace fmu_model {

using Flight = @name @ ::Flight<double>;
inline constexpr const char* guid = "@guid@";
inline constexpr double infinite = std::numeric_limits<double>::infinity();

enum class Type { real, integer, boolean };  // an enumeration is an integer here, as in FMI

struct Parameter {
  enum Role { observer, detector, controller, allocator } role;
  const char* name;
  unsigned first;  // value reference of the first element
  int count;
};
// A parameter without a component of that name would not be set: exitInitializationMode says so.
inline constexpr Parameter parameters[] = {@parameters @};
inline constexpr int parameter_count = @parameter_count @;

// Value references: parameters, then inputs, then outputs.
inline constexpr unsigned first_input = @first_input @, first_output = @first_output @, variables = @variables @;
inline constexpr double start[variables] = {@start @};
inline constexpr Type types[variables] = {@types @};

}  // namespace fmu_model
