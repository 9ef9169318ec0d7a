// SPDX-License-Identifier: MIT
#include "gyrostat/host/catalogue.hpp"

namespace gyrostat::host {

std::vector<Entry<AllocatorBase>> builtin_allocators() { return {}; }

}  // namespace gyrostat::host
