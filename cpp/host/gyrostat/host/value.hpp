// SPDX-License-Identifier: MIT
/// @file  A tree of plain values: what a TOML table or a Python dictionary says, before it means anything.
#pragma once
#include <cstdint>
#include <initializer_list>
#include <string>
#include <utility>
#include <variant>
#include <vector>

namespace gyrostat::host {

class Value;
using List = std::vector<Value>;

/// Keys in the order they were written.
class Table {
 public:
  Table() = default;
  Table(std::initializer_list<std::pair<std::string, Value>> entries);
  /// Entries whose keys differ.
  explicit Table(std::vector<std::pair<std::string, Value>> entries);

  const Value* find(const std::string& key) const noexcept;
  Value* find(const std::string& key) noexcept;
  void set(std::string key, Value value);
  const std::vector<std::pair<std::string, Value>>& entries() const noexcept { return entries_; }
  bool empty() const noexcept;

 private:
  std::vector<std::pair<std::string, Value>> entries_;
};

/// Nothing, a bool, an integer, a number, a text, a list or a table.
class Value {
 public:
  Value() = default;
  Value(bool b) : data_(b) {}
  Value(int i) : data_(std::int64_t{i}) {}
  Value(std::int64_t i) : data_(i) {}
  Value(double x) : data_(x) {}
  Value(const char* s) : data_(std::string(s)) {}
  Value(std::string s) : data_(std::move(s)) {}
  Value(List l) : data_(std::move(l)) {}
  Value(Table t) : data_(std::move(t)) {}

  template <class T>
  const T* as() const noexcept {
    return std::get_if<T>(&data_);
  }
  template <class T>
  T* as() noexcept {
    return std::get_if<T>(&data_);
  }
  bool is_none() const noexcept { return std::holds_alternative<std::monostate>(data_); }
  const auto& variant() const noexcept { return data_; }

  /// As a reader would write it, shortened when long; for messages.
  std::string text() const;
  /// "a number", "a table", ... for messages.
  const char* kind() const noexcept;

 private:
  std::variant<std::monostate, bool, std::int64_t, double, std::string, List, Table> data_;
};

inline bool Table::empty() const noexcept { return entries_.empty(); }  // here, where Value is complete

/// Shortest usual form of a number: 0.25, 1e-09, inf.
std::string number_text(double x);

/// The name of `names` that differs least from `word`, or "" when none is near.
std::string nearest(const std::string& word, const std::vector<std::string>& names);

/// "a, b, c".
std::string join(const std::vector<std::string>& words);

}  // namespace gyrostat::host
