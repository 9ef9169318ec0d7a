// SPDX-License-Identifier: MIT
#include "gyrostat/truth/actuators.hpp"

#include <cmath>

namespace gyrostat::truth {
namespace {

std::string check_length(const char* what, const VecN<double>& v, int n) {
  if (v.size() == n) return {};
  return std::string("actuators: ") + what + " has " + std::to_string(v.size()) + " elements, need " +
         std::to_string(n);
}

std::string check_sign(const char* what, const VecN<double>& v) {
  return (v.array() >= 0).all() ? std::string{} : std::string("actuators: ") + what + " must not be negative";
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
    if (thrusters.has(i) && is_wheel(i)) return who + "a thruster is no wheel";
    if (thrusters.has(i) && !(u_lo[i] == 0 && u_up[i] > 0 && std::isfinite(u_up[i])))
      return who + "a thruster gives between nothing and a finite torque: u_min = 0 < u_max";
  }
  if (!thrusters.each.empty() &&
      (thrusters.first < 0 || thrusters.first + static_cast<int>(thrusters.each.size()) > n)) {
    return "thrusters: there are more than actuators";
  }
  return thrusters.check();
}

template class FaultyActuatorsOf<Fault>;

}  // namespace gyrostat::truth
