// SPDX-License-Identifier: MIT
/// @file  Actuators as they really are: limits, wheels with friction, thrusters with valves, and the faults on top.
///
/// Over one control period the command is held, so what an actuator delivers is a function of time alone (for a thruster one
/// that jumps where its valve opens and closes), but for
/// bearing friction (which depends on wheel speed and belongs to the equations of motion, see effectors/).
/// Sign: command, delivered torque, effectiveness and bias act ON the body along the actuator's axis.
#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <stdexcept>
#include <vector>

#include "gyrostat/core/power.hpp"
#include "gyrostat/truth/faults/list.hpp"
#include "gyrostat/truth/thrusters.hpp"

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
  Thrusters thrusters;            ///< which of them are; u_lo = 0, u_up of full thrust

  /// n ideal torquers without limits.
  static Actuators ideal(int n);

  int size() const noexcept { return static_cast<int>(u_lo.size()); }
  bool is_wheel(int i) const noexcept { return wheel_inertia[i] > 0; }
  bool has_valve(int i) const noexcept { return thrusters.on_off() && thrusters.has(i); }
  Limits limits(int i) const noexcept { return {u_lo[i], u_up[i], has_valve(i)}; }
  /// What is wrong with the numbers; empty when nothing is.
  std::string check() const;
};

/// From t on an actuator gives `value` (N m, A m^2 of a magnetorquer), until the next one.
struct DriveStep {
  double t = 0, value = 0;
};

/// Actuators with their faults and the command they hold. A `List` is a FaultList.
template <class List>
class FaultyActuatorsOf {
 public:
  /// @throws std::invalid_argument for a fault that does not fit, or two that contradict.
  FaultyActuatorsOf(Actuators actuators, std::vector<List> faults);

  int size() const noexcept { return actuators_.size(); }
  const Actuators& actuators() const noexcept { return actuators_; }

  /// Next onset, end or jump of any fault, or edge of a valve, after t.
  double next_switch(double t) const noexcept;
  /// Begins the smooth piece that contains `branch` at time t, under the command held so far.
  void enter(double t, double branch) noexcept;
  /// Holds a new command. Where there are valves `at` and `until` say from when to when (no more than a period where
  /// it is for ever), and a new piece begins with it.
  void command(const VecN<double>& u, double at = 0, double until = infinity);
  /// Instead of its command actuator i gives this to its faults, until it is told anew: in order of time, from the beginning
  /// of the next command on. What says so knows the law of an actuator that these do not have.
  void drive(int i, std::span<const DriveStep> steps);
  /// What arrives at actuator i of a command of u.
  double arriving(int i, double u) const noexcept {
    return actuators_.limit_on == LimitOn::command ? std::clamp(u, actuators_.u_lo[i], actuators_.u_up[i]) : u;
  }
  /// Some actuators open and close by themselves: a command begins a new piece.
  bool steps_between() const noexcept { return !valves_.empty() || driven_.any(); }
  bool dry() const noexcept { return dry_; }
  /// The propellant is used up: thrusters give nothing from now on.
  void run_dry() noexcept {
    dry_ = true;
    deliver_constants();
  }

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
    Effect effect;  ///< of a constant law
  };
  Effect combine(int i, double t) const noexcept;
  void deliver_constants() noexcept;
  double limited_output(int i, double torque) const noexcept;
  double output(int i, const Effect& e) const noexcept {
    if (dry_ && actuators_.thrusters.has(i)) return 0;
    return limited_output(i, e.effectiveness * u_[i] + e.bias);
  }
  const Valve& valve(int i) const noexcept { return valves_[static_cast<std::size_t>(i - actuators_.thrusters.first)]; }
  Span delays(int i, double t) const noexcept;
  /// The same law where the command is: nothing of it below the dead zone.
  Effect at_command(int i, Effect e) const noexcept {
    if (std::abs(u_[i]) < e.dead_zone) e.effectiveness = 0;
    return e;
  }

  Actuators actuators_;
  std::vector<List> faults_;
  std::vector<double> at_onset_;  ///< N m, what the actuator of each fault delivered when it began
  std::vector<Valve> valves_;     ///< of the thrusters
  Mask driven_;                   ///< actuators that are told what to give,
  std::array<std::vector<DriveStep>, max_actuators> steps_;  ///< of these
  Mask closed_;                                              ///< valves that are, on the current piece
  bool dry_ = false;
  VecN<double> u_;  ///< held command, limited when limits act on it; what valves make of it
  VecN<double> constant_delivered_;
  bool all_constant_ = true;
  double fastest_ = 0, branch_ = -infinity;  ///< the branch is before every onset until the first piece begins
  std::array<Law, max_actuators> law_{};
};

using FaultyActuators = FaultyActuatorsOf<Fault>;

// ---- its definitions -------------------------------------------------------------------------------------------------

template <class List>
FaultyActuatorsOf<List>::FaultyActuatorsOf(Actuators actuators, std::vector<List> faults)
    : actuators_(std::move(actuators)), faults_(std::move(faults)), at_onset_(faults_.size(), 0.0) {
  const auto refuse_if = [](const std::string& error) {
    if (!error.empty()) throw std::invalid_argument(error);
  };
  refuse_if(actuators_.check());
  std::vector<Limits> limits;
  for (int i = 0; i < size(); ++i) limits.push_back(actuators_.limits(i));
  for (const List& fault : faults_) refuse_if(std::visit([&](const auto& f) { return check(f, limits); }, fault));
  refuse_if(contradiction(faults_));
  u_ = constant_delivered_ = VecN<double>::Zero(size());
  if (actuators_.thrusters.on_off()) valves_.resize(actuators_.thrusters.each.size());
}

template <class List>
double FaultyActuatorsOf<List>::next_switch(double t) const noexcept {
  double next = infinity;
  for (const List& fault : faults_) {
    next = std::min(next, std::visit([&](const auto& f) { return truth::next_switch(f, t); }, fault));
  }
  for (const Valve& valve : valves_) next = std::min(next, valve.next_edge(t));
  for (int i = 0; i < size() && driven_.any(); ++i) {
    for (const DriveStep& step : steps_[static_cast<std::size_t>(i)]) {
      if (step.t > t) next = std::min(next, step.t);
    }
  }
  return next;
}

template <class List>
void FaultyActuatorsOf<List>::drive(int i, std::span<const DriveStep> steps) {
  driven_.set(i);
  steps_[static_cast<std::size_t>(i)].assign(steps.begin(), steps.end());
}

template <class List>
void FaultyActuatorsOf<List>::enter(double t, double branch) noexcept {
  for (std::size_t k = 0; k < faults_.size(); ++k) {  // still in the old piece: what was delivered until now
    const Window& window = window_of(faults_[k]);
    if (!window.holds(branch) || window.holds(branch_)) continue;
    at_onset_[k] = branch_ == -infinity ? 0.0 : delivered(window.actuator, t);
  }
  branch_ = branch;
  for (int i = 0; i < size(); ++i) {
    if (!actuators_.has_valve(i)) continue;
    const bool open = valve(i).open(branch);
    closed_.set(i, !open);
    u_[i] = open ? actuators_.u_up[i] : 0;
  }
  for (int i = 0; i < size() && driven_.any(); ++i) {
    for (const DriveStep& step : steps_[static_cast<std::size_t>(i)]) {
      if (step.t <= branch) u_[i] = step.value;
    }
  }
  fastest_ = 0;
  all_constant_ = true;
  for (int i = 0; i < size(); ++i) {
    Law& law = law_[static_cast<std::size_t>(i)];
    law = {};
    double fastest_here = 0;
    for (const List& fault : faults_) {
      if (window_of(fault).actuator != i || !window_of(fault).holds(branch)) continue;
      law.constant = law.constant && std::visit([](const auto& f) { return piecewise_constant(f); }, fault);
      fastest_here += std::visit([](const auto& f) { return truth::fastest(f); }, fault);
    }
    if (law.constant) law.effect = combine(i, t);
    fastest_ = std::max(fastest_, fastest_here);
    all_constant_ = all_constant_ && law.constant;
  }
  deliver_constants();
}

template <class List>
double FaultyActuatorsOf<List>::limited_output(int i, double torque) const noexcept {
  if (actuators_.limit_on == LimitOn::command) return torque;
  return torque < actuators_.u_lo[i] ? actuators_.u_lo[i] : (torque > actuators_.u_up[i] ? actuators_.u_up[i] : torque);
}

template <class List>
void FaultyActuatorsOf<List>::deliver_constants() noexcept {
  for (int i = 0; i < size(); ++i) {
    const Law& law = law_[static_cast<std::size_t>(i)];
    if (law.constant) constant_delivered_[i] = output(i, at_command(i, law.effect));
  }
}

template <class List>
void FaultyActuatorsOf<List>::command(const VecN<double>& u, double at, double until) {
  VecN<double> held = u;
  if (actuators_.limit_on == LimitOn::command) held = clip(u, actuators_.u_lo, actuators_.u_up);
  if (until == infinity) until = at + actuators_.thrusters.period;
  for (std::size_t k = 0; k < valves_.size(); ++k) {
    const int i = actuators_.thrusters.first + static_cast<int>(k);
    const double level = std::clamp(u[i] / actuators_.u_up[i], 0.0, 1.0);
    valves_[k].command(actuators_.thrusters, level, at, until, [&](double t) { return delays(i, t); });
    held[i] = u_[i];  // until the new piece
  }
  for (int i = 0; i < size() && driven_.any(); ++i) {
    if (driven_.test(i)) held[i] = u_[i];
  }
  u_ = held;
  deliver_constants();
}

/// By which the valve of actuator i is late at t.
template <class List>
Span FaultyActuatorsOf<List>::delays(int i, double t) const noexcept {
  Span late{0, 0};
  for (const List& fault : faults_) {
    std::visit(
        [&](const auto& f) {
          if constexpr (requires { f.delay_open; }) {
            if (f.window.actuator == i && f.window.holds(t)) late = {late.from + f.delay_open, late.to + f.delay_close};
          }
        },
        fault);
  }
  return late;
}

/// Of all active faults of actuator i; after one that decides the output nothing else counts.
template <class List>
Effect FaultyActuatorsOf<List>::combine(int i, double t) const noexcept {
  Effect effect;
  for (std::size_t k = 0; k < faults_.size(); ++k) {
    const bool decided = std::visit(
        [&](const auto& f) {
          if (f.window.actuator != i || !f.window.holds(branch_)) return false;
          f.apply(effect, At{t, branch_, actuators_.limits(i), at_onset_[k], !closed_.test(i)});
          return f.decides_output;
        },
        faults_[k]);
    if (decided) break;
  }
  return effect;
}

template <class List>
Effect FaultyActuatorsOf<List>::effect(int i, double t) const noexcept {
  const Law& law = law_[static_cast<std::size_t>(i)];
  return at_command(i, law.constant ? law.effect : combine(i, t));
}

template <class List>
double FaultyActuatorsOf<List>::delivered(int i, double t) const noexcept {
  return output(i, effect(i, t));
}

template <class List>
int FaultyActuatorsOf<List>::limit_side(int i, double t) const noexcept {
  const Effect e = effect(i, t);
  const double commanded = e.effectiveness * u_[i], torque = commanded + e.bias;
  const double rounding = 1e-12 * (std::abs(commanded) + std::abs(e.bias));
  return torque < actuators_.u_lo[i] - rounding ? -1 : (torque > actuators_.u_up[i] + rounding ? 1 : 0);
}

extern template class FaultyActuatorsOf<Fault>;

}  // namespace gyrostat::truth
