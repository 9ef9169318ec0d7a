// SPDX-License-Identifier: MIT
#include <pybind11/pybind11.h>

namespace gyrostat::bindings {
void bind_allocation(pybind11::module_& m);
void bind_core(pybind11::module_& m);
void bind_host(pybind11::module_& m);
void bind_words(pybind11::module_& m);
}  // namespace gyrostat::bindings

PYBIND11_MODULE(_core, m) {
  m.doc() = "C++ core of gyrostat.";
  m.attr("__version__") = GYROSTAT_VERSION;
  m.def("compiler", [] { return __VERSION__; }, "Version of the compiler that made this module.");
  gyrostat::bindings::bind_allocation(m);
  gyrostat::bindings::bind_core(m);
  gyrostat::bindings::bind_host(m);
  gyrostat::bindings::bind_words(m);
}
