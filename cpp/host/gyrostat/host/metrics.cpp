// SPDX-License-Identifier: MIT
#include "gyrostat/host/metrics.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

namespace gyrostat::host {
namespace {

constexpr double tolerance = 1e-9;  // s
constexpr double never = std::numeric_limits<double>::quiet_NaN();

std::span<const double> sample(const Series& s, std::size_t k) { return s.x.subspan(k * s.width(), s.width()); }

/// A NaN stays.
double larger(double m, double v) { return std::isnan(m) || m >= v ? m : v; }

double largest(std::span<const double> x) {
  double m = 0;
  for (double v : x) m = larger(m, std::abs(v));
  return m;
}

double sum_of_squares(std::span<const double> x) {
  double sum = 0;
  for (double v : x) sum += v * v;
  return sum;
}

struct Window {
  std::size_t begin, end;
};

Window window(const Series& s, double t0, double t1) {
  (void)s.width();
  const auto begin = std::lower_bound(s.t.begin(), s.t.end(), t0 - tolerance);
  const auto end = std::upper_bound(s.t.begin(), s.t.end(), t1 + tolerance);
  if (begin >= end)
    throw std::invalid_argument("no sample between " + std::to_string(t0) + " s and " + std::to_string(t1) + " s");
  return {static_cast<std::size_t>(begin - s.t.begin()), static_cast<std::size_t>(end - s.t.begin())};
}

std::span<const double> values(const Series& s, double t0, double t1) {
  const Window w = window(s, t0, t1);
  return s.x.subspan(w.begin * s.width(), (w.end - w.begin) * s.width());
}

template <class F>
double window_largest(const Series& s, double t0, double t1, F of) {
  const Window w = window(s, t0, t1);
  double m = 0;
  for (std::size_t k = w.begin; k < w.end; ++k) m = larger(m, of(sample(s, k)));
  return m;
}

}  // namespace

std::size_t Series::width() const {
  if (t.empty() || x.empty() || x.size() % t.size() != 0) {
    throw std::invalid_argument(std::to_string(t.size()) + " instants and " + std::to_string(x.size()) +
                                " values do not fit");
  }
  return x.size() / t.size();
}

double settling_time(const Series& s, double band, double after) {
  (void)s.width();
  std::size_t k = s.t.size();
  while (k > 0 && s.t[k - 1] >= after - tolerance && largest(sample(s, k - 1)) < band) --k;
  return k == s.t.size() ? never : s.t[k] - after;
}

double window_max(const Series& s, double t0, double t1) { return window_largest(s, t0, t1, largest); }

double window_norm(const Series& s, double t0, double t1) {
  return std::sqrt(window_largest(s, t0, t1, sum_of_squares));
}

double window_rms(const Series& s, double t0, double t1) {
  const Window w = window(s, t0, t1);
  double sum = 0;
  for (std::size_t k = w.begin; k < w.end; ++k) sum += sum_of_squares(sample(s, k));
  return std::sqrt(sum / static_cast<double>(w.end - w.begin));
}

double window_lowest(const Series& s, double t0, double t1) {
  double m = std::numeric_limits<double>::infinity();
  for (double v : values(s, t0, t1)) m = -larger(-m, -v);
  return m;
}

double window_highest(const Series& s, double t0, double t1) {
  double m = -std::numeric_limits<double>::infinity();
  for (double v : values(s, t0, t1)) m = larger(m, v);
  return m;
}

double energy(const Series& s) {
  double sum = 0;
  for (std::size_t k = 0; k + 1 < s.t.size(); ++k) sum += sum_of_squares(sample(s, k)) * (s.t[k + 1] - s.t[k]);
  return sum;
}

double total_variation(const Series& s, double t0, double t1) {
  const Window w = window(s, t0, t1);
  double sum = 0;
  for (std::size_t k = w.begin + 1; k < w.end; ++k) {
    for (std::size_t i = 0; i < s.width(); ++i) sum += std::abs(sample(s, k)[i] - sample(s, k - 1)[i]);
  }
  return sum / (s.t[w.end - 1] - s.t[w.begin]);
}

double fraction_at_least(const Series& s, double level, double t0, double t1) {
  const Window w = window(s, t0, t1);
  std::size_t count = 0;
  for (std::size_t k = w.begin; k < w.end; ++k) count += largest(sample(s, k)) >= level * (1 - 1e-9) ? 1u : 0u;
  return static_cast<double>(count) / static_cast<double>(w.end - w.begin);
}

double first_reach(const Series& s, double level, double after) {
  (void)s.width();
  for (std::size_t k = 0; k < s.t.size(); ++k) {
    if (s.t[k] >= after - tolerance && largest(sample(s, k)) >= level) return s.t[k];
  }
  return never;
}

}  // namespace gyrostat::host
