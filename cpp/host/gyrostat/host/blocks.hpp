// SPDX-License-Identifier: MIT
/// @file  The blocks of a scenario that are no components: vehicle, truth, initial state, run. Data with descriptions.
#pragma once
#include <limits>
#include <vector>

#include "gyrostat/core/params.hpp"
#include "gyrostat/flight/desaturation.hpp"

namespace gyrostat::host {

namespace detail {
inline constexpr double none = std::numeric_limits<double>::quiet_NaN();
inline constexpr double infinite = std::numeric_limits<double>::infinity();
}  // namespace detail

/// The nominal vehicle as a user states it.
struct VehicleBlock {
  static constexpr const char* name = "vehicle";
  Mat3<double> J_B = Mat3<double>::Constant(detail::none);
  Mat3N<double> D_B{3, 0};
  VecN<double> u_max, u_min, u_rate, wheel_inertia, momentum_max;
  Mask magnetorquers, spare;
  double orbit_rate = 0;
  Coordinates coordinates = Coordinates::body;

  static constexpr void describe(auto& p, auto&& field) {
    field(p.J_B,
          Field{"J_B", "kg m^2", -1e9, 1e9, "inertia of the whole vehicle, wheels included; 3 numbers are a diagonal"});
    field(p.D_B,
          Field{"D_B", "", -1e6, 1e6, "actuator axes in columns, body frame; absent with [cmg]: no other actuators"});
    field(p.u_max, Field{"u_max", "N m", -detail::infinite, detail::infinite,
                         "largest command that flight knows of; absent: no limit"});
    field(p.u_min, Field{"u_min", "N m", -detail::infinite, detail::infinite, "smallest command; absent: -u_max"});
    field(p.u_rate, Field{"u_rate", "N m/s", 0, detail::infinite, "fastest change of a command; absent: no limit"});
    field(p.wheel_inertia,
          Field{"wheel_inertia", "kg m^2", 0, 1e6, "axial inertia of each wheel; 0 or absent: ideal torque actuator"});
    field(p.momentum_max, Field{"momentum_max", "N m s", 0, detail::infinite,
                                "of each wheel, as flight knows it: it gives no more there; absent: not known"});
    field(p.magnetorquers,
          Field{"magnetorquers", "", 0, max_actuators - 1,
                "actuators that are a dipole along their column of D_B; commands and limits in A m^2"});
    field(p.spare, Field{"spare", "", 0, max_actuators - 1, "actuators that stay off until a detector enables them"});
    field(p.orbit_rate, Field{"orbit_rate", "rad/s", 0, 1, "of a circular orbit; 0: none"});
    field(p.coordinates,
          Choice{"coordinates", "body|euler_angles", "euler_angles: the printed Euler-angle plant of cao2023"});
  }
};

/// What really flies where it differs from the nominal vehicle.
struct TruthBlock {
  static constexpr const char* name = "truth";
  enum class LimitOn : std::uint8_t { command, output };
  Mat3<double> dJ_B = Mat3<double>::Zero();
  Mat3N<double> dD_B{3, 0};
  VecN<double> u_max, u_min, viscous_friction, coulomb_friction, momentum_max;
  LimitOn limit_on = LimitOn::command;

  static void describe(auto& p, auto&& field) {
    field(p.dJ_B, Field{"dJ_B", "kg m^2", -1e9, 1e9, "true inertia less the nominal"});
    field(p.dD_B, Field{"dD_B", "", -1e6, 1e6, "true actuator axes less the nominal"});
    field(p.u_max, Field{"u_max", "N m", -detail::infinite, detail::infinite, "true limit; absent: the vehicle's"});
    field(p.u_min, Field{"u_min", "N m", -detail::infinite, detail::infinite, "absent: -u_max, or the vehicle's"});
    field(p.limit_on,
          Choice{"limit_on", "command|output", "the limit acts on the command, or on the torque after the faults"});
    field(p.viscous_friction, Field{"viscous_friction", "N m s", 0, 1e6, "of each wheel"});
    field(p.coulomb_friction, Field{"coulomb_friction", "N m", 0, 1e6, "of each wheel"});
    field(p.momentum_max,
          Field{"momentum_max", "N m s", 0, detail::infinite, "of each wheel; absent: the vehicle's, or no limit"});
  }
};

/// Attitude, rate and wheel speeds at t = 0. One of q_NB, mrp and euler; none: identity.
struct InitialBlock {
  static constexpr const char* name = "initial";
  Quat<double> q_NB = Quat<double>::Identity();
  Vec3<double> mrp = Vec3<double>::Constant(detail::none), euler = Vec3<double>::Constant(detail::none);
  Vec3<double> omega_BN_B = Vec3<double>::Zero();
  VecN<double> wheel_speed;

  static constexpr void describe(auto& p, auto&& field) {
    field(p.q_NB, Field{"q_NB", "", -1.1, 1.1, "attitude as a quaternion, scalar first"});
    field(p.mrp, Field{"mrp", "", -1e3, 1e3, "attitude as MRP, instead of q_NB"});
    field(p.euler,
          Field{"euler", "rad", -full_turn, full_turn, "attitude as roll, pitch, yaw, instead of q_NB", "degrees"});
    field(p.omega_BN_B, Field{"omega_BN_B", "rad/s", -1e3, 1e3, "body rate"});
    field(p.wheel_speed,
          Field{"wheel_speed", "rad/s", -1e6, 1e6, "of each wheel relative to the body; absent: at rest"});
  }
};

/// Appendages that bend, on the true vehicle; flight knows nothing of them.
struct FlexibleBlock {
  static constexpr const char* name = "flexible";
  static constexpr int most_modes = 8;
  std::vector<std::vector<double>> delta;
  std::vector<double> omega, xi, eta, eta_rate;

  static constexpr void describe(auto& p, auto&& field) {
    field(p.delta, Field{"delta", "kg^1/2 m", -1e6, 1e6,
                         "coupling of each mode with the body's rotation, modes normalised to unit modal mass; a row a "
                         "mode, up to 8"});
    field(p.omega, Field{"omega", "rad/s", 0, 1e6, "frequency of each mode with the body held, > 0"});
    field(p.xi, Field{"xi", "", 0, 1, "damping ratio of each mode; absent: 0.005"});
    field(p.eta, Field{"eta", "kg^1/2 m", -1e6, 1e6, "displacement of each mode at t = 0; absent: 0"});
    field(p.eta_rate, Field{"eta_rate", "kg^1/2 m/s", -1e6, 1e6, "its rate at t = 0; absent: 0"});
  }
};

/// On/off thrusters. They are the actuators after those of the vehicle's D_B; their axes and limits follow from where they sit.
struct ThrustersBlock {
  static constexpr const char* name = "thrusters";
  enum class Align : std::uint8_t { start, centre };
  enum class Modulator : std::uint8_t { pwm, pwpf, proportional };
  std::vector<std::vector<double>> positions, directions;
  VecN<double> thrust, Isp;
  Vec3<double> centre_of_mass = Vec3<double>::Zero();
  double tick = 0.001, propellant_mass = detail::infinite;
  int min_on = 1, min_off = 1;
  Align align = Align::start;
  Modulator modulator = Modulator::pwm;
  double pwpf_gain = 4.5, pwpf_time_constant = 0.15, pwpf_on = 0.45, pwpf_off = 0.15;

  static constexpr void describe(auto& p, auto&& field) {
    field(p.positions, Field{"positions", "m", -1e3, 1e3, "where each thruster sits, body axes; a row of three each"});
    field(p.directions, Field{"directions", "", -1e3, 1e3,
                              "of the force of each on the body, against its jet; a row of three each, any length"});
    field(p.thrust, Field{"thrust", "N", 0, 1e6, "force of each while its valve is open, > 0"});
    field(p.centre_of_mass, Field{"centre_of_mass", "m", -1e3, 1e3, "of the vehicle, body axes"});
    field(p.tick, Field{"tick", "s", 1e-6, 1e3, "a pulse is a whole number of ticks, a period too"});
    field(p.min_on, Field{"min_on", "", 1, 1e6, "ticks of the shortest pulse; a shorter one is none"});
    field(p.min_off, Field{"min_off", "", 1, 1e6, "ticks of the shortest pause in a period; a shorter one is none"});
    field(p.align, Choice{"align", "start|centre", "where in its period a pulse lies"});
    field(p.modulator,
          Choice{"modulator", "pwm|pwpf|proportional",
                 "pwm: a pulse a period; pwpf: pulse width and frequency, by a lag and a trigger with hysteresis; "
                 "proportional: no valve, thrust as commanded"});
    field(p.pwpf_gain, Field{"pwpf_gain", "", 1e-6, 1e6, "of the lag of the pwpf modulator"});
    field(p.pwpf_time_constant, Field{"pwpf_time_constant", "s", 1e-6, 1e6, "of that lag"});
    field(p.pwpf_on, Field{"pwpf_on", "", 0, 1e6, "its output at which the valve is opened"});
    field(p.pwpf_off, Field{"pwpf_off", "", 0, 1e6, "and at which it is closed, below pwpf_on"});
    field(p.Isp, Field{"Isp", "s", 0, 1e5, "specific impulse of each; absent: 220"});
    field(p.propellant_mass, Field{"propellant_mass", "kg", 0, detail::infinite, "at t = 0; infinity: never runs dry"});
  }
};

/// Control moment gyros: actuators behind those of the vehicle's D_B, known to flight as they are.
struct CmgBlock {
  static constexpr const char* name = "cmg";
  std::vector<std::vector<double>> gimbal_axes, spin_axes;
  VecN<double> rotor_momentum, rate_max, angles, angle_max;

  static constexpr void describe(auto& p, auto&& field) {
    field(p.gimbal_axes, Field{"gimbal_axes", "", -1.1, 1.1, "unit vector along each gimbal axis; a row a gyro"});
    field(p.spin_axes, Field{"spin_axes", "", -1.1, 1.1,
                             "unit vector along each rotor at gimbal angle zero, perpendicular to the gimbal axis"});
    field(p.rotor_momentum, Field{"rotor_momentum", "N m s", 0, 1e9, "of each rotor, > 0"});
    field(p.rate_max,
          Field{"rate_max", "rad/s", 0, 1e6, "fastest gimbal, > 0: commands are limited to rotor_momentum rate_max"});
    field(p.angles, Field{"angles", "rad", -1e6, 1e6, "of each gimbal at t = 0; absent: 0"});
    field(p.angle_max, Field{"angle_max", "rad", 0, detail::infinite,
                             "of the stops of each gimbal, on both sides; flight does not know of them; absent: none"});
  }
};

/// What flight does about momentum, with its magnetorquers.
struct DesaturationBlock : CrossProductDesaturation<double>::Params {
  static constexpr const char* name = "desaturation";
  DesaturationBlock() : Params(Setup<double>{}) {}
};

/// Length, period, seed and number of a run.
struct RunBlock {
  static constexpr const char* name = "run";
  double duration = detail::none, dt = detail::none;
  std::uint64_t seed = 0, run_number = 0;
  std::vector<double> noise_versions;
  bool allow_unstable = false;

  static constexpr void describe(auto& p, auto&& field) {
    field(p.duration, Field{"duration", "s", 0, 1e9, "simulated time, a whole number of periods"});
    field(p.dt, Field{"dt", "s", 1e-6, 1e3, "period of the flight stack"});
    field(p.seed, Field{"seed", "", 0, 9.2e18, "of all noise"});
    field(p.run_number,
          Field{"run_number", "", 0, 9.2e18, "of a flight among many: noise of its own from the same seed"});
    field(p.noise_versions,
          Field{"noise_versions", "", 0, 0x1p53,
                "of the noise of each second, whole numbers; 0, and after the last: the run's own; any other is the "
                "same noise in all runs of a seed"});
    field(p.allow_unstable, Switch{"allow_unstable", "run settings whose check says unstable"});
  }
};

}  // namespace gyrostat::host
