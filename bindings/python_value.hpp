// SPDX-License-Identifier: MIT
/// @file  Plain Python objects to and from host values.
#pragma once
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include "gyrostat/host/value.hpp"

namespace gyrostat::bindings {

namespace py = pybind11;

/// None, bool, int, float, str, sequences, numpy arrays and mappings; `where` names the key for the message.
host::Value to_value(py::handle object, const std::string& where = "scenario");
host::Table to_table(const py::dict& dict, const std::string& where = "scenario");
py::object to_python(const host::Value& value);
py::dict to_python(const host::Table& table);

}  // namespace gyrostat::bindings
