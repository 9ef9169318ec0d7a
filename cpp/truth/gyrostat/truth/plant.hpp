// SPDX-License-Identifier: MIT
/// @file  What flies: what the loop, the recorder and the metrics ask of a plant, and what its models have in common.
#pragma once
#include <concepts>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "gyrostat/truth/actuators.hpp"
#include "gyrostat/truth/disturbances.hpp"
#include "gyrostat/truth/effectors/control_moment_gyro.hpp"
#include "gyrostat/truth/effectors/flexible_mode.hpp"
#include "gyrostat/truth/integrator.hpp"
#include "gyrostat/truth/orbit.hpp"
#include "gyrostat/truth/sensors.hpp"

namespace gyrostat::truth {

/// The true vehicle and what happens to it.
struct PlantModel {
  Mat3<double> J_B = Mat3<
      double>::Identity();  ///< kg m^2, total inertia less what effectors take (wheels: Js g g', modes: delta delta')
  Mat3N<double> D_B{3, 0};  ///< actuator axes in columns; of magnetorquers those of their dipoles
  Actuators actuators = Actuators::ideal(0);
  std::vector<Fault> faults;
  std::vector<FlexibleMode> modes;       ///< of appendages
  std::vector<ControlMomentGyro> gyros;  ///< each drives its channel; their slow_downs come from the faults
  Mask magnetorquers;                    ///< actuators whose command is a dipole, A m^2
  std::vector<Disturbance> disturbances;
  double orbit_rate = 0;       ///< rad/s, for gravity_gradient without an orbit and the Euler-angle model
  std::optional<Orbit> orbit;  ///< N is then the Earth's equatorial frame
  Integrator integrator;
};

struct InitialState {
  Quat<double> q_NB = Quat<double>::Identity();    ///< normalised on entry
  Vec3<double> omega_BN_B = Vec3<double>::Zero();  ///< rad/s
  VecN<double> h_w;                           ///< N m s, Js (Omega_i + g_i . w), zero for torquers; empty: all zero
  Vec3<double> euler = Vec3<double>::Zero();  ///< rad, roll, pitch, yaw; read by the Euler-angle model, instead of q_NB
};

/// Where the truth is.
struct TruthState {
  double t = 0;  ///< s
  Quat<double> q_NB = Quat<double>::Identity();
  Vec3<double> omega_BN_B = Vec3<double>::Zero();  ///< rad/s
  VecN<double> h_w;                                ///< N m s
  VecN<double> eta, eta_rate;                      ///< kg^1/2 m, kg^1/2 m/s, of the modes of appendages
  VecN<double> gimbal, rotor_momentum;             ///< rad, N m s, one an actuator; empty without control moment gyros
  double propellant = 0;                           ///< kg, that thrusters have used
  Vec3<double> thruster_impulse_B = Vec3<double>::Zero();  ///< N s, integral of their force in body axes
  Vec3<double> angles = Vec3<double>::Zero();  ///< rad, roll, pitch, yaw of a plant whose states they are; else zero
};

/// The truth at one time, one-sided: faults and command are those of the interval that just ended. Before the first
/// one nothing is commanded or delivered. Of thrusters, what was delivered is the mean over the interval.
struct TruthSample : TruthState {
  Vec3<double> omegadot_BN_B = Vec3<double>::Zero();  ///< rad/s^2
  VecN<double> delivered;      ///< N m on the body along each axis, limits and friction included: h_w' = -delivered
  VecN<double> effectiveness;  ///< of the faults
  VecN<double> bias;           ///< N m, of the faults
  Vec3<double> external_B = Vec3<double>::Zero();        ///< N m
  Vec3<double> thruster_force_B = Vec3<double>::Zero();  ///< N, mean over the interval
};

/// How quickly the truth's own motion goes on, beside what drives it.
struct InnerRates {
  double turning = 0;  ///< 1/s, sqrt(2 (|w|^2 + |H|^2 |J^-1|^2)), H what turns with the body: of turning and precession
  double bending = 0;  ///< rad/s, of the quickest mode of an appendage
  double friction = 0;  ///< 1/s, at which the quickest wheel stops in viscous friction

  static constexpr double longest_step = 0.5;       ///< of rk4, in time constants; it would diverge from 2.785 on
  static constexpr double longest_bending = 2.785;  ///< rad of the quickest mode in a step of rk4
  static constexpr double most_in_a_sample = 1000;  ///< time constants; no integrator goes on beyond
};

/// Attitude, rate or momentum became infinite or NaN.
class NonFiniteState : public std::runtime_error {
 public:
  explicit NonFiniteState(double time_in)
      : std::runtime_error("the state is no longer finite at t = " + std::to_string(time_in) + " s"), time(time_in) {}
  double time;  ///< s
};

/// A model of what flies. It is constructed from (PlantModel, InitialState, period) and names no coordinates to anybody.
template <class P>
concept Plant = requires(P p, const P& c, Sensors& sensors, const VecN<double>& u, const Vec3<double>& angles) {
  { c.time() } noexcept -> std::same_as<double>;                // s
  { c.measure(sensors) } -> std::same_as<Measurement<double>>;  // what they show of it at this sample
  p.advance(u);                                                 // holds u (N m) to the next sample
  { c.state() } noexcept -> std::same_as<const TruthState&>;
  { c.sample() } -> std::same_as<TruthSample>;
  { c.euler() } -> std::same_as<EulerState<double>>;                      // roll, pitch, yaw and their rates
  { P::angle_difference(angles, angles) } -> std::same_as<Vec3<double>>;  // of these: up to full turns, or not
  { c.statistics() } -> std::same_as<IntegratorStatistics>;
  { c.inner_rates() } -> std::same_as<InnerRates>;
};

}  // namespace gyrostat::truth
