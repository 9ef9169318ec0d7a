// SPDX-License-Identifier: MIT
/// @file  How large flight code is when it is compiled for a vehicle of few actuators: `gyrostat export` copies the library with
///        the capacity that a vehicle needs, and what is written in C has to say how much memory to set aside.
///
/// stack_sizes.cpp is compiled once for each capacity, with the library's namespace renamed so that its types are its own. Hence
/// plain structs in no namespace.
#pragma once
#include <cstddef>

/// A component, or what FlightStack holds beside components (`role` null): bytes, with Eigen aligned to 16.
struct GyrostatPartSize {
  const char *role, *name;
  std::size_t bytes_double, bytes_float;
};

/// Of one capacity.
struct GyrostatPartSizes {
  int capacity;  ///< most actuators
  const GyrostatPartSize* parts;
  std::size_t count;
};

extern "C" {
GyrostatPartSizes gyrostat_part_sizes_4();
GyrostatPartSizes gyrostat_part_sizes_8();
GyrostatPartSizes gyrostat_part_sizes_16();
}
