// SPDX-License-Identifier: MIT
#include "gyrostat/flight/allocators.hpp"

#include "gyrostat/host/catalogue.hpp"

namespace gyrostat::host {

std::vector<Entry<AllocatorBase>> builtin_allocators() {
  return detail::entries<AllocatorBase, detail::AllocatorModel>(Allocators{});
}

}  // namespace gyrostat::host
