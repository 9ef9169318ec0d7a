// SPDX-License-Identifier: MIT
/// @file  Vehicles that the flight tests fly, and components with default parameters.
#pragma once
#include <cmath>
#include <limits>

#include "gyrostat/core/params.hpp"

namespace gyrostat::test {

/// Commands limited to +-u_max (infinite: flight knows no limit), no rate limit, ideal torquers.
template <class S>
Setup<S> vehicle_with(const Mat3<S>& J_B, const Mat3N<S>& D_B, S u_max, S dt) {
  const Eigen::Index n = D_B.cols();
  Setup<S> setup;
  setup.vehicle.J_B = J_B;
  setup.vehicle.D_B = D_B;
  setup.vehicle.u_up = VecN<S>::Constant(n, u_max);
  setup.vehicle.u_lo = VecN<S>::Constant(n, -u_max);
  setup.vehicle.u_rate = VecN<S>::Constant(n, std::numeric_limits<S>::infinity());
  setup.dt = dt;
  return setup;
}

/// Four axes (1,1,1), (1,-1,1), (-1,-1,1), (-1,1,1) over sqrt 3.
template <class S>
Mat3N<S> pyramid() {
  Mat3N<S> D(3, 4);
  D << S(1), S(1), S(-1), S(-1), S(1), S(-1), S(-1), S(1), S(1), S(1), S(1), S(1);
  return D / std::sqrt(S(3));
}

template <class S>
Mat3<S> satellite_inertia() {
  Mat3<S> J;
  J << S(20), S(0), S(0.9), S(0), S(17), S(0), S(0.9), S(0), S(15);
  return J;
}

/// A component or a stack with its default parameters, whatever its `check` says of them.
template <class T>
T by_default(const Setup<typename T::Scalar>& setup) {
  return T(unchecked, setup, typename T::Params(setup));
}

/// The library's reference vehicle: 100 Hz, 0.2 N m a wheel.
template <class S>
Setup<S> ftc_4rw() {
  return vehicle_with<S>(satellite_inertia<S>(), pyramid<S>(), S(0.2), S(0.01));
}

}  // namespace gyrostat::test
