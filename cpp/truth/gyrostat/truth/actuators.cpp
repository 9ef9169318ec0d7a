// SPDX-License-Identifier: MIT
#include "gyrostat/truth/actuators.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "gyrostat/core/power.hpp"

namespace gyrostat::truth {
namespace {

constexpr double never = -infinity;  // a branch time before every onset

std::string check_length(const char* what, const VecN<double>& v, int n) {
  if (v.size() == n) return {};
  return std::string("actuators: ") + what + " has " + std::to_string(v.size()) + " elements, need " +
         std::to_string(n);
}

std::string check_sign(const char* what, const VecN<double>& v) {
  return (v.array() >= 0).all() ? std::string{} : std::string("actuators: ") + what + " must not be negative";
}

/// Adds one active fault to an actuator's effect; true when it alone decides the output.
struct Combine {
  double t, branch;
  double u_lo, u_up, frozen;
  Effect& effect;

  bool operator()(const LossOfEffectiveness& f) const noexcept {
    effect.effectiveness *= f.remaining(t, branch);
    return false;
  }
  bool operator()(const Bias& f) const noexcept {
    effect.bias += f.torque(t, branch);
    return false;
  }
  bool operator()(const Drift& f) const noexcept {
    effect.bias += f.rate * (t - f.t_on);
    return false;
  }
  bool operator()(const Intermittent& f) const noexcept {
    if (f.gate().is_high(branch)) {
      effect.effectiveness *= f.remaining;
      effect.bias += f.torque;
    }
    return false;
  }
  bool operator()(const DeadZone&) const noexcept { return false; }  // depends on the command: see Law::dead_zone
  bool operator()(const StuckOutput& f) const noexcept { return only(f.torque); }
  bool operator()(const HardOver& f) const noexcept { return only(f.sign > 0 ? u_up : u_lo); }
  bool operator()(const Dead&) const noexcept { return only(0); }
  bool operator()(const Lock&) const noexcept { return only(frozen); }

  bool only(double torque) const noexcept {
    effect = {0, torque};
    return true;
  }
};

/// Largest angular frequency of a fault's law; zero when it is constant on a piece.
double frequency(const Fault& fault) noexcept {
  if (const auto* loss = std::get_if<LossOfEffectiveness>(&fault)) return loss->remaining.fastest();
  if (const auto* bias = std::get_if<Bias>(&fault)) return bias->torque.fastest();
  return 0;
}

bool varies(const Fault& fault) noexcept {
  if (const auto* loss = std::get_if<LossOfEffectiveness>(&fault)) return !loss->remaining.piecewise_constant();
  if (const auto* bias = std::get_if<Bias>(&fault)) return !bias->torque.piecewise_constant();
  return std::holds_alternative<Drift>(fault);
}

}  // namespace

Actuators Actuators::ideal(int n) {
  Actuators a;
  a.u_lo = VecN<double>::Constant(n, -infinity);
  a.u_up = VecN<double>::Constant(n, infinity);
  a.wheel_inertia = a.viscous_friction = a.coulomb_friction = VecN<double>::Zero(n);
  a.momentum_max = VecN<double>::Constant(n, infinity);
  return a;
}

std::string Actuators::check() const {
  const int n = size();
  for (const std::string& error :
       {check_length("u_up", u_up, n), check_length("wheel_inertia", wheel_inertia, n),
        check_length("viscous_friction", viscous_friction, n), check_length("coulomb_friction", coulomb_friction, n),
        check_length("momentum_max", momentum_max, n)}) {
    if (!error.empty()) return error;
  }
  for (const std::string& error :
       {check_sign("wheel_inertia", wheel_inertia), check_sign("viscous_friction", viscous_friction),
        check_sign("coulomb_friction", coulomb_friction), check_sign("momentum_max", momentum_max)}) {
    if (!error.empty()) return error;
  }
  for (int i = 0; i < n; ++i) {
    const std::string who = "actuator " + std::to_string(i) + ": ";
    if (!(u_lo[i] <= u_up[i])) return who + "u_min must not exceed u_max";
    if (!is_wheel(i) && (viscous_friction[i] > 0 || coulomb_friction[i] > 0))
      return who + "friction needs a wheel_inertia";
    if (!is_wheel(i) && std::isfinite(momentum_max[i])) return who + "momentum_max needs a wheel_inertia";
  }
  return {};
}

FaultyActuators::FaultyActuators(Actuators actuators, std::vector<Fault> faults)
    : actuators_(std::move(actuators)), faults_(std::move(faults)) {
  const int n = size();
  const auto refuse_if = [](const std::string& error) {
    if (!error.empty()) throw std::invalid_argument(error);
  };
  refuse_if(actuators_.check());
  for (const Fault& fault : faults_) {
    refuse_if(check(fault, n));
    if (const auto* over = std::get_if<HardOver>(&fault)) {
      const double limit = over->sign > 0 ? actuators_.u_up[over->actuator] : actuators_.u_lo[over->actuator];
      if (!std::isfinite(limit)) {
        refuse_if("fault hard_over: actuator " + std::to_string(over->actuator) + " has no finite limit to run to");
      }
    }
  }
  refuse_if(contradiction(faults_));
  u_ = frozen_ = constant_delivered_ = VecN<double>::Zero(n);
  branch_ = never;
}

double FaultyActuators::next_switch(double t) const noexcept {
  double next = infinity;
  for (const Fault& fault : faults_) next = std::min(next, truth::next_switch(fault, t));
  return next;
}

void FaultyActuators::enter(double t, double branch) noexcept {
  for (const Fault& fault : faults_) {  // still in the old piece: what will be locked is delivered here
    const int i = actuator_of(fault);
    if (std::holds_alternative<Lock>(fault) && active(fault, branch) && !active(fault, branch_)) {
      frozen_[i] = branch_ == never ? 0.0 : delivered(i, t);
    }
  }
  branch_ = branch;
  fastest_ = 0;
  all_constant_ = true;
  for (int i = 0; i < size(); ++i) {
    Law& law = law_[static_cast<std::size_t>(i)];
    law = {};
    double fastest_here = 0;
    for (const Fault& fault : faults_) {
      if (actuator_of(fault) != i || !active(fault, branch)) continue;
      law.constant = law.constant && !varies(fault);
      fastest_here += frequency(fault);  // frequencies add in a product
      if (const auto* zone = std::get_if<DeadZone>(&fault)) law.dead_zone = std::max(law.dead_zone, zone->width);
    }
    if (law.constant) law.effect = combine(i, t);
    fastest_ = std::max(fastest_, fastest_here);
    all_constant_ = all_constant_ && law.constant;
  }
  deliver_constants();
}

double FaultyActuators::limited_output(int i, double torque) const noexcept {
  if (actuators_.limit_on == LimitOn::command) return torque;
  return torque < actuators_.u_lo[i] ? actuators_.u_lo[i] : (torque > actuators_.u_up[i] ? actuators_.u_up[i] : torque);
}

void FaultyActuators::deliver_constants() noexcept {
  for (int i = 0; i < size(); ++i) {
    const Law& law = law_[static_cast<std::size_t>(i)];
    if (!law.constant) continue;
    const double effectiveness = std::abs(u_[i]) < law.dead_zone ? 0.0 : law.effect.effectiveness;
    constant_delivered_[i] = limited_output(i, effectiveness * u_[i] + law.effect.bias);
  }
}

void FaultyActuators::command(const VecN<double>& u) noexcept {
  u_ = u;
  if (actuators_.limit_on == LimitOn::command) u_ = clip(u, actuators_.u_lo, actuators_.u_up);
  deliver_constants();
}

Effect FaultyActuators::combine(int i, double t) const noexcept {
  Effect effect;
  for (const Fault& fault : faults_) {
    if (actuator_of(fault) != i || !active(fault, branch_)) continue;
    const Combine add{t, branch_, actuators_.u_lo[i], actuators_.u_up[i], frozen_[i], effect};
    if (std::visit(add, fault)) break;
  }
  return effect;
}

Effect FaultyActuators::effect(int i, double t) const noexcept {
  const Law& law = law_[static_cast<std::size_t>(i)];
  Effect effect = law.constant ? law.effect : combine(i, t);
  if (std::abs(u_[i]) < law.dead_zone) effect.effectiveness = 0;
  return effect;
}

double FaultyActuators::delivered(int i, double t) const noexcept {
  const Effect e = effect(i, t);
  return limited_output(i, e.effectiveness * u_[i] + e.bias);
}

int FaultyActuators::limit_side(int i, double t) const noexcept {
  const Effect e = effect(i, t);
  const double commanded = e.effectiveness * u_[i], torque = commanded + e.bias;
  const double rounding = 1e-12 * (std::abs(commanded) + std::abs(e.bias));
  return torque < actuators_.u_lo[i] - rounding ? -1 : (torque > actuators_.u_up[i] + rounding ? 1 : 0);
}

}  // namespace gyrostat::truth
