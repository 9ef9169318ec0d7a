// SPDX-License-Identifier: MIT
#include "gyrostat/host/flight_model.hpp"

namespace gyrostat::host {
namespace {

/// Each member on a boundary of 16 of its own: no less than what the compiler lays out.
constexpr std::size_t padded(std::size_t bytes) { return (bytes + 15) / 16 * 16; }

/// Members of FlightStack and Estimator beside the components.
template <class S>
constexpr std::size_t frame_bytes() {
  return 2 * padded(sizeof(Vehicle<S>)) + padded(sizeof(Estimate<S>)) + padded(sizeof(Detection<S>)) +
         padded(sizeof(VecN<S>)) + padded(sizeof(Measurement<S>)) + padded(sizeof(Reference<S>)) +
         padded(sizeof(Demand<S>)) + padded(sizeof(Allocation<S>)) + padded(3 * sizeof(bool));
}

template <class Base>
FlightComponent component(const Family<Base>& family, const Assembly& a, const ComponentSpec& spec) {
  const Place place{spec.where, a.setup.vehicle.actuators()};
  if (spec.type == "python") place.refuse("is Python; only components of the catalogue have C++");
  const Entry<Base>& entry = family.find(spec.type, spec.where);
  return {family.role(), entry.name, entry.cpp, entry.settings(a.setup, spec.params, place)};
}

}  // namespace

FlightModel flight_model(const Assembly& a) {
  const Catalogue& c = catalogue();
  if (a.setup.vehicle.magnetorquers.any())
    throw std::invalid_argument(
        "vehicle: magnetorquers are not exported yet: the axes of a generated stack stand still");
  FlightModel m{a.setup, a.run.allow_unstable, {}, frame_bytes<double>(), frame_bytes<float>()};
  m.components = {component(c.navigators, a, a.navigator), component(c.observers, a, a.observer),
                  component(c.detectors, a, a.detector), component(c.controllers, a, a.controller),
                  component(c.allocators, a, a.allocator)};
  (void)make_stack(a, {});           // refuses what its components refuse
  if (a.navigator.type != "none") {  // what it was given, and what it made of it
    m.bytes_double += 2 * padded(sizeof(Measurement<double>));
    m.bytes_float += 2 * padded(sizeof(Measurement<float>));
  }
  for (const FlightComponent& part : m.components) {
    m.bytes_double += padded(part.cpp.bytes_double);
    m.bytes_float += padded(part.cpp.bytes_float);
  }
  return m;
}

}  // namespace gyrostat::host
