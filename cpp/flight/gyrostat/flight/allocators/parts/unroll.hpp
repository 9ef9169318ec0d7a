// SPDX-License-Identifier: MIT
/// @file  Unrolls the loop that follows: loops over three or six rows are the allocators' inner arithmetic, and compilers leave
///        them rolled where code size counts. Not under a sanitizer, which checks every access and makes long code of it.
#pragma once

#if defined(__SANITIZE_ADDRESS__)
#define GYROSTAT_UNROLL
#elif defined(__clang__)
#define GYROSTAT_UNROLL _Pragma("clang loop unroll(full)")
#elif defined(__GNUC__)
#define GYROSTAT_UNROLL _Pragma("GCC unroll 6")
#else
#define GYROSTAT_UNROLL
#endif
