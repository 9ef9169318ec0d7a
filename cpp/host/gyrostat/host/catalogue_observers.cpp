// SPDX-License-Identifier: MIT
#include "gyrostat/flight/observers.hpp"

#include "gyrostat/host/catalogue.hpp"

namespace gyrostat::host {

std::vector<Entry<ObserverBase>> builtin_observers() {
  return detail::entries<ObserverBase, detail::ObserverModel>(Observers{});
}

}  // namespace gyrostat::host
