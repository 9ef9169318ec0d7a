// SPDX-License-Identifier: MIT
#include "gyrostat/truth/thrusters.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

namespace gyrostat::truth {
namespace {

constexpr double infinite = std::numeric_limits<double>::infinity();
constexpr double most_cycles = 1000;  // of a modulator in a period

std::string in_words(double x) {
  std::array<char, 32> out{};
  std::snprintf(out.data(), out.size(), "%.10g", x);
  return out.data();
}

}  // namespace

double Pwpf::shortest_cycle() const noexcept { return 2 * time_constant * std::log1p((on - off) / gain); }

double Thrusters::ticks() const noexcept { return std::round(period / tick); }

double Thrusters::open_ticks(double level) const noexcept {
  const double all = ticks(), n = std::floor(level * all + 0.5);
  if (n < min_on) return 0;
  return all - n < min_off ? all : n;
}

std::string Thrusters::check() const {
  if (each.empty()) return {};
  const auto positive = [](double x) { return x > 0 && std::isfinite(x); };
  for (std::size_t i = 0; i < each.size(); ++i) {
    const std::string who = "thruster " + std::to_string(i) + ": ";
    if (!positive(each[i].lever)) return who + "its lever must be positive";
    if (!positive(each[i].Isp)) return who + "Isp must be positive";
  }
  if (!(propellant_mass > 0)) return "thrusters: propellant_mass must be positive";
  if (modulator == Modulator::pwpf) {
    if (!positive(pwpf.gain) || !positive(pwpf.time_constant))
      return "thrusters: gain and time_constant must be positive";
    if (!(pwpf.on > pwpf.off) || !(pwpf.off > 0)) return "thrusters: 0 < pwpf_off < pwpf_on belongs there";
    if (pwpf.on >= pwpf.gain) return "thrusters: pwpf_on must be below pwpf_gain, or no level opens a valve";
    if (pwpf.shortest_cycle() * most_cycles < period)
      return "thrusters: the modulator switches more than 1000 times in a period";
  }
  if (modulator != Modulator::pwm) return {};
  if (!(tick >= 1e-6)) return "thrusters: tick must be at least 1e-6 s";
  if (std::abs(period / tick - ticks()) > 1e-9 * ticks() || ticks() < 1)
    return "thrusters: the period of " + in_words(period) + " s is not a whole number of ticks of " + in_words(tick) +
           " s";
  if (min_on < 1 || min_off < 1) return "thrusters: min_on and min_off must be at least 1 tick";
  if (min_on > ticks() || min_off > ticks())
    return "thrusters: min_on and min_off must not exceed the " + in_words(ticks()) + " ticks of a period";
  return {};
}

// ---- one valve -------------------------------------------------------------------------------------------------------

bool Valve::open(double t) const noexcept {
  return std::any_of(open_.begin(), open_.end(), [t](const Span& s) { return s.from <= t && t < s.to; });
}

double Valve::next_edge(double t) const noexcept {
  double next = infinite;
  for (const Span& s : open_) {
    if (s.from > t) next = std::min(next, s.from);
    if (s.to > t) next = std::min(next, s.to);
  }
  return next;
}

void Valve::forget(double t) noexcept {
  const auto over = [t](const Span& s) { return s.to < t; };
  open_.erase(std::remove_if(open_.begin(), open_.end(), over), open_.end());
}

void Valve::drive(const Thrusters& how, double level, double t0, double t1) {
  if (how.modulator == Thrusters::Modulator::pwpf) return modulate(how.pwpf, level, t0, t1);
  const double all = how.ticks(), n = how.open_ticks(level);
  if (!(n > 0)) return;
  if (n == all) return drives_.push_back({t0, t1});
  const double from = how.align == Thrusters::Align::centre ? t0 + 0.5 * (all - n) * how.tick : t0;
  const Span on{from, std::min(from + n * how.tick, t1)};
  if (!on.empty()) drives_.push_back(on);
}

/// From switch to switch; what lies between them is an exponential.
void Valve::modulate(const Pwpf& how, double level, double t0, double t1) {
  const double T = how.time_constant;
  for (double t = t0, began = t0;;) {
    const double at_last = how.gain * (level - (on_ ? 1 : 0)), trigger = on_ ? how.off : how.on;
    double dt = infinite;
    if (on_ ? filter_ <= trigger : filter_ >= trigger) {
      dt = 0;
    } else if (on_ ? at_last < trigger : at_last > trigger) {
      dt = T * std::log((filter_ - at_last) / (trigger - at_last));
    }
    if (!(t + dt < t1)) {
      filter_ = at_last + (filter_ - at_last) * std::exp((t - t1) / T);
      if (on_) drives_.push_back({began, t1});
      return;
    }
    t += dt;
    if (dt > 0) filter_ = trigger;
    if (on_ && began < t) drives_.push_back({began, t});
    on_ = !on_;
    began = t;
  }
}

}  // namespace gyrostat::truth
