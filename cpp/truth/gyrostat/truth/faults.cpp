// SPDX-License-Identifier: MIT
#include "gyrostat/truth/faults.hpp"

#include <algorithm>
#include <cmath>
#include <sstream>

namespace gyrostat::truth {
namespace {

template <class... T>
bool is_any(const Fault& fault) noexcept {
  return (std::holds_alternative<T>(fault) || ...);
}

/// The output is this fault's alone.
bool decides_output(const Fault& fault) noexcept { return is_any<StuckOutput, HardOver, Dead, Lock>(fault); }

double onset(const Fault& fault) noexcept {
  return std::visit([](const auto& f) { return f.t_on; }, fault);
}
double end(const Fault& fault) noexcept {
  return std::visit([](const auto& f) { return f.t_off; }, fault);
}

std::string in_words(const Fault& fault) {
  std::ostringstream text;
  text << name_of(fault) << " (from " << onset(fault) << " s";
  if (std::isfinite(end(fault))) text << " to " << end(fault) << " s";
  text << ")";
  return text.str();
}

std::string check_law(const LossOfEffectiveness& f) { return f.remaining.check(); }
std::string check_law(const Bias& f) { return f.torque.check(); }
std::string check_law(const Intermittent& f) { return f.gate().check(); }
std::string check_law(const HardOver& f) { return f.sign == 0 ? "sign must not be zero" : ""; }
std::string check_law(const auto&) { return {}; }

double next_in_law(const LossOfEffectiveness& f, double t) noexcept { return f.remaining.next_switch(t); }
double next_in_law(const Bias& f, double t) noexcept { return f.torque.next_switch(t); }
double next_in_law(const Intermittent& f, double t) noexcept { return f.gate().next_switch(t); }
double next_in_law(const auto&, double) noexcept { return infinity; }

}  // namespace

const char* name_of(const Fault& fault) noexcept {
  return std::visit([](const auto& f) { return f.name; }, fault);
}

int actuator_of(const Fault& fault) noexcept {
  return std::visit([](const auto& f) { return f.actuator; }, fault);
}

double next_switch(const Fault& fault, double t) noexcept {
  if (t < onset(fault)) return onset(fault);
  if (t >= end(fault)) return infinity;
  return std::min(end(fault), std::visit([&](const auto& f) { return next_in_law(f, t); }, fault));
}

bool active(const Fault& fault, double branch) noexcept { return onset(fault) <= branch && branch < end(fault); }

std::string check(const Fault& fault, int n) {
  const std::string who = "fault " + std::string(name_of(fault)) + ": ";
  if (actuator_of(fault) < 0) return who + "needs its actuator";
  if (actuator_of(fault) >= n) {
    return who + "actuator " + std::to_string(actuator_of(fault)) + " does not exist, the vehicle has " +
           std::to_string(n) + " (counted from 0)";
  }
  if (!(onset(fault) < end(fault))) return who + "t_on must be before t_off";
  const std::string law = std::visit([](const auto& f) { return check_law(f); }, fault);
  return law.empty() ? law : who + law;
}

std::string contradiction(const std::vector<Fault>& faults) {
  for (std::size_t i = 0; i < faults.size(); ++i) {
    for (std::size_t j = i + 1; j < faults.size(); ++j) {
      const Fault &a = faults[i], &b = faults[j];
      const bool overlap = onset(a) < end(b) && onset(b) < end(a);
      if (actuator_of(a) == actuator_of(b) && decides_output(a) && decides_output(b) && overlap) {
        return "faults of actuator " + std::to_string(actuator_of(a)) + " contradict: " + in_words(a) + " and " +
               in_words(b);
      }
    }
  }
  return {};
}

}  // namespace gyrostat::truth
