// SPDX-License-Identifier: MIT
#include "gyrostat/host/run_parts.hpp"

#include <algorithm>

namespace gyrostat::host {

FlightParts::FlightParts(const Assembly& a, const ExternalComponents& external)
    : stack(make_stack(a, external)), shadows(make_shadows(a, external)) {
  components = {{"observer", &stack.estimator.observer.reporting()},
                {"detector", &stack.estimator.detector.reporting()},
                {"controller", &stack.controller.reporting()},
                {"allocator", &stack.allocator.reporting()}};
  for (std::size_t i = 0; i < shadows.size(); ++i) {
    const std::string role = "shadow" + std::to_string(i);
    components.push_back({role + ".observer", &shadows[i].observer.reporting()});
    components.push_back({role + ".detector", &shadows[i].detector.reporting()});
    views.push_back({role, &shadows[i].estimate(), &shadows[i].detection()});
  }
}

Moments::Moments(const Assembly& a, const truth::Plant& plant, const Stack& stack, bool previous)
    : plant_(plant), moment_(a.vehicles, plant), previous_(previous) {
  u_held_ = VecN<double>::Zero(a.setup.vehicle.actuators());
  omega_before_ = plant.omega_BN_B();
  h_w_before_ = plant.h_w();
  if (plant.flies_euler()) angles_before_ = plant.euler().angles;
  moment_.x = &stack.estimate();
  moment_.det = &stack.detection();
  moment_.demand = &stack.demand();
  moment_.last = &stack.last();
  moment_.u_held = &u_held_;
  moment_.omega_before_B = &omega_before_;
  moment_.h_w_before = &h_w_before_;
  moment_.angles_before = &angles_before_;
}

void Moments::after() {
  if (!previous_) return;
  omega_before_ = plant_.omega_BN_B();
  h_w_before_ = plant_.h_w();
  if (plant_.flies_euler()) angles_before_ = plant_.euler().angles;
}

bool wants_euler(const Assembly& a, const std::vector<std::string>& channels) {
  if (a.setup.vehicle.coordinates == Coordinates::euler_angles) return true;
  return std::any_of(channels.begin(), channels.end(),
                     [](const std::string& name) { return name.starts_with("measurement."); });
}

}  // namespace gyrostat::host
