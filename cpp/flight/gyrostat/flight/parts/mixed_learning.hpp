// SPDX-License-Identifier: MIT
/// @file  Learning of a torque from an error and its past, and the stability of the sampled loop it closes.
///
///   learnt[k] = clamp( keep learnt[k-n] + K (before error[k-n] + now error[k]) )
///
/// Source: Wang, Jia, Yu 2023, eq. (6) and (31), with a clamp. One delay line of `keep learnt + before K error` suffices.
/// Page: docs/components/mixed_learning_disturbance.md
#pragma once
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "gyrostat/core/params.hpp"
#include "gyrostat/flight/parts/delay_line.hpp"
#include "gyrostat/flight/parts/stiffness.hpp"

namespace gyrostat {

/// before = 0: repetitive (a leaky integral); now = 0: iterative; both: mixed.
template <class S>
struct MixedLearningGains {
  Mat3<S> K;  ///< N m s, torque learnt per rate error
  S now;      ///< share of the present error
  S before;   ///< share of the error `delay` samples ago
  S keep;     ///< of the torque learnt `delay` samples ago
  int delay;  ///< samples, 1 to max_delay
  S clamp;    ///< N m, each axis; may be infinite
};

template <class S>
class MixedLearning {
 public:
  explicit MixedLearning(const MixedLearningGains<S>& gains) noexcept
      : gains_(gains), carried_(gains.delay, Vec3<S>(Vec3<S>::Zero())) {}

  /// Nothing learnt, no past error.
  void reset() noexcept {
    carried_.fill(Vec3<S>::Zero());
    learnt_.setZero();
  }

  /// Takes the error of this sample and returns the learnt torque, N m. Once a sample.
  const Vec3<S>& update(const Vec3<S>& error) noexcept {
    const Vec3<S> torque_B = gains_.K * error;
    const Vec3<S> sum = carried_.oldest() + gains_.now * torque_B;
    learnt_ = sum.cwiseMax(-gains_.clamp).cwiseMin(gains_.clamp);
    carried_.push(gains_.keep * learnt_ + gains_.before * torque_B);
    return learnt_;
  }

  const Vec3<S>& learnt() const noexcept { return learnt_; }

 private:
  MixedLearningGains<S> gains_;
  DelayLine<Vec3<S>> carried_;
  Vec3<S> learnt_ = Vec3<S>::Zero();
};

/// Growth a sample of the linear error loop (its spectral radius), when the error obeys
///
///   error[k+1] = error[k] - dt J^-1 ( K_lin error[k] + learnt[k] )
///
/// One sample of delay: the root of a high power of the 6 x 6 matrix in (error, carried), by repeated squaring. Squaring j
/// adds a rounding error of 2^-j epsilon to the radius, so it is exact but for rounding. Longer delays: the loop itself is
/// run, rescaled, and its peaks compared 8000 samples apart; the phase of the peaks leaves 1e-5 of the radius.
template <class S>
S learning_loop_radius(const Mat3<S>& J_inv, S dt, const Mat3<S>& K_lin, const MixedLearningGains<S>& gains) noexcept {
  const Mat3<S> direct = Mat3<S>::Identity() - dt * J_inv * (K_lin + gains.now * gains.K);
  const Mat3<S> carry = (gains.keep * gains.now + gains.before) * gains.K;
  // In the unit J / dt the carried torque has the size of a rate.
  const S unit = S(1) / (dt * J_inv.diagonal().maxCoeff());
  if (gains.delay == 1) {
    using Mat6 = Eigen::Matrix<S, 6, 6>;
    Mat6 power;
    power << direct, -dt * unit * J_inv, carry / unit, gains.keep * Mat3<S>::Identity();
    S log_radius = S(0), exponent = S(1);
    for (int squaring = 0; squaring < 40; ++squaring) {
      const S size = power.cwiseAbs().maxCoeff();
      if (!(size > S(0)) || !std::isfinite(size)) break;
      log_radius += std::log(size) / exponent;
      power /= size;
      const Mat6 once = power;
      power.noalias() = once.lazyProduct(once);
      exponent *= S(2);
    }
    return std::exp(log_radius);
  }
  DelayLine<Vec3<S>> carried(gains.delay, Vec3<S>(S(0.3), S(-0.5), S(0.7)));
  Vec3<S> error(S(1), S(0.8), S(-0.6));
  S log_scale = S(0), first = S(0), last = S(0);
  constexpr int settle = 4000, apart = 8000, window = 1000;
  for (int k = 0; k < settle + apart + window; ++k) {
    const Vec3<S> before = carried.oldest();
    carried.push(gains.keep * before + carry / unit * error);
    error = direct * error - dt * unit * J_inv * before;
    const S size = error.cwiseAbs().maxCoeff();
    if (!(size > S(0)) || !std::isfinite(size)) break;
    const S height = std::log(size) + log_scale;
    if (k == settle || (k > settle && k < settle + window)) first = k == settle ? height : std::max(first, height);
    if (k >= settle + apart) last = k == settle + apart ? height : std::max(last, height);
    if (k % window == window - 1) {
      log_scale += std::log(size);
      error /= size;
      for (int i = 0; i < gains.delay; ++i) {
        const Vec3<S> smaller = carried.oldest() / size;
        carried.push(smaller);
      }
    }
  }
  return std::exp((last - first) / static_cast<S>(apart));
}

/// Refuses a loop that would diverge, with its spectral radius. `slope`, N m s: what a boundary layer adds to K_lin near zero.
template <class S>
Status<S> learning_loop_is_stable(const Setup<S>& setup, const Mat3<S>& K_lin, S slope,
                                  const MixedLearningGains<S>& gains) noexcept {
  const Mat3<S> J_inv = setup.vehicle.J_B.inverse();
  const Mat3<S> inside = K_lin + slope * Mat3<S>::Identity();
  const S far = learning_loop_radius<S>(J_inv, setup.dt, K_lin, gains);
  const S near = slope > S(0) ? learning_loop_radius<S>(J_inv, setup.dt, inside, gains) : far;
  const S radius = std::max(far, near);
  return Status<S>::require(radius < S(1), "spectral radius of the sampled learning loop", radius, S(1), "<",
                            Status<S>::Code::unstable);
}

}  // namespace gyrostat
