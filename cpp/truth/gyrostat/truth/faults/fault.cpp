// SPDX-License-Identifier: MIT
#include "gyrostat/truth/faults/fault.hpp"

#include <cmath>
#include <sstream>

namespace gyrostat::truth {

std::string Window::text() const {
  std::ostringstream out;
  out << "from " << t_on << " s";
  if (std::isfinite(t_off)) out << " to " << t_off << " s";
  return out.str();
}

}  // namespace gyrostat::truth
