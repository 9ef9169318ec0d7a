// SPDX-License-Identifier: MIT
/// @file  The border of a stack: whatever comes in, what the components get has its sizes, is finite and could be.
#pragma once
#include "gyrostat/flight/guard.hpp"

namespace gyrostat {

/// Measurement and reference as the components get them. Of a measurement that is invalid, impossible or not renewed, attitude,
/// rate and wheel momentum are each carried on by the model; a reference that is impossible holds the last possible one.
template <class S>
class Inputs {
 public:
  /// One sample. False before the first one with a valid attitude and rate after a valid reference: there is nothing to fly on.
  /// @param x  what was known at the sample before
  /// @param u  what was issued then
  bool take(const Guard<S>& guard, const Measurement<S>& in, const Reference<S>& ref, const Estimate<S>& x,
            const VecN<S>& u) noexcept {
    replaced_ = {};
    take(guard, ref);
    if (begun_) {
      take(guard, in, x, u);
    } else {
      begin(guard, in);
    }
    take_field(guard, in);
    return begun_;
  }

  /// Axes of this sample, where they move.
  void point(const Axes<S>& axes) noexcept { y_.axes = axes; }

  const Measurement<S>& measurement() const noexcept { return y_; }
  const Reference<S>& reference() const noexcept { return ref_; }
  /// What was replaced at this sample.
  const GuardActions& replaced() const noexcept { return replaced_; }

 private:
  void take(const Guard<S>& guard, const Reference<S>& ref) noexcept {
    replaced_.reference = !guard.possible(ref);
    if (replaced_.reference) return;
    ref_ = ref;
    ref_known_ = true;
  }

  /// A field that was not measured stands still in space.
  void take_field(const Guard<S>& guard, const Measurement<S>& in) noexcept {
    if (!guard.vehicle().magnetorquers.any() || !guard.attitude_possible(y_)) return;
    y_.field_valid = in.field_valid && guard.field_possible(in.field_B);
    if (y_.field_valid) {
      y_.field_B = in.field_B;
      field_N_ = y_.q_NB * in.field_B;
    } else {
      y_.field_B = y_.q_NB.conjugate() * field_N_;
    }
  }

  void judge(const Guard<S>& guard, const Measurement<S>& in) noexcept {
    replaced_.attitude = !(in.attitude_valid && guard.attitude_possible(in));
    replaced_.rate = !(in.rate_valid && guard.rate_possible(in.omega_BN_B));
    replaced_.momentum = !(in.momentum_valid && guard.momentum_possible(in.h_w));
  }

  /// Wheels that nobody has measured yet stand still.
  void begin(const Guard<S>& guard, const Measurement<S>& in) noexcept {
    judge(guard, in);
    begun_ = ref_known_ && !replaced_.attitude && !replaced_.rate;
    y_ = in;
    y_.momentum_valid = !replaced_.momentum;
    if (replaced_.momentum) y_.h_w.setZero(guard.vehicle().actuators());
    y_.event = 0;
  }

  /// With the tick of the sample before it is that sample once more (0: the caller does not count).
  void take(const Guard<S>& guard, const Measurement<S>& in, const Estimate<S>& x, const VecN<S>& u) noexcept {
    judge(guard, in);
    if (in.tick == y_.tick && in.tick != 0) replace_all();
    const std::uint32_t event = y_.event;
    if (replaced_.measurement() || guard.jumps(motion(y_), y_.axes, in, u)) {
      y_ = completed(guard, in, x, u);
    } else {
      doubts_ = 0;
      y_ = in;
    }
    y_.event = event + (jumped_ ? 1u : 0u);
    jumped_ = false;
  }

  /// What no motion leads to is garbage until the next sample bears it out; a sensor that goes on like that is flown as it is.
  Measurement<S> completed(const Guard<S>& guard, const Measurement<S>& in, const Estimate<S>& x,
                           const VecN<S>& u) noexcept {
    constexpr int patience = 10;  // samples
    const Measurement<S> y = carried_on(guard, in, x, u);
    const bool jumps = guard.jumps(motion(y_), y_.axes, y, u);
    if (jumps && doubts_ == patience) {
      jumped_ = guard.rates_jump(motion(y_), y_.axes, y, u);
      return y;
    }
    jumped_ = jumps && doubts_ > 0 && !guard.jumps(doubted_, y_.axes, y, u);
    if (!jumps || jumped_) {
      doubts_ = 0;
      return y;
    }
    ++doubts_;
    doubted_ = motion(y);
    replace_all();
    return carried_on(guard, in, x, u);
  }

  Measurement<S> carried_on(const Guard<S>& guard, Measurement<S> y, const Estimate<S>& x,
                            const VecN<S>& u) const noexcept {
    y.attitude_valid = !replaced_.attitude;
    y.rate_valid = !replaced_.rate;
    y.momentum_valid = !replaced_.momentum;
    guard.carry_on(y_, x, u, y);
    return y;
  }

  static Motion<S> motion(const Measurement<S>& y) noexcept { return {y.q_NB, y.omega_BN_B, y.h_w}; }
  void replace_all() noexcept { replaced_.attitude = replaced_.rate = replaced_.momentum = true; }

  Measurement<S> y_;
  Motion<S> doubted_;                  ///< what was measured at the sample before, where it was doubted
  Vec3<S> field_N_ = Vec3<S>::Zero();  ///< T, when it was measured last
  Reference<S> ref_;
  GuardActions replaced_;
  int doubts_ = 0;  ///< samples in a row
  bool jumped_ = false, begun_ = false, ref_known_ = false;
};

}  // namespace gyrostat
