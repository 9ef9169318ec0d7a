// SPDX-License-Identifier: MIT
/// @file  A scenario's table turned into the objects of a run, every number checked on the way.
#pragma once
#include <functional>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "gyrostat/flight/moving_axes.hpp"
#include "gyrostat/flight/stack.hpp"
#include "gyrostat/host/blocks.hpp"
#include "gyrostat/host/catalogue.hpp"
#include "gyrostat/host/channels.hpp"
#include "gyrostat/host/loop.hpp"
#include "gyrostat/host/reference.hpp"
#include "gyrostat/truth/euler_plant.hpp"
#include "gyrostat/truth/rigid_plant.hpp"

namespace gyrostat::host {

/// Takes momentum off where a scenario says so.
struct AnyManagement {
  std::optional<CrossProductDesaturation<double>> law;

  void operator()(const Vehicle<double>& vehicle, const Estimate<double>& x, const Detection<double>& det,
                  Demand<double>& demand) const noexcept {
    if (law) (*law)(vehicle, x, det, demand);
  }
};

using Stack =
    FlightStack<AnyObserver, AnyDetector, AnyController, AnyAllocator, AnyNavigator, MovingAxes<double>, AnyManagement>;
using Shadow = Estimator<AnyObserver, AnyDetector>;

/// Components that come from outside the catalogue, for roles whose entry has type = "python".
struct ExternalComponents {
  std::function<std::unique_ptr<NavigatorBase>(const Setup<double>&)> navigator;
  std::function<std::unique_ptr<ObserverBase>(const Setup<double>&)> observer;
  std::function<std::unique_ptr<DetectorBase>(const Setup<double>&)> detector;
  std::function<std::unique_ptr<ControllerBase>(const Setup<double>&)> controller;
  std::function<std::unique_ptr<AllocatorBase>(const Setup<double>&)> allocator;
  std::function<Outside(const Setup<double>&)> outside;  ///< what is no flight component
};

/// One line of `gyrostat check`.
struct CheckRow {
  std::string where, name;
  Status<double> status;
};

/// The models that fly. A run visits it once.
using AnyPlant = std::variant<truth::RigidPlant, truth::EulerPlant>;

/// A component as a scenario names it.
struct ComponentSpec {
  std::string where, type;
  Table params;
};

/// Everything of a scenario but the flight components themselves.
struct Assembly {
  RunBlock run;
  Tick ticks = 0;
  Setup<double> setup;
  Counts counts() const {
    const int n = setup.vehicle.actuators();
    return {n, static_cast<int>(plant.modes.size()), plant.gyros.empty() ? 0 : n,
            !plant.actuators.thrusters.each.empty(), plant.orbit.has_value()};
  }
  std::optional<CrossProductDesaturation<double>::Params> desaturation;
  Vehicles vehicles;
  truth::PlantModel plant;
  truth::InitialState initial;
  std::vector<truth::Sensor> sensors;
  ReferenceSpec reference;
  bool reference_outside = false;  ///< type = "python"
  ComponentSpec navigator, observer, detector, controller, allocator;
  std::vector<std::pair<ComponentSpec, ComponentSpec>> shadows;
  Table record;
};

/// Reads and cross-checks. Throws std::invalid_argument.
Assembly assemble(const Table& scenario);

/// Throws std::invalid_argument for what does not fit the model.
AnyPlant make_plant(const Assembly& a);
/// What takes part beside the catalogue. Throws std::invalid_argument for what does not fit the vehicle.
Outside make_outside(const Assembly& a, const ExternalComponents& external);
ReferencePath make_reference(const Assembly& a, const Outside& outside);

/// Estimates by role: those that the observer makes and those that the others use. Nothing is known of a component from
/// outside the catalogue: its role is left out.
std::vector<std::pair<std::string, Estimates>> estimate_flow(const Assembly& a);

/// What the components say of their settings, and of each other; unstable ones are refused by `make_stack` unless allowed.
std::vector<CheckRow> check_components(const Assembly& a, const ExternalComponents& external);

/// Throws std::invalid_argument for the first setting that its component, or another one, refuses.
Stack make_stack(const Assembly& a, const ExternalComponents& external);
std::vector<Shadow> make_shadows(const Assembly& a, const ExternalComponents& external);

}  // namespace gyrostat::host
