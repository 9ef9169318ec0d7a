// SPDX-License-Identifier: MIT
/// @file  Numbers that sum up a run: one struct each, which sees the samples of a channel one after the other and keeps
///        no more than it needs. Single runs, claims and experiments measure with the same ones, under the same names.
///
/// The size of a sample is the largest |x_i|, and one that is NaN makes the metric NaN. Windows are closed, with 1e-9 s of
/// tolerance at both ends. A metric without a value, or without a sample, is NaN. Adding one: a struct and its name in
/// `Metric`.
#pragma once
#include <algorithm>
#include <cmath>
#include <concepts>
#include <limits>
#include <span>
#include <variant>
#include <vector>

#include "gyrostat/core/params.hpp"

namespace gyrostat::host {

/// What a metric must offer. `add` is called with the samples of a run in order.
template <class A>
concept Accumulator = std::copyable<A> && requires(A a, const A& c, double t, std::span<const double> x) {
  { A::name } -> std::convertible_to<const char*>;
  { A::meaning } -> std::convertible_to<const char*>;
  { a.add(t, x) };
  { c.value() } noexcept -> std::same_as<double>;
};

namespace measure {

inline constexpr double never = std::numeric_limits<double>::quiet_NaN();
inline constexpr double infinity = std::numeric_limits<double>::infinity();
inline constexpr double tolerance = 1e-9;  // s

/// A NaN stays.
inline double larger(double m, double v) noexcept { return std::isnan(m) || m >= v ? m : v; }

inline double largest(std::span<const double> x) noexcept {
  double m = 0;
  for (double v : x) m = larger(m, std::abs(v));
  return m;
}

inline double sum_of_squares(std::span<const double> x) noexcept {
  double sum = 0;
  for (double v : x) sum += v * v;
  return sum;
}

/// The samples that a metric looks at.
struct Window {
  double t0 = -infinity, t1 = infinity;
  std::size_t samples = 0;

  bool holds(double t) noexcept {
    const bool inside = t >= t0 - tolerance && t <= t1 + tolerance;
    samples += inside ? 1u : 0u;
    return inside;
  }
  double or_never(double value) const noexcept { return samples > 0 ? value : never; }

  static constexpr void describe(auto& p, auto&& field) {
    field(p.t0, Field{"t0", "s", -infinity, infinity, "first instant"});
    field(p.t1, Field{"t1", "s", -infinity, infinity, "last instant"});
  }
};

/// The first instant from which the size stays below a band.
struct Settling {
  double band = never, since = never;

  void look(double t, bool counts, std::span<const double> x) noexcept {
    if (!counts || !(largest(x) < band)) {
      since = never;
    } else if (std::isnan(since)) {
      since = t;
    }
  }
};

}  // namespace measure

struct SettlingTime : measure::Settling {
  static constexpr const char* name = "settling_time";
  static constexpr const char* meaning =
      "time (s) from `after` to the first instant from which max_i |x_i| < band to the end";
  double after = 0;

  static constexpr void describe(auto& p, auto&& field) {
    field(p.band, Field{"band", "", 0, measure::infinity, "size that counts as settled"});
    field(p.after, Field{"after", "s", -measure::infinity, measure::infinity, "instant from which time is counted"});
  }
  void add(double t, std::span<const double> x) noexcept { look(t, t >= after - measure::tolerance, x); }
  double value() const noexcept { return since - after; }
};

struct Recovery : measure::Settling {
  static constexpr const char* name = "recovery";
  static constexpr const char* meaning =
      "time (s) from a fault at `after`, whose sample is before it, to where max_i |x_i| < band until `until`";
  double after = measure::never, until = measure::infinity;

  static constexpr void describe(auto& p, auto&& field) {
    field(p.band, Field{"band", "", 0, measure::infinity, "size that counts as settled"});
    field(p.after, Field{"after", "s", -measure::infinity, measure::infinity, "instant of the fault"});
    field(p.until, Field{"until", "s", -measure::infinity, measure::infinity, "last instant that counts"});
  }
  void add(double t, std::span<const double> x) noexcept {
    if (t <= until + measure::tolerance) look(t, t > after + measure::tolerance, x);
  }
  double value() const noexcept { return since - after; }
};

struct WindowMax : measure::Window {
  static constexpr const char* name = "window_max";
  static constexpr const char* meaning = "largest |x_i| of the samples in [t0, t1]";
  double most = 0;

  void add(double t, std::span<const double> x) noexcept {
    if (holds(t)) most = measure::larger(most, measure::largest(x));
  }
  double value() const noexcept { return or_never(most); }
};

struct WindowNorm : measure::Window {
  static constexpr const char* name = "window_norm";
  static constexpr const char* meaning = "largest Euclidean norm of x in [t0, t1]";
  double most = 0;

  void add(double t, std::span<const double> x) noexcept {
    if (holds(t)) most = measure::larger(most, measure::sum_of_squares(x));
  }
  double value() const noexcept { return or_never(std::sqrt(most)); }
};

struct WindowRms : measure::Window {
  static constexpr const char* name = "window_rms";
  static constexpr const char* meaning = "root of the mean over [t0, t1] of sum_i x_i^2";
  double sum = 0;

  void add(double t, std::span<const double> x) noexcept {
    if (holds(t)) sum += measure::sum_of_squares(x);
  }
  double value() const noexcept { return or_never(std::sqrt(sum / static_cast<double>(samples))); }
};

struct WindowLowest : measure::Window {
  static constexpr const char* name = "window_lowest";
  static constexpr const char* meaning = "smallest value (signed) of any x_i in [t0, t1]";
  double least = measure::infinity;

  void add(double t, std::span<const double> x) noexcept {
    if (!holds(t)) return;
    for (double v : x) least = -measure::larger(-least, -v);
  }
  double value() const noexcept { return or_never(least); }
};

struct WindowHighest : measure::Window {
  static constexpr const char* name = "window_highest";
  static constexpr const char* meaning = "largest value (signed) of any x_i in [t0, t1]";
  double most = -measure::infinity;

  void add(double t, std::span<const double> x) noexcept {
    if (!holds(t)) return;
    for (double v : x) most = measure::larger(most, v);
  }
  double value() const noexcept { return or_never(most); }
};

struct Energy {
  static constexpr const char* name = "energy";
  static constexpr const char* meaning = "integral of sum_i x_i^2 dt, x held from each sample to the next";
  double sum = 0, t_before = measure::never, before = 0;

  static constexpr void describe(auto&, auto&&) {}
  void add(double t, std::span<const double> x) noexcept {
    if (!std::isnan(t_before)) sum += before * (t - t_before);
    t_before = t;
    before = measure::sum_of_squares(x);
  }
  double value() const noexcept { return std::isnan(t_before) ? measure::never : sum; }
};

struct TotalVariation : measure::Window {
  static constexpr const char* name = "total_variation";
  static constexpr const char* meaning = "sum over [t0, t1] of sum_i |change of x_i|, per second";
  double sum = 0, first = 0, last = 0;
  std::vector<double> before;  ///< the first sample makes room

  void add(double t, std::span<const double> x) {
    if (!holds(t)) return;
    if (samples == 1) {
      first = t;
      before.resize(x.size());
    } else {
      for (std::size_t i = 0; i < x.size(); ++i) sum += std::abs(x[i] - before[i]);
    }
    last = t;
    std::copy(x.begin(), x.end(), before.begin());
  }
  double value() const noexcept { return or_never(sum / (last - first)); }
};

struct FractionAtLeast : measure::Window {
  static constexpr const char* name = "fraction_at_least";
  static constexpr const char* meaning =
      "share of the samples in [t0, t1] with max_i |x_i| >= level (1 - 1e-9): time at a limit, breaches";
  double level = measure::never;
  std::size_t count = 0;

  static constexpr void describe(auto& p, auto&& field) {
    field(p.level, Field{"level", "", -measure::infinity, measure::infinity, "size that counts"});
    Window::describe(p, field);
  }
  void add(double t, std::span<const double> x) noexcept {
    if (holds(t)) count += measure::largest(x) >= level * (1 - 1e-9) ? 1u : 0u;
  }
  double value() const noexcept { return or_never(static_cast<double>(count) / static_cast<double>(samples)); }
};

struct FirstReach {
  static constexpr const char* name = "first_reach";
  static constexpr const char* meaning = "first instant (s), not before `after`, with max_i |x_i| >= level";
  double level = measure::never, after = 0, at = measure::never;

  static constexpr void describe(auto& p, auto&& field) {
    field(p.level, Field{"level", "", -measure::infinity, measure::infinity, "size that counts"});
    field(p.after, Field{"after", "s", -measure::infinity, measure::infinity, "first instant that counts"});
  }
  void add(double t, std::span<const double> x) noexcept {
    if (std::isnan(at) && t >= after - measure::tolerance && measure::largest(x) >= level) at = t;
  }
  double value() const noexcept { return at; }
};

struct Final {
  static constexpr const char* name = "final";
  static constexpr const char* meaning = "largest |x_i| of the last sample";
  double last = measure::never;

  static constexpr void describe(auto&, auto&&) {}
  void add(double, std::span<const double> x) noexcept { last = measure::largest(x); }
  double value() const noexcept { return last; }
};

using Metric = std::variant<SettlingTime, Recovery, WindowMax, WindowNorm, WindowRms, WindowLowest, WindowHighest,
                            Energy, TotalVariation, FractionAtLeast, FirstReach, Final>;

/// n samples of k values, sample after sample.
struct Series {
  std::span<const double> t;  ///< s, increasing
  std::span<const double> x;  ///< n k values
  /// k. @throws std::invalid_argument for lengths that do not fit
  std::size_t width() const;
};

[[noreturn]] void refuse_empty_window(double t0, double t1);

/// What a metric makes of a series.
/// @throws std::invalid_argument for lengths that do not fit, or a window without samples
template <Accumulator A>
double measured(A metric, const Series& s) {
  const std::size_t width = s.width();
  for (std::size_t k = 0; k < s.t.size(); ++k) metric.add(s.t[k], s.x.subspan(k * width, width));
  if constexpr (std::derived_from<A, measure::Window>) {
    if (metric.samples == 0) refuse_empty_window(metric.t0, metric.t1);
  }
  return metric.value();
}

}  // namespace gyrostat::host
