// SPDX-License-Identifier: MIT
/// @file  Four wheels in a pyramid, flown by our own law. Needs Eigen and gyrostat::flight, nothing else.
#pragma once
#include <cmath>
#include <limits>

#include "gyrostat/flight/allocators/pseudo_inverse.hpp"
#include "gyrostat/flight/detectors/none.hpp"
#include "gyrostat/flight/observers/passthrough.hpp"
#include "gyrostat/flight/stack.hpp"
#include "quaternion_law.hpp"

namespace consumer {

template <class S>
using FourWheels = gyrostat::FlightStack<gyrostat::PassthroughObserver<S>, gyrostat::NoDetector<S>, QuaternionLaw<S>,
                                         gyrostat::PseudoInverse<S>>;

template <class S>
gyrostat::Setup<S> four_wheels() {
  gyrostat::Setup<S> setup;
  setup.dt = S(0.01);
  gyrostat::Vehicle<S>& v = setup.vehicle;
  v.J_B = gyrostat::Vec3<S>(20, 17, 15).asDiagonal();
  v.D_B.resize(3, 4);
  v.D_B << 1, 1, -1, -1, 1, -1, -1, 1, 1, 1, 1, 1;
  v.D_B /= std::sqrt(S(3));
  v.u_up = gyrostat::VecN<S>::Constant(4, S(0.2));
  v.u_lo = -v.u_up;
  v.u_rate = gyrostat::VecN<S>::Constant(4, std::numeric_limits<S>::infinity());
  return setup;
}

template <class S>
gyrostat::Checked<FourWheels<S>> make_four_wheels() {
  const gyrostat::Setup<S> setup = four_wheels<S>();
  typename FourWheels<S>::Params p(setup);  // the defaults for this vehicle and period
  p.controller.k_omega = S(8);
  return {setup, p};  // a stack, or the Status that refuses its parameters
}

}  // namespace consumer
