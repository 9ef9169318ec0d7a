// SPDX-License-Identifier: MIT
/// @file  Numbers from Python objects, with one line that says what belongs there where they do not fit.
#pragma once
#include <pybind11/numpy.h>

#include <Eigen/Core>

#include <stdexcept>
#include <string>

namespace gyrostat::bindings {

/// Whatever numpy makes an array of: only what becomes of it can be judged.
class ArrayLike : public pybind11::object {
  PYBIND11_OBJECT_DEFAULT(ArrayLike, object, [](PyObject*) { return 1; })
};

inline std::string class_name(const pybind11::object& object) {
  return pybind11::cast<std::string>(pybind11::type::handle_of(object).attr("__name__"));
}

using Numbers = pybind11::array_t<double, pybind11::array::c_style | pybind11::array::forcecast>;

/// @param who   "controller Law.step returned": how the line begins
/// @param what  "3 numbers": what belongs there
inline Numbers numbers(const pybind11::object& from, const std::string& who, const std::string& what) {
  if (from.is_none()) throw std::invalid_argument(who + " nothing (None); " + what + " belong there");
  try {
    return Numbers(from);
  } catch (const pybind11::error_already_set&) {
    throw std::invalid_argument(who + " a " + class_name(from) + "; " + what + " belong there");
  }
}

/// Into a vector of size `n`; the stack's guard judges their values.
template <class Vector>
void copy_numbers(const pybind11::object& from, Eigen::Index n, Vector& out, const std::string& who) {
  const Numbers array = numbers(from, who, std::to_string(n) + " numbers");
  if (array.size() != n)
    throw std::invalid_argument(who + " " + std::to_string(array.size()) + " numbers; " + std::to_string(n) +
                                " belong there");
  if constexpr (Vector::SizeAtCompileTime == Eigen::Dynamic) out.resize(n);
  for (Eigen::Index i = 0; i < n; ++i) out[i] = array.data()[i];
}

}  // namespace gyrostat::bindings

namespace pybind11::detail {
template <>
struct handle_type_name<gyrostat::bindings::ArrayLike> {
  static constexpr auto name = const_name("numpy.typing.ArrayLike");
};
}  // namespace pybind11::detail
