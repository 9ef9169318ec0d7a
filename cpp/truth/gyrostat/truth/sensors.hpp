// SPDX-License-Identifier: MIT
/// @file  Sensors: gyro, attitude sensor or star tracker, sun sensor, magnetometer and tachometers; faults of sensors.
///
/// A sensor that has nothing at a sample says so (`rate_valid`, `attitude_valid`, ...), and what it showed last goes on standing there.
/// Noise is counter-based (Philox, keyed by seed and run; the counter is tick, stream and version): each number depends on
/// its own (seed, run, stream, tick, version) alone, whoever else draws and in whatever order.
#pragma once
#include <cstdint>
#include <limits>
#include <numbers>
#include <optional>
#include <utility>
#include <variant>
#include <vector>

#include "gyrostat/core/params.hpp"
#include "gyrostat/truth/orbit.hpp"

namespace gyrostat::truth {

/// Spans of time, s: rows [t_on, t_off), t_on <= t < t_off.
using Windows = std::vector<std::vector<double>>;

/// Body rate: quantise(clip((1 + scale_factor + misalignment) omega + bias + noise)). Fresh at ticks phase + j every.
struct Gyro {
  static constexpr const char* name = "gyro";
  double noise = 0;
  Vec3<double> bias = Vec3<double>::Zero();
  double quantisation = 0;
  int delay = 0;
  double angle_random_walk = 0, rate_random_walk = 0;
  Vec3<double> scale_factor = Vec3<double>::Zero();
  Mat3<double> misalignment = Mat3<double>::Zero();
  double range = std::numeric_limits<double>::infinity();
  int every = 1, phase = 0;
  Windows dropouts = {};

  static constexpr void describe(auto& p, auto&& field) {
    field(p.noise, Field{"noise", "rad/s", 0, 1e2, "white, one sigma a sample and axis"});
    field(p.bias, Field{"bias", "rad/s", -1e2, 1e2, "at the start, in body axes"});
    field(p.quantisation, Field{"quantisation", "rad/s", 0, 1e2, "size of a step; 0: none"});
    field(p.delay, Field{"delay", "samples", 0, 1000, "age of what is measured"});
    field(p.angle_random_walk, Field{"angle_random_walk", "rad/sqrt(s)", 0, 1e2,
                                     "white noise, instead of `noise`: one sigma times sqrt(every dt)"});
    field(p.rate_random_walk, Field{"rate_random_walk", "rad/s^1.5", 0, 1e2, "of the bias: one sigma over sqrt(dt)"});
    field(p.scale_factor, Field{"scale_factor", "", -0.5, 0.5, "relative error of each axis"});
    field(p.misalignment,
          Field{"misalignment", "", -0.5, 0.5, "what an axis (row) shows of the others (columns); zero diagonal"});
    field(p.range, Field{"range", "rad/s", 1e-9, std::numeric_limits<double>::infinity(),
                         "largest rate shown; with an axis beyond it the rate is not valid"});
    field(p.every, Field{"every", "samples", 1, 1e6, "from one rate to the next"});
    field(p.phase, Field{"phase", "samples", 0, 1e6, "tick of the first rate"});
    field(p.dropouts, Field{"dropouts", "s", 0, std::numeric_limits<double>::infinity(),
                            "rows [t_on, t_off] in which nothing is measured"});
  }
};

/// Attitude: q_NB turned by a small random vector.
struct AttitudeSensor {
  static constexpr const char* name = "attitude";
  double noise = 0, quantisation = 0;
  int delay = 0;

  static constexpr void describe(auto& p, auto&& field) {
    field(p.noise, Field{"noise", "rad", 0, 1, "white, one sigma a sample and axis of the error rotation"});
    field(p.quantisation, Field{"quantisation", "rad", 0, 1,
                                "step of the angle near zero rotation (quaternion elements: half of it); 0: none"});
    field(p.delay, Field{"delay", "samples", 0, 1000, "age of what is measured"});
  }
};

/// Star tracker: q_NB of `latency` samples ago, turned by noise that is given in the tracker's own axes, boresight z. A fix at ticks
/// phase + j every, unless the latency has not filled or, when the stars were seen, it was blind, the body turned too fast, or sun or
/// Earth stood too near to the boresight.
struct StarTracker {
  static constexpr const char* name = "star_tracker";
  Vec3<double> noise = Vec3<double>::Zero();
  Quat<double> q_BS = Quat<double>::Identity();
  int latency = 0, every = 1, phase = 0;
  Windows blind = {};
  double rate_max = std::numeric_limits<double>::infinity();
  double sun_keepout = 0, earth_keepout = 0;
  double outlier_probability = 0, outlier_angle = 0;
  bool flip_sign = false;

  static constexpr void describe(auto& p, auto&& field) {
    field(p.noise, Field{"noise", "rad", 0, 1, "white, one sigma a fix across (x, y) and about (z) the boresight"});
    field(p.q_BS, Field{"q_BS", "", -1.1, 1.1, "mounting: axes of the tracker, boresight z; scalar first"});
    field(p.latency, Field{"latency", "samples", 0, 1000, "age of what is shown; no fix until it has filled"});
    field(p.every, Field{"every", "samples", 1, 1e6, "from one fix to the next"});
    field(p.phase, Field{"phase", "samples", 0, 1e6, "tick of the first fix"});
    field(p.blind, Field{"blind", "s", 0, std::numeric_limits<double>::infinity(),
                         "rows [t_on, t_off] in which no star is seen"});
    field(p.rate_max, Field{"rate_max", "rad/s", 0, std::numeric_limits<double>::infinity(),
                            "body rate above which no star is seen"});
    field(p.sun_keepout, Field{"sun_keepout", "rad", 0, std::numbers::pi,
                               "angle from the sun below which no star is seen; 0: none", "degrees"});
    field(p.earth_keepout, Field{"earth_keepout", "rad", 0, std::numbers::pi,
                                 "angle from the edge of the Earth below which no star is seen; 0: none", "degrees"});
    field(p.outlier_probability, Field{"outlier_probability", "", 0, 1, "of a fix that is wrong and called valid"});
    field(p.outlier_angle, Field{"outlier_angle", "rad", 0, std::numbers::pi,
                                 "turn of an outlier, about an axis drawn from the sphere"});
    field(p.flip_sign, Switch{"flip_sign", "give q or -q, drawn for each fix"});
  }
};

/// Direction to the sun, in body axes: unit(C_BN s_N + noise). New at ticks phase + j every where the sun is in the field of view and
/// shines.
struct SunSensor {
  static constexpr const char* name = "sun_sensor";
  double noise = 0;
  Vec3<double> boresight_B{0, 0, 1};
  double field_of_view = std::numbers::pi;
  int every = 1, phase = 0;
  Windows blind = {};

  static constexpr void describe(auto& p, auto&& field) {
    field(p.noise, Field{"noise", "rad", 0, 1, "white, one sigma a sample and axis of the unit vector"});
    field(p.boresight_B, Field{"boresight_B", "", -1e12, 1e12, "middle of the field of view, of any length"});
    field(p.field_of_view, Field{"field_of_view", "rad", 0, std::numbers::pi,
                                 "half-angle of the cone in which the sun is seen; pi: everywhere", "degrees"});
    field(p.every, Field{"every", "samples", 1, 1e6, "from one direction to the next"});
    field(p.phase, Field{"phase", "samples", 0, 1e6, "tick of the first direction"});
    field(p.blind, Field{"blind", "s", 0, std::numeric_limits<double>::infinity(),
                         "rows [t_on, t_off] in which nothing is seen"});
  }
};

/// Magnetic field in body axes: C_BN B_N + offset + noise. New at ticks phase + j every.
struct Magnetometer {
  static constexpr const char* name = "magnetometer";
  double noise = 0;
  Vec3<double> offset = Vec3<double>::Zero();
  int every = 1, phase = 0;
  Windows blind = {};

  static constexpr void describe(auto& p, auto&& field) {
    field(p.noise, Field{"noise", "T", 0, 1e-3, "white, one sigma a sample and axis"});
    field(p.offset, Field{"offset", "T", -1e-3, 1e-3, "of the vehicle's own magnetism, in body axes"});
    field(p.every, Field{"every", "samples", 1, 1e6, "from one field to the next"});
    field(p.phase, Field{"phase", "samples", 0, 1e6, "tick of the first field"});
    field(p.blind, Field{"blind", "s", 0, std::numeric_limits<double>::infinity(),
                         "rows [t_on, t_off] in which nothing is measured"});
  }
};

/// Tachometers: momentum of each wheel, as it follows from its speed.
struct Tachometer {
  static constexpr const char* name = "tachometer";
  double noise = 0, quantisation = 0;
  int delay = 0;

  static constexpr void describe(auto& p, auto&& field) {
    field(p.noise, Field{"noise", "N m s", 0, 1e6, "white, one sigma a sample and wheel"});
    field(p.quantisation, Field{"quantisation", "N m s", 0, 1e6, "size of a step; 0: none"});
    field(p.delay, Field{"delay", "samples", 0, 1000, "age of what is measured"});
  }
};

namespace detail {
/// What all sensor faults have: from when, until when (t_on <= t < t_off).
constexpr void describe_onset(auto& p, auto&& field) {
  field(p.t_on, Field{"t_on", "s", 0, std::numeric_limits<double>::infinity(), "onset"});
  field(p.t_off, Field{"t_off", "s", 0, std::numeric_limits<double>::infinity(), "end; infinity: permanent"});
}
}  // namespace detail

/// Fault of the rate sensor: a constant is added to what it shows.
struct RateBias {
  static constexpr const char* name = "rate_bias";
  double t_on = 0, t_off = std::numeric_limits<double>::infinity();
  Vec3<double> bias = Vec3<double>::Zero();

  static constexpr void describe(auto& p, auto&& field) {
    detail::describe_onset(p, field);
    field(p.bias, Field{"bias", "rad/s", -1e2, 1e2, "added to each axis"});
  }
};

/// Fault of the rate sensor: it goes on showing what it showed last, in every axis.
struct RateFreeze {
  static constexpr const char* name = "rate_freeze";
  double t_on = 0, t_off = std::numeric_limits<double>::infinity();

  static constexpr void describe(auto& p, auto&& field) { detail::describe_onset(p, field); }
};

/// Fault of the rate sensor: what it shows is multiplied.
struct RateScale {
  static constexpr const char* name = "rate_scale";
  double t_on = 0, t_off = std::numeric_limits<double>::infinity();
  Vec3<double> scale = Vec3<double>::Ones();

  static constexpr void describe(auto& p, auto&& field) {
    detail::describe_onset(p, field);
    field(p.scale, Field{"scale", "", -1e3, 1e3, "factor of each axis; 1 is healthy"});
  }
};

/// Fault of the rate sensor: it gives nothing, and says so. What it shows is what it showed last.
struct RateDropout {
  static constexpr const char* name = "rate_dropout";
  double t_on = 0, t_off = std::numeric_limits<double>::infinity();

  static constexpr void describe(auto& p, auto&& field) { detail::describe_onset(p, field); }
};

/// Fault of the attitude sensor: it gives nothing, and says so. What it shows is what it showed last.
struct AttitudeDropout {
  static constexpr const char* name = "attitude_dropout";
  double t_on = 0, t_off = std::numeric_limits<double>::infinity();

  static constexpr void describe(auto& p, auto&& field) { detail::describe_onset(p, field); }
};

/// Fault of the wheels' speed sensors: they give nothing, and say so. What they show is what they showed last.
struct MomentumDropout {
  static constexpr const char* name = "momentum_dropout";
  double t_on = 0, t_off = std::numeric_limits<double>::infinity();

  static constexpr void describe(auto& p, auto&& field) { detail::describe_onset(p, field); }
};

/// Sensors, one of a kind (an attitude sensor or a star tracker), and faults of sensors, any number. Scale acts first, then bias,
/// freeze, dropout.
using Sensor = std::variant<Gyro, AttitudeSensor, StarTracker, SunSensor, Magnetometer, Tachometer, RateBias,
                            RateFreeze, RateScale, RateDropout, AttitudeDropout, MomentumDropout>;

class Sensors {
 public:
  /// A kind that is not in `sensors` is perfect, the magnetometer on an orbit alone; a sun sensor that is not there is none.
  /// @param euler  fill Measurement::euler too (3-2-1 angles and rates of what was measured)
  /// @param dt  sample period, s, of which faults count their onset
  /// @param wheels  actuators with a tachometer
  /// @param orbit     where sun, Earth and field are; without it there are none
  /// @param versions  of the noise of each second, whole numbers: 0, and after the last one, that of the run; any other is the
  ///                  same noise in all runs of a seed
  /// @throws std::invalid_argument for two of a kind, or parameters that cannot be
  Sensors(const std::vector<Sensor>& sensors, std::uint64_t seed, std::uint64_t run, bool euler = false, double dt = 0,
          Mask wheels = Mask::all(max_actuators), std::optional<Orbit> orbit = {}, std::vector<double> versions = {});

  /// To be called once a sample, in order: delays count calls, and a bias that walks adds up. Until its delay has filled a gyro or
  /// an attitude sensor has measured nothing; tachometers show the first momentum, which was that of before the first command.
  Measurement<double> measure(Tick tick, const Quat<double>& q_NB, const Vec3<double>& omega_BN_B,
                              const VecN<double>& h_w);

  // The parts, for a plant that is measured otherwise: each of them once a sample, then what drops out.
  Vec3<double> rate(Tick tick, const Vec3<double>& omega);
  Quat<double> attitude(Tick tick, const Quat<double>& q_NB, const Vec3<double>& omega_BN_B);
  VecN<double> momentum(Tick tick, const VecN<double>& h_w);
  /// Roll, pitch, yaw: the attitude sensor's error adds to them.
  Vec3<double> angles(Tick tick, const Vec3<double>& angles);
  void drop_out(Measurement<double>& y);

 private:
  /// The last `delay` + 1 values.
  template <class T>
  class DelayLine {
   public:
    explicit DelayLine(int delay) : values_(static_cast<std::size_t>(delay) + 1) {}
    const T& through(const T& now);
    bool full() const noexcept { return calls_ >= values_.size(); }  ///< what comes out went in `delay` calls ago

   private:
    std::vector<T> values_;
    std::size_t next_ = 0, calls_ = 0;
  };

  /// What a star tracker needs of an instant.
  struct Exposure {
    Quat<double> q_NB = Quat<double>::Identity();
    double rate = 0;  ///< rad/s
  };

  void take(const Sensor& sensor);
  bool take_fault(const Sensor& sensor);
  void check() const;
  void check_sky() const;
  Quat<double> tracked(Tick tick, const Exposure& now);
  bool dazzled(double t, const Quat<double>& q_NB) const;
  void see_sky(Measurement<double>& y, const Quat<double>& q_NB);
  void apply_faults(double t, Vec3<double>& rate);
  std::pair<std::uint64_t, std::uint64_t> run_and_version(Tick tick) const noexcept;
  Vec3<double> normals(std::uint64_t stream, Tick tick) const noexcept;

  Gyro gyro_;
  AttitudeSensor attitude_;
  StarTracker tracker_;
  SunSensor sun_sensor_;
  Magnetometer magnetometer_;
  Tachometer tachometer_;
  bool has_tracker_ = false, has_sun_sensor_ = false, has_magnetometer_ = false;
  std::optional<Orbit> orbit_;
  std::uint64_t seed_, run_;
  bool euler_;
  double dt_;
  Mask wheels_;
  std::vector<double> versions_;
  std::vector<RateScale> scales_;
  std::vector<RateBias> biases_;
  std::vector<RateFreeze> freezes_;
  std::vector<RateDropout> rate_dropouts_;
  std::vector<AttitudeDropout> attitude_dropouts_;
  std::vector<MomentumDropout> momentum_dropouts_;
  double rate_noise_ = 0;                           ///< rad/s, one sigma
  Mat3<double> distortion_ = Mat3<double>::Zero();  ///< of the gyro: scale factor and misalignment
  Vec3<double> walk_ = Vec3<double>::Zero();        ///< rad/s, of the gyro's bias
  bool never_silent_ = true;                        ///< every sensor has something new at every sample
  bool rate_fresh_ = true, rate_clipped_ = false, attitude_fresh_ = true;
  Vec3<double> shown_ = Vec3<double>::Zero();  ///< rad/s, by the rate sensor at the sample before
  Vec3<double> sun_shown_B_ = Vec3<double>::Zero(), field_shown_B_ = Vec3<double>::Zero();  ///< likewise; T
  Measurement<double> last_;  ///< at the sample before, where something drops out
  DelayLine<Vec3<double>> rates_{0};
  DelayLine<Quat<double>> attitudes_{0};
  DelayLine<Exposure> exposures_{0};
  DelayLine<Vec3<double>> angles_{0};
  DelayLine<VecN<double>> momenta_{0};
};

}  // namespace gyrostat::truth
