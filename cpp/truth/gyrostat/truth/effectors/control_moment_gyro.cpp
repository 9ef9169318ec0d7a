// SPDX-License-Identifier: MIT
#include "gyrostat/truth/effectors/control_moment_gyro.hpp"

#include <algorithm>

namespace gyrostat::truth {

double ControlMomentGyro::momentum(double t) const noexcept {
  double h = rotor_momentum;
  for (const RotorSlowDown& f : slow_downs) {
    if (t > f.window.t_on) h -= f.rate * (std::min(t, f.window.t_off) - f.window.t_on);
  }
  return std::max(h, 0.0);
}

double ControlMomentGyro::momentum_rate(double t) const noexcept {
  double rate = 0;
  for (const RotorSlowDown& f : slow_downs) {
    if (f.window.t_on < t && t <= f.window.t_off) rate -= f.rate;
  }
  return rate;
}

double ControlMomentGyro::rest_time(const std::vector<RotorSlowDown>& faults) const {
  std::vector<double> edges;
  for (const RotorSlowDown& f : faults) {
    edges.push_back(f.window.t_on);
    edges.push_back(f.window.t_off);
  }
  std::sort(edges.begin(), edges.end());
  double h = rotor_momentum;
  for (std::size_t k = 0; k + 1 < edges.size(); ++k) {
    const double from = edges[k], to = edges[k + 1];
    double rate = 0;
    for (const RotorSlowDown& f : faults) {
      if (f.window.t_on <= from && to <= f.window.t_off) rate += f.rate;
    }
    if (!(to > from) || !(rate > 0)) continue;
    if (from + h / rate <= to) return from + h / rate;
    h -= rate * (to - from);
  }
  return infinity;
}

}  // namespace gyrostat::truth
