// SPDX-License-Identifier: MIT
/// @file  The whole contract between sensors, navigator, observer, detector, controller, allocator and actuators.
///
/// SI and radians, scalar-first Hamilton quaternions, frames in names (N inertial, B body, R reference).
/// One model for all, so that stacks of different papers never count a fault twice:
///
///     J w' = -w x (J w + D h_w) + D diag(effectiveness) u + d_B
///
/// Page: docs/architecture.md
#pragma once
#include <algorithm>
#include <array>
#include <limits>

#include "gyrostat/core/types.hpp"

namespace gyrostat {

/// What kind of plant the numbers describe. `euler_angles`: the printed Euler-angle model of cao2023, where
/// `omega_BN_B` holds the Euler rates; everything else is `body`.
enum class Coordinates : std::uint8_t { body, euler_angles };

/// The nominal vehicle: all that flight knows of it.
template <class S>
struct Vehicle {
  Mat3<S> J_B = Mat3<S>::Identity();  ///< kg m^2; with wheels: total inertia less sum Js g g'
  Mat3N<S> D_B{3, 0};                 ///< actuator axes in columns
  VecN<S> u_lo, u_up;                 ///< N m, limits of the command; infinite when flight knows none
  VecN<S> u_rate;                     ///< N m/s, limit of its change; infinite when there is none
  VecN<S> h_max;                      ///< N m s, |h_w| at which a wheel gives no more; infinite, or empty: not known
  VecN<S>
      u_quantum;  ///< N m, of on/off actuators: one tick of the valve, as a mean over the period; 0, or empty: continuous
  VecN<S> u_dead;       ///< N m, smallest command of these that acts,
  VecN<S> u_gap;        ///< N m, smallest distance from u_up that they keep: what is nearer is u_up
  Mask spare;           ///< off until a detector enables them
  Mask wheels;          ///< actuators that store momentum (h_w)
  Mask magnetorquers;   ///< actuators that are a dipole (A m^2): their D_B is zero but in `Axes`
  S orbit_rate = S(0);  ///< rad/s, circular orbit
  Coordinates coordinates = Coordinates::body;
  bool moving_axes = false;  ///< D_B is where they start: the signals say where they are (Axes)

  int actuators() const noexcept { return static_cast<int>(D_B.cols()); }
};

/// Constructor argument of every component. The period is fixed here: delays and stability are decided with it.
template <class S>
struct Setup {
  Vehicle<S> vehicle;
  S dt = S(0);  ///< s
};

/// 3-2-1 Euler angles (roll, pitch, yaw) and their rates.
template <class S>
struct EulerState {
  Vec3<S> angles = Vec3<S>::Zero();  ///< rad
  Vec3<S> rates = Vec3<S>::Zero();   ///< rad/s
};

/// Actuator axes at one sample, where they move: gimbals turn, a magnetic field does. Empty: those of the vehicle, for good.
template <class S>
struct Axes {
  Mat3N<S> D_B{3, 0};             ///< in columns; empty: Vehicle::D_B
  Vec3<S> h_B = Vec3<S>::Zero();  ///< N m s, momentum that actuators store; with empty D_B it is D h_w
  std::uint32_t revision = 0;     ///< another one wherever D_B is another one

  bool move() const noexcept { return D_B.cols() > 0; }
  /// The axes of this sample, and the momentum along them, where those of the vehicle are `fixed_B`.
  const Mat3N<S>& of(const Mat3N<S>& fixed_B) const noexcept { return move() ? D_B : fixed_B; }
  Vec3<S> momentum_B(const Mat3N<S>& fixed_B, const VecN<S>& h_w) const noexcept {
    return move() ? h_B : torque<S>(fixed_B, h_w);
  }
};

/// What went wrong or was limited; a set of bits, so that several can hold at once. 0: nothing to report.
enum class Flag : std::uint16_t {
  input_held = 1,       ///< an input was invalid: attitude and rate were carried on, others are the last valid ones
  component_reset = 2,  ///< an output that cannot be: its component was started again
  command_held = 4,     ///< the previous command was issued again
  demand_not_met = 8,   ///< the allocator could not deliver the demanded torque
  cap_reached = 16,     ///< a solve is not proven optimal (an iteration limit, rounding): best so far was used
  bad_input = 32,       ///< an allocator refused its input
  rank_lost = 64,       ///< an axis of torque cannot be produced, or is too weak, and was dropped
  singular = 128,       ///< near a singularity: of the chart in use, or of the gimbals
  breach = 256,         ///< a promised bound was left
};

/// A set of `Flag`s.
class Flags {
 public:
  constexpr Flags() noexcept = default;
  constexpr Flags(Flag f) noexcept : bits_(static_cast<std::uint16_t>(f)) {}
  constexpr bool has(Flag f) const noexcept { return (bits_ & static_cast<std::uint16_t>(f)) != 0; }
  constexpr void set(Flag f) noexcept { bits_ = static_cast<std::uint16_t>(bits_ | static_cast<std::uint16_t>(f)); }
  constexpr Flags operator|(Flags o) const noexcept {
    Flags r;
    r.bits_ = static_cast<std::uint16_t>(bits_ | o.bits_);
    return r;
  }
  constexpr std::uint16_t bits() const noexcept { return bits_; }
  constexpr bool operator==(const Flags&) const noexcept = default;

 private:
  std::uint16_t bits_ = 0;
};

/// sensors -> navigator -> observer. What is not valid was not measured at this sample: the stack replaces it, and keeps the bit.
template <class S>
struct Measurement {
  Tick tick = 0;
  Quat<S> q_NB = Quat<S>::Identity();    ///< sign continuous from the initial state
  Vec3<S> omega_BN_B = Vec3<S>::Zero();  ///< rad/s
  VecN<S> h_w;                           ///< N m s, one an actuator; zero for ideal torquers
  VecN<S> gimbal;                        ///< rad, one an actuator; zero for those that have none, empty without any
  EulerState<S>
      euler;  ///< the state in euler_angles coordinates, where it shares the validity of q_NB; else for the curious
  bool attitude_valid = true, rate_valid = true, momentum_valid = true;
  Vec3<S> rate_step =
      Vec3<S>::Zero();  ///< rad/s, share of the change of the rate that is knowledge, not motion: a navigator
                        ///< has moved its gyro bias by less so much
  Vec3<S> field_B = Vec3<S>::Zero();  ///< T, magnetic field
  bool field_valid = false;           ///< it was measured at this sample
  bool sun_valid = false;             ///< sun_B was measured at this sample
  Vec3<S> sun_B = Vec3<S>::Zero();    ///< unit, direction to the sun
  Vec3<S> field_N = Vec3<S>::Zero();  ///< T, the field as the orbit and a model of it have it; zero: not known
  Vec3<S> sun_N = Vec3<S>::Zero();    ///< unit, the sun as the almanac has it; zero: not known
  Axes<S> axes;                       ///< the stack sets them
  std::uint32_t event = 0;            ///< counts jumps that no motion explains; the stack sets it
};

/// -> controller
template <class S>
struct Reference {
  Quat<S> q_NR = Quat<S>::Identity();
  Vec3<S> omega_RN_R = Vec3<S>::Zero();     ///< rad/s
  Vec3<S> omegadot_RN_R = Vec3<S>::Zero();  ///< rad/s^2
  EulerState<S> euler;
  Vec3<S> euler_accelerations = Vec3<S>::Zero();  ///< rad/s^2
  std::uint32_t event = 0;                        ///< counts discontinuities (steps)
};

/// observer -> detector, controller, allocator
template <class S>
struct Estimate {
  Tick tick = 0;
  Quat<S> q_NB = Quat<S>::Identity();
  Vec3<S> omega_BN_B = Vec3<S>::Zero();
  VecN<S> h_w;
  EulerState<S> euler;
  VecN<S> effectiveness;              ///< delivered / commanded, one an actuator
  VecN<S> effectiveness_bound;        ///< relative half-width; infinity: never excited
  Vec3<S> d_B = Vec3<S>::Zero();      ///< N m, what effectiveness does not explain
  Axes<S> axes;                       ///< of the measurement
  Vec3<S> field_B = Vec3<S>::Zero();  ///< T, of the measurement; the stack sets it
  bool momentum_valid = true;         ///< of the measurement: h_w was measured at this sample; the stack sets it
  std::uint32_t event = 0;            ///< of the measurement: counts jumps of the state that no motion explains
  Flags status;

  /// Measured state, healthy actuators of unknown certainty, no disturbance: what an observer does not estimate stays so.
  static Estimate healthy(const Measurement<S>& y) noexcept {
    const Eigen::Index n = y.h_w.size();
    Estimate x;
    x.tick = y.tick;
    x.q_NB = y.q_NB;
    x.omega_BN_B = y.omega_BN_B;
    x.h_w = y.h_w;
    x.euler = y.euler;
    x.axes = y.axes;
    x.event = y.event;
    x.effectiveness = VecN<S>::Ones(n);
    x.effectiveness_bound = VecN<S>::Constant(n, std::numeric_limits<S>::infinity());
    return x;
  }
};

/// What is wrong with an actuator, as far as a detector can tell.
enum class FaultClass : std::uint8_t {
  healthy,       ///< nothing declared
  gain,          ///< it delivers a share of the command
  additive,      ///< the command and a torque beside it
  stuck,         ///< a torque of its own, whatever the command
  intermittent,  ///< a fault that comes and goes
  unclear,       ///< a change of no class that could be told yet
};
inline constexpr std::array fault_class_names = {"healthy", "gain", "additive", "stuck", "intermittent", "unclear"};

/// detector -> controller, allocator
template <class S>
struct Detection {
  Mask changed;                                     ///< a change was declared and has not gone
  Mask failed;                                      ///< declared useless
  Mask enabled;                                     ///< may be used
  VecN<S> u_probe;                                  ///< N m, a dither that makes faults visible; empty: none
  std::array<FaultClass, max_actuators> classes{};  ///< of each actuator
  VecN<S> gain, bias;       ///< it delivers gain u + bias (N m) as far as is known; empty: all 1 and 0
  std::uint32_t event = 0;  ///< counts declarations and recoveries

  /// Nothing detected: everything but the spares is enabled.
  static Detection none(const Vehicle<S>& vehicle) noexcept {
    const int n = std::max(vehicle.actuators(), 0);  // or gcc 14 warns of a copy of less than nothing
    Detection det;
    det.enabled = Mask::all(n).without(vehicle.spare);
    det.gain = VecN<S>::Ones(n);
    det.bias = VecN<S>::Zero(n);
    return det;
  }
};

/// controller -> allocator
template <class S>
struct Demand {
  Vec3<S> tau_B = Vec3<S>::Zero();  ///< N m
  VecN<S> u_pref;                   ///< N m, preferred command; empty: zero
  Flags status;
};

/// allocator -> actuators, and as `last` to the others at the next sample
template <class S>
struct Allocation {
  VecN<S> u;                             ///< N m, issued command, inside [u_lo, u_up]
  Vec3<S> demand_B = Vec3<S>::Zero();    ///< N m, what was asked
  Vec3<S> achieved_B = Vec3<S>::Zero();  ///< N m, D diag(effectiveness) u as far as flight knows
  Mask saturated;       ///< commands at a limit of this sample, box or rate; one at rest (u = 0) is not
  S gap = S(0);         ///< certified distance to the optimum, for allocators that optimise
  S worst_case = S(0);  ///< N m, worst residual under the effectiveness bound
  int iterations = 0;
  Flags status;

  static Allocation idle(int n) noexcept {
    Allocation a;
    a.u = VecN<S>::Zero(n);
    return a;
  }
};

}  // namespace gyrostat
