// SPDX-License-Identifier: MIT
#include "gyrostat/truth/rigid_plant_definitions.hpp"

#include <algorithm>
#include <stdexcept>

namespace gyrostat::truth {
namespace detail {

void refuse_quick_bearings(const std::vector<FrictionWheel>& wheels, double rate, double dt) {
  if (rate * dt <= InnerRates::most_in_a_sample) return;
  const auto quicker = [](const FrictionWheel& a, const FrictionWheel& b) {
    return a.viscous / a.inertia < b.viscous / b.inertia;
  };
  const FrictionWheel& quickest = *std::max_element(wheels.begin(), wheels.end(), quicker);
  throw std::invalid_argument("plant: viscous_friction = " + text(quickest.viscous) +
                              " N m s stops the wheel of actuator " + std::to_string(quickest.channel) + " (" +
                              text(quickest.inertia) + " kg m^2) in " + text(1 / rate) +
                              " s; nothing quicker than a thousandth of the period, " +
                              text(dt / InnerRates::most_in_a_sample) + " s, can be integrated");
}

std::vector<ControlMomentGyro> with_slow_downs(std::vector<ControlMomentGyro> gyros, std::vector<Fault>& faults) {
  std::vector<bool> taken(faults.size(), false);
  for (ControlMomentGyro& gyro : gyros) {
    std::vector<RotorSlowDown*> own;
    for (std::size_t k = 0; k < faults.size(); ++k) {
      auto* fault = std::get_if<RotorSlowDown>(&faults[k]);
      if (fault == nullptr || fault->window.actuator != gyro.channel) continue;
      own.push_back(fault);
      gyro.slow_downs.push_back(*fault);
      taken[k] = true;
    }
    const double rest = gyro.rest_time(gyro.slow_downs);
    gyro.slow_downs.clear();
    for (RotorSlowDown* fault : own) {
      if (!(fault->window.t_on < rest)) continue;
      fault->window.t_off = std::min(fault->window.t_off, rest);
      gyro.slow_downs.push_back(*fault);
    }
  }
  for (std::size_t k = 0; k < faults.size(); ++k) {
    const auto* fault = std::get_if<RotorSlowDown>(&faults[k]);
    if (fault == nullptr || taken[k]) continue;
    throw std::invalid_argument("fault rotor_slow_down: actuator " + std::to_string(fault->window.actuator) +
                                " is no control moment gyro");
  }
  return gyros;
}

}  // namespace detail

template class RigidPlantOf<Effectors>;
static_assert(Plant<RigidPlant>);

}  // namespace gyrostat::truth
