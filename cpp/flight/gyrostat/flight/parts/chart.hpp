// SPDX-License-Identifier: MIT
/// @file  Refusal of a law on a vehicle whose coordinates it does not fit.
#pragma once
#include "gyrostat/core/params.hpp"

namespace gyrostat {

/// For laws of the rigid body in rates and quaternion; the printed Euler-angle model has neither.
template <class S>
Status<S> needs_body_coordinates(const Setup<S>& setup) noexcept {
  return Status<S>::require(setup.vehicle.coordinates == Coordinates::body, "coordinates (body 0, euler_angles 1)",
                            static_cast<S>(setup.vehicle.coordinates), S(0), "=", Status<S>::Code::wrong_chart);
}

}  // namespace gyrostat
