// SPDX-License-Identifier: MIT
/// @file  The catalogue: every component by family and name. Those of the library come from the lists of flight
///        (flight/observers.hpp and its like); an application adds its own with `catalogue().add(controller<MyLaw>())`.
#pragma once
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "gyrostat/core/components.hpp"
#include "gyrostat/flight/parts/effectiveness_floor.hpp"
#include "gyrostat/host/any.hpp"
#include "gyrostat/host/parameters.hpp"

namespace gyrostat::host {

/// The class template behind a component, for code that is written from a scenario.
struct CppClass {
  std::string name;  ///< "gyrostat::SaturatedPd", without its scalar
};

/// What a component with its parameters has to do with the estimates that others make or use.
struct Coupling {
  Estimates uses;
  double effectiveness_floor = -1;  ///< see flight/parts/effectiveness_floor.hpp
};

/// A flight component of one role, by name.
template <class Base>
struct Entry {
  std::string name;
  Traits traits;
  /// Parameters with their defaults for a vehicle.
  std::function<std::vector<ParamInfo>(const Setup<double>&)> describe;
  /// Reads the parameters (throws std::invalid_argument), then asks the component.
  std::function<Status<double>(const Setup<double>&, const Table&, const Place&)> check;
  std::function<std::unique_ptr<Base>(const Setup<double>&, const Table&, const Place&)> make;
  std::function<Coupling(const Setup<double>&, const Table&, const Place&)> coupling;
  /// The parameters that `make` takes, as their defaults.
  std::function<std::vector<ParamInfo>(const Setup<double>&, const Table&, const Place&)> settings;
  CppClass cpp;
};

namespace detail {

/// From what the compiler calls this function: "... [with T = gyrostat::SaturatedPd<double>; ...]".
template <class T>
std::string class_name() {
  const std::string text = __PRETTY_FUNCTION__;
  const std::size_t from = text.find("T = ") + 4;
  return text.substr(from, text.find('<', from) - from);
}

template <template <class> class Component, class Base, template <class> class ModelOf>
Entry<Base> entry() {
  using T = Component<double>;
  static_assert(Checkable<T>, "see core/params.hpp: Params(setup), and a constructor that takes Unchecked first");
  using Params = typename T::Params;
  const auto params = [](const Setup<double>& setup, const Table& table, const Place& place) {
    return read_params(Params(setup), table, place);
  };
  return {T::name,
          traits_of<T>(),
          [](const Setup<double>& setup) { return describe_params(Params(setup)); },
          [params](const Setup<double>& setup, const Table& table, const Place& place) {
            return component_check<T>(setup, params(setup, table, place));
          },
          [params](const Setup<double>& setup, const Table& table, const Place& place) -> std::unique_ptr<Base> {
            return std::make_unique<ModelOf<T>>(T(unchecked, setup, params(setup, table, place)));
          },
          [params](const Setup<double>& setup, const Table& table, const Place& place) -> Coupling {
            const Params p = params(setup, table, place);
            return {uses_of<T>(p), effectiveness_floor_of<T>(p)};
          },
          [params](const Setup<double>& setup, const Table& table, const Place& place) {
            return describe_params<Params>(params(setup, table, place));
          },
          {class_name<T>()}};
}

template <class Base, template <class> class ModelOf, template <class> class... Component>
std::vector<Entry<Base>> entries(Components<Component...>) {
  return {entry<Component, Base, ModelOf>()...};
}

}  // namespace detail

template <template <class> class T>
Entry<NavigatorBase> navigator() {
  return detail::entry<T, NavigatorBase, detail::NavigatorModel>();
}
template <template <class> class T>
Entry<ObserverBase> observer() {
  return detail::entry<T, ObserverBase, detail::ObserverModel>();
}
template <template <class> class T>
Entry<DetectorBase> detector() {
  return detail::entry<T, DetectorBase, detail::DetectorModel>();
}
template <template <class> class T>
Entry<ControllerBase> controller() {
  return detail::entry<T, ControllerBase, detail::ControllerModel>();
}
template <template <class> class T>
Entry<AllocatorBase> allocator() {
  return detail::entry<T, AllocatorBase, detail::AllocatorModel>();
}

/// The components of one role.
template <class Base>
class Family {
 public:
  Family(std::string role, std::vector<Entry<Base>> entries) : role_(std::move(role)), entries_(std::move(entries)) {}

  /// Throws std::invalid_argument when the name is taken.
  void add(Entry<Base> entry);
  /// Throws std::invalid_argument naming the nearest component.
  const Entry<Base>& find(const std::string& name, const std::string& where) const;
  std::vector<std::string> names() const;
  const std::string& role() const noexcept { return role_; }

 private:
  std::string role_;
  std::vector<Entry<Base>> entries_;
};

class Catalogue {
 public:
  Catalogue();
  Family<NavigatorBase> navigators;
  Family<ObserverBase> observers;
  Family<DetectorBase> detectors;
  Family<ControllerBase> controllers;
  Family<AllocatorBase> allocators;

  void add(Entry<NavigatorBase> e) { navigators.add(std::move(e)); }
  void add(Entry<ObserverBase> e) { observers.add(std::move(e)); }
  void add(Entry<DetectorBase> e) { detectors.add(std::move(e)); }
  void add(Entry<ControllerBase> e) { controllers.add(std::move(e)); }
  void add(Entry<AllocatorBase> e) { allocators.add(std::move(e)); }
};

/// The catalogue of this process. Add before the first run; adding is not thread-safe.
Catalogue& catalogue();

// One role a file: each compiles all components of its role.
std::vector<Entry<NavigatorBase>> builtin_navigators();
std::vector<Entry<ObserverBase>> builtin_observers();
std::vector<Entry<DetectorBase>> builtin_detectors();
std::vector<Entry<ControllerBase>> builtin_controllers();
std::vector<Entry<AllocatorBase>> builtin_allocators();

/// What `gyrostat describe` prints of any member of any family.
struct Description {
  std::string family, name;
  Traits traits;
  std::vector<ParamInfo> params;
};

/// Every family with its names; flight roles first, then the parts of truth and the blocks of a scenario.
std::vector<std::pair<std::string, std::vector<std::string>>> families();
/// Throws std::invalid_argument with the nearest family or name.
Description describe(const std::string& family, const std::string& name);
/// Checks names, types and ranges of parameters without a vehicle.
void check_params(const std::string& family, const std::string& name, const Table& params, const std::string& where);

}  // namespace gyrostat::host
