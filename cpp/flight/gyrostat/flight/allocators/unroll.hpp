// SPDX-License-Identifier: MIT
/// @file  Unrolls the loop that follows: loops over three or six rows are the allocators' inner arithmetic, and compilers leave
///        them rolled where code size counts.
#pragma once

#if defined(__clang__)
#define GYROSTAT_UNROLL _Pragma("clang loop unroll(full)")
#elif defined(__GNUC__)
#define GYROSTAT_UNROLL _Pragma("GCC unroll 6")
#else
#define GYROSTAT_UNROLL
#endif
