// SPDX-License-Identifier: MIT
/// @file  Sensors: gyro, attitude sensor and tachometers with delay, bias, noise and quantisation, applied in that order; faults.
///
/// Noise is counter-based (Philox, keyed by seed and run; the counter is tick and stream): each number depends on its
/// own (seed, run, stream, tick) alone, whoever else draws and in whatever order.
#pragma once
#include <cstdint>
#include <limits>
#include <variant>
#include <vector>

#include "gyrostat/core/params.hpp"

namespace gyrostat::truth {

/// Body rate: omega + bias + noise.
struct Gyro {
  static constexpr const char* name = "gyro";
  double noise = 0;
  Vec3<double> bias = Vec3<double>::Zero();
  double quantisation = 0;
  int delay = 0;

  static constexpr void describe(auto& p, auto&& field) {
    field(p.noise, Field{"noise", "rad/s", 0, 1e2, "white, one sigma a sample and axis"});
    field(p.bias, Field{"bias", "rad/s", -1e2, 1e2, "constant, in body axes"});
    field(p.quantisation, Field{"quantisation", "rad/s", 0, 1e2, "size of a step; 0: none"});
    field(p.delay, Field{"delay", "samples", 0, 1000, "age of what is measured"});
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

/// Sensors, one of a kind, and faults of sensors, any number. Scale acts first, then bias, freeze, dropout.
using Sensor = std::variant<Gyro, AttitudeSensor, Tachometer, RateBias, RateFreeze, RateScale, RateDropout,
                            AttitudeDropout, MomentumDropout>;

class Sensors {
 public:
  /// A kind that is not in `sensors` is perfect.
  /// @param euler  fill Measurement::euler too (3-2-1 angles and rates of what was measured)
  /// @param dt  sample period, s, of which faults count their onset
  /// @param wheels  actuators with a tachometer
  /// @throws std::invalid_argument for two of a kind, or parameters out of range
  Sensors(const std::vector<Sensor>& sensors, std::uint64_t seed, std::uint64_t run, bool euler = false, double dt = 0,
          Mask wheels = Mask::all(max_actuators));

  /// To be called once a sample, in order: delays count calls. Until a delay has filled, the first values are given.
  Measurement<double> measure(Tick tick, const Quat<double>& q_NB, const Vec3<double>& omega_BN_B,
                              const VecN<double>& h_w);

  // The parts, for a plant that is measured otherwise: each of them once a sample, then what drops out.
  Vec3<double> rate(Tick tick, const Vec3<double>& omega);
  Quat<double> attitude(Tick tick, const Quat<double>& q_NB);
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

   private:
    std::vector<T> values_;
    std::size_t next_ = 0;
    bool filled_ = false;
  };

  bool take_fault(const Sensor& sensor);
  void apply_faults(double t, Vec3<double>& rate);

  Gyro gyro_;
  AttitudeSensor attitude_;
  Tachometer tachometer_;
  std::uint64_t seed_, run_;
  bool euler_;
  double dt_;
  Mask wheels_;
  std::vector<RateScale> scales_;
  std::vector<RateBias> biases_;
  std::vector<RateFreeze> freezes_;
  std::vector<RateDropout> rate_dropouts_;
  std::vector<AttitudeDropout> attitude_dropouts_;
  std::vector<MomentumDropout> momentum_dropouts_;
  Vec3<double> shown_ = Vec3<double>::Zero();  ///< rad/s, by the rate sensor at the sample before
  Measurement<double> last_;                   ///< at the sample before, where something drops out
  DelayLine<Vec3<double>> rates_{0};
  DelayLine<Quat<double>> attitudes_{0};
  DelayLine<Vec3<double>> angles_{0};
  DelayLine<VecN<double>> momenta_{0};
};

}  // namespace gyrostat::truth
