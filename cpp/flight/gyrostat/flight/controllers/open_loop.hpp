// SPDX-License-Identifier: MIT
/// @file  No feedback: a preferred command, and the torque that it makes on the nominal vehicle. Page: docs/components/open_loop.md
#pragma once
#include "gyrostat/core/params.hpp"

namespace gyrostat {

/// Demanding D command along with the preference leaves an allocator of D nothing to correct: u = command, clipped.
/// (`pseudo_inverse` with use_effectiveness = false; with it on, an estimated loss would be made up for.)
template <class S>
class OpenLoop {
 public:
  using Scalar = S;
  static constexpr const char* name = "open_loop";
  static constexpr bool axiswise = true;

  struct Params {
    VecN<S> command;

    static constexpr void describe(auto& p, auto&& field) {
      field(p.command, Field{"command", "N m", -1e9, 1e9, "constant command, one an actuator"});
    }
    explicit Params(const Setup<S>& setup) noexcept : command(VecN<S>::Zero(setup.vehicle.actuators())) {}
  };

  static Status<S> check(const Setup<S>& setup, const Params& p) noexcept {
    const int n = setup.vehicle.actuators();
    return Status<S>::require(p.command.size() == n, "entries of command", static_cast<S>(p.command.size()),
                              static_cast<S>(n), "=");
  }

  OpenLoop(Unchecked, const Setup<S>&, const Params& params) noexcept { demand_.u_pref = params.command; }

  [[nodiscard]] Demand<S> start(const Vehicle<S>& vehicle, const Estimate<S>& x, const Detection<S>&,
                                const Reference<S>&) noexcept {
    return demand(vehicle, x);
  }
  [[nodiscard]] Demand<S> step(const Vehicle<S>& vehicle, const Estimate<S>& x, const Detection<S>&,
                               const Reference<S>&, const Allocation<S>&) noexcept {
    return demand(vehicle, x);
  }

  void telemetry(auto&&) const {}

 private:
  const Demand<S>& demand(const Vehicle<S>& vehicle, const Estimate<S>& x) noexcept {
    demand_.tau_B = torque<S>(x.axes.of(vehicle.D_B), demand_.u_pref);
    return demand_;
  }

  Demand<S> demand_;
};

}  // namespace gyrostat
