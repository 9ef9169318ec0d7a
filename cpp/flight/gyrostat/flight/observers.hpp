// SPDX-License-Identifier: MIT
/// @file  Every observer of the library, in the order of the catalogue.
#pragma once
#include "gyrostat/core/components.hpp"
#include "gyrostat/flight/observers/adaptive_iterative_learning.hpp"
#include "gyrostat/flight/observers/adaptive_sliding_mode_effectiveness.hpp"
#include "gyrostat/flight/observers/finite_time_disturbance.hpp"
#include "gyrostat/flight/observers/iterative_learning.hpp"
#include "gyrostat/flight/observers/joint_kalman.hpp"
#include "gyrostat/flight/observers/learning_disturbance.hpp"
#include "gyrostat/flight/observers/learning_effectiveness.hpp"
#include "gyrostat/flight/observers/learning_effectiveness_printed.hpp"
#include "gyrostat/flight/observers/mixed_learning_disturbance.hpp"
#include "gyrostat/flight/observers/passthrough.hpp"

namespace gyrostat {

using Observers =
    Components<AdaptiveIterativeLearningObserver, AdaptiveSlidingModeEffectivenessObserver,
               FiniteTimeDisturbanceObserver, IterativeLearningObserver, JointKalmanObserver,
               LearningDisturbanceObserver, LearningEffectivenessObserver, LearningEffectivenessPrintedObserver,
               MixedLearningDisturbanceObserver, PassthroughObserver>;

}  // namespace gyrostat
