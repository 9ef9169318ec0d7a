// SPDX-License-Identifier: MIT
#include "gyrostat/host/catalogue.hpp"

#include "gyrostat/flight/observers/finite_time_disturbance.hpp"
#include "gyrostat/flight/observers/passthrough.hpp"

namespace gyrostat::host {

std::vector<Entry<ObserverBase>> builtin_observers() {
  return {
      observer<FiniteTimeDisturbanceObserver>(),
      observer<Passthrough>(),
  };
}

}  // namespace gyrostat::host
