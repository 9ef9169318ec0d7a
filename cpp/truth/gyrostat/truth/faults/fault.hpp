// SPDX-License-Identifier: MIT
/// @file  What a fault of an actuator is: a window of time and a law, all of it in one struct.
///
/// Actuator i delivers  effectiveness_i u_i + bias_i  (torque on the body along its axis), nothing of u_i where |u_i| is below
/// its dead zone. Active faults of one actuator combine independently of their order:
///   - what multiplies the effectiveness and what adds to the bias does so, the one also where the other is zero;
///   - a fault that decides the output does so alone: of these only one may be active at a time.
/// Of a thruster u_i is full thrust while its valve is open and zero else.
/// A fault is active for t_on <= t < t_off.
#pragma once
#include <algorithm>
#include <concepts>
#include <string>
#include <variant>
#include <vector>

#include "gyrostat/truth/waveform.hpp"

namespace gyrostat::truth {

/// Whose fault it is, from when, until when.
struct Window {
  int actuator = -1;  ///< must be given
  double t_on = 0, t_off = infinity;

  static constexpr void describe(auto& w, auto&& field) {
    field(w.actuator, Field{"actuator", "", 0, max_actuators - 1, "which one, counted from 0"});
    field(w.t_on, Field{"t_on", "s", 0, infinity, "onset"});
    field(w.t_off, Field{"t_off", "s", 0, infinity, "end; infinity: permanent"});
  }
  /// Whether it can be: an infinite onset is that of a fault that never begins, whatever its end.
  bool ordered() const noexcept { return t_on < t_off || t_on == infinity; }
  /// Whether it is open on the piece that contains `branch`.
  bool holds(double branch) const noexcept { return t_on <= branch && branch < t_off; }
  /// Its first edge after t.
  double next_edge(double t) const noexcept { return t < t_on ? t_on : (t < t_off ? t_off : infinity); }
  /// "from 5 s to 20 s"
  std::string text() const;
};

/// Limits of one actuator, N m, and whether a valve opens and closes it: a thruster, which pushes one way.
struct Limits {
  double lo = -infinity, up = infinity;
  bool valve = false;
};

/// What a law may look at: time and branch, the actuator's limits, what it delivered when the fault began (N m), and whether
/// its valve is open.
struct At {
  double t, branch;
  Limits limits;
  double at_onset;
  bool open = true;
};

/// What the faults of one actuator amount to.
struct Effect {
  double effectiveness = 1, bias = 0, dead_zone = 0;  ///< 1; N m; N m
};

/// No part has a default, and nothing else chooses by the type of a fault: a kind that leaves one out does not compile.
template <class F>
concept FaultLaw =
    requires(const F& f, Effect& effect, const At& at, const Limits& limits, void (&see)(const Waveform&)) {
      { F::name } -> std::convertible_to<const char*>;
      { f.window } -> std::convertible_to<const Window&>;
      requires std::same_as<decltype(F::decides_output), const bool>;  // the output is this fault's alone
      requires std::same_as<decltype(F::degree), const int>;  // of its own polynomial of t, beside its waveforms
      f.waveforms(
          see);  // shows every waveform that `apply` reads: where the law switches and how quick it is follow from them
      { f.apply(effect, at) } noexcept;
      { f.check(limits) } -> std::same_as<std::string>;  // what is wrong with its numbers; empty when nothing is
    };

template <FaultLaw... F>
using FaultList = std::variant<F...>;

// ---- what follows for any of them ------------------------------------------------------------------------------------

/// First onset, end or jump of its law after t; infinity when there is none.
template <FaultLaw F>
double next_switch(const F& f, double t) noexcept {
  double next = f.window.next_edge(t);
  if (t < f.window.t_on || t >= f.window.t_off) return next;
  f.waveforms([&](const Waveform& w) { next = std::min(next, w.next_switch(t)); });
  return next;
}

/// Constant between its switches.
template <FaultLaw F>
bool piecewise_constant(const F& f) noexcept {
  bool constant = F::degree == 0;
  f.waveforms([&](const Waveform& w) { constant = constant && w.piecewise_constant(); });
  return constant;
}

/// Largest angular frequency between its switches (rad/s): frequencies add in a product.
template <FaultLaw F>
double fastest(const F& f) noexcept {
  double sum = 0;
  f.waveforms([&](const Waveform& w) { sum += w.fastest(); });
  return sum;
}

/// What is wrong with a fault on a vehicle with these limits; empty when nothing is.
template <FaultLaw F>
std::string check(const F& f, const std::vector<Limits>& limits) {
  const std::string who = "fault " + std::string(F::name) + ": ", actuator = std::to_string(f.window.actuator);
  if (f.window.actuator < 0) return who + "needs its actuator";
  if (f.window.actuator >= static_cast<int>(limits.size())) {
    return who + "actuator " + actuator + " does not exist, the vehicle has " + std::to_string(limits.size()) +
           " (counted from 0)";
  }
  if (!f.window.ordered()) return who + "t_on must be before t_off";
  std::string wrong;
  f.waveforms([&](const Waveform& w) { wrong = wrong.empty() ? w.check() : wrong; });
  if (wrong.empty()) wrong = f.check(limits[static_cast<std::size_t>(f.window.actuator)]);
  return wrong.empty() ? wrong : who + wrong;
}

template <class... F>
const Window& window_of(const std::variant<F...>& fault) noexcept {
  return std::visit([](const auto& f) -> const Window& { return f.window; }, fault);
}

/// The first two faults that decide one actuator's output at the same time, in words; empty when there are none.
template <class... F>
std::string contradiction(const std::vector<std::variant<F...>>& faults) {
  const auto decides = [](const auto& fault) {
    return std::visit([](const auto& f) { return f.decides_output; }, fault);
  };
  const auto in_words = [](const auto& fault) {
    return std::visit([](const auto& f) { return f.name + (" (" + f.window.text() + ")"); }, fault);
  };
  for (std::size_t i = 0; i < faults.size(); ++i) {
    for (std::size_t j = i + 1; j < faults.size(); ++j) {
      const Window &a = window_of(faults[i]), &b = window_of(faults[j]);
      if (a.actuator != b.actuator || !(a.t_on < b.t_off && b.t_on < a.t_off)) continue;
      if (!decides(faults[i]) || !decides(faults[j])) continue;
      return "faults of actuator " + std::to_string(a.actuator) + " contradict: " + in_words(faults[i]) + " and " +
             in_words(faults[j]);
    }
  }
  return {};
}

}  // namespace gyrostat::truth
