// SPDX-License-Identifier: MIT
/// @file  Vehicle and parameters of Li, Hu, Yang, Postolache 2018, section 4. What the paper leaves open (wheel axes, P = J, eps,
/// s_lim, initial gain, period) is as in the reference implementation of the li2018 study.
#pragma once
#include "gyrostat/flight/allocators/pseudo_inverse.hpp"
#include "gyrostat/flight/controllers/integral_sliding_mode.hpp"
#include "gyrostat/flight/controllers/saturated_pd.hpp"
#include "gyrostat/flight/detectors/none.hpp"
#include "gyrostat/flight/observers/finite_time_disturbance.hpp"
#include "gyrostat/flight/observers/passthrough.hpp"
#include "gyrostat/flight/stack.hpp"
#include "vehicles.hpp"

namespace gyrostat::test::li2018 {

/// u_max = 0.25: the command is limited; infinite: the paper's other reading, where only the wheel's output is.
template <class S>
Setup<S> setup(S u_max = S(0.25), S dt = S(0.001)) {
  Mat3N<S> D(3, 4);
  D << S(1), S(-1), S(-1), S(1), S(1), S(1), S(-1), S(-1), S(1), S(1), S(1), S(1);
  return vehicle_with<S>(satellite_inertia<S>(), D / std::sqrt(S(3)), u_max, dt);
}

template <class S>
typename FiniteTimeDisturbanceObserver<S>::Params observer() {
  typename FiniteTimeDisturbanceObserver<S>::Params p(setup<S>());
  p.alpha1 = S(0.6);
  p.lambda1 = S(1);
  p.lambda2 = S(0.6);
  return p;
}

template <class S>
typename IntegralSlidingMode<S>::Params controller() {
  typename IntegralSlidingMode<S>::Params p(setup<S>());
  p.nominal.k1 = S(4.9);
  p.nominal.k2 = S(3);
  p.nominal.beta1 = S(0.9);
  p.K3 = {S(6.5), S(6.7), S(7.2)};
  p.K4 = {S(4), S(4.22), S(4)};
  p.gamma = S(0.88);
  p.zeta1 = p.zeta2 = S(0.2);
  p.mu = S(0.1);
  p.gain_0.setConstant(S(0.15));
  p.eps = S(0.01);
  p.s_lim = S(0.05);
  return p;
}

template <class S>
typename SaturatedPd<S>::Params saturated_pd() {
  typename SaturatedPd<S>::Params p(setup<S>());
  p.kp = S(10);
  p.kd = S(13);
  p.ws = S(0.1);
  return p;
}

template <class S>
typename PseudoInverse<S>::Params allocator() {
  typename PseudoInverse<S>::Params p(setup<S>());
  p.use_effectiveness = false;
  return p;
}

template <class S>
using Stack = FlightStack<FiniteTimeDisturbanceObserver<S>, NoDetector<S>, IntegralSlidingMode<S>, PseudoInverse<S>>;
template <class S>
using PdStack = FlightStack<PassthroughObserver<S>, NoDetector<S>, SaturatedPd<S>, PseudoInverse<S>>;

template <class S>
Stack<S> stack(const Setup<S>& s) {
  typename Stack<S>::Params p(s);
  p.observer = observer<S>();
  p.controller = controller<S>();
  p.allocator = allocator<S>();
  return Stack<S>(unchecked, s, p);
}
template <class S>
PdStack<S> pd_stack(const Setup<S>& s) {
  typename PdStack<S>::Params p(s);
  p.controller = saturated_pd<S>();
  p.allocator = allocator<S>();
  return PdStack<S>(unchecked, s, p);
}

}  // namespace gyrostat::test::li2018
