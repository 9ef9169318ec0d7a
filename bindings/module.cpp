// SPDX-License-Identifier: MIT
/// @file  Python module gyrostat._core.
#include <pybind11/pybind11.h>

PYBIND11_MODULE(_core, m) {
  m.doc() = "Compiled part of gyrostat. Private: use the package.";
  m.attr("__version__") = GYROSTAT_VERSION;
}
