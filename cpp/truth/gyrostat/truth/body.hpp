// SPDX-License-Identifier: MIT
/// @file  Equations of motion of a rigid body with wheels and ideal torquers, in momentum form: a pure function.
///
/// With h_w,i the axial momentum of wheel i in inertial space (J is the total inertia less sum Js g g') and p_i the
/// impulse that ideal torquer i has given away, h_w,i' = p_i' = -delivered_i:
///
///     H_B = J w + D_wheels h_w + D_torquers p
///     H_B' = d_B - w x (J w + D_wheels h_w) = d_B - w x (H_B - D_torquers p)
///     w = J^-1 (H_B - D_wheels h_w - D_torquers p),   q_NB' = 1/2 q_NB (0, w)
///
/// Under a held command h_w and p are known functions of time, so that a new command or a fault is no discontinuity
/// of the right-hand side. Viscous friction depends on wheel speed: what it has taken out of each such wheel is a state.
/// Dry friction is constant while the wheel turns one way, and so part of the known exchange. A wheel that stands still
/// in its bearing turns with the body: its inertia is the body's, w = (J + Js g g')^-1 (H_B less all others). A wheel that is full
/// has constant momentum. All three leave w and the speed of the wheel continuous: what changes is a slope, as at a command.
///
///     y = [ q_NB (w, x, y, z), H_B, momentum that viscous friction took, one for each wheel with friction ]
#pragma once
#include <array>
#include <vector>

#include "gyrostat/truth/actuators.hpp"
#include "gyrostat/truth/disturbances.hpp"

namespace gyrostat::truth {

/// Mass properties and axes. `J_B` and `D_B` are those that really fly.
class Body {
 public:
  /// A wheel whose bearing has friction.
  struct FrictionWheel {
    int actuator;
    Vec3<double> axis_B;
    double inertia, viscous;
  };
  enum class Kind : std::uint8_t { torquers, wheels, mixed };

  /// @throws std::invalid_argument unless J_B is symmetric and positive definite and D_B has one column an actuator
  Body(const Mat3<double>& J_B, const Mat3N<double>& D_B, const Actuators& actuators);

  static constexpr int rigid_states = 7, max_states = rigid_states + max_actuators;
  int states() const noexcept { return rigid_states + static_cast<int>(friction_wheels.size()); }

  Mat3<double> J_B, J_B_inverse;
  Mat3<double> J_total_B;  ///< with the wheels' axial inertia
  Mat3N<double> D_B;
  Kind kind;
  std::vector<FrictionWheel> friction_wheels;
  double friction_rate = 0;  ///< 1/s, at which the quickest speed dies out in viscous friction
};

/// A polynomial of time of degree at most 4, for t in [t0, t0 + 1 / per_length].
template <class T>
struct Quartic {
  double t0 = 0, per_length = 0;
  int degree = 0;
  std::array<T, 5> c{};

  T operator()(double t) const noexcept {
    const double x = (t - t0) * per_length;
    if (degree <= 1) return c[0] + x * c[1];
    return c[0] + x * (c[1] + x * (c[2] + x * (c[3] + x * c[4])));
  }
};

/// What the actuators do on one smooth piece of time.
struct Exchange {
  Quartic<Vec3<double>> stored_B;    ///< D_wheels h_w + D_torquers p, without what viscous friction took
  Quartic<Vec3<double>> torquers_B;  ///< D_torquers p; used by mixed vehicles only
  Mat3<double> J_B_inverse;          ///< of the body and the wheels that stand still in their bearings

  struct FrictionWheel {
    Quartic<double> momentum;  ///< h_w, without what viscous friction took
    double counts = 1;         ///< 0 for a wheel that stands or is full: what friction takes is no part of its h_w
    double viscous = 0;        ///< N m s; 0 for a wheel that stands
  };
  std::array<FrictionWheel, max_actuators> friction_wheels;
};

/// All that the right-hand side needs.
struct Motion {
  const Body& body;
  const Disturbances& external;
  const Exchange& exchange;
};

/// J w at time t and state y, where J is that of J_B_inverse.
template <bool friction>
Vec3<double> body_momentum_B(const Motion& m, double t, const double* y) noexcept {
  Vec3<double> Jw = Vec3<double>{y[4], y[5], y[6]} - m.exchange.stored_B(t);
  if constexpr (friction) {
    for (std::size_t j = 0; j < m.body.friction_wheels.size(); ++j) {
      Jw -= m.exchange.friction_wheels[j].counts * y[Body::rigid_states + j] * m.body.friction_wheels[j].axis_B;
    }
  }
  return Jw;
}

/// y' of the state y at time t. `friction`: some wheel has it; `varying`: external torque depends on time or state.
/// Inlined by force: an RK4 step takes 20 % less time with the inertia kept in registers over its four stages.
template <bool friction, bool varying>
[[gnu::always_inline]] inline void derivative(const Motion& m, double t, const double* y, double* ydot) noexcept {
  const Vec3<double> Jw = body_momentum_B<friction>(m, t, y);
  const Vec3<double> w = (friction ? m.exchange.J_B_inverse : m.body.J_B_inverse) * Jw;
  const double a = 0.5 * y[0], b = 0.5 * y[1], c = 0.5 * y[2], d = 0.5 * y[3];
  ydot[0] = -b * w[0] - c * w[1] - d * w[2];
  ydot[1] = a * w[0] + c * w[2] - d * w[1];
  ydot[2] = a * w[1] + d * w[0] - b * w[2];
  ydot[3] = a * w[2] + b * w[1] - c * w[0];

  Vec3<double> rotating = Jw;  // the momentum that turns with the body
  if (m.body.kind == Body::Kind::wheels) rotating = {y[4], y[5], y[6]};
  if (m.body.kind == Body::Kind::mixed) rotating = Vec3<double>{y[4], y[5], y[6]} - m.exchange.torquers_B(t);
  Vec3<double> d_B = m.external.constant_B();
  if constexpr (varying) d_B = m.external.torque_B(t, {y[0], y[1], y[2], y[3]}, w);
  const Vec3<double> Hdot = d_B - w.cross(rotating);
  ydot[4] = Hdot[0];
  ydot[5] = Hdot[1];
  ydot[6] = Hdot[2];

  if constexpr (friction) {
    for (std::size_t j = 0; j < m.body.friction_wheels.size(); ++j) {
      const Body::FrictionWheel& wheel = m.body.friction_wheels[j];
      const Exchange::FrictionWheel& now = m.exchange.friction_wheels[j];
      const double h = now.momentum(t) + now.counts * y[Body::rigid_states + j];
      ydot[Body::rigid_states + j] = -now.viscous * (h / wheel.inertia - wheel.axis_B.dot(w));
    }
  }
}

}  // namespace gyrostat::truth
