// SPDX-License-Identifier: MIT
/// @file  Sensors: gyro and attitude sensor with delay, bias, noise and quantisation, applied in that order.
///
/// Noise is counter-based (Philox, keyed by seed and run; the counter is tick and stream): each number depends on its
/// own (seed, run, stream, tick) alone, whoever else draws and in whatever order.
#pragma once
#include <cstdint>
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

using Sensor = std::variant<Gyro, AttitudeSensor>;

/// Three standard normal numbers of a stream at a tick.
Vec3<double> standard_normals(std::uint64_t seed, std::uint64_t run, std::uint64_t stream, Tick tick) noexcept;

class Sensors {
 public:
  /// A kind that is not in `sensors` is perfect.
  /// @param euler  fill Measurement::euler too (3-2-1 angles and rates of what was measured)
  /// @throws std::invalid_argument for two of a kind, or parameters out of range
  Sensors(const std::vector<Sensor>& sensors, std::uint64_t seed, std::uint64_t run, bool euler = false);

  /// To be called once a sample, in order: delays count calls. Until a delay has filled, the first values are given.
  Measurement<double> measure(Tick tick, const Quat<double>& q_NB, const Vec3<double>& omega_BN_B,
                              const VecN<double>& h_w);

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

  Gyro gyro_;
  AttitudeSensor attitude_;
  std::uint64_t seed_, run_;
  bool euler_;
  DelayLine<Vec3<double>> rates_{0};
  DelayLine<Quat<double>> attitudes_{0};
};

}  // namespace gyrostat::truth
