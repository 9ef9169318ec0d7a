// SPDX-License-Identifier: MIT
/// @file  A small plant of its own for the flight tests: rigid body, ideal torquers, RK4 in double, one step a sample.
#pragma once
#include <functional>

#include "gyrostat/core/attitude.hpp"
#include "gyrostat/core/signals.hpp"

namespace gyrostat::test {

struct Body {
  Mat3<double> J_B;
  Mat3N<double> D_B;
  Quat<double> q_NB = Quat<double>::Identity();
  Vec3<double> omega_BN_B = Vec3<double>::Zero();
  Vec3<double> d_B = Vec3<double>::Zero();  ///< N m, constant disturbance
  VecN<double> effectiveness;               ///< of each actuator

  template <class S>
  explicit Body(const Vehicle<S>& nominal)
      : J_B(nominal.J_B.template cast<double>()),
        D_B(nominal.D_B.template cast<double>()),
        effectiveness(VecN<double>::Ones(nominal.D_B.cols())) {}

  Vec3<double> fault_B(const VecN<double>& u) const;
  void advance(const VecN<double>& u, double h);

  template <class S>
  Measurement<S> measured(Tick tick) const {
    Measurement<S> y;
    y.tick = tick;
    y.q_NB = q_NB.cast<S>();
    y.omega_BN_B = omega_BN_B.cast<S>();
    y.h_w = VecN<S>::Zero(D_B.cols());
    return y;
  }
};

/// Flies `stack` over `body` for `samples`; `before(k)` may change body and reference, `after(k)` looks at the sample.
template <class Stack>
void fly(Stack& stack, Body& body, double dt, int samples, const std::function<void(int)>& before,
         const std::function<void(int)>& after, const Reference<typename Stack::Scalar>* ref = nullptr) {
  using S = typename Stack::Scalar;
  const Reference<S> rest;
  for (int k = 0; k < samples; ++k) {
    if (before) before(k);
    stack.step(body.measured<S>(static_cast<Tick>(k)), ref != nullptr ? *ref : rest);
    if (after) after(k);
    body.advance(stack.last().u.template cast<double>(), dt);
  }
}

inline double degrees(double radians) { return radians * 57.295779513082320877; }

}  // namespace gyrostat::test
