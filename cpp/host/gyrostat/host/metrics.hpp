// SPDX-License-Identifier: MIT
/// @file  Numbers that sum up a run. Written once, for single runs, claims and campaigns alike, under one name each.
///
/// A Series is n samples of k values, sample after sample. Windows are closed, with 1e-9 s of tolerance at both ends.
/// A window without samples, or t and x of different length, throws std::invalid_argument.
#pragma once
#include <cstddef>
#include <span>

namespace gyrostat::host {

struct Series {
  std::span<const double> t;  ///< s, increasing
  std::span<const double> x;  ///< n k values
  std::size_t width() const;  ///< k
};

/// Time (s) from `after` to the first instant from which max_i |x_i| < band to the end; NaN when it is never so.
double settling_time(const Series& s, double band, double after = 0);

/// max over the window of max_i |x_i|.
double window_max(const Series& s, double t0, double t1);

/// max over the window of the Euclidean norm of x.
double window_norm(const Series& s, double t0, double t1);

/// Root of the mean over the window of sum_i x_i^2.
double window_rms(const Series& s, double t0, double t1);

/// Smallest and largest value (signed) of any x_i in the window.
double window_lowest(const Series& s, double t0, double t1);
double window_highest(const Series& s, double t0, double t1);

/// Integral of sum_i u_i^2 dt, u held from each sample to the next.
double energy(const Series& s);

/// Sum over the window of sum_i |u_i(k) - u_i(k-1)|, per second of the window.
double total_variation(const Series& s, double t0, double t1);

/// Fraction of the window's samples in which max_i |x_i| >= level (1 - 1e-9): share of time at a limit, bound violations.
double fraction_at_least(const Series& s, double level, double t0, double t1);

/// First instant (s), not before `after`, with max_i |x_i| >= level; NaN when there is none. Detection delays.
double first_reach(const Series& s, double level, double after = 0);

}  // namespace gyrostat::host
