// SPDX-License-Identifier: MIT
#include "python_value.hpp"

#include <stdexcept>

namespace gyrostat::bindings {

using host::List;
using host::Table;
using host::Value;

namespace {

/// Counts how deep a value lies. Python knows how much room is left; a list that holds itself ends here.
class Descent {
 public:
  explicit Descent(const std::string& where) {
    if (Py_EnterRecursiveCall("") == 0) return;
    PyErr_Clear();
    throw std::invalid_argument((where.size() < 80 ? where : "a value") +
                                ": lists and tables lie too deep, or hold themselves");
  }
  ~Descent() { Py_LeaveRecursiveCall(); }
  Descent(const Descent&) = delete;
  Descent& operator=(const Descent&) = delete;
};

std::string text_of(py::handle object, const std::string& where) {
  Py_ssize_t size = 0;
  const char* text = PyUnicode_AsUTF8AndSize(object.ptr(), &size);
  if (text != nullptr) return {text, static_cast<std::size_t>(size)};
  PyErr_Clear();
  throw std::invalid_argument(where + ": holds half of a surrogate pair, which is no text");
}

Value number_of(py::handle object, const std::string& where) {
  int overflow = 0;
  const long long whole = PyLong_AsLongLongAndOverflow(object.ptr(), &overflow);
  if (overflow == 0) return Value(std::int64_t{whole});
  const double number = PyLong_AsDouble(object.ptr());
  if (PyErr_Occurred() == nullptr) return Value(number);
  PyErr_Clear();
  throw std::invalid_argument(where + ": an integer beyond the largest number, 1.8e308");
}

}  // namespace

Table to_table(const py::dict& dict, const std::string& where) {
  const Descent descent(where);
  std::vector<std::pair<std::string, Value>> entries;
  for (const auto& [key, value] : dict) {
    if (!py::isinstance<py::str>(key)) throw std::invalid_argument(where + ": a key is no text");
    std::string name = text_of(key, where);
    Value entry = to_value(value, where == "scenario" ? name : where + "." + name);
    entries.emplace_back(std::move(name), std::move(entry));
  }
  return Table(std::move(entries));
}

Value to_value(py::handle object, const std::string& where) {
  const Descent descent(where);
  if (object.is_none()) return {};
  if (py::isinstance<py::bool_>(object)) return py::cast<bool>(object);
  if (py::isinstance<py::int_>(object)) return number_of(object, where);
  if (py::isinstance<py::float_>(object)) return py::cast<double>(object);
  if (py::isinstance<py::str>(object)) return text_of(object, where);
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
