// SPDX-License-Identifier: MIT
/// @file  What the vehicle should do: references with exact derivatives, one struct a kind, data only.
#pragma once
#include <functional>
#include <limits>
#include <numbers>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "gyrostat/core/attitude.hpp"
#include "gyrostat/core/params.hpp"
#include "gyrostat/host/attitude_spline.hpp"
#include "gyrostat/host/direction_frame.hpp"
#include "gyrostat/truth/orbit.hpp"

namespace gyrostat::host {

namespace detail {
inline Vec3<double> absent() { return Vec3<double>::Constant(std::numeric_limits<double>::quiet_NaN()); }
}  // namespace detail

/// Hold one attitude: q_NR, or mrp, or euler.
struct Hold {
  static constexpr const char* name = "hold";
  Quat<double> q_NR = Quat<double>::Identity();
  Vec3<double> mrp = detail::absent(), euler = detail::absent();

  static constexpr void describe(auto& p, auto&& field) {
    field(p.q_NR, Field{"q_NR", "", -1, 1, "attitude as a quaternion, scalar first"});
    field(p.mrp, Field{"mrp", "", -unbounded, unbounded, "attitude as MRP, instead of q_NR"});
    field(p.euler,
          Field{"euler", "rad", -full_turn, full_turn, "attitude as roll, pitch, yaw, instead of q_NR", "degrees"});
  }
};

/// Jump to a new attitude at each time; every jump counts as an event.
struct Steps {
  static constexpr const char* name = "steps";
  std::vector<double> times;
  std::vector<std::vector<double>> euler, mrp;

  static constexpr void describe(auto& p, auto&& field) {
    field(p.times, Field{"times", "s", 0, unbounded,
                         "instants of the jumps, increasing; the first attitude holds before them too"});
    field(p.euler, Field{"euler", "rad", -full_turn, full_turn, "one row [roll, pitch, yaw] a time", "degrees"});
    field(p.mrp, Field{"mrp", "", -unbounded, unbounded, "one row a time, instead of euler"});
  }
};

/// Rest-to-rest slew about the eigenaxis with a quintic angle profile (rate and acceleration zero at both ends).
struct Slew {
  static constexpr const char* name = "slew";
  Vec3<double> from = Vec3<double>::Zero(), to = Vec3<double>::Zero();
  double start = 0, duration = std::numeric_limits<double>::quiet_NaN();

  static constexpr void describe(auto& p, auto&& field) {
    field(p.from, Field{"from_euler", "rad", -full_turn, full_turn, "roll, pitch, yaw before", "degrees"});
    field(p.to, Field{"to_euler", "rad", -full_turn, full_turn, "roll, pitch, yaw after", "degrees"});
    field(p.start, Field{"start", "s", 0, unbounded, "when it begins"});
    field(p.duration, Field{"duration", "s", 1e-9, unbounded, "how long it takes"});
  }
};

/// MRP on sines: sigma_i = offset_i + amplitude_i sin(frequency_i t + phase_i).
struct MrpSine {
  static constexpr const char* name = "mrp_sine";
  Vec3<double> offset = Vec3<double>::Zero(), amplitude = Vec3<double>::Zero(), frequency = Vec3<double>::Zero(),
               phase = Vec3<double>::Zero();

  static constexpr void describe(auto& p, auto&& field) {
    field(p.offset, Field{"offset", "", -10, 10, "mean MRP"});
    field(p.amplitude, Field{"amplitude", "", -10, 10, "of each component"});
    field(p.frequency, Field{"frequency", "rad/s", -1e3, 1e3, "of each component"});
    field(p.phase, Field{"phase", "rad", -unbounded, unbounded, "of each component"});
  }
};

/// Euler angles on sines: angle_i = offset_i + amplitude_i sin(frequency_i t + phase_i).
struct EulerSine {
  static constexpr const char* name = "euler_sine";
  Vec3<double> offset = Vec3<double>::Zero(), amplitude = Vec3<double>::Zero(), frequency = Vec3<double>::Zero(),
               phase = Vec3<double>::Zero();

  static constexpr void describe(auto& p, auto&& field) {
    field(p.offset, Field{"offset", "rad", -full_turn, full_turn, "mean roll, pitch, yaw", "degrees"});
    field(p.amplitude, Field{"amplitude", "rad", -full_turn, full_turn, "of each angle", "degrees"});
    field(p.frequency, Field{"frequency", "rad/s", -1e3, 1e3, "of each angle"});
    field(p.phase, Field{"phase", "rad", -unbounded, unbounded, "of each angle"});
  }
};

/// Body rate of the reference on sines, integrated from an attitude: omega_i = amplitude_i sin(frequency_i t + phase_i).
struct RateSine {
  static constexpr const char* name = "sine";
  Vec3<double> euler = Vec3<double>::Zero(), amplitude = Vec3<double>::Zero(), frequency = Vec3<double>::Zero(),
               phase = Vec3<double>::Zero();

  static constexpr void describe(auto& p, auto&& field) {
    field(p.euler, Field{"euler", "rad", -full_turn, full_turn, "roll, pitch, yaw at the start", "degrees"});
    field(p.amplitude, Field{"amplitude", "rad/s", -10, 10, "of each rate"});
    field(p.frequency, Field{"frequency", "rad/s", -1e3, 1e3, "of each rate"});
    field(p.phase, Field{"phase", "rad", -unbounded, unbounded, "of each rate"});
  }
};

/// Attitudes at times, between them cubics of the rotation vector (attitude_spline.hpp). At rest outside the times.
struct AttitudeTable {
  static constexpr const char* name = "table";
  std::vector<double> times = {};
  std::vector<std::vector<double>> q_NR = {}, omega_RN_R = {};

  static constexpr void describe(auto& p, auto&& field) {
    field(p.times, Field{"times", "s", 0, unbounded, "of the rows, increasing, at least two"});
    field(p.q_NR, Field{"q_NR", "", -1.1, 1.1, "one quaternion a time, scalar first; either sign"});
    field(p.omega_RN_R, Field{"omega_RN_R", "rad/s", -10, 10,
                              "one rate a time, in axes of the reference; absent: from the neighbouring rows"});
  }
};

/// Rest-to-rest turn about a fixed axis: accelerate, coast at the largest rate (or turn back before it is reached), brake.
struct BangBang {
  static constexpr const char* name = "bang_bang";
  Vec3<double> from = Vec3<double>::Zero(), axis = Vec3<double>(0, 0, 1);
  double angle = std::numeric_limits<double>::quiet_NaN(), rate_max = std::numeric_limits<double>::quiet_NaN(),
         acceleration_max = std::numeric_limits<double>::quiet_NaN(), start = 0;

  static constexpr void describe(auto& p, auto&& field) {
    field(p.from, Field{"from_euler", "rad", -full_turn, full_turn, "roll, pitch, yaw before", "degrees"});
    field(p.axis, Field{"axis", "", -unbounded, unbounded, "of the turn, in axes of the reference; of any length"});
    field(p.angle, Field{"angle", "rad", 1e-9, full_turn, "of the turn", "degrees"});
    field(p.rate_max, Field{"rate_max", "rad/s", 1e-9, 10, "largest rate"});
    field(p.acceleration_max, Field{"acceleration_max", "rad/s^2", 1e-12, 100, "acceleration and deceleration"});
    field(p.start, Field{"start", "s", 0, unbounded, "when it begins"});
  }
};

/// The orbital frame O (z to nadir, y against the orbit's normal), or a frame that rests in it.
struct Nadir {
  static constexpr const char* name = "nadir";
  Quat<double> q_OR = Quat<double>::Identity();

  static constexpr void describe(auto& p, auto&& field) {
    field(p.q_OR, Field{"q_OR", "", -1, 1, "attitude in the orbital frame, scalar first"});
  }
};

/// A place on the turning Earth, a sphere of the equator's radius.
struct Site {
  double latitude = std::numeric_limits<double>::quiet_NaN(), longitude = std::numeric_limits<double>::quiet_NaN(),
         altitude = 0;

  static constexpr void describe(auto& p, auto&& field) {
    field(p.latitude,
          Field{"latitude", "rad", -std::numbers::pi / 2, std::numbers::pi / 2, "of the site, geocentric", "degrees"});
    field(p.longitude,
          Field{"longitude", "rad", -full_turn, full_turn, "of the site, to the east of Greenwich", "degrees"});
    field(p.altitude, Field{"altitude", "m", -1e5, 1e5, "of the site above the sphere"});
  }
};

/// Which axes of the reference go with the two directions.
struct PointingAxes {
  Vec3<double> axis, second_axis;

  static constexpr void describe(auto& p, auto&& field) {
    field(p.axis, Field{"axis", "", -unbounded, unbounded, "of the reference, that points there; of any length"});
    field(p.second_axis, Field{"second_axis", "", -unbounded, unbounded,
                               "of the reference, as near to the second direction as it goes"});
  }
};

/// An axis to a place on the Earth, another one along the velocity. The Earth is no obstacle.
struct Target : Site, PointingAxes {
  static constexpr const char* name = "target";
  Target() : PointingAxes{{0, 0, 1}, {1, 0, 0}} {}

  static constexpr void describe(auto& p, auto&& field) {
    Site::describe(p, field);
    PointingAxes::describe(p, field);
  }
};

/// An axis to the sun, another one away from the Earth.
struct SunPointing : PointingAxes {
  static constexpr const char* name = "sun";
  SunPointing() : PointingAxes{{0, 0, 1}, {0, 1, 0}} {}

  static constexpr void describe(auto& p, auto&& field) { PointingAxes::describe(p, field); }
};

/// Two axes along two directions, the first exactly.
struct TwoVector : Site, PointingAxes {
  static constexpr const char* name = "two_vector";
  enum class Direction : std::uint8_t { nadir, zenith, velocity, orbit_normal, sun, site };
  Direction first = Direction::nadir, second = Direction::velocity;

  /// The site, which only the direction of that name needs, is where the meridian of Greenwich meets the equator.
  TwoVector() : PointingAxes{{0, 0, 1}, {1, 0, 0}} { latitude = longitude = 0; }

  static constexpr void describe(auto& p, auto&& field) {
    constexpr const char* directions = "nadir|zenith|velocity|orbit_normal|sun|site";
    field(p.first, Choice{"first", directions, "where `axis` points"});
    field(p.second, Choice{"second", directions, "where `second_axis` points as nearly as it can"});
    PointingAxes::describe(p, field);
    Site::describe(p, field);
  }
};

using ReferenceSpec = std::variant<Hold, Steps, Slew, MrpSine, EulerSine, RateSine, AttitudeTable, BangBang, Nadir,
                                   Target, SunPointing, TwoVector>;

/// Where a reference is flown. Without an orbit, `orbit_rate` alone turns an orbital frame that is N at t = 0.
struct Surroundings {
  std::optional<truth::Orbit> orbit = {};
  double orbit_rate = 0;  ///< rad/s
};

/// A reference in time. Samples must be asked in order of their tick (RateSine integrates, the sign of q_NR goes on).
class ReferencePath {
 public:
  using Function = std::function<Reference<double>(Tick tick, double t)>;

  /// Throws std::invalid_argument with one line.
  ReferencePath(ReferenceSpec spec, double dt, Surroundings around = {}, const std::string& where = "reference");
  /// One that comes from outside: attitude, rate and acceleration are what it returns.
  ReferencePath(Function outside, double dt) : dt_(dt), outside_(std::move(outside)) {}

  /// Refuses a flight on which the two directions of a pointing reference come together, at steps of a quarter of a second.
  /// @throws std::invalid_argument with time and angle
  void survey(Tick ticks) const;

  /// The reference at t = tick dt.
  const Reference<double>& at(Tick tick);

 private:
  void evaluate(Tick tick);
  MovingVector direction(TwoVector::Direction which, double t) const;
  Reference<double> pointed(double t) const;
  Reference<double> over_the_ground(const Nadir& p, double t) const;
  void point(const TwoVector& p);

  ReferenceSpec spec_;
  double dt_;
  Surroundings around_;
  Function outside_;
  std::string where_;
  std::optional<TwoVector> two_vector_;  // Target, SunPointing, TwoVector
  Reference<double> now_;
  Tick next_ = 0;
  std::vector<Quat<double>> stops_;  // Steps: one a time
  AttitudeSpline spline_;            // AttitudeTable
};

}  // namespace gyrostat::host
