// SPDX-License-Identifier: MIT
#include "contract/counted_eigen.hpp"

#include <cstdlib>
#include <new>

namespace gyrostat::test {
std::atomic<long> allocations{0};
std::atomic<long> eigen_failures{0};
}  // namespace gyrostat::test

void* operator new(std::size_t size) {
  ++gyrostat::test::allocations;
  if (void* p = std::malloc(size)) return p;
  std::abort();
}
void operator delete(void* p) noexcept { std::free(p); }
void operator delete(void* p, std::size_t) noexcept { std::free(p); }
