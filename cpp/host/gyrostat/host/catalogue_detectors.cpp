// SPDX-License-Identifier: MIT
#include "gyrostat/host/catalogue.hpp"

#include "gyrostat/flight/detectors/none.hpp"

namespace gyrostat::host {

std::vector<Entry<DetectorBase>> builtin_detectors() {
  return {
      detector<NoDetector>(),
  };
}

}  // namespace gyrostat::host
