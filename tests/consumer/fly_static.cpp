// SPDX-License-Identifier: MIT
/// @file  The static flight stack with a law of our own, in float as on a small processor. Needs Eigen and nothing else.
#include <cmath>
#include <cstdio>

#include "gyrostat/flight/allocators/pseudo_inverse.hpp"
#include "gyrostat/flight/detectors/none.hpp"
#include "gyrostat/flight/observers/passthrough.hpp"
#include "gyrostat/flight/stack.hpp"
#include "quaternion_law.hpp"

namespace {

using S = float;
using Stack = gyrostat::FlightStack<gyrostat::Passthrough<S>, gyrostat::NoDetector<S>, consumer::QuaternionLaw<S>,
                                    gyrostat::PseudoInverse<S>>;
static_assert(Stack::cannot_throw, "a flight stack of flight components never throws");

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

}  // namespace

int main() {
  const gyrostat::Setup<S> setup = four_wheels();
  Stack stack(setup, gyrostat::Passthrough<S>(setup, {}), gyrostat::NoDetector<S>(setup, {}),
              consumer::QuaternionLaw<S>(setup, {}), gyrostat::PseudoInverse<S>(setup, {}));
  gyrostat::Measurement<S> y;
  y.q_NB = gyrostat::Quat<S>(S(0.95), S(0.1), S(0.2), S(-0.2)).normalized();
  y.h_w = gyrostat::VecN<S>::Zero(4);
  const gyrostat::Mat3<S>& J = setup.vehicle.J_B;
  for (; y.tick < 12000; ++y.tick) {
    const gyrostat::Vec3<S> tau_B = gyrostat::torque<S>(setup.vehicle.D_B, stack.step(y, {}).u);
    const gyrostat::Vec3<S> momentum_B = J * y.omega_BN_B;
    y.omega_BN_B += setup.dt * J.inverse() * (tau_B - y.omega_BN_B.cross(momentum_B));
    y.q_NB = (y.q_NB * gyrostat::quat_exp<S>(setup.dt * y.omega_BN_B)).normalized();
  }
  const double angle_deg = 114.59155902616465 * std::acos(std::fmin(1.0, std::abs(double(y.q_NB.w()))));
  std::printf("pointing error after 120 s: %.3f deg\n", angle_deg);
  return angle_deg < 0.1 ? 0 : 1;  // the law is stable: the error of 35 deg decays; float resolves 0.04 deg in acos
}
