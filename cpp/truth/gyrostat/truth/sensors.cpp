// SPDX-License-Identifier: MIT
#include "gyrostat/truth/sensors.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "gyrostat/core/attitude.hpp"
#include "gyrostat/truth/noise.hpp"

namespace gyrostat::truth {
namespace {

/// Of tachometers one for each three wheels, from the first one on.
enum Stream : std::uint64_t { gyro_stream = 1, attitude_stream = 2, tachometer_stream = 16 };

double quantised(double x, double step) noexcept { return step > 0 ? step * std::round(x / step) : x; }

void check_range(const char* name, double noise, double quantisation, int delay) {
  if (noise >= 0 && quantisation >= 0 && delay >= 0) return;
  throw std::invalid_argument("sensor " + std::string(name) + ": noise, quantisation and delay must not be negative");
}

/// An onset or end within 1e-9 s of a sample happens at it.
bool active(const auto& fault, double t) noexcept { return t >= fault.t_on - 1e-9 && t < fault.t_off - 1e-9; }

}  // namespace

template <class T>
const T& Sensors::DelayLine<T>::through(const T& now) {
  if (!filled_) values_.assign(values_.size(), now);
  filled_ = true;
  values_[next_] = now;
  next_ = (next_ + 1) % values_.size();
  return values_[next_];  // the oldest
}

Sensors::Sensors(const std::vector<Sensor>& sensors, std::uint64_t seed, std::uint64_t run, bool euler, double dt,
                 Mask wheels)
    : seed_(seed), run_(run), euler_(euler), dt_(dt), wheels_(wheels) {
  bool has_gyro = false, has_attitude = false, has_tachometer = false;
  for (const Sensor& sensor : sensors) {
    if (take_fault(sensor)) continue;
    bool& seen = std::holds_alternative<Gyro>(sensor)         ? has_gyro
                 : std::holds_alternative<Tachometer>(sensor) ? has_tachometer
                                                              : has_attitude;
    if (seen) throw std::invalid_argument("sensors: one gyro, one attitude sensor and one tachometer at most");
    seen = true;
    if (const auto* gyro = std::get_if<Gyro>(&sensor)) gyro_ = *gyro;
    if (const auto* attitude = std::get_if<AttitudeSensor>(&sensor)) attitude_ = *attitude;
    if (const auto* tachometer = std::get_if<Tachometer>(&sensor)) tachometer_ = *tachometer;
  }
  check_range(Gyro::name, gyro_.noise, gyro_.quantisation, gyro_.delay);
  check_range(AttitudeSensor::name, attitude_.noise, attitude_.quantisation, attitude_.delay);
  check_range(Tachometer::name, tachometer_.noise, tachometer_.quantisation, tachometer_.delay);
  momenta_ = DelayLine<VecN<double>>(tachometer_.delay);
  rates_ = DelayLine<Vec3<double>>(gyro_.delay);
  attitudes_ = DelayLine<Quat<double>>(attitude_.delay);
  angles_ = DelayLine<Vec3<double>>(attitude_.delay);
}

bool Sensors::take_fault(const Sensor& sensor) {
  const auto take = [&](const auto& fault, auto& list) {
    const std::string who = "sensor " + std::string(fault.name) + ": ";
    if (!(fault.t_on >= 0) || !(fault.t_off > fault.t_on))
      throw std::invalid_argument(who + "t_off must be after t_on");
    if (!(dt_ > 0)) throw std::invalid_argument(who + "needs the sample period");
    list.push_back(fault);
    return true;
  };
  if (const auto* bias = std::get_if<RateBias>(&sensor)) return take(*bias, biases_);
  if (const auto* freeze = std::get_if<RateFreeze>(&sensor)) return take(*freeze, freezes_);
  if (const auto* scale = std::get_if<RateScale>(&sensor)) return take(*scale, scales_);
  if (const auto* dropout = std::get_if<RateDropout>(&sensor)) return take(*dropout, rate_dropouts_);
  if (const auto* dropout = std::get_if<AttitudeDropout>(&sensor)) return take(*dropout, attitude_dropouts_);
  if (const auto* dropout = std::get_if<MomentumDropout>(&sensor)) return take(*dropout, momentum_dropouts_);
  return false;
}

/// A freeze from the first sample on shows the first value.
void Sensors::apply_faults(double t, Vec3<double>& rate) {
  for (const RateScale& fault : scales_) {
    if (active(fault, t)) rate = rate.cwiseProduct(fault.scale).eval();
  }
  for (const RateBias& fault : biases_) {
    if (active(fault, t)) rate += fault.bias;
  }
  for (const RateFreeze& fault : freezes_) {
    if (active(fault, t) && t > 0) rate = shown_;
  }
  shown_ = rate;
}

/// Where a sensor gives nothing, the number that stood there last goes on standing there.
void Sensors::drop_out(Measurement<double>& y) {
  const double t = static_cast<double>(y.tick) * dt_;
  if (rate_dropouts_.empty() && attitude_dropouts_.empty() && momentum_dropouts_.empty()) return;
  const auto any = [t](const auto& faults) {
    return std::any_of(faults.begin(), faults.end(), [t](const auto& fault) { return active(fault, t); });
  };
  y.rate_valid = !any(rate_dropouts_);
  y.attitude_valid = !any(attitude_dropouts_);
  y.momentum_valid = !any(momentum_dropouts_);
  if (t > 0 && !y.rate_valid) {
    y.omega_BN_B = last_.omega_BN_B;
    y.euler.rates = last_.euler.rates;
  }
  if (t > 0 && !y.attitude_valid) {
    y.q_NB = last_.q_NB;
    y.euler.angles = last_.euler.angles;
  }
  if (t > 0 && !y.momentum_valid) y.h_w = last_.h_w;
  last_ = y;
}

Vec3<double> Sensors::rate(Tick tick, const Vec3<double>& omega) {
  Vec3<double> shown = rates_.through(omega) + gyro_.bias;
  if (gyro_.noise > 0) shown += gyro_.noise * standard_normals(seed_, run_, gyro_stream, tick);
  for (double& element : shown) element = quantised(element, gyro_.quantisation);
  apply_faults(static_cast<double>(tick) * dt_, shown);
  return shown;
}

Quat<double> Sensors::attitude(Tick tick, const Quat<double>& q_NB) {
  Quat<double> q = attitudes_.through(q_NB);
  if (attitude_.noise > 0) {
    const Vec3<double> error_B = attitude_.noise * standard_normals(seed_, run_, attitude_stream, tick);
    q = q * small_rotation(error_B);
  }
  if (attitude_.quantisation > 0) {
    for (double& element : q.coeffs()) element = quantised(element, attitude_.quantisation / 2);
    q.normalize();
  }
  return q;
}

Vec3<double> Sensors::angles(Tick tick, const Vec3<double>& angles) {
  Vec3<double> shown = angles_.through(angles);
  if (attitude_.noise > 0) shown += attitude_.noise * standard_normals(seed_, run_, attitude_stream, tick);
  for (double& angle : shown) angle = quantised(angle, attitude_.quantisation);
  return shown;
}

VecN<double> Sensors::momentum(Tick tick, const VecN<double>& h_w) {
  if (tachometer_.noise == 0 && tachometer_.quantisation == 0 && tachometer_.delay == 0) return h_w;
  VecN<double> shown = momenta_.through(h_w);
  Vec3<double> noise = Vec3<double>::Zero();
  for (Eigen::Index i = 0; i < shown.size(); ++i) {
    if (i % 3 == 0 && tachometer_.noise > 0)
      noise = tachometer_.noise *
              standard_normals(seed_, run_, tachometer_stream + static_cast<std::uint64_t>(i / 3), tick);
    if (!wheels_.test(static_cast<int>(i))) continue;
    shown[i] = quantised(shown[i] + noise[i % 3], tachometer_.quantisation);
  }
  return shown;
}

Measurement<double> Sensors::measure(Tick tick, const Quat<double>& q_NB, const Vec3<double>& omega_BN_B,
                                     const VecN<double>& h_w) {
  Measurement<double> y;
  y.tick = tick;
  y.h_w = momentum(tick, h_w);
  y.omega_BN_B = rate(tick, omega_BN_B);
  y.q_NB = attitude(tick, q_NB);
  if (euler_) {
    y.euler.angles = euler(y.q_NB);
    y.euler.rates = euler_rates(y.euler.angles, y.omega_BN_B);
  }
  drop_out(y);
  return y;
}

}  // namespace gyrostat::truth
