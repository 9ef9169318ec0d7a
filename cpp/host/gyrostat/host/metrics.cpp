// SPDX-License-Identifier: MIT
#include "gyrostat/host/metrics.hpp"

#include <stdexcept>
#include <string>

namespace gyrostat::host {

std::size_t Series::width() const {
  if (t.empty() || x.empty() || x.size() % t.size() != 0) {
    throw std::invalid_argument(std::to_string(t.size()) + " instants and " + std::to_string(x.size()) +
                                " values do not fit");
  }
  return x.size() / t.size();
}

void refuse_empty_window(double t0, double t1) {
  throw std::invalid_argument("no sample between " + std::to_string(t0) + " s and " + std::to_string(t1) + " s");
}

}  // namespace gyrostat::host
