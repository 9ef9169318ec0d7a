// SPDX-License-Identifier: MIT
/// @file  Which class of fault explains pairs of command and output: least squares of each, and whether one stands out.
///
///   gain  y = g u      additive  y = u + b      stuck  y = c
///
/// A class is possible when it leaves less than a quarter of sum (y - u)^2, or no more than rounding and noise; it is told when
/// the others leave three times as much. Page: docs/components/evidence.md
#pragma once
#include <algorithm>

#include "gyrostat/core/signals.hpp"
#include "gyrostat/flight/detectors/parts/momentum_pairs.hpp"

namespace gyrostat {

template <class S>
struct FaultFit {
  FaultClass fault = FaultClass::unclear;
  S gain = S(1), bias = S(0);  ///< delivered = gain u + bias; of an unclear one the mean error as bias
  S slope = S(1);              ///< of the output on the command, where that moved
  bool moved = false;          ///< the command, by more than the tolerance
};

/// @param n  the newest so many pairs, at least one
/// @param failed_below  a gain below it is a wheel that is stuck at zero
template <class S>
FaultFit<S> fit_fault(const MomentumPairs<S>& pairs, int n, S failed_below) noexcept {
  const S N = static_cast<S>(n);
  S u_mean = S(0), y_mean = S(0), tolerance = S(0);
  for (int k = 0; k < n; ++k) {
    u_mean += pairs[k].commanded / N;
    y_mean += pairs[k].delivered / N;
    tolerance += pairs[k].tolerance / N;
  }
  const S b = y_mean - u_mean;
  S uu = S(0), uy = S(0), var = S(0), cov = S(0), yy = S(0), error = S(0), additive = S(0);
  for (int k = 0; k < n; ++k) {
    const S u = pairs[k].commanded, y = pairs[k].delivered, du = u - u_mean, dy = y - y_mean;
    uu += u * u;
    uy += u * y;
    var += du * du;
    cov += du * dy;
    yy += dy * dy;
    error += (y - u) * (y - u);
    additive += (y - u - b) * (y - u - b);
  }
  const S g = uu > S(0) ? uy / uu : S(1);
  S scaled = S(0);
  for (int k = 0; k < n; ++k) {
    const S left = pairs[k].delivered - g * pairs[k].commanded;
    scaled += left * left;
  }

  const S noise = N * S(0.09) * tolerance * tolerance;  // (0.3 tolerance)^2 a pair
  const bool moved = var > N * tolerance * tolerance / S(4);
  FaultFit<S> fit;
  fit.bias = b;
  fit.moved = moved;
  if (moved) fit.slope = cov / var;
  const auto possible = [&](S left) { return left < error / S(4) || left < noise; };
  const auto clear = [&](S left, S other) { return std::max(other, noise) >= S(3) * std::max(left, noise); };
  const bool weakened = g > S(-0.05) && g < S(1.2) && possible(scaled) && clear(scaled, additive);
  const bool shifted = possible(additive) && clear(additive, scaled) && clear(additive, yy);
  const bool held = moved && fit.slope < S(0.25) && possible(yy) && clear(yy, additive);
  if (weakened && moved && g < failed_below) {  // gain and stuck at zero are one
    fit = {FaultClass::stuck, S(0), y_mean, fit.slope, true};
  } else if (held && clear(yy, scaled)) {
    fit = {FaultClass::stuck, S(0), y_mean, fit.slope, true};
  } else if (weakened && clear(scaled, yy)) {
    fit = {FaultClass::gain, std::max(g, S(0)), S(0), fit.slope, moved};
  } else if (shifted) {
    fit = {FaultClass::additive, S(1), b, fit.slope, moved};
  } else if (n >= 8 && std::min({scaled, additive, yy}) > S(0.3) * error) {
    fit.fault = FaultClass::intermittent;
  }
  return fit;
}

}  // namespace gyrostat
