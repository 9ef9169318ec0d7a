// SPDX-License-Identifier: MIT
#include "gyrostat/host/parameters.hpp"

#include <cmath>
#include <stdexcept>
#include <string_view>

namespace gyrostat::host {

void Place::refuse(const std::string& what) const { throw std::invalid_argument(where + ": " + what); }

void refuse_name(const std::string& where, const std::string& family, const std::string& name,
                 const std::vector<std::string>& names) {
  const std::string near = nearest(name, names);
  std::string what = where + ": no " + family + " '" + name + "'";
  what += near.empty() ? "; there are: " + join(names) : ", did you mean '" + near + "'?";
  throw std::invalid_argument(what);
}

void Key::refuse(const Value& value, const std::string& why) const {
  place.refuse(std::string(name) + " = " + value.text() + " " + why);
}

void Key::in_range(const Value& value, double x) const {
  if (std::isnan(x)) refuse(value, "is not a number");
  if (x >= lo && x <= hi) return;
  if (std::isinf(x)) refuse(value, "must be finite");
  const std::string low = lo <= -unbounded ? "" : number_text(lo);
  const std::string high = hi >= unbounded ? "" : number_text(hi);
  if (high.empty()) refuse(value, "must be at least " + low);
  if (low.empty()) refuse(value, "must be at most " + high);
  const std::string like(mistaken);
  refuse(value, "is outside [" + low + ", " + high + "]" + (like.empty() ? "" : "; looks like " + like));
}

namespace {

/// A number as written; integers are numbers too.
bool number(const Value& value, double& out) {
  if (const double* x = value.as<double>()) {
    out = *x;
  } else if (const std::int64_t* i = value.as<std::int64_t>()) {
    out = static_cast<double>(*i);
  } else {
    return false;
  }
  return true;
}

/// Numbers of a list into `out(i)`; anything else in it is refused.
template <class Out>
void numbers(const Value& whole, const List& list, const Key& key, Out out) {
  for (std::size_t i = 0; i < list.size(); ++i) {
    double x = 0;
    if (!number(list[i], x)) key.refuse(whole, std::string("holds ") + list[i].kind() + " where a number belongs");
    key.in_range(whole, x);
    out(i, x);
  }
}

const List& list_of(const Value& value, const Key& key, std::size_t size, std::string_view allowed) {
  const List* list = value.as<List>();
  if (list == nullptr || (size != 0 && list->size() != size)) {
    std::string why = "must be " + std::string(allowed);
    if (list != nullptr) why += ", not " + std::to_string(list->size()) + " entries";
    key.refuse(value, why);
  }
  return *list;
}

Value list_value(const double* x, Eigen::Index n) {
  List list;
  for (Eigen::Index i = 0; i < n; ++i) list.emplace_back(x[i]);
  return list;
}

}  // namespace

void read(const Value& value, const Key& key, double& out) {
  if (!number(value, out)) key.refuse(value, std::string("is ") + value.kind() + "; a number belongs here");
  key.in_range(value, out);
}

void read(const Value& value, const Key& key, int& out) {
  double x = 0;
  if (!number(value, x) || x != std::floor(x) || std::abs(x) > 2147483647.0)
    key.refuse(value, "must be a whole number");
  key.in_range(value, x);
  out = static_cast<int>(x);
}

void read(const Value& value, const Key& key, std::uint64_t& out) {
  const std::int64_t* i = value.as<std::int64_t>();
  if (i == nullptr || *i < 0) key.refuse(value, "must be a whole number, 0 or more");
  key.in_range(value, static_cast<double>(*i));
  out = static_cast<std::uint64_t>(*i);
}

void read(const Value& value, const Key& key, bool& out) {
  const bool* b = value.as<bool>();
  if (b == nullptr) key.refuse(value, std::string("is ") + value.kind() + "; true or false belongs here");
  out = *b;
}

void read(const Value& value, const Key& key, std::string& out) {
  const std::string* s = value.as<std::string>();
  if (s == nullptr) key.refuse(value, std::string("is ") + value.kind() + "; a text belongs here");
  out = *s;
}

void read(const Value& value, const Key& key, Vec3<double>& out) {
  double same = 0;
  if (number(value, same)) {
    key.in_range(value, same);
    out.setConstant(same);
    return;
  }
  const List& list = list_of(value, key, 3, "a number or a list of 3 numbers");
  numbers(value, list, key, [&](std::size_t i, double x) { out[static_cast<Eigen::Index>(i)] = x; });
}

void read(const Value& value, const Key& key, Mat3<double>& out) {
  const char* const allowed = "a number, a list of 3 numbers (diagonal) or 3 rows of 3 numbers";
  double same = 0;
  if (number(value, same)) {
    key.in_range(value, same);
    out = Vec3<double>::Constant(same).asDiagonal();
    return;
  }
  const List& rows = list_of(value, key, 3, allowed);
  if (rows[0].as<List>() == nullptr) {
    out.setZero();
    numbers(value, rows, key,
            [&](std::size_t i, double x) { out(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(i)) = x; });
    return;
  }
  for (Eigen::Index r = 0; r < 3; ++r) {
    const List* row = rows[static_cast<std::size_t>(r)].as<List>();
    if (row == nullptr || row->size() != 3) key.refuse(value, std::string("must be ") + allowed);
    numbers(value, *row, key, [&](std::size_t i, double x) { out(r, static_cast<Eigen::Index>(i)) = x; });
  }
}

void read(const Value& value, const Key& key, VecN<double>& out) {
  double same = 0;
  if (number(value, same)) {
    key.in_range(value, same);
    out.setConstant(key.place.actuators >= 0 ? key.place.actuators : 1, same);
    return;
  }
  const int n = key.place.actuators;
  const List& list = list_of(value, key, n >= 0 ? static_cast<std::size_t>(n) : 0,
                             n >= 0 ? "a number or a list of " + std::to_string(n) + " numbers, one an actuator"
                                    : "a number or a list of numbers, one an actuator");
  if (list.empty() || list.size() > std::size_t{max_actuators}) key.refuse(value, "must hold 1 to 16 numbers");
  out.resize(static_cast<Eigen::Index>(list.size()));
  numbers(value, list, key, [&](std::size_t i, double x) { out[static_cast<Eigen::Index>(i)] = x; });
}

void read(const Value& value, const Key& key, Mat3N<double>& out) {
  const char* const allowed = "3 rows of as many numbers as there are actuators (1 to 16)";
  const List& rows = list_of(value, key, 3, allowed);
  const List* first = rows[0].as<List>();
  if (first == nullptr || first->empty() || first->size() > std::size_t{max_actuators})
    key.refuse(value, std::string("must be ") + allowed);
  out.resize(3, static_cast<Eigen::Index>(first->size()));
  for (Eigen::Index r = 0; r < 3; ++r) {
    const List* row = rows[static_cast<std::size_t>(r)].as<List>();
    if (row == nullptr || row->size() != first->size()) key.refuse(value, std::string("must be ") + allowed);
    numbers(value, *row, key, [&](std::size_t i, double x) { out(r, static_cast<Eigen::Index>(i)) = x; });
  }
}

void read(const Value& value, const Key& key, Quat<double>& out) {
  const List& list = list_of(value, key, 4, "a list of 4 numbers, scalar first");
  double q[4];
  numbers(value, list, key, [&](std::size_t i, double x) { q[i] = x; });
  out = Quat<double>(q[0], q[1], q[2], q[3]);
  const double norm = out.norm();
  if (norm == 0.0) key.refuse(value, "is zero and names no attitude");
  if (std::abs(norm - 1.0) > 1e-3)
    key.refuse(value, "has norm " + number_text(norm) + "; a unit quaternion belongs here (within 1e-3)");
  out.normalize();
}

void read(const Value& value, const Key& key, Mask& out) {
  const List& list = list_of(value, key, 0, "a list of actuator numbers");
  out = Mask{};
  const int n = key.place.actuators;
  numbers(value, list, key, [&](std::size_t, double x) {
    const int limit = n >= 0 ? n : max_actuators;
    if (x != std::floor(x) || x < 0 || x >= limit) {
      key.refuse(value, "names actuator " + number_text(x) + "; allowed are 0 to " + std::to_string(limit - 1));
    }
    out.set(static_cast<int>(x));
  });
}

void read(const Value& value, const Key& key, std::array<truth::Waveform, 3>& out) {
  const List& list = list_of(value, key, 3, "a list of 3, each a number or a waveform");
  for (std::size_t i = 0; i < 3; ++i) read(list[i], key, out[i]);
}

void read(const Value& value, const Key& key, std::vector<truth::Waveform>& out) {
  const List& list = list_of(value, key, 0, "a list, each entry a number or a waveform");
  out.assign(list.size(), truth::Waveform(0.0));
  for (std::size_t i = 0; i < list.size(); ++i) read(list[i], key, out[i]);
}

void read(const Value& value, const Key& key, std::vector<double>& out) {
  const List& list = list_of(value, key, 0, "a list of numbers");
  out.assign(list.size(), 0.0);
  numbers(value, list, key, [&](std::size_t i, double x) { out[i] = x; });
}

void read(const Value& value, const Key& key, std::vector<std::vector<double>>& out) {
  const List& rows = list_of(value, key, 0, "a list of rows of numbers");
  out.clear();
  for (const Value& row : rows) {
    const List* list = row.as<List>();
    if (list == nullptr) key.refuse(value, "must be a list of rows of numbers");
    std::vector<double>& target = out.emplace_back(list->size(), 0.0);
    numbers(value, *list, key, [&](std::size_t i, double x) { target[i] = x; });
  }
}

Value write(double x) { return std::isnan(x) ? Value() : Value(x); }
Value write(int i) { return i < 0 ? Value() : Value(i); }
Value write(std::uint64_t i) { return Value(static_cast<std::int64_t>(i)); }
Value write(bool b) { return b; }
Value write(const std::string& s) { return s; }
Value write(const Vec3<double>& v) { return v.hasNaN() ? Value() : list_value(v.data(), 3); }
Value write(const Mat3<double>& m) {
  if (m.hasNaN()) return {};
  List rows;
  for (Eigen::Index r = 0; r < 3; ++r) {
    const Vec3<double> row = m.row(r);
    rows.push_back(list_value(row.data(), 3));
  }
  return rows;
}
Value write(const VecN<double>& v) { return v.size() == 0 || v.hasNaN() ? Value() : list_value(v.data(), v.size()); }
Value write(const Mat3N<double>& m) {
  if (m.cols() == 0 || m.hasNaN()) return {};
  List rows;
  for (Eigen::Index r = 0; r < 3; ++r) {
    const VecN<double> row = m.row(r);
    rows.push_back(list_value(row.data(), row.size()));
  }
  return rows;
}
Value write(const Quat<double>& q) { return List{q.w(), q.x(), q.y(), q.z()}; }
Value write(const Mask& m) {
  List members;
  for (int i = 0; i < max_actuators; ++i) {
    if (m.test(i)) members.emplace_back(i);
  }
  return members;
}
Value write(const std::array<truth::Waveform, 3>& w) { return List{write(w[0]), write(w[1]), write(w[2])}; }
Value write(const std::vector<truth::Waveform>& w) {
  List list;
  for (const truth::Waveform& one : w) list.push_back(write(one));
  return list;
}
Value write(const std::vector<double>& v) { return list_value(v.data(), static_cast<Eigen::Index>(v.size())); }
Value write(const std::vector<std::vector<double>>& rows) {
  List list;
  for (const std::vector<double>& row : rows) list.push_back(write(row));
  return list;
}

std::vector<std::string> split_options(const char* options) {
  std::vector<std::string> out(1);
  for (const char* c = options; *c != '\0'; ++c) {
    if (*c == '|') {
      out.emplace_back();
    } else {
      out.back() += *c;
    }
  }
  return out;
}

namespace detail {

std::size_t Filler::option(const Value& value, const Choice& c) const {
  const std::vector<std::string> options = split_options(c.options);
  const std::string* word = value.as<std::string>();
  for (std::size_t i = 0; word != nullptr && i < options.size(); ++i) {
    if (options[i] == *word) return i;
  }
  Key{place, c.name}.refuse(value, "is not one of: " + join(options));
}

void refuse_unknown(const Table& table, const Place& place, const std::vector<std::string>& known) {
  for (const auto& [key, value] : table.entries()) {
    bool found = key == "type";
    for (const std::string& name : known) found = found || name == key;
    if (found) continue;
    const std::string near = nearest(key, known);
    std::string what = "no parameter '" + key + "'";
    if (!near.empty()) {
      what += ", did you mean '" + near + "'?";
    } else if (known.empty()) {
      what += "; there are none";
    } else {
      what += "; there are: " + join(known);
    }
    place.refuse(what);
  }
}

}  // namespace detail
}  // namespace gyrostat::host
