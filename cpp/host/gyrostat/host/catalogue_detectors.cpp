// SPDX-License-Identifier: MIT
#include "gyrostat/host/catalogue.hpp"

#include "gyrostat/flight/detectors/none.hpp"
#include "gyrostat/flight/detectors/threshold.hpp"

namespace gyrostat::host {

std::vector<Entry<DetectorBase>> builtin_detectors() {
  return {
      detector<NoDetector>(),
      detector<ThresholdDetector>(),
  };
}

}  // namespace gyrostat::host
