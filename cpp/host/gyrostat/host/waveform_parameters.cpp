// SPDX-License-Identifier: MIT
// Waveforms as parameters: a number, or a table with a type.
#include <algorithm>
#include <cmath>

#include "gyrostat/host/alternatives.hpp"

namespace gyrostat::host {
namespace {

struct Range {
  double lo = 0, hi = 0;
};

/// What a waveform stays within; the range of a sum is the sum of the ranges.
Range range_of(const truth::Waveform& w) {
  struct Visitor {
    Range operator()(const truth::ConstantWave& c) const { return {c.value, c.value}; }
    Range operator()(const truth::SineWave& s) const {
      return {s.offset - std::abs(s.amplitude), s.offset + std::abs(s.amplitude)};
    }
    Range operator()(const truth::SquareWave& s) const { return {std::min(s.low, s.high), std::max(s.low, s.high)}; }
    Range operator()(const truth::StepsWave& s) const { return of(s.values); }
    Range operator()(const truth::TableWave& t) const { return of(t.values); }
    Range operator()(const truth::SumWave& sum) const {
      Range out;
      for (const truth::Waveform& term : sum.terms) {
        const Range r = range_of(term);
        out = {out.lo + r.lo, out.hi + r.hi};
      }
      return out;
    }
    static Range of(const std::vector<double>& values) {
      const auto [lo, hi] = std::minmax_element(values.begin(), values.end());
      return {*lo, *hi};
    }
  };
  return std::visit(Visitor{}, w.kind());
}

}  // namespace

void read(const Value& value, const Key& key, truth::Waveform& out) {
  const Table* table = value.as<Table>();
  if (table == nullptr) {
    if (value.as<double>() == nullptr && value.as<std::int64_t>() == nullptr) {
      key.refuse(value, std::string("is ") + value.kind() + "; a number or a waveform {type = ...} belongs here");
    }
    double x = 0;
    read(value, key, x);
    out = x;
    return;
  }
  const Value* type = table->find("type");
  const std::string* name = type == nullptr ? nullptr : type->as<std::string>();
  const Place place{key.place.where + ": " + key.name, key.place.actuators};
  using Kinds = Alternatives<truth::Waveform::Kind>;
  if (name == nullptr) place.refuse("a waveform needs its type, one of: " + join(Kinds::names()));
  out = Kinds::read("waveform", *name, *table, place);
  if (const std::string wrong = out.check(); !wrong.empty()) place.refuse(wrong);
  const Range range = range_of(out);
  key.in_range(value, range.lo);
  key.in_range(value, range.hi);
}

Value write(const truth::Waveform& w) {
  if (const auto* constant = std::get_if<truth::ConstantWave>(&w.kind())) return write(constant->value);
  return std::visit(
      [](const auto& kind) -> Value {
        Table table{{"type", kind.name}};
        for (const ParamInfo& p : describe_params(kind)) table.set(p.name, p.default_value);
        return table;
      },
      w.kind());
}

}  // namespace gyrostat::host
