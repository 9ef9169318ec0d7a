// SPDX-License-Identifier: MIT
/// @file  Stacks that between them hold every observer, detector and controller of the catalogue, with default parameters;
///        the optimal allocators have flight/allocators/test_optimal_allocators.cpp. tests/python/test_package.py compares
///        both with the catalogue.
#pragma once
#include "gyrostat/flight/controllers/mixed_learning_sliding_mode.hpp"
#include "gyrostat/flight/controllers/mixed_learning_terminal_sliding_mode.hpp"
#include "gyrostat/flight/controllers/preassigned_time_sliding_mode.hpp"
#include "gyrostat/flight/controllers/predefined_time.hpp"
#include "gyrostat/flight/controllers/sliding_mode.hpp"
#include "gyrostat/flight/controllers/terminal_sliding_mode.hpp"
#include "gyrostat/flight/observers/adaptive_sliding_mode.hpp"
#include "gyrostat/flight/observers/learning_disturbance.hpp"
#include "gyrostat/flight/observers/learning_effectiveness.hpp"
#include "gyrostat/flight/observers/learning_effectiveness_printed.hpp"
#include "gyrostat/flight/observers/mixed_learning.hpp"
#include "stacks.hpp"

namespace gyrostat::test {

/// Calls `with` for every stack: those of `for_every_stack`, and one for each further component.
template <class S>
void for_every_component(const Setup<S>& s, auto&& with) {
  for_every_stack<S>(s, with);
  using N = NoDetector<S>;
  using P = PseudoInverse<S>;
  with(stack_of<LearningEffectiveness<S>, N, PredefinedTime<S>, P>(s));
  with(stack_of<LearningEffectivenessPrinted<S>, N, TerminalSlidingMode<S>, P>(s));
  with(stack_of<AdaptiveSlidingMode<S>, N, SlidingMode<S>, P>(s));
  with(stack_of<MixedLearningObserver<S>, N, MixedLearningSlidingMode<S>, P>(s));
  with(stack_of<Passthrough<S>, N, MixedLearningTerminalSlidingMode<S>, P>(s));
  with(stack_of<LearningDisturbanceObserver<S>, N, PreassignedTimeSlidingMode<S>, P>(s));
}

}  // namespace gyrostat::test
