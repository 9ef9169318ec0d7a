// SPDX-License-Identifier: MIT
/// @file  Some static stacks with default parameters; every_component.hpp has the others.
#pragma once
#include <cmath>

#include "../flight/vehicles.hpp"
#include "gyrostat/flight/allocators/pseudo_inverse.hpp"
#include "gyrostat/flight/controllers/fast_terminal_sliding_mode.hpp"
#include "gyrostat/flight/controllers/finite_time.hpp"
#include "gyrostat/flight/controllers/integral_sliding_mode.hpp"
#include "gyrostat/flight/controllers/mrp_feedback.hpp"
#include "gyrostat/flight/controllers/open_loop.hpp"
#include "gyrostat/flight/controllers/prescribed_performance.hpp"
#include "gyrostat/flight/controllers/saturated_pd.hpp"
#include "gyrostat/flight/detectors/none.hpp"
#include "gyrostat/flight/detectors/threshold.hpp"
#include "gyrostat/flight/observers/adaptive_iterative_learning.hpp"
#include "gyrostat/flight/observers/finite_time_disturbance.hpp"
#include "gyrostat/flight/observers/iterative_learning.hpp"
#include "gyrostat/flight/observers/passthrough.hpp"
#include "gyrostat/flight/stack.hpp"

namespace gyrostat::test {

/// A stack of components with their default parameters.
template <class O, class D, class C, class A>
auto stack_of(const Setup<typename O::Scalar>& s) {
  return by_default<FlightStack<O, D, C, A>>(s);
}

/// Calls `with` for every stack.
template <class S>
void for_every_stack(const Setup<S>& s, auto&& with) {
  using N = NoDetector<S>;
  using P = PseudoInverse<S>;
  with(stack_of<FiniteTimeDisturbanceObserver<S>, N, IntegralSlidingMode<S>, P>(s));
  with(stack_of<FiniteTimeDisturbanceObserver<S>, N, FiniteTime<S>, P>(s));
  with(stack_of<Passthrough<S>, N, SaturatedPd<S>, P>(s));
  with(stack_of<Passthrough<S>, N, MrpFeedback<S>, P>(s));
  with(stack_of<Passthrough<S>, N, OpenLoop<S>, P>(s));
  with(stack_of<AdaptiveIterativeLearningObserver<S>, ThresholdDetector<S>, PrescribedPerformance<S>, P>(s));
  with(stack_of<IterativeLearningObserver<S>, ThresholdDetector<S>, FastTerminalSlidingMode<S>, P>(s));
}

/// A measurement of a body that turns and nods; no plant, so that nothing but flight is exercised.
template <class S>
Measurement<S> wobble(Tick tick, int actuators) {
  const double t = 0.01 * static_cast<double>(tick);
  const Eigen::Vector4d q(std::cos(0.2 * t), 0.3 * std::sin(t), 0.1 + 0.2 * std::cos(0.7 * t), -0.1);
  Measurement<S> y;
  y.tick = tick;
  y.q_NB = Quat<S>(static_cast<S>(q[0]), static_cast<S>(q[1]), static_cast<S>(q[2]), static_cast<S>(q[3])).normalized();
  y.omega_BN_B = {static_cast<S>(0.05 * std::sin(t)), static_cast<S>(0.02), static_cast<S>(-0.03 * std::cos(2 * t))};
  y.h_w = VecN<S>::Zero(actuators);
  return y;
}

}  // namespace gyrostat::test
