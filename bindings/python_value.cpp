// SPDX-License-Identifier: MIT
#include "python_value.hpp"

#include <stdexcept>

namespace gyrostat::bindings {

using host::List;
using host::Table;
using host::Value;

Table to_table(const py::dict& dict, const std::string& where) {
  Table out;
  for (const auto& [key, value] : dict) {
    if (!py::isinstance<py::str>(key)) throw std::invalid_argument(where + ": a key is no text");
    const std::string name = py::cast<std::string>(key);
    out.set(name, to_value(value, where == "scenario" ? name : where + "." + name));
  }
  return out;
}

Value to_value(py::handle object, const std::string& where) {
  if (object.is_none()) return {};
  if (py::isinstance<py::bool_>(object)) return py::cast<bool>(object);
  if (py::isinstance<py::int_>(object)) {
    int overflow = 0;
    const long long whole = PyLong_AsLongLongAndOverflow(object.ptr(), &overflow);
    return overflow != 0 ? Value(py::cast<double>(py::float_(py::reinterpret_borrow<py::object>(object))))
                         : Value(std::int64_t{whole});
  }
  if (py::isinstance<py::float_>(object)) return py::cast<double>(object);
  if (py::isinstance<py::str>(object)) return py::cast<std::string>(object);
  if (py::isinstance<py::dict>(object)) return to_table(py::reinterpret_borrow<py::dict>(object), where);
  if (py::hasattr(object, "tolist")) return to_value(object.attr("tolist")(), where);  // numpy scalars and arrays
  if (py::isinstance<py::sequence>(object)) {
    List list;
    for (const py::handle item : object) list.push_back(to_value(item, where));
    return list;
  }
  throw std::invalid_argument(where + ": a " + py::cast<std::string>(py::type::handle_of(object).attr("__name__")) +
                              " is no plain value (number, text, list or table)");
}

py::object to_python(const Value& value) {
  struct Converter {
    py::object operator()(std::monostate) const { return py::none(); }
    py::object operator()(bool b) const { return py::bool_(b); }
    py::object operator()(std::int64_t i) const { return py::int_(i); }
    py::object operator()(double x) const { return py::float_(x); }
    py::object operator()(const std::string& s) const { return py::str(s); }
    py::object operator()(const List& list) const {
      py::list out;
      for (const Value& v : list) out.append(to_python(v));
      return out;
    }
    py::object operator()(const Table& table) const { return to_python(table); }
  };
  return std::visit(Converter{}, value.variant());
}

py::dict to_python(const Table& table) {
  py::dict out;
  for (const auto& [key, value] : table.entries()) out[py::str(key)] = to_python(value);
  return out;
}

}  // namespace gyrostat::bindings
