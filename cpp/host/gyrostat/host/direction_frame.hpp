// SPDX-License-Identifier: MIT
/// @file  A frame from two directions that move: one body axis along the first, another as near to the second as it goes.
///
///     R = [e1 e2 e3] [a, c3 x a, c3]',   e3 = unit(e1 x s),  e2 = e3 x e1,  c3 = unit(a x c)
///     omega = vee(R' R'),  omegadot = vee(R' R''),  vee(A) = 1/2 (A32 - A23, A13 - A31, A21 - A12)
///
/// e1 and s are unit vectors along the two directions, a and c the body axes for them. Rate and acceleration are exact: every
/// derivative is written out, and what of R' R'' is not omegadot is symmetric.
#pragma once
#include "gyrostat/core/signals.hpp"

namespace gyrostat::host {

/// A vector with its first two derivatives, in axes that rest.
struct MovingVector {
  Vec3<double> p = Vec3<double>::Zero(), v = Vec3<double>::Zero(), a = Vec3<double>::Zero();

  MovingVector operator-() const;
  MovingVector operator-(const MovingVector& o) const;

  MovingVector cross(const MovingVector& o) const;
  /// Its direction.
  MovingVector unit() const;
};

class DirectionFrame {
 public:
  /// @param to_first  body axis that points along the first direction, of any length
  /// @param to_second  body axis that points as near to the second as it goes; not along `to_first`
  DirectionFrame(const Vec3<double>& to_first, const Vec3<double>& to_second);

  /// Sine of the angle between the two directions: near zero they name no frame.
  static double apart(const MovingVector& first, const MovingVector& second);

  /// Attitude (of positive scalar part, or zero), rate and acceleration of the frame.
  Reference<double> frame(const MovingVector& first, const MovingVector& second) const;

 private:
  Mat3<double> axes_;  ///< columns: axes of the frame of the two directions, in those of the body
};

}  // namespace gyrostat::host
