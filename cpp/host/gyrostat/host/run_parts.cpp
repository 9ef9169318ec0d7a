// SPDX-License-Identifier: MIT
#include "gyrostat/host/run_parts.hpp"

#include <algorithm>

namespace gyrostat::host {

FlightParts::FlightParts(const Assembly& a, const ExternalComponents& external)
    : stack(make_stack(a, external)), shadows(make_shadows(a, external)), outside(make_outside(a, external)) {
  components = {{"navigator", &stack.navigation.navigator.reporting()},
                {"observer", &stack.estimator.observer.reporting()},
                {"detector", &stack.estimator.detector.reporting()},
                {"controller", &stack.controller.reporting()},
                {"allocator", &stack.allocator.reporting()}};
  for (std::size_t i = 0; i < shadows.size(); ++i) {
    const std::string role = "shadow" + std::to_string(i);
    components.push_back({role + ".observer", &shadows[i].observer.reporting()});
    components.push_back({role + ".detector", &shadows[i].detector.reporting()});
    views.push_back({role, {&shadows[i].estimate(), &shadows[i].detection(), a.setup.vehicle.actuators()}});
  }
  for (const auto& [role, component] : outside.reports) components.push_back({role, component.get()});
}

bool wants_euler(const std::vector<std::string>& channels) {
  return std::any_of(channels.begin(), channels.end(),
                     [](const std::string& name) { return name.starts_with("measurement."); });
}

}  // namespace gyrostat::host
