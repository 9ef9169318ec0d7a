// SPDX-License-Identifier: MIT
/// @file  Every controller of the library, in the order of the catalogue.
#pragma once
#include "gyrostat/core/components.hpp"
#include "gyrostat/flight/controllers/fast_terminal_sliding_mode.hpp"
#include "gyrostat/flight/controllers/finite_time.hpp"
#include "gyrostat/flight/controllers/integral_sliding_mode.hpp"
#include "gyrostat/flight/controllers/mixed_learning_sliding_mode.hpp"
#include "gyrostat/flight/controllers/mixed_learning_terminal_sliding_mode.hpp"
#include "gyrostat/flight/controllers/mrp_feedback.hpp"
#include "gyrostat/flight/controllers/open_loop.hpp"
#include "gyrostat/flight/controllers/preassigned_time_sliding_mode.hpp"
#include "gyrostat/flight/controllers/predefined_time.hpp"
#include "gyrostat/flight/controllers/prescribed_performance.hpp"
#include "gyrostat/flight/controllers/saturated_pd.hpp"
#include "gyrostat/flight/controllers/sliding_mode.hpp"
#include "gyrostat/flight/controllers/terminal_sliding_mode.hpp"

namespace gyrostat {

using Controllers = Components<FastTerminalSlidingMode, FiniteTime, IntegralSlidingMode, MixedLearningSlidingMode,
                               MixedLearningTerminalSlidingMode, MrpFeedback, OpenLoop, PreassignedTimeSlidingMode,
                               PredefinedTime, PrescribedPerformance, SaturatedPd, SlidingMode, TerminalSlidingMode>;

}  // namespace gyrostat
