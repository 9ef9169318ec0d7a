/* SPDX-License-Identifier: MIT */
/* The linker turns hypot of the module into __wrap_hypot, which is the first version of glibc's: the same arithmetic, and a wheel
 * that also runs where glibc is older than 2.35. */
double first_hypot(double x, double y);
__asm__(".symver first_hypot, hypot@" GYROSTAT_FIRST_GLIBC);
__attribute__((visibility("hidden"))) double __wrap_hypot(double x, double y);
double __wrap_hypot(double x, double y) { return first_hypot(x, y); }
