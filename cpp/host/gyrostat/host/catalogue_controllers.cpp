// SPDX-License-Identifier: MIT
#include "gyrostat/host/catalogue.hpp"

#include "gyrostat/flight/controllers/finite_time.hpp"
#include "gyrostat/flight/controllers/integral_sliding_mode.hpp"
#include "gyrostat/flight/controllers/mrp_feedback.hpp"
#include "gyrostat/flight/controllers/open_loop.hpp"
#include "gyrostat/flight/controllers/saturated_pd.hpp"

namespace gyrostat::host {

std::vector<Entry<ControllerBase>> builtin_controllers() {
  return {
      controller<FiniteTime>(), controller<IntegralSlidingMode>(), controller<MrpFeedback>(),
      controller<OpenLoop>(),   controller<SaturatedPd>(),
  };
}

}  // namespace gyrostat::host
