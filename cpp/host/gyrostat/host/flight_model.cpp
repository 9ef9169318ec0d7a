// SPDX-License-Identifier: MIT
#include "gyrostat/host/flight_model.hpp"

#include <algorithm>
#include <iterator>
#include <stdexcept>

#include "gyrostat/host/stack_sizes.hpp"

namespace gyrostat::host {
namespace {

/// Of the least capacity that holds `actuators`.
GyrostatPartSizes part_sizes(int actuators) {
  const GyrostatPartSizes all[] = {gyrostat_part_sizes_4(), gyrostat_part_sizes_8(), gyrostat_part_sizes_16()};
  return *std::find_if(std::begin(all), std::end(all), [&](const auto& s) { return s.capacity >= actuators; });
}

const GyrostatPartSize& part_size(const GyrostatPartSizes& sizes, const std::string& role, const std::string& name) {
  const auto is = [&](const GyrostatPartSize& p) {
    return (p.role == nullptr ? "" : p.role) == role && p.name == name;
  };
  const auto* found = std::find_if(sizes.parts, sizes.parts + sizes.count, is);
  if (found == sizes.parts + sizes.count)
    throw std::invalid_argument(role + " " + name + ": only components of the library can be exported");
  return *found;
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
  FlightModel m;
  m.setup = a.setup;
  m.allow_unstable = a.run.allow_unstable;
  m.gyros = a.plant.gyros;
  if (a.setup.vehicle.magnetorquers.any()) m.dipole_B.setZero(3, a.setup.vehicle.actuators());
  for (Eigen::Index i = 0; i < m.dipole_B.cols(); ++i) {
    if (a.setup.vehicle.magnetorquers.test(static_cast<int>(i))) m.dipole_B.col(i) = a.vehicles.D_B.col(i);
  }
  m.components = {component(c.navigators, a, a.navigator), component(c.observers, a, a.observer),
                  component(c.detectors, a, a.detector), component(c.controllers, a, a.controller),
                  component(c.allocators, a, a.allocator)};
  if (a.desaturation) {
    using Law = CrossProductDesaturation<double>;
    m.components.push_back(
        {"desaturation", Law::name, {detail::class_name<Law>()}, describe_params<Law::Params>(*a.desaturation)});
  }
  (void)make_stack(a, {});  // refuses what its components refuse
  const GyrostatPartSizes sizes = part_sizes(a.setup.vehicle.actuators());
  m.capacity = sizes.capacity;
  const auto add = [&](const std::string& role, const std::string& name) {
    const GyrostatPartSize& part = part_size(sizes, role, name);
    m.bytes_double += part.bytes_double;
    m.bytes_float += part.bytes_float;
  };
  add("", "frame");
  if (a.navigator.type != "none") add("", "navigation");
  if (!m.gyros.empty() || m.dipole_B.cols() > 0) add("", "moving_axes");
  for (const FlightComponent& part : m.components) add(part.role, part.name);
  return m;
}

}  // namespace gyrostat::host
