// SPDX-License-Identifier: MIT
/// @file  Parameters between a component's `describe` and the outside: tables of facts out, checked values in.
///
/// One description (core/params.hpp) serves messages, defaults, `gyrostat describe`, the schema and the docs.
#pragma once
#include <array>
#include <string>
#include <type_traits>
#include <vector>

#include "gyrostat/core/params.hpp"
#include "gyrostat/host/value.hpp"
#include "gyrostat/truth/waveform.hpp"

namespace gyrostat::host {

/// All that is known of one parameter.
struct ParamInfo {
  std::string name, kind, unit;  ///< kind: number, integer, vector3, matrix3, per_actuator, waveform, ...
  double lo = -unbounded, hi = unbounded;
  std::string meaning;
  std::vector<std::string> options;  ///< of a choice
  Value default_value;               ///< nothing: there is none
  bool required = false;             ///< must be given
  bool scales = false;               ///< the default depends on the vehicle
};

/// Where a table stands, for messages ("observer 'finite_time_disturbance'"), and the vehicle's actuator count if known.
struct Place {
  std::string where;
  int actuators = -1;

  [[noreturn]] void refuse(const std::string& what) const;
};

/// Raises std::invalid_argument: no such `family`, with the nearest name and the list.
[[noreturn]] void refuse_name(const std::string& where, const std::string& family, const std::string& name,
                              const std::vector<std::string>& names);

/// One key of a table: raises std::invalid_argument with where, key, value and what is allowed.
struct Key {
  const Place& place;
  const char* name;
  double lo = -unbounded, hi = unbounded;
  const char* mistaken = "";  ///< of the Field

  [[noreturn]] void refuse(const Value& value, const std::string& why) const;
  void in_range(const Value& value, double x) const;
};

// What each type of member reads, says of itself and is called. `read` throws through `key`.
void read(const Value& value, const Key& key, double& out);
void read(const Value& value, const Key& key, int& out);
void read(const Value& value, const Key& key, std::uint64_t& out);
void read(const Value& value, const Key& key, bool& out);
void read(const Value& value, const Key& key, std::string& out);
void read(const Value& value, const Key& key, Vec3<double>& out);
void read(const Value& value, const Key& key, Mat3<double>& out);
void read(const Value& value, const Key& key, VecN<double>& out);
void read(const Value& value, const Key& key, Mat3N<double>& out);
void read(const Value& value, const Key& key, Quat<double>& out);
void read(const Value& value, const Key& key, Mask& out);
void read(const Value& value, const Key& key, truth::Waveform& out);
void read(const Value& value, const Key& key, std::array<truth::Waveform, 3>& out);
void read(const Value& value, const Key& key, std::vector<truth::Waveform>& out);
void read(const Value& value, const Key& key, std::vector<double>& out);
void read(const Value& value, const Key& key, std::vector<std::vector<double>>& out);

Value write(double x);
Value write(int i);
Value write(std::uint64_t i);
Value write(bool b);
Value write(const std::string& s);
Value write(const Vec3<double>& v);
Value write(const Mat3<double>& m);
Value write(const VecN<double>& v);
Value write(const Mat3N<double>& m);
Value write(const Quat<double>& q);
Value write(const Mask& m);
Value write(const truth::Waveform& w);
Value write(const std::array<truth::Waveform, 3>& w);
Value write(const std::vector<truth::Waveform>& w);
Value write(const std::vector<double>& v);
Value write(const std::vector<std::vector<double>>& rows);

template <class M>
constexpr const char* kind_of() {
  if constexpr (std::is_same_v<M, double>)
    return "number";
  else if constexpr (std::is_same_v<M, int> || std::is_same_v<M, std::uint64_t>)
    return "integer";
  else if constexpr (std::is_same_v<M, std::string>)
    return "text";
  else if constexpr (std::is_same_v<M, Vec3<double>>)
    return "vector3";
  else if constexpr (std::is_same_v<M, Mat3<double>>)
    return "matrix3";
  else if constexpr (std::is_same_v<M, VecN<double>>)
    return "per_actuator";
  else if constexpr (std::is_same_v<M, Mat3N<double>>)
    return "columns3";
  else if constexpr (std::is_same_v<M, Quat<double>>)
    return "quaternion";
  else if constexpr (std::is_same_v<M, Mask>)
    return "mask";
  else if constexpr (std::is_same_v<M, truth::Waveform>)
    return "waveform";
  else if constexpr (std::is_same_v<M, std::array<truth::Waveform, 3>>)
    return "waveforms3";
  else if constexpr (std::is_same_v<M, std::vector<truth::Waveform>>)
    return "waveforms";
  else if constexpr (std::is_same_v<M, std::vector<double>>)
    return "numbers";
  else if constexpr (std::is_same_v<M, std::vector<std::vector<double>>>)
    return "rows";
  else
    static_assert(sizeof(M) == 0, "a parameter type that the host does not know");
}

/// A number or matrix without a default must be given; an absent vector means "not this one".
template <class M>
bool must_be_given(const M& member) {
  if constexpr (std::is_same_v<M, double> || std::is_same_v<M, int> || std::is_same_v<M, Mat3<double>>) {
    return write(member).is_none();
  } else if constexpr (std::is_same_v<M, Mat3N<double>>) {
    return member.hasNaN();  // without columns: "not this one"
  } else {
    return false;
  }
}

std::vector<std::string> split_options(const char* options);

namespace detail {

/// Collects ParamInfo.
struct Informer {
  std::vector<ParamInfo>& out;

  template <class M>
  void operator()(const M& member, const Field& f) const {
    out.push_back(
        {f.name, kind_of<M>(), f.unit, f.lo, f.hi, f.meaning, {}, write(member), must_be_given(member), false});
  }
  template <class E>
  void operator()(const E& member, const Choice& c) const {
    std::vector<std::string> options = split_options(c.options);
    Value chosen = options.at(static_cast<std::size_t>(member));
    out.push_back({c.name, "choice", "", 0, 0, c.meaning, std::move(options), std::move(chosen), false, false});
  }
  void operator()(const bool& member, const Switch& s) const {
    out.push_back({s.name, "switch", "", 0, 1, s.meaning, {}, Value(member), false, false});
  }
};

/// Fills members from a table.
struct Filler {
  const Table& table;
  const Place& place;
  std::vector<std::string>& known;

  template <class M>
  void operator()(M& member, const Field& f) const {
    known.push_back(f.name);
    if (const Value* v = given(f.name)) {
      read(*v, Key{place, f.name, f.lo, f.hi, f.mistaken}, member);
    } else if (must_be_given(member)) {
      place.refuse(std::string(f.name) + " is missing: " + f.meaning);
    }
  }
  template <class E>
  void operator()(E& member, const Choice& c) const {
    known.push_back(c.name);
    if (const Value* v = given(c.name)) member = static_cast<E>(option(*v, c));
  }
  void operator()(bool& member, const Switch& s) const {
    known.push_back(s.name);
    if (const Value* v = given(s.name)) read(*v, Key{place, s.name}, member);
  }

 private:
  /// The value of a key that was written; an explicit nothing counts as not written.
  const Value* given(const char* name) const {
    const Value* v = table.find(name);
    return v != nullptr && !v->is_none() ? v : nullptr;
  }
  std::size_t option(const Value& value, const Choice& c) const;
};

void refuse_unknown(const Table& table, const Place& place, const std::vector<std::string>& known);

}  // namespace detail

template <class Params>
std::vector<ParamInfo> describe_params(const Params& defaults) {
  std::vector<ParamInfo> out;
  Params::describe(defaults, detail::Informer{out});
  return out;
}

/// Defaults overwritten by what the table says; "type" is no parameter.
template <class Params>
Params read_params(Params params, const Table& table, const Place& place) {
  std::vector<std::string> known;
  Params::describe(params, detail::Filler{table, place, known});
  detail::refuse_unknown(table, place, known);
  return params;
}

}  // namespace gyrostat::host
