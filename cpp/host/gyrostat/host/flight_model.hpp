// SPDX-License-Identifier: MIT
/// @file  The flight half of a scenario as facts: vehicle, components, every parameter. What `gyrostat export` writes from.
#pragma once
#include <string>
#include <vector>

#include "gyrostat/host/assembly.hpp"

namespace gyrostat::host {

/// A component with its C++ class and the parameters that it flies with.
struct FlightComponent {
  std::string role, name;
  CppClass cpp;
  std::vector<ParamInfo> params;  ///< the value of each is its `default_value`
};

struct FlightModel {
  Setup<double> setup;
  bool allow_unstable = false;
  std::vector<truth::ControlMomentGyro> gyros;
  Mat3N<double> dipole_B{3, 0};             ///< axes of magnetorquers in their columns; empty without any
  std::vector<FlightComponent> components;  ///< navigator, observer, detector, controller, allocator; desaturation
  int capacity = 0;                         ///< most actuators of the library as it is to be compiled for them
  std::size_t bytes_double = 0, bytes_float = 0;  ///< at least the size of their FlightStack, with Eigen aligned to 16
};

/// Throws std::invalid_argument for what does not run, and for components that are not in the catalogue.
FlightModel flight_model(const Assembly& a);

}  // namespace gyrostat::host
