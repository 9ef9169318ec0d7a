// SPDX-License-Identifier: MIT
#include "gyrostat/truth/waveform.hpp"

#include <algorithm>
#include <cmath>

namespace gyrostat::truth {
namespace {

template <class... F>
struct Overloaded : F... {
  using F::operator()...;
};
template <class... F>
Overloaded(F...) -> Overloaded<F...>;

/// How many of `times` are not after t.
std::size_t passed(const std::vector<double>& times, double t) noexcept {
  return static_cast<std::size_t>(std::upper_bound(times.begin(), times.end(), t) - times.begin());
}

double first_after(const std::vector<double>& times, double t) noexcept {
  const std::size_t i = passed(times, t);
  return i < times.size() ? times[i] : infinity;
}

std::string check_points(const std::vector<double>& times, const std::vector<double>& values) {
  if (times.empty()) return "times is empty";
  if (times.size() != values.size()) {
    return "times and values differ in length (" + std::to_string(times.size()) + ", " + std::to_string(values.size()) +
           ")";
  }
  for (std::size_t i = 1; i < times.size(); ++i) {
    if (!(times[i] > times[i - 1])) return "times must increase, but times[" + std::to_string(i) + "] does not";
  }
  return {};
}

double value(const ConstantWave& w, double, double) noexcept { return w.value; }
double value(const SineWave& w, double t, double) noexcept {
  return w.offset + w.amplitude * std::sin(w.omega * t + w.phase);
}
double value(const SquareWave& w, double, double branch) noexcept { return w.is_high(branch) ? w.high : w.low; }
double value(const StepsWave& w, double, double branch) noexcept {
  const std::size_t i = passed(w.times, branch);
  return w.values[i == 0 ? 0 : i - 1];
}
double value(const TableWave& w, double t, double branch) noexcept {
  const std::size_t i = passed(w.times, branch);
  if (i == 0) return w.values.front();
  if (i == w.times.size()) return w.values.back();
  return w.values[i - 1] + (w.values[i] - w.values[i - 1]) * ((t - w.times[i - 1]) / (w.times[i] - w.times[i - 1]));
}
double value(const SumWave& w, double t, double branch) noexcept {
  double sum = 0;
  for (const Waveform& term : w.terms) sum += term(t, branch);
  return sum;
}

}  // namespace

std::string SquareWave::check() const {
  if (!(period > 0) || !std::isfinite(period)) return "period must be positive and finite";
  if (!(duty >= 0 && duty <= 1)) return "duty must lie in [0, 1]";
  return {};
}
std::string StepsWave::check() const { return check_points(times, values); }
std::string TableWave::check() const { return check_points(times, values); }
std::string SumWave::check() const {
  for (std::size_t i = 0; i < terms.size(); ++i) {
    const std::string error = terms[i].check();
    if (!error.empty()) return "terms[" + std::to_string(i) + "]: " + error;
  }
  return {};
}

bool SquareWave::is_high(double t) const noexcept {
  const double periods = (t + phase) / period;
  return periods - std::floor(periods) < duty;
}

double SquareWave::next_switch(double t) const noexcept {
  if (duty <= 0 || duty >= 1) return infinity;
  const double k = std::floor((t + phase) / period);
  double next = infinity;
  for (double j = k - 1; j <= k + 1; ++j) {  // one period to each side: floor may be off by one at an edge
    for (const double edge : {j * period - phase, (j + duty) * period - phase}) {
      if (edge > t) next = std::min(next, edge);
    }
  }
  return next;
}

Waveform::Waveform(const Waveform&) = default;
Waveform::Waveform(Waveform&&) noexcept = default;
Waveform& Waveform::operator=(const Waveform&) = default;
Waveform& Waveform::operator=(Waveform&&) noexcept = default;
Waveform::~Waveform() = default;

double Waveform::operator()(double t, double branch) const noexcept {
  return std::visit([&](const auto& w) { return value(w, t, branch); }, kind_);
}

double Waveform::next_switch(double t) const noexcept {
  return std::visit(Overloaded{[&](const SquareWave& w) { return w.next_switch(t); },
                               [&](const StepsWave& w) { return first_after(w.times, t); },
                               [&](const TableWave& w) { return first_after(w.times, t); },
                               [&](const SumWave& w) {
                                 double next = infinity;
                                 for (const Waveform& term : w.terms) next = std::min(next, term.next_switch(t));
                                 return next;
                               },
                               [](const auto&) { return infinity; }},
                    kind_);
}

bool Waveform::piecewise_constant() const noexcept {
  return std::visit(Overloaded{[](const SineWave& w) { return w.amplitude == 0 || w.omega == 0; },
                               [](const TableWave& w) { return w.times.size() < 2; },
                               [](const SumWave& w) {
                                 return std::all_of(w.terms.begin(), w.terms.end(),
                                                    [](const Waveform& term) { return term.piecewise_constant(); });
                               },
                               [](const auto&) { return true; }},
                    kind_);
}

double Waveform::fastest() const noexcept {
  return std::visit(Overloaded{[](const SineWave& w) { return w.amplitude == 0 ? 0.0 : std::abs(w.omega); },
                               [](const SumWave& w) {
                                 double fastest = 0;
                                 for (const Waveform& term : w.terms) fastest = std::max(fastest, term.fastest());
                                 return fastest;
                               },
                               [](const auto&) { return 0.0; }},
                    kind_);
}

std::string Waveform::check() const {
  return std::visit([](const auto& w) { return w.check(); }, kind_);
}

}  // namespace gyrostat::truth
