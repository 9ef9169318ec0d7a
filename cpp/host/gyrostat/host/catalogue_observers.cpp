// SPDX-License-Identifier: MIT
#include "gyrostat/host/catalogue.hpp"

namespace gyrostat::host {

std::vector<Entry<ObserverBase>> builtin_observers() { return {}; }

}  // namespace gyrostat::host
