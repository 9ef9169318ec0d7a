// SPDX-License-Identifier: MIT
/// @file  Equations of motion of a rigid body with effectors, in momentum form: a pure function.
///
/// With h_w,i the axial momentum of wheel i in inertial space and p_i the impulse that ideal torquer i has given away,
/// h_w,i' = p_i' = -delivered_i (J is the total inertia less sum Js g g'):
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
/// What other effectors add: effectors/effector.hpp.
///
///     y = [ q_NB (w, x, y, z), H_B, states of the effectors in the right-hand side ]
#pragma once
#include <array>

#include "gyrostat/truth/cubic.hpp"
#include "gyrostat/truth/disturbances.hpp"
#include "gyrostat/truth/effectors/list.hpp"
#include "gyrostat/truth/orbit.hpp"

namespace gyrostat::truth {

inline constexpr int rigid_states = 7;

/// What the effectors hold on one smooth piece of time.
struct Held {
  enum class Leaves : std::uint8_t { nothing, all, some };  ///< of what goes along fixed axes

  Quartic<Vec3<double>> stored_B;                      ///< sum P g along fixed axes
  Quartic<Vec3<double>> outer_B;                       ///< of these what has left the vehicle, where some does
  std::array<Quartic<double>, max_actuators> impulse;  ///< P of the channels of effectors in the right-hand side
  Mat3<double> J_B_inverse;  ///< of the body and the wheels that stand still in their bearings
  Leaves leaves = Leaves::all;
};

/// All that the right-hand side needs.
template <class List>
struct Motion {
  const List& effectors;
  const Disturbances& external;
  const Held& held;
  const Orbit* orbit = nullptr;  ///< where effectors need its field
};

/// What effectors see. The rate may not be known yet.
inline Scene scene_at(double t, const double* y, const Vec3<double>& omega_BN_B, const Orbit* orbit) noexcept {
  Scene s{t, {y[0], y[1], y[2], y[3]}, omega_BN_B};
  if (orbit == nullptr) return s;
  const Orbit::Field field = orbit->field(t);
  const Quat<double> q_BN = s.q_NB.conjugate();
  s.field_B = q_BN * field.B_N;
  s.drift_B = q_BN * field.rate_N;
  return s;
}

/// y' of the state y at time t. `coupled`: some effector is in it; `varying`: external torque depends on time or state.
/// Inlined by force: an RK4 step takes 20 % less time with the inertia kept in registers over its four stages.
template <bool coupled, bool varying, class List>
[[gnu::always_inline]] inline void derivative(const Motion<List>& m, double t, const double* y, double* ydot) noexcept {
  const auto impulse = [&](const auto& e) {
    return e.channel < 0 ? 0.0 : m.held.impulse[static_cast<std::size_t>(e.channel)](t);
  };
  const Vec3<double> H{y[4], y[5], y[6]};
  Vec3<double> Jw = H - m.held.stored_B(t);
  Vec3<double> left_B = Vec3<double>::Zero();  // of the others, what is not the vehicle's
  Scene s{t, {y[0], y[1], y[2], y[3]}, {}};
  if constexpr (coupled) {
    if (m.orbit != nullptr) s = scene_at(t, y, Vec3<double>::Zero(), m.orbit);
  }
  constexpr bool some_leave = List::any([]<class E>() { return detail::Coupled<E> && E::storage == Storage::outer; });
  if constexpr (coupled) {
    const double* inner = y + rigid_states;
    m.effectors.each_coupled([&]<class E>(const E& e) {
      const Vec3<double> h = e.momentum_B(s, impulse(e), inner);
      Jw -= h;
      if constexpr (E::storage == Storage::outer) left_B += h;
      inner += E::states;
    });
  }
  const Vec3<double> w = m.held.J_B_inverse * Jw;
  const double a = 0.5 * y[0], b = 0.5 * y[1], c = 0.5 * y[2], d = 0.5 * y[3];
  ydot[0] = -b * w[0] - c * w[1] - d * w[2];
  ydot[1] = a * w[0] + c * w[2] - d * w[1];
  ydot[2] = a * w[1] + d * w[0] - b * w[2];
  ydot[3] = a * w[2] + b * w[1] - c * w[0];

  Vec3<double> rotating = H;  // the momentum that turns with the vehicle
  if (m.held.leaves == Held::Leaves::all) rotating = coupled ? Vec3<double>(H - m.held.stored_B(t)) : Jw;
  if (m.held.leaves == Held::Leaves::some) rotating = H - m.held.outer_B(t);
  Vec3<double> d_B = m.external.constant_B();
  if constexpr (varying) d_B = m.external.torque_B(t, s.q_NB, w);
  if constexpr (coupled) {
    if constexpr (some_leave) rotating -= left_B;
    s.omega_BN_B = w;
    const double* inner = y + rigid_states;
    double* rate = ydot + rigid_states;
    m.effectors.each_coupled([&]<class E>(const E& e) {
      if constexpr (E::storage == Storage::outer) d_B += e.torque_B(s, impulse(e), inner);
      e.rates(s, impulse(e), inner, rate);
      inner += E::states;
      rate += E::states;
    });
  }
  const Vec3<double> Hdot = d_B - w.cross(rotating);
  ydot[4] = Hdot[0];
  ydot[5] = Hdot[1];
  ydot[6] = Hdot[2];
}

}  // namespace gyrostat::truth
