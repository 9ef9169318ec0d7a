// SPDX-License-Identifier: MIT
#include "gyrostat/host/catalogue.hpp"

#include "gyrostat/flight/allocators/lexicographic.hpp"
#include "gyrostat/flight/allocators/lexicographic_scaled.hpp"
#include "gyrostat/flight/allocators/pseudo_inverse.hpp"
#include "gyrostat/flight/allocators/robust_socp.hpp"
#include "gyrostat/flight/allocators/weighted_least_squares.hpp"

namespace gyrostat::host {

std::vector<Entry<AllocatorBase>> builtin_allocators() {
  return {
      allocator<Lexicographic>(), allocator<LexicographicScaled>(),  allocator<PseudoInverse>(),
      allocator<RobustSocp>(),    allocator<WeightedLeastSquares>(),
  };
}

}  // namespace gyrostat::host
