// SPDX-License-Identifier: MIT
#include "gyrostat/host/catalogue.hpp"

namespace gyrostat::host {

std::vector<Entry<ControllerBase>> builtin_controllers() { return {}; }

}  // namespace gyrostat::host
