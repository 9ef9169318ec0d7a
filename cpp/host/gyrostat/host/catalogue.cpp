// SPDX-License-Identifier: MIT
#include "gyrostat/host/catalogue.hpp"

#include <stdexcept>

#include "gyrostat/host/alternatives.hpp"
#include "gyrostat/host/blocks.hpp"
#include "gyrostat/host/reference.hpp"
#include "gyrostat/truth/disturbances.hpp"
#include "gyrostat/truth/faults/list.hpp"
#include "gyrostat/truth/integrator.hpp"
#include "gyrostat/truth/orbit.hpp"
#include "gyrostat/truth/sensors.hpp"

namespace gyrostat::host {

template <class Base>
void Family<Base>::add(Entry<Base> entry) {
  for (const Entry<Base>& e : entries_) {
    if (e.name == entry.name) throw std::invalid_argument(role_ + " '" + entry.name + "' is in the catalogue already");
  }
  entries_.push_back(std::move(entry));
}

template <class Base>
const Entry<Base>& Family<Base>::find(const std::string& name, const std::string& where) const {
  for (const Entry<Base>& e : entries_) {
    if (e.name == name) return e;
  }
  refuse_name(where, role_, name, names());
}

template <class Base>
std::vector<std::string> Family<Base>::names() const {
  std::vector<std::string> out;
  for (const Entry<Base>& e : entries_) out.push_back(e.name);
  return out;
}

template class Family<NavigatorBase>;
template class Family<ObserverBase>;
template class Family<DetectorBase>;
template class Family<ControllerBase>;
template class Family<AllocatorBase>;

Catalogue::Catalogue()
    : navigators("navigator", builtin_navigators()),
      observers("observer", builtin_observers()),
      detectors("detector", builtin_detectors()),
      controllers("controller", builtin_controllers()),
      allocators("allocator", builtin_allocators()) {}

Catalogue& catalogue() {
  static Catalogue the_catalogue;
  return the_catalogue;
}

namespace {

/// The vehicle that defaults are shown for: FTC-4RW, four wheels in a pyramid. `scale` enlarges inertia and torque
/// differently, so that a default which depends on the vehicle shows it.
Setup<double> reference_setup(double scale = 1) {
  Setup<double> setup;
  setup.dt = 0.01 / scale;
  setup.vehicle.J_B << 20, 0, 0.9, 0, 17, 0, 0.9, 0, 15;
  setup.vehicle.J_B *= scale * scale;
  setup.vehicle.D_B.resize(3, 4);
  setup.vehicle.D_B << 1, 1, -1, -1, 1, -1, -1, 1, 1, 1, 1, 1;
  setup.vehicle.D_B /= std::sqrt(3.0);
  setup.vehicle.u_up = VecN<double>::Constant(4, 0.2 * scale);
  setup.vehicle.u_lo = -setup.vehicle.u_up;
  setup.vehicle.u_rate = VecN<double>::Constant(4, detail::infinite);
  setup.vehicle.h_max = setup.vehicle.u_rate;
  setup.vehicle.wheels = Mask::all(4);
  return setup;
}

/// Description and unchecked reading of one family, whatever stands behind it.
struct FamilyAccess {
  std::string family;
  std::vector<std::string> names;
  std::function<Description(const std::string&)> describe;
  std::function<void(const std::string&, const Table&, const Place&)> check;
};

template <class Base>
FamilyAccess access(const Family<Base>& family) {
  return {family.role(), family.names(),
          [&family](const std::string& name) {
            const Entry<Base>& entry = family.find(name, family.role());
            Description d{family.role(), name, entry.traits, entry.describe(reference_setup())};
            const std::vector<ParamInfo> other = entry.describe(reference_setup(2));
            for (std::size_t i = 0; i < d.params.size(); ++i) {
              d.params[i].scales = d.params[i].default_value.text() != other[i].default_value.text();
            }
            return d;
          },
          [&family](const std::string& name, const Table& table, const Place& place) {
            const std::vector<ParamInfo> unused = family.find(name, place.where).describe(reference_setup());
            (void)family.find(name, place.where).make(reference_setup(), table, place);
          }};
}

template <class Variant>
FamilyAccess access(const std::string& family) {
  using A = Alternatives<Variant>;
  return {family, A::names(),
          [family](const std::string& name) { return Description{family, name, {}, A::describe(family, name)}; },
          [family](const std::string& name, const Table& table, const Place& place) {
            (void)A::read(family, name, table, place);
          }};
}

std::vector<FamilyAccess> all_families() {
  const Catalogue& c = catalogue();
  return {access(c.navigators),
          access(c.observers),
          access(c.detectors),
          access(c.controllers),
          access(c.allocators),
          access<truth::Fault>("fault"),
          access<truth::Disturbance>("disturbance"),
          access<truth::Sensor>("sensor"),
          access<truth::Waveform::Kind>("waveform"),
          access<ReferenceSpec>("reference"),
          access<truth::Integrator>("integrator"),
          access<std::variant<VehicleBlock>>("vehicle"),
          access<std::variant<truth::OrbitElements>>("orbit"),
          access<std::variant<DesaturationBlock>>("desaturation"),
          access<std::variant<FlexibleBlock>>("flexible"),
          access<std::variant<ThrustersBlock>>("thrusters"),
          access<std::variant<CmgBlock>>("cmg"),
          access<std::variant<TruthBlock>>("truth"),
          access<std::variant<InitialBlock>>("initial"),
          access<std::variant<RunBlock>>("run")};
}

FamilyAccess family_named(const std::string& family) {
  std::vector<std::string> names;
  for (FamilyAccess& f : all_families()) {
    if (f.family == family) return f;
    names.push_back(f.family);
  }
  refuse_name("catalogue", "family", family, names);
}

}  // namespace

std::vector<std::pair<std::string, std::vector<std::string>>> families() {
  std::vector<std::pair<std::string, std::vector<std::string>>> out;
  for (const FamilyAccess& f : all_families()) out.emplace_back(f.family, f.names);
  return out;
}

Description describe(const std::string& family, const std::string& name) { return family_named(family).describe(name); }

void check_params(const std::string& family, const std::string& name, const Table& params, const std::string& where) {
  family_named(family).check(name, params, Place{where});
}

}  // namespace gyrostat::host
