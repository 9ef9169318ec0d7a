// SPDX-License-Identifier: MIT
/// @file  Actuator faults: plain data, one actuator each, any number at once.
///
/// Actuator i delivers  effectiveness_i u_i + bias_i  (torque on the body along its axis). Active faults combine
/// independently of their order:
///   - loss_of_effectiveness, intermittent and dead_zone multiply the effectiveness;
///   - bias, drift and intermittent add to the bias, also on an actuator whose effectiveness is zero;
///   - dead, stuck, hard_over and lock decide the output alone: of these only one may be active at a time.
/// A fault is active for t_on <= t < t_off.
#pragma once
#include <string>
#include <variant>
#include <vector>

#include "gyrostat/truth/waveform.hpp"

namespace gyrostat::truth {

namespace detail {
/// What all faults have: whose, from when, until when.
constexpr void describe_window(auto& p, auto&& field) {
  field(p.actuator, Field{"actuator", "", 0, max_actuators - 1, "which one, counted from 0"});
  field(p.t_on, Field{"t_on", "s", 0, infinity, "onset"});
  field(p.t_off, Field{"t_off", "s", 0, infinity, "end; infinity: permanent"});
}
}  // namespace detail

/// The command is delivered in part: effectiveness = remaining(t). Several multiply.
struct LossOfEffectiveness {
  static constexpr const char* name = "loss_of_effectiveness";
  int actuator = -1;  ///< must be given
  double t_on = 0, t_off = infinity;
  Waveform remaining = 0.5;

  static constexpr void describe(auto& p, auto&& field) {
    detail::describe_window(p, field);
    field(p.remaining,
          Field{"remaining", "", -2, 2, "delivered / commanded; 1 is healthy, 0 delivers no command", "per cent"});
  }
};

/// A torque is added to what is delivered. Several add.
struct Bias {
  static constexpr const char* name = "bias";
  int actuator = -1;  ///< must be given
  double t_on = 0, t_off = infinity;
  Waveform torque = 0.0;

  static constexpr void describe(auto& p, auto&& field) {
    detail::describe_window(p, field);
    field(p.torque, Field{"torque", "N m", -infinity, infinity, "added to what is delivered"});
  }
};

/// Delivers a constant torque whatever is commanded.
struct StuckOutput {
  static constexpr const char* name = "stuck";
  int actuator = -1;  ///< must be given
  double t_on = 0, t_off = infinity;
  double torque = 0;

  static constexpr void describe(auto& p, auto&& field) {
    detail::describe_window(p, field);
    field(p.torque, Field{"torque", "N m", -infinity, infinity, "delivered whatever is commanded"});
  }
};

/// Delivers its limit whatever is commanded; the actuator needs a finite one.
struct HardOver {
  static constexpr const char* name = "hard_over";
  int actuator = -1;  ///< must be given
  double t_on = 0, t_off = infinity;
  double sign = 1;

  static constexpr void describe(auto& p, auto&& field) {
    detail::describe_window(p, field);
    field(p.sign, Field{"sign", "", -1, 1, "positive: at the upper limit; negative: at the lower one"});
  }
};

/// Floats: delivers nothing at all, biases included. A dead wheel keeps its momentum (but for friction).
struct Dead {
  static constexpr const char* name = "dead";
  int actuator = -1;  ///< must be given
  double t_on = 0, t_off = infinity;

  static constexpr void describe(auto& p, auto&& field) { detail::describe_window(p, field); }
};

/// Goes on delivering what it delivered at the onset, nothing if that is before the first command. It is the torque
/// that is locked: a wheel with a locked torque goes on changing its speed. A wheel that seizes is not this.
struct Lock {
  static constexpr const char* name = "lock";
  int actuator = -1;  ///< must be given
  double t_on = 0, t_off = infinity;

  static constexpr void describe(auto& p, auto&& field) { detail::describe_window(p, field); }
};

/// A bias that starts at zero and grows: rate (t - t_on).
struct Drift {
  static constexpr const char* name = "drift";
  int actuator = -1;  ///< must be given
  double t_on = 0, t_off = infinity;
  double rate = 0;

  static constexpr void describe(auto& p, auto&& field) {
    detail::describe_window(p, field);
    field(p.rate, Field{"rate", "N m/s", -infinity, infinity, "growth of the bias"});
  }
};

/// Comes and goes: from t_on, the first `duty` of each period is faulty, the rest healthy.
struct Intermittent {
  static constexpr const char* name = "intermittent";
  int actuator = -1;  ///< must be given
  double t_on = 0, t_off = infinity;
  double period = 1, duty = 0.5, remaining = 0, torque = 0;

  static constexpr void describe(auto& p, auto&& field) {
    detail::describe_window(p, field);
    field(p.period, Field{"period", "s", 1e-6, infinity, "of the faulty and healthy parts together"});
    field(p.duty, Field{"duty", "", 0, 1, "fraction of a period that is faulty"});
    field(p.remaining, Field{"remaining", "", -2, 2, "delivered / commanded while faulty", "per cent"});
    field(p.torque, Field{"torque", "N m", -infinity, infinity, "added to what is delivered while faulty"});
  }
  /// 1 while faulty.
  SquareWave gate() const noexcept { return {.low = 0, .high = 1, .period = period, .duty = duty, .phase = -t_on}; }
};

/// Commands smaller than a width give nothing; larger ones are delivered whole (a threshold, not an offset).
struct DeadZone {
  static constexpr const char* name = "dead_zone";
  int actuator = -1;  ///< must be given
  double t_on = 0, t_off = infinity;
  double width = 0;

  static constexpr void describe(auto& p, auto&& field) {
    detail::describe_window(p, field);
    field(p.width, Field{"width", "N m", 0, infinity, "smallest command that is delivered"});
  }
};

using Fault = std::variant<LossOfEffectiveness, Bias, StuckOutput, HardOver, Dead, Lock, Drift, Intermittent, DeadZone>;

const char* name_of(const Fault& fault) noexcept;
int actuator_of(const Fault& fault) noexcept;

/// First onset, end or jump of a fault's law after t; infinity when there is none.
double next_switch(const Fault& fault, double t) noexcept;
/// Whether the fault is active on the piece that contains `branch`.
bool active(const Fault& fault, double branch) noexcept;

/// What is wrong with the parameters of a fault on a vehicle of n actuators; empty when nothing is.
std::string check(const Fault& fault, int n);

/// The first two faults that decide one actuator's output at the same time, in words; empty when there are none.
std::string contradiction(const std::vector<Fault>& faults);

}  // namespace gyrostat::truth
