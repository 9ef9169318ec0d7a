// SPDX-License-Identifier: MIT
/// @file  The static flight stack with a law of our own, in float as on a small processor. Needs Eigen and nothing else.
#include <cmath>
#include <cstdio>

#include "four_wheels.hpp"

namespace {

using S = float;
using Stack = consumer::FourWheels<S>;
static_assert(Stack::cannot_throw, "a flight stack of flight components never throws");

/// A damping that the period cannot carry is refused with the number and the limit, and there is no stack.
bool refuses_too_much_damping() {
  typename Stack::Params p(consumer::four_wheels<S>());
  p.controller.k_omega = S(2000);
  const gyrostat::Checked<Stack> stack(consumer::four_wheels<S>(), p);
  std::printf("refused as it should: %s = %g\n", stack.status().quantity, double(stack.status().value));
  return !stack;
}

}  // namespace

int main() {
  const gyrostat::Setup<S> setup = consumer::four_wheels<S>();
  gyrostat::Checked<Stack> stack = consumer::make_four_wheels<S>();
  if (!stack) return 2;
  gyrostat::Measurement<S> y;
  y.q_NB = gyrostat::Quat<S>(S(0.95), S(0.1), S(0.2), S(-0.2)).normalized();
  y.h_w = gyrostat::VecN<S>::Zero(4);
  const gyrostat::Mat3<S>& J = setup.vehicle.J_B;
  for (; y.tick < 12000; ++y.tick) {
    const gyrostat::Vec3<S> tau_B = gyrostat::torque<S>(setup.vehicle.D_B, stack->step(y, {}).u);
    const gyrostat::Vec3<S> momentum_B = J * y.omega_BN_B;
    y.omega_BN_B += setup.dt * J.inverse() * (tau_B - y.omega_BN_B.cross(momentum_B));
    y.q_NB = (y.q_NB * gyrostat::quat_exp<S>(setup.dt * y.omega_BN_B)).normalized();
  }
  const double angle_deg = 114.59155902616465 * std::acos(std::fmin(1.0, std::abs(double(y.q_NB.w()))));
  std::printf("pointing error after 120 s: %.3f deg\n", angle_deg);
  // The law is stable: the error of 35 deg decays; float resolves 0.04 deg in acos.
  return angle_deg < 0.1 && refuses_too_much_damping() ? 0 : 1;
}
