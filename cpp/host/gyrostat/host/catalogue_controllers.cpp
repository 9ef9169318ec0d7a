// SPDX-License-Identifier: MIT
#include "gyrostat/flight/controllers.hpp"

#include "gyrostat/host/catalogue.hpp"
#include "gyrostat/host/open_loop.hpp"

namespace gyrostat::host {

/// The host's own `open_loop` stands in for the embedded one of that name.
std::vector<Entry<ControllerBase>> builtin_controllers() {
  std::vector<Entry<ControllerBase>> entries = detail::entries<ControllerBase, detail::ControllerModel>(Controllers{});
  for (Entry<ControllerBase>& entry : entries)
    if (entry.name == OpenLoopWaveforms<double>::name) entry = controller<OpenLoopWaveforms>();
  return entries;
}

}  // namespace gyrostat::host
