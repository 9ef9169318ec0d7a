// SPDX-License-Identifier: MIT
#include "gyrostat/host/slots.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "gyrostat/host/catalogue.hpp"

namespace gyrostat::host {
namespace {

[[noreturn]] void refuse_slot(const std::string& path, const std::string& why) {
  throw std::invalid_argument("'" + path + "': " + why);
}

[[noreturn]] void refuse_word(const std::string& path, const std::string& what, const std::string& word,
                              const std::vector<std::string>& known) {
  const std::string near = nearest(word, known);
  refuse_slot(path, "no " + what + " '" + word + "'" +
                        (near.empty() ? "; there are: " + join(known) : ", did you mean '" + near + "'?"));
}

std::vector<std::string> words_of(const std::string& path) {
  std::vector<std::string> words(1);
  for (const char c : path) {
    if (c == '.') {
      words.emplace_back();
    } else {
      words.back() += c;
    }
  }
  return words;
}

std::size_t index_of(const std::string& path, const std::string& word, std::size_t size) {
  const bool digits = !word.empty() && word.size() < 10 &&
                      std::all_of(word.begin(), word.end(), [](char c) { return c >= '0' && c <= '9'; });
  const std::size_t i = digits ? std::stoul(word) : size;
  if (i >= size) {
    refuse_slot(path, "'" + word + "' is no position in a list of " + std::to_string(size) + ", which counts from 0");
  }
  return i;
}

bool is_number(const Value& v) { return v.as<double>() != nullptr || v.as<std::int64_t>() != nullptr; }

/// One number a wheel and a diagonal become what elements can be named in.
Value spread(const ParamInfo& p, const Value& value, int actuators) {
  if (p.kind == "per_actuator" && (is_number(value) || value.is_none()))
    return List(static_cast<std::size_t>(actuators), value);
  if (p.kind == "vector3" && is_number(value)) return List(3, value);
  const List* list = value.as<List>();
  if (p.kind == "matrix3" && list != nullptr && list->size() == 3 && is_number(list->front())) {
    List rows;
    for (std::size_t r = 0; r < 3; ++r) {
      List row(3, Value(0.0));
      row[r] = (*list)[r];
      rows.emplace_back(std::move(row));
    }
    return rows;
  }
  if (value.is_none() && (p.kind == "vector3" || p.kind == "quaternion")) return List(p.kind == "vector3" ? 3 : 4);
  return value;
}

const ParamInfo& named(const std::vector<ParamInfo>& params, const std::string& path, const std::string& word) {
  std::vector<std::string> names;
  for (const ParamInfo& p : params) {
    if (p.name == word) return p;
    names.push_back(p.name);
  }
  refuse_word(path, "parameter", word, names);
}

const std::string& text_at(const Table& table, const char* key) {
  static const std::string empty;
  const Value* value = table.find(key);
  const std::string* text = value == nullptr ? nullptr : value->as<std::string>();
  return text == nullptr ? empty : *text;
}

Table& table_at(Table& table, const std::string& key) {
  const Value* value = table.find(key);
  if (value == nullptr || value->is_none()) table.set(key, Table());
  return *table.find(key)->as<Table>();
}

}  // namespace

/// Where the words of a path have led: a table with parameters, and the words that are left.
struct Slots::Target {
  Table* table;
  Path steps;
  std::vector<ParamInfo> params;  ///< with the values that hold now
  std::vector<std::string> words;
};

Slots::Target Slots::target_of(const Assembly& a, const std::string& path, std::vector<std::string> words) {
  static const std::vector<std::string> heads = {
      "vehicle",   "orbit",  "desaturation",   "flexible",     "cmg",       "thrusters", "truth",
      "initial",   "seed",   "noise_versions", "navigator",    "observer",  "detector",  "controller",
      "allocator", "faults", "shadows",        "disturbances", "reference", "sensors",   "integrator"};
  const auto next = [&] {
    if (words.empty()) refuse_slot(path, "more belongs here: the name of a parameter");
    const std::string word = words.front();
    words.erase(words.begin());
    return word;
  };
  const auto typed = [&](const std::string& family, Table& table, Path steps, const char* fallback) -> Target {
    if (table.empty()) table.set("type", fallback);
    std::vector<ParamInfo> params = describe(family, text_at(table, "type")).params;
    return {&table, std::move(steps), std::move(params), words};
  };
  const auto component = [&](const auto& family, Table& table, Path steps, const ComponentSpec& spec) -> Target {
    if (spec.type == "python") refuse_slot(path, "a Python object has no parameters that can be named here");
    if (table.empty()) table.set("type", spec.type);
    const Place place{spec.where, a.setup.vehicle.actuators()};
    return {&table, std::move(steps), family.find(spec.type, spec.where).settings(a.setup, spec.params, place), words};
  };
  const auto entry = [&](const std::string& list) -> std::pair<Table*, Path> {
    Value* value = table_.find(list);
    List* entries = value == nullptr ? nullptr : value->as<List>();
    const std::size_t i = index_of(path, next(), entries == nullptr ? 0 : entries->size());
    return {(*entries)[i].as<Table>(), {list, i}};
  };
  const Catalogue& c = catalogue();
  const std::string head = next();
  if (head == "seed") {
    if (table_.find("seed") == nullptr) table_.set("seed", 0);
    return {&table_, {}, describe("run", "run").params, {"seed"}};
  }
  if (head == "noise_versions") {
    words.insert(words.begin(), head);
    return {&table_, {}, describe("run", "run").params, words};
  }
  if (head == "vehicle" || head == "orbit" || head == "desaturation" || head == "flexible" || head == "cmg" ||
      head == "thrusters" || head == "truth" || head == "initial")
    return {&table_at(table_, head), {head}, describe(head, head).params, words};
  if (head == "navigator") return component(c.navigators, table_at(table_, head), {head}, a.navigator);
  if (head == "observer") return component(c.observers, table_at(table_, head), {head}, a.observer);
  if (head == "detector") return component(c.detectors, table_at(table_, head), {head}, a.detector);
  if (head == "controller") return component(c.controllers, table_at(table_, head), {head}, a.controller);
  if (head == "allocator") return component(c.allocators, table_at(table_, head), {head}, a.allocator);
  if (head == "reference") return typed(head, table_at(table_, head), {head}, "hold");
  if (head == "integrator") return typed(head, table_at(table_, head), {head}, "cvode");
  if (head == "faults" || head == "disturbances" || head == "sensors") {
    auto [table, steps] = entry(head);
    return typed(head.substr(0, head.size() - 1), *table, std::move(steps), "");
  }
  if (head == "shadows") {
    auto [pair, steps] = entry(head);
    const std::string role = next();
    if (role != "observer" && role != "detector") refuse_word(path, "role of a shadow", role, {"observer", "detector"});
    const auto& specs = a.shadows[std::get<std::size_t>(steps.back())];
    Table& table = table_at(*pair, role);
    steps.emplace_back(role);
    return role == "observer" ? component(c.observers, table, std::move(steps), specs.first)
                              : component(c.detectors, table, std::move(steps), specs.second);
  }
  for (const char* fixed : {"duration", "dt", "name", "description", "allow_unstable", "record"}) {
    if (head == fixed) refuse_slot(path, head + " is the same in all flights of an experiment");
  }
  refuse_word(path, "number of a scenario under", head, heads);
}

Slots::Slots(Table scenario, const Assembly& a, const std::vector<std::string>& paths) : table_(std::move(scenario)) {
  for (const std::string& path : paths) add(a, path);
  refuse_gaps();
}

void Slots::add(const Assembly& a, const std::string& path) {
  Target target = target_of(a, path, words_of(path));
  if (target.words.empty()) refuse_slot(path, "more belongs here: the name of a parameter");
  const int n = a.setup.vehicle.actuators();
  while (true) {
    const std::string word = target.words.front();
    target.words.erase(target.words.begin());
    const ParamInfo& p = named(target.params, path, word);
    if (p.kind == "choice" || p.kind == "switch" || p.kind == "text" || p.kind == "mask")
      refuse_slot(path, "is a " + p.kind + "; only numbers differ from flight to flight");
    target.steps.emplace_back(word);
    const Value* given = target.table->find(word);
    Value value = given != nullptr && !given->is_none() ? *given : p.default_value;
    if (!target.words.empty() || p.kind != "per_actuator") value = spread(p, value, n);
    if (target.words.empty() && p.kind == "integer" && !is_number(value)) value = 0;
    target.table->set(word, value);
    Value* now = target.table->find(word);
    // Elements of lists, and parameters of the waveform that stands there.
    while (!target.words.empty() && now->as<List>() != nullptr) {
      const std::size_t i = index_of(path, target.words.front(), now->as<List>()->size());
      target.words.erase(target.words.begin());
      target.steps.emplace_back(i);
      now = &(*now->as<List>())[i];
    }
    if (target.words.empty()) {
      const Value found = *now;
      take(path, target.steps, found, p.kind == "integer");
      return;
    }
    if (now->as<Table>() == nullptr) refuse_slot(path, "'" + word + "' has no part '" + target.words.front() + "'");
    target.table = now->as<Table>();
    target.params = describe("waveform", text_at(*target.table, "type")).params;
  }
}

/// One column a number: lists element by element, anything else whole.
void Slots::take(const std::string& path, const Path& steps, const Value& value, bool whole) {
  if (const List* list = value.as<List>(); list != nullptr) {
    if (list->empty()) refuse_slot(path, "is empty; nothing in it can differ");
    for (std::size_t i = 0; i < list->size(); ++i) {
      Path deeper = steps;
      deeper.emplace_back(i);
      take(path + "." + std::to_string(i), deeper, (*list)[i], whole);
    }
    return;
  }
  if (value.as<std::string>() != nullptr || value.as<bool>() != nullptr)
    refuse_slot(path, "is " + value.text() + "; only numbers differ from flight to flight");
  for (std::size_t k = 0; k < paths_.size(); ++k) {
    const Path& other = paths_[k];
    const std::size_t common = std::min(other.size(), steps.size());
    if (std::equal(other.begin(), other.begin() + static_cast<std::ptrdiff_t>(common), steps.begin()))
      refuse_slot(path, "stands twice, the first time as '" + columns_[k] + "'");
  }
  columns_.push_back(path);
  paths_.push_back(steps);
  whole_.push_back(whole);
}

/// Elements beside those that differ must have a value of their own.
void Slots::refuse_gaps() {
  for (std::size_t k = 0; k < paths_.size(); ++k) {
    Path whole = paths_[k];
    const auto* last = std::get_if<std::size_t>(&whole.back());
    if (last == nullptr) continue;
    whole.pop_back();
    const List& list = *at(table_, whole).as<List>();
    for (std::size_t i = 0; i < list.size(); ++i) {
      Path beside = whole;
      beside.emplace_back(i);
      if (!list[i].is_none() || std::find(paths_.begin(), paths_.end(), beside) != paths_.end()) continue;
      refuse_slot(columns_[k],
                  "element " + std::to_string(i) + " beside it has no value; give it one, or let it differ too");
    }
  }
}

Value& Slots::at(Table& table, const Path& steps) {
  Value* value = nullptr;
  for (const Step& step : steps) {
    if (const auto* key = std::get_if<std::string>(&step)) {
      value = (value == nullptr ? &table : value->as<Table>())->find(*key);
    } else {
      value = &(*value->as<List>())[std::get<std::size_t>(step)];
    }
  }
  return *value;
}

Slots::Copy::Copy(const Slots& slots) : table_(slots.table_), whole_(slots.whole_) {
  for (const Path& path : slots.paths_) numbers_.push_back(&at(table_, path));
}

const Table& Slots::Copy::with(std::span<const double> values) {
  for (std::size_t i = 0; i < numbers_.size(); ++i) {
    const double x = values[i];
    const bool whole = whole_[i] && x == std::floor(x) && std::abs(x) < 9e15;
    *numbers_[i] = whole ? Value(static_cast<std::int64_t>(x)) : Value(x);
  }
  return table_;
}

}  // namespace gyrostat::host
