// SPDX-License-Identifier: MIT
/// @file  Actuators as they really are: limits, wheels with friction, and the faults on top.
///
/// Over one control period the command is held, so what an actuator delivers is a function of time alone, but for
/// bearing friction (which depends on wheel speed and belongs to the equations of motion, see body.hpp).
/// Sign: command, delivered torque, effectiveness and bias act ON the body along the actuator's axis.
#pragma once
#include <array>
#include <vector>

#include "gyrostat/truth/faults.hpp"

namespace gyrostat::truth {

/// Where the torque limit applies: to the command before the faults, or to the faulty output.
enum class LimitOn : std::uint8_t { command, output };

/// The numbers of n actuators. Vectors have one element an actuator.
struct Actuators {
  VecN<double> u_lo, u_up;  ///< N m, may be infinite
  LimitOn limit_on = LimitOn::command;
  VecN<double> wheel_inertia;     ///< kg m^2 about the spin axis; 0: an ideal torquer, which stores no momentum
  VecN<double> viscous_friction;  ///< N m s/rad, of the wheel speed relative to the body
  VecN<double> coulomb_friction;  ///< N m, magnitude of dry friction; at standstill it takes what is needed, up to that
  VecN<double> momentum_max;      ///< N m s, |h_w|; infinite when there is no limit

  /// n ideal torquers without limits.
  static Actuators ideal(int n);

  int size() const noexcept { return static_cast<int>(u_lo.size()); }
  bool is_wheel(int i) const noexcept { return wheel_inertia[i] > 0; }
  /// What is wrong with the numbers; empty when nothing is.
  std::string check() const;
};

/// One actuator's law on one smooth piece: delivered = effectiveness u + bias, before an output limit.
struct Effect {
  double effectiveness = 1, bias = 0;
};

/// Actuators with their faults and the command they hold.
class FaultyActuators {
 public:
  /// @throws std::invalid_argument for a fault that does not fit, or two that contradict.
  FaultyActuators(Actuators actuators, std::vector<Fault> faults);

  int size() const noexcept { return actuators_.size(); }
  const Actuators& actuators() const noexcept { return actuators_; }

  /// Next onset, end or jump of any fault after t.
  double next_switch(double t) const noexcept;
  /// Begins the smooth piece that contains `branch` at time t, under the command held so far.
  void enter(double t, double branch) noexcept;
  /// Holds a new command.
  void command(const VecN<double>& u) noexcept;

  /// Actuator i's delivered torque is constant until the next switch or command.
  bool constant(int i) const noexcept { return law_[static_cast<std::size_t>(i)].constant; }
  bool all_constant() const noexcept { return all_constant_; }
  /// A limit on the output of laws that vary: the delivered torque may have kinks.
  bool may_kink() const noexcept { return actuators_.limit_on == LimitOn::output && !all_constant_; }
  /// Largest angular frequency of the delivered torques (rad/s).
  double fastest() const noexcept { return fastest_; }

  Effect effect(int i, double t) const noexcept;
  /// N m, of actuator i at time t of the current piece. Friction and the momentum limit are not in it.
  double delivered(int i, double t) const noexcept;
  /// The same for a constant law, where it costs nothing.
  double constant_delivered(int i) const noexcept { return constant_delivered_[i]; }
  /// Which side of its output limit actuator i's unlimited output is on: -1 below, 0 inside, 1 above. Beyond begins at a
  /// relative 1e-12, lest an output that slides along its limit seem to cross it at every rounding.
  int limit_side(int i, double t) const noexcept;

 private:
  /// What the faults of one actuator amount to on the current piece.
  struct Law {
    bool constant = true;
    Effect effect;         ///< of a constant law, without dead zone
    double dead_zone = 0;  ///< N m
  };
  Effect combine(int i, double t) const noexcept;
  void deliver_constants() noexcept;
  double limited_output(int i, double torque) const noexcept;

  Actuators actuators_;
  std::vector<Fault> faults_;
  VecN<double> u_;       ///< held command, limited when limits act on it
  VecN<double> frozen_;  ///< what locked actuators deliver
  VecN<double> constant_delivered_;
  bool all_constant_ = true;
  double fastest_ = 0, branch_ = 0;
  std::array<Law, max_actuators> law_{};
};

}  // namespace gyrostat::truth
