// SPDX-License-Identifier: MIT
#include "gyrostat/host/catalogue.hpp"

namespace gyrostat::host {

std::vector<Entry<DetectorBase>> builtin_detectors() { return {}; }

}  // namespace gyrostat::host
