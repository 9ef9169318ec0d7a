// SPDX-License-Identifier: MIT
/// @file  Eigen as an embedded target has it, and what it would not have counted: before anything else that includes Eigen.
///        It allocates past operator new, so it is asked to assert that it does not.
#pragma once
#include <atomic>

#ifdef __cpp_exceptions
#error "this test is meant to be compiled with -fno-exceptions"
#endif
#ifdef __cpp_rtti
#error "this test is meant to be compiled with -fno-rtti"
#endif

namespace gyrostat::test {
extern std::atomic<long> allocations;     ///< by operator new
extern std::atomic<long> eigen_failures;  ///< of Eigen's assertions
}  // namespace gyrostat::test

#define EIGEN_RUNTIME_NO_MALLOC
#define eigen_assert(condition)                         \
  do {                                                  \
    if (!(condition)) ++gyrostat::test::eigen_failures; \
  } while (false)

#include <Eigen/Dense>
