// SPDX-License-Identifier: MIT
/// @file  The objects of one run, and the moment of each sample as those who look on see it.
#pragma once
#include <string>
#include <vector>

#include "gyrostat/host/assembly.hpp"
#include "gyrostat/host/channels.hpp"

namespace gyrostat::host {

/// The flight half: the stack that closes the loop, shadows beside it, and what all of them report.
struct FlightParts {
  Stack stack;
  std::vector<Shadow> shadows;
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
  Moments(const Assembly& a, const truth::Plant& plant, const Stack& stack, bool previous);
  Moments(const Moments&) = delete;  // the moment points to what is kept here
  Moments& operator=(const Moments&) = delete;

  void before(const Allocation<double>& last) {
    if (previous_ && !first_) u_held_ = last.u;
    first_ = false;
  }
  const Moment& now(const Measurement<double>& y, const Reference<double>& ref) {
    moment_.advance(plant_.time());
    moment_.y = &y;
    moment_.ref = &ref;
    return moment_;
  }
  /// The sample is over.
  void after();

 private:
  const truth::Plant& plant_;
  Moment moment_;
  bool previous_, first_ = true;
  VecN<double> u_held_, h_w_before_;
  Vec3<double> omega_before_;
  Vec3<double> angles_before_ = Vec3<double>::Zero();
};

/// Euler angles cost more than the rest of the measurement: filled for Euler laws, or when somebody reads them.
bool wants_euler(const Assembly& a, const std::vector<std::string>& channels);

}  // namespace gyrostat::host
