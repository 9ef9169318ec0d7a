// SPDX-License-Identifier: MIT
/// @file  The objects of one run, and the moment of each sample as those who look on see it.
#pragma once
#include <string>
#include <vector>

#include "gyrostat/host/assembly.hpp"
#include "gyrostat/host/channels.hpp"

namespace gyrostat::host {

/// The stack that closes the loop, shadows beside it, what takes part from outside, and what all of them report.
struct FlightParts {
  Stack stack;
  std::vector<Shadow> shadows;
  Outside outside;
  std::vector<Reported> components;
  std::vector<ShadowView> views;

  FlightParts(const Assembly& a, const ExternalComponents& external);
  FlightParts(const FlightParts&) = delete;
  FlightParts& operator=(const FlightParts&) = delete;
};

/// Shadows see what the first pair saw.
class ShadowFlight {
 public:
  void before(const FlightParts& parts, const Allocation<double>& last) {
    if (!parts.shadows.empty()) last_ = last;
  }
  void after(FlightParts& parts) {
    if (!parts.stack.started()) return;
    for (Shadow& s : parts.shadows) {
      started_ ? s.step(parts.stack.measurement(), last_) : s.start(parts.stack.measurement());
    }
    started_ = true;
  }

 private:
  bool started_ = false;
  Allocation<double> last_;  ///< issued over the interval just ended
};

/// Keeps the moment of the present sample, and what a channel compares it with.
class Moments {
 public:
  template <truth::Plant Plant>
  Moments(const Assembly& a, const Plant& plant, const Stack& stack, bool previous)
      : moment_(a.vehicles, plant), previous_(previous) {
    moment_.u_held = VecN<double>::Zero(a.setup.vehicle.actuators());
    moment_.pair = {&stack.estimate(), &stack.detection(), a.setup.vehicle.actuators()};
    moment_.demand = &stack.demand();
    moment_.last = &stack.last();
  }

  void before(const Allocation<double>& last) {
    if (previous_ && !first_) moment_.u_held = last.u;
    first_ = false;
  }
  const Moment& now(double t, const Measurement<double>& y, const Reference<double>& ref) {
    moment_.advance(t);
    moment_.y = &y;
    moment_.ref = &ref;
    return moment_;
  }
  /// The sample is over.
  void after() {
    if (previous_) moment_.before = moment_.now;
  }

 private:
  Moment moment_;
  bool previous_, first_ = true;
};

/// Euler angles cost more than the rest of the measurement of a body: filled when somebody reads them.
bool wants_euler(const std::vector<std::string>& channels);

}  // namespace gyrostat::host
