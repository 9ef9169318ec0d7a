// SPDX-License-Identifier: MIT
/// @file  On/off thrusters: what their valves make in time of a command that is held, what that burns, how they push.
///
/// The drive of a valve is on for spans of time that follow from the held level r = u / u_up when it comes; the valve is open
/// on these spans, moved by its delays. An edge is an exact switch time, the thrust in between is constant, and so its impulse
/// is carried as that of any ideal torquer: no edge is a discontinuity of the equations of motion.
///
/// Page: docs/thrusters.md
#pragma once
#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include "gyrostat/core/types.hpp"

namespace gyrostat::truth {

/// Pulse-width, pulse-frequency modulator: a lag T f' = K (r - y) - f before a trigger with hysteresis, y = 1 from f = on up
/// until f = off. Between its switches f is known in closed form, and so is the next switch.
struct Pwpf {
  double gain = 4.5;            ///< K
  double time_constant = 0.15;  ///< s, T
  double on = 0.45, off = 0.15;

  /// s, of a cycle; neither the on nor the off time at any level is shorter than half of it.
  double shortest_cycle() const noexcept;
};

/// One thruster.
struct Thruster {
  Vec3<double> direction_B = Vec3<double>::UnitX();  ///< of the force on the body
  double lever = 1;                                  ///< m: torque along its axis over force
  double Isp = 220;                                  ///< s
};

/// Thrusters on the actuators from `first` on; none: nothing here is read.
struct Thrusters {
  enum class Align : std::uint8_t { start, centre };                ///< of a pulse in its period
  enum class Modulator : std::uint8_t { pwm, pwpf, proportional };  ///< proportional: no valve, thrust as commanded

  int first = 0;
  std::vector<Thruster> each;
  double period = 1;            ///< s, of the commands
  double tick = 1;              ///< s, a pulse is a whole number of these
  int min_on = 1, min_off = 1;  ///< ticks, shortest pulse and shortest pause
  Align align = Align::start;
  Modulator modulator = Modulator::pwm;
  Pwpf pwpf;
  double propellant_mass =
      std::numeric_limits<double>::infinity();  ///< kg, at the start; inertia does not change with it

  bool has(int actuator) const noexcept {
    return actuator >= first && actuator - first < static_cast<int>(each.size());
  }
  const Thruster& operator[](int actuator) const noexcept { return each[static_cast<std::size_t>(actuator - first)]; }
  bool on_off() const noexcept { return !each.empty() && modulator != Modulator::proportional; }
  /// In a period, rounded: `check` sees to it that it is whole.
  double ticks() const noexcept;
  /// Ticks that a valve is open at this level, a fraction of full thrust.
  double open_ticks(double level) const noexcept;
  /// What is wrong with the numbers; empty when nothing is.
  std::string check() const;

  static constexpr double g0 = 9.80665;  ///< m/s^2
};

/// From its opening to its closing, s.
struct Span {
  double from, to;
  bool empty() const noexcept { return !(from < to); }
};

/// One valve: what its drive has made of the commands so far, and when it is open.
class Valve {
 public:
  Valve() {
    drives_.reserve(4);
    open_.reserve(4);
  }

  /// A command comes at t0 and is held to t1. `delays(t)` says how much later than the drive it opens and closes at t.
  template <class Delays>
  void command(const Thrusters& how, double level, double t0, double t1, const Delays& delays) {
    forget(t0);
    drives_.clear();
    drive(how, level, t0, t1);
    for (const Span& on : drives_) {
      const bool goes_on = on.from <= driven_.to;  // the drive stays on over a sample
      driven_ = {goes_on ? driven_.from : on.from, on.to};
      const Span open{driven_.from + delays(driven_.from).from, driven_.to + delays(driven_.to).to};
      if (goes_on && listed_) open_.pop_back();
      listed_ = !open.empty();
      if (listed_) open_.push_back(open);
    }
  }
  bool open(double t) const noexcept;
  /// First time after t at which it opens or closes, or may.
  double next_edge(double t) const noexcept;

 private:
  void drive(const Thrusters& how, double level, double t0, double t1);
  void modulate(const Pwpf& how, double level, double t0, double t1);
  void forget(double t) noexcept;

  std::vector<Span> drives_;  ///< of this command
  Span driven_{-1, -1};       ///< the last one, with all that it continues
  bool listed_ = false;       ///< it opens the valve: open_ ends with it
  std::vector<Span> open_;    ///< those that are not over; they may overlap
  double filter_ = 0;         ///< f of the modulator
  bool on_ = false;           ///< its y
};

}  // namespace gyrostat::truth
