// SPDX-License-Identifier: MIT
// Waveforms as parameters: a number, or a table with a type.
#include "gyrostat/host/alternatives.hpp"

namespace gyrostat::host {

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
