// SPDX-License-Identifier: MIT
#include "gyrostat/flight/navigators.hpp"
#include "gyrostat/host/catalogue.hpp"

namespace gyrostat::host {

std::vector<Entry<NavigatorBase>> builtin_navigators() {
  return detail::entries<NavigatorBase, detail::NavigatorModel>(Navigators{});
}

}  // namespace gyrostat::host
