// SPDX-License-Identifier: MIT
#include "gyrostat/host/catalogue.hpp"

#include "gyrostat/flight/observers/adaptive_iterative_learning.hpp"
#include "gyrostat/flight/observers/adaptive_sliding_mode.hpp"
#include "gyrostat/flight/observers/finite_time_disturbance.hpp"
#include "gyrostat/flight/observers/iterative_learning.hpp"
#include "gyrostat/flight/observers/learning_disturbance.hpp"
#include "gyrostat/flight/observers/learning_effectiveness.hpp"
#include "gyrostat/flight/observers/learning_effectiveness_printed.hpp"
#include "gyrostat/flight/observers/mixed_learning.hpp"
#include "gyrostat/flight/observers/passthrough.hpp"

namespace gyrostat::host {

std::vector<Entry<ObserverBase>> builtin_observers() {
  return {
      observer<AdaptiveIterativeLearningObserver>(),
      observer<AdaptiveSlidingMode>(),
      observer<FiniteTimeDisturbanceObserver>(),
      observer<IterativeLearningObserver>(),
      observer<LearningDisturbanceObserver>(),
      observer<LearningEffectiveness>(),
      observer<LearningEffectivenessPrinted>(),
      observer<MixedLearningObserver>(),
      observer<Passthrough>(),
  };
}

}  // namespace gyrostat::host
