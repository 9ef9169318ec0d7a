// SPDX-License-Identifier: MIT
#include "gyrostat/flight/detectors.hpp"

#include "gyrostat/host/catalogue.hpp"

namespace gyrostat::host {

std::vector<Entry<DetectorBase>> builtin_detectors() {
  return detail::entries<DetectorBase, detail::DetectorModel>(Detectors{});
}

}  // namespace gyrostat::host
