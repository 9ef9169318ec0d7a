// SPDX-License-Identifier: MIT
/// @file  The catalogue's `open_loop`: commands that are waveforms, sampled once a period. Flight knows ticks and no waveforms;
///        the constant command of flight/controllers/open_loop.hpp is the embedded form. Page: docs/components/open_loop.md
#pragma once
#include <vector>

#include "gyrostat/core/params.hpp"
#include "gyrostat/truth/waveform.hpp"

namespace gyrostat::host {

/// As the flight component: the preference, and the torque that it makes on the nominal vehicle.
template <class S>
class OpenLoopWaveforms {
 public:
  using Scalar = S;
  static constexpr const char* name = "open_loop";
  static constexpr bool axiswise = true;

  struct Params {
    std::vector<truth::Waveform> command;

    static constexpr void describe(auto& p, auto&& field) {
      field(p.command, Field{"command", "N m", -1e9, 1e9, "command, a number or a waveform an actuator"});
    }
    explicit Params(const Setup<S>& setup)
        : command(static_cast<std::size_t>(setup.vehicle.actuators()), truth::Waveform(0.0)) {}
  };

  static Status<S> check(const Setup<S>& setup, const Params& p) {
    const int n = setup.vehicle.actuators();
    return Status<S>::require(p.command.size() == static_cast<std::size_t>(n), "entries of command",
                              static_cast<S>(p.command.size()), static_cast<S>(n), "=");
  }

  OpenLoopWaveforms(Unchecked, const Setup<S>& setup, const Params& params) : dt_(setup.dt), command_(params.command) {
    demand_.u_pref = VecN<S>::Zero(setup.vehicle.actuators());
  }

  [[nodiscard]] Demand<S> start(const Vehicle<S>& vehicle, const Estimate<S>& x, const Detection<S>&,
                                const Reference<S>&) noexcept {
    return sampled(vehicle, x.tick);
  }
  [[nodiscard]] Demand<S> step(const Vehicle<S>& vehicle, const Estimate<S>& x, const Detection<S>&,
                               const Reference<S>&, const Allocation<S>&) noexcept {
    return sampled(vehicle, x.tick);
  }

  void telemetry(auto&&) const {}

 private:
  /// The value just after the sample: a switch on a sample shows at once.
  Demand<S> sampled(const Vehicle<S>& vehicle, Tick tick) noexcept {
    const double t = static_cast<double>(tick) * dt_;
    for (std::size_t i = 0; i < command_.size(); ++i)
      demand_.u_pref[static_cast<Eigen::Index>(i)] = static_cast<S>(command_[i](t, t + 0.5 * dt_));
    demand_.tau_B = torque<S>(vehicle.D_B, demand_.u_pref);
    return demand_;
  }

  double dt_;
  std::vector<truth::Waveform> command_;
  Demand<S> demand_;
};

}  // namespace gyrostat::host
