// SPDX-License-Identifier: MIT
#include "gyrostat/host/value.hpp"

#include <algorithm>
#include <cstdio>
#include <numeric>

namespace gyrostat::host {

Table::Table(std::initializer_list<std::pair<std::string, Value>> entries) : entries_(entries) {}
Table::Table(std::vector<std::pair<std::string, Value>> entries) : entries_(std::move(entries)) {}

const Value* Table::find(const std::string& key) const noexcept {
  for (const auto& [name, value] : entries_) {
    if (name == key) return &value;
  }
  return nullptr;
}

Value* Table::find(const std::string& key) noexcept { return const_cast<Value*>(std::as_const(*this).find(key)); }

void Table::set(std::string key, Value value) {
  for (auto& [name, old] : entries_) {
    if (name == key) {
      old = std::move(value);
      return;
    }
  }
  entries_.emplace_back(std::move(key), std::move(value));
}

std::string number_text(double x) {
  char text[32];
  std::snprintf(text, sizeof text, "%.6g", x);
  return text;
}

namespace {

/// The first `size` bytes of a UTF-8 text, less a character that they would cut.
std::string whole_characters(const std::string& text, std::size_t size) {
  while (size > 0 && (static_cast<unsigned char>(text[size]) & 0xC0U) == 0x80U) --size;
  return text.substr(0, size);
}

}  // namespace

std::string Value::text() const {
  struct Writer {
    std::string operator()(std::monostate) const { return "nothing"; }
    std::string operator()(bool b) const { return b ? "true" : "false"; }
    std::string operator()(std::int64_t i) const { return std::to_string(i); }
    std::string operator()(double x) const { return number_text(x); }
    std::string operator()(const std::string& s) const {
      return "'" + (s.size() <= 80 ? s : whole_characters(s, 77) + "...") + "'";
    }
    std::string operator()(const List& list) const {
      std::string out = "[";
      for (std::size_t i = 0; i < list.size(); ++i) {
        if (i > 0) out += ", ";
        if (out.size() > 60) return out + "...]";
        out += list[i].text();
      }
      return out + "]";
    }
    std::string operator()(const Table& table) const {
      const Value* type = table.find("type");
      return type != nullptr ? "{type = " + type->text() + ", ...}" : "{...}";
    }
  };
  return std::visit(Writer{}, data_);
}

const char* Value::kind() const noexcept {
  static constexpr const char* kinds[] = {"nothing", "true/false", "an integer", "a number",
                                          "a text",  "a list",     "a table"};
  return kinds[data_.index()];
}

std::string nearest(const std::string& word, const std::vector<std::string>& names) {
  const auto distance = [&](const std::string& other) {  // Levenshtein
    std::vector<std::size_t> row(other.size() + 1);
    std::iota(row.begin(), row.end(), std::size_t{0});
    for (std::size_t i = 0; i < word.size(); ++i) {
      std::size_t diagonal = row[0];
      row[0] = i + 1;
      for (std::size_t j = 0; j < other.size(); ++j) {
        const std::size_t change = diagonal + (word[i] == other[j] ? 0 : 1);
        diagonal = row[j + 1];
        row[j + 1] = std::min({change, row[j] + 1, row[j + 1] + 1});
      }
    }
    return row.back();
  };
  std::string best;
  std::size_t least = std::max<std::size_t>(2, word.size() / 3) + 1;
  for (const std::string& name : names) {
    const std::size_t longer = std::max(name.size(), word.size()), shorter = std::min(name.size(), word.size());
    if (longer - shorter >= least) continue;  // they differ by that much at least
    if (const std::size_t d = distance(name); d < least) {
      least = d;
      best = name;
    }
  }
  return best;
}

std::string join(const std::vector<std::string>& words) {
  std::string out;
  for (const std::string& w : words) out += (out.empty() ? "" : ", ") + w;
  return out;
}

}  // namespace gyrostat::host
