// SPDX-License-Identifier: MIT
#include "gyrostat/host/catalogue.hpp"

#include "gyrostat/flight/controllers/fast_terminal_sliding_mode.hpp"
#include "gyrostat/flight/controllers/finite_time.hpp"
#include "gyrostat/flight/controllers/integral_sliding_mode.hpp"
#include "gyrostat/flight/controllers/mixed_learning_sliding_mode.hpp"
#include "gyrostat/flight/controllers/mixed_learning_terminal_sliding_mode.hpp"
#include "gyrostat/flight/controllers/mrp_feedback.hpp"
#include "gyrostat/flight/controllers/preassigned_time_sliding_mode.hpp"
#include "gyrostat/flight/controllers/predefined_time.hpp"
#include "gyrostat/flight/controllers/prescribed_performance.hpp"
#include "gyrostat/flight/controllers/saturated_pd.hpp"
#include "gyrostat/flight/controllers/sliding_mode.hpp"
#include "gyrostat/flight/controllers/terminal_sliding_mode.hpp"
#include "gyrostat/host/open_loop.hpp"

namespace gyrostat::host {

std::vector<Entry<ControllerBase>> builtin_controllers() {
  return {
      controller<FastTerminalSlidingMode>(),
      controller<FiniteTime>(),
      controller<IntegralSlidingMode>(),
      controller<MixedLearningSlidingMode>(),
      controller<MixedLearningTerminalSlidingMode>(),
      controller<MrpFeedback>(),
      controller<OpenLoopWaveforms>(),
      controller<PreassignedTimeSlidingMode>(),
      controller<PredefinedTime>(),
      controller<PrescribedPerformance>(),
      controller<SaturatedPd>(),
      controller<SlidingMode>(),
      controller<TerminalSlidingMode>(),
  };
}

}  // namespace gyrostat::host
