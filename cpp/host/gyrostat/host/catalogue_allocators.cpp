// SPDX-License-Identifier: MIT
#include "gyrostat/host/catalogue.hpp"

#include "gyrostat/flight/allocators/pseudo_inverse.hpp"

namespace gyrostat::host {

std::vector<Entry<AllocatorBase>> builtin_allocators() {
  return {
      allocator<PseudoInverse>(),
  };
}

}  // namespace gyrostat::host
