// SPDX-License-Identifier: MIT
#include "gyrostat/truth/sensors.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "gyrostat/core/attitude.hpp"
#include "gyrostat/truth/noise.hpp"

namespace gyrostat::truth {
namespace {

/// Of tachometers one for each three wheels, from the first one on.
enum Stream : std::uint64_t {
  gyro_stream = 1,
  attitude_stream = 2,
  rate_random_walk_stream = 3,
  tracker_stream = 4,
  outlier_stream = 5,
  sun_stream = 6,
  magnetometer_stream = 7,
  tachometer_stream = 16
};

double quantised(double x, double step) noexcept { return step > 0 ? step * std::round(x / step) : x; }

[[noreturn]] void refuse(const char* sensor, const std::string& what) {
  throw std::invalid_argument("sensor " + std::string(sensor) + ": " + what);
}

void check_range(const char* name, double noise, double quantisation, int delay) {
  if (noise >= 0 && quantisation >= 0 && delay >= 0) return;
  refuse(name, "noise, quantisation and delay must not be negative");
}

void check_schedule(const char* name, int every, int phase) {
  if (every < 1 || phase < 0) refuse(name, "every must be at least 1, phase at least 0");
}

void check_windows(const char* name, const char* key, Windows windows) {
  for (const std::vector<double>& w : windows) {
    if (w.size() != 2)
      refuse(name, std::string(key) + ": a row has " + std::to_string(w.size()) + " numbers; it is [t_on, t_off]");
    if (!(w[0] >= 0) || !(w[1] > w[0])) refuse(name, std::string(key) + ": t_off must be after t_on, and t_on >= 0");
  }
  std::sort(windows.begin(), windows.end());
  for (std::size_t i = 1; i < windows.size(); ++i) {
    if (windows[i][0] < windows[i - 1][1]) refuse(name, std::string(key) + ": windows overlap");
  }
}

/// A direction, uniform on the sphere for uniform u and v in [0, 1).
Vec3<double> on_sphere(double u, double v) noexcept {
  const double z = 2 * u - 1, r = std::sqrt(1 - z * z);
  const detail::OnCircle at = detail::circle(v);
  return {r * at.cosine, r * at.sine, z};
}

/// An onset or end within 1e-9 s of a sample happens at it.
bool within(double t, double t_on, double t_off) noexcept { return t >= t_on - 1e-9 && t < t_off - 1e-9; }
bool active(const auto& fault, double t) noexcept { return within(t, fault.t_on, fault.t_off); }
bool inside(const Windows& windows, double t) noexcept {
  return std::any_of(windows.begin(), windows.end(), [t](const auto& w) { return within(t, w[0], w[1]); });
}

double angle_between(const Vec3<double>& a, const Vec3<double>& b) noexcept {
  return std::atan2(a.cross(b).norm(), a.dot(b));
}

/// At ticks phase + j every.
bool scheduled(Tick tick, int every, int phase) noexcept {
  const auto first = static_cast<Tick>(phase);
  return tick >= first && (tick - first) % static_cast<Tick>(every) == 0;
}

}  // namespace

template <class T>
const T& Sensors::DelayLine<T>::through(const T& now) {
  if (calls_++ == 0) values_.assign(values_.size(), now);
  values_[next_] = now;
  next_ = (next_ + 1) % values_.size();
  return values_[next_];  // the oldest
}

Sensors::Sensors(const std::vector<Sensor>& sensors, std::uint64_t seed, std::uint64_t run, bool euler, double dt,
                 Mask wheels, std::optional<Orbit> orbit, std::vector<double> versions)
    : orbit_(std::move(orbit)),
      seed_(seed),
      run_(run),
      euler_(euler),
      dt_(dt),
      wheels_(wheels),
      versions_(std::move(versions)) {
  int gyros = 0, attitudes = 0, suns = 0, fields = 0, tachometers = 0;
  for (const Sensor& sensor : sensors) {
    if (take_fault(sensor)) continue;
    ++(std::holds_alternative<Gyro>(sensor)           ? gyros
       : std::holds_alternative<SunSensor>(sensor)    ? suns
       : std::holds_alternative<Magnetometer>(sensor) ? fields
       : std::holds_alternative<Tachometer>(sensor)   ? tachometers
                                                      : attitudes);
    if (gyros > 1 || attitudes > 1 || suns > 1 || fields > 1 || tachometers > 1)
      throw std::invalid_argument(
          "sensors: one gyro, one attitude sensor (attitude or star_tracker), one sun_sensor, one magnetometer and one "
          "tachometer at most");
    take(sensor);
  }
  check();
  rate_noise_ = gyro_.angle_random_walk > 0 ? gyro_.angle_random_walk / std::sqrt(gyro_.every * dt_) : gyro_.noise;
  distortion_ = gyro_.misalignment;
  distortion_.diagonal() = gyro_.scale_factor;
  never_silent_ = rate_dropouts_.empty() && attitude_dropouts_.empty() && momentum_dropouts_.empty() && !has_tracker_ &&
                  gyro_.every == 1 && gyro_.phase == 0 && gyro_.dropouts.empty() && std::isinf(gyro_.range) &&
                  gyro_.delay == 0 && attitude_.delay == 0;
  momenta_ = DelayLine<VecN<double>>(tachometer_.delay);
  rates_ = DelayLine<Vec3<double>>(gyro_.delay);
  attitudes_ = DelayLine<Quat<double>>(attitude_.delay);
  angles_ = DelayLine<Vec3<double>>(attitude_.delay);
  exposures_ = DelayLine<Exposure>(tracker_.latency);
}

void Sensors::take(const Sensor& sensor) {
  if (const auto* gyro = std::get_if<Gyro>(&sensor)) gyro_ = *gyro;
  if (const auto* attitude = std::get_if<AttitudeSensor>(&sensor)) attitude_ = *attitude;
  if (const auto* tachometer = std::get_if<Tachometer>(&sensor)) tachometer_ = *tachometer;
  if (const auto* tracker = std::get_if<StarTracker>(&sensor)) {
    tracker_ = *tracker;
    has_tracker_ = true;
  }
  if (const auto* sun_sensor = std::get_if<SunSensor>(&sensor)) {
    sun_sensor_ = *sun_sensor;
    has_sun_sensor_ = true;
  }
  if (const auto* magnetometer = std::get_if<Magnetometer>(&sensor)) {
    magnetometer_ = *magnetometer;
    has_magnetometer_ = true;
  }
}

void Sensors::check() const {
  check_range(Gyro::name, gyro_.noise, gyro_.quantisation, gyro_.delay);
  check_range(AttitudeSensor::name, attitude_.noise, attitude_.quantisation, attitude_.delay);
  check_range(Tachometer::name, tachometer_.noise, tachometer_.quantisation, tachometer_.delay);
  check_range(StarTracker::name, tracker_.noise.minCoeff(), 0, tracker_.latency);
  check_schedule(Gyro::name, gyro_.every, gyro_.phase);
  check_schedule(StarTracker::name, tracker_.every, tracker_.phase);
  check_windows(Gyro::name, "dropouts", gyro_.dropouts);
  check_windows(StarTracker::name, "blind", tracker_.blind);
  if (!(gyro_.angle_random_walk >= 0) || !(gyro_.rate_random_walk >= 0) || !(gyro_.range > 0))
    refuse(Gyro::name, "random walks must not be negative, and the range positive");
  if (gyro_.noise > 0 && gyro_.angle_random_walk > 0) refuse(Gyro::name, "give one of noise and angle_random_walk");
  if (!gyro_.misalignment.diagonal().isZero(0))
    refuse(Gyro::name, "misalignment has a diagonal that is not zero; that is scale_factor");
  const bool timed = gyro_.angle_random_walk > 0 || gyro_.rate_random_walk > 0 || !gyro_.dropouts.empty();
  if (timed && !(dt_ > 0)) refuse(Gyro::name, "needs the sample period");
  if (!tracker_.blind.empty() && !(dt_ > 0)) refuse(StarTracker::name, "needs the sample period");
  if (std::abs(tracker_.q_BS.norm() - 1) > 1e-3) refuse(StarTracker::name, "q_BS is no unit quaternion");
  for (const double v : versions_) {
    if (!(v >= 0) || v > 0x1p53 || v != std::floor(v))
      throw std::invalid_argument("noise_versions: whole numbers from 0 to 2^53 belong there");
  }
  if (!versions_.empty() && !(dt_ > 0)) throw std::invalid_argument("noise_versions: need the sample period");
  if (!(tracker_.rate_max >= 0) || !(tracker_.outlier_probability >= 0) || tracker_.outlier_probability > 1)
    refuse(StarTracker::name, "rate_max must not be negative, and outlier_probability in [0, 1]");
  if (tracker_.outlier_probability > 0 && tracker_.outlier_angle == 0)
    refuse(StarTracker::name, "outlier_probability needs an outlier_angle");
  check_sky();
}

/// What looks at sun, Earth and field.
void Sensors::check_sky() const {
  const auto in_half_turn = [](double angle) { return angle >= 0 && angle <= std::numbers::pi; };
  if (!in_half_turn(tracker_.sun_keepout) || !in_half_turn(tracker_.earth_keepout))
    refuse(StarTracker::name, "sun_keepout and earth_keepout must be in [0, pi]");
  check_range(SunSensor::name, sun_sensor_.noise, 0, 0);
  check_range(Magnetometer::name, magnetometer_.noise, 0, 0);
  check_schedule(SunSensor::name, sun_sensor_.every, sun_sensor_.phase);
  check_schedule(Magnetometer::name, magnetometer_.every, magnetometer_.phase);
  check_windows(SunSensor::name, "blind", sun_sensor_.blind);
  check_windows(Magnetometer::name, "blind", magnetometer_.blind);
  if (!(sun_sensor_.boresight_B.norm() > 1e-9)) refuse(SunSensor::name, "boresight_B is zero and names no direction");
  if (!in_half_turn(sun_sensor_.field_of_view)) refuse(SunSensor::name, "field_of_view must be in [0, pi]");
  const char* asks = tracker_.sun_keepout > 0     ? "star_tracker: sun_keepout"
                     : tracker_.earth_keepout > 0 ? "star_tracker: earth_keepout"
                     : has_sun_sensor_            ? SunSensor::name
                     : has_magnetometer_          ? Magnetometer::name
                                                  : nullptr;
  if (asks == nullptr) return;
  if (!orbit_) throw std::invalid_argument("sensor " + std::string(asks) + " needs an orbit");
  if (!(dt_ > 0)) throw std::invalid_argument("sensor " + std::string(asks) + " needs the sample period");
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
  if (rate_fresh_) shown_ = rate;
}

/// Where a sensor gives nothing, the number that stood there last goes on standing there.
void Sensors::drop_out(Measurement<double>& y) {
  const double t = static_cast<double>(y.tick) * dt_;
  if (never_silent_) return;
  const auto any = [t](const auto& faults) {
    return std::any_of(faults.begin(), faults.end(), [t](const auto& fault) { return active(fault, t); });
  };
  y.rate_valid = rate_fresh_ && !any(rate_dropouts_);
  y.attitude_valid = attitude_fresh_ && !any(attitude_dropouts_);
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
  y.rate_valid = y.rate_valid && !rate_clipped_;
}

std::pair<std::uint64_t, std::uint64_t> Sensors::run_and_version(Tick tick) const noexcept {
  if (versions_.empty()) return {run_, 0};
  const auto second = static_cast<std::size_t>(static_cast<double>(tick) * dt_ + 1e-9);
  if (second >= versions_.size() || versions_[second] == 0) return {run_, 0};
  return {0, static_cast<std::uint64_t>(versions_[second])};
}

Vec3<double> Sensors::normals(std::uint64_t stream, Tick tick) const noexcept {
  const auto [run, version] = run_and_version(tick);
  return standard_normals(seed_, run, stream, tick, version);
}

Vec3<double> Sensors::rate(Tick tick, const Vec3<double>& omega) {
  const double t = static_cast<double>(tick) * dt_;
  Vec3<double> shown = rates_.through(omega);
  rate_fresh_ = rates_.full() && scheduled(tick, gyro_.every, gyro_.phase) && !inside(gyro_.dropouts, t);
  if (!distortion_.isZero(0)) shown += (distortion_ * shown).eval();
  shown += gyro_.bias;
  if (gyro_.rate_random_walk > 0) {
    if (tick > 0) walk_ += gyro_.rate_random_walk * std::sqrt(dt_) * normals(rate_random_walk_stream, tick);
    shown += walk_;
  }
  if (rate_noise_ > 0) shown += rate_noise_ * normals(gyro_stream, tick);
  rate_clipped_ = shown.cwiseAbs().maxCoeff() > gyro_.range;
  if (rate_clipped_) shown = shown.cwiseMax(-gyro_.range).cwiseMin(gyro_.range).eval();
  for (double& element : shown) element = quantised(element, gyro_.quantisation);
  apply_faults(t, shown);
  return shown;
}

/// What the tracker shows of the instant that its latency lets out, with whether it is a fix.
Quat<double> Sensors::tracked(Tick tick, const Exposure& now) {
  const Exposure& seen = exposures_.through(now);
  const double t_seen = (static_cast<double>(tick) - tracker_.latency) * dt_;
  attitude_fresh_ = exposures_.full() && scheduled(tick, tracker_.every, tracker_.phase) &&
                    !inside(tracker_.blind, t_seen) && !(seen.rate > tracker_.rate_max) && !dazzled(t_seen, seen.q_NB);
  const Vec3<double> error_S = tracker_.noise.cwiseProduct(normals(tracker_stream, tick));
  Quat<double> q = seen.q_NB * small_rotation(tracker_.q_BS * error_S);
  if (tracker_.outlier_probability > 0 || tracker_.flip_sign) {
    const auto [run, version] = run_and_version(tick);
    const std::array<double, 4> u = standard_uniforms(seed_, run, outlier_stream, tick, version);
    if (u[0] < tracker_.outlier_probability) q = q * quat_exp<double>(tracker_.outlier_angle * on_sphere(u[1], u[2]));
    if (tracker_.flip_sign && u[3] < 0.5) q.coeffs() = -q.coeffs();
  }
  return q;
}

/// Whether sun or Earth stands too near to the tracker's boresight.
bool Sensors::dazzled(double t, const Quat<double>& q_NB) const {
  if (tracker_.sun_keepout == 0 && tracker_.earth_keepout == 0) return false;
  const Vec3<double> boresight_N = q_NB * tracker_.q_BS.normalized() * Vec3<double>::UnitZ();
  if (angle_between(boresight_N, orbit_->sun_N()) < tracker_.sun_keepout) return true;
  if (tracker_.earth_keepout == 0) return false;
  const Vec3<double> r_N = orbit_->r_N(t);
  return angle_between(boresight_N, -r_N) < std::asin(earth::radius / r_N.norm()) + tracker_.earth_keepout;
}

/// Sun and field: what the sensors show, and where both are.
void Sensors::see_sky(Measurement<double>& y, const Quat<double>& q_NB) {
  if (!orbit_) return;
  const double t = static_cast<double>(y.tick) * dt_;
  const Quat<double> q_BN = q_NB.conjugate();
  y.field_N = orbit_->field(t).B_N;
  y.sun_N = orbit_->sun_N();
  y.field_valid = scheduled(y.tick, magnetometer_.every, magnetometer_.phase) && !inside(magnetometer_.blind, t);
  if (y.field_valid) {
    field_shown_B_ = q_BN * y.field_N + magnetometer_.offset;
    if (magnetometer_.noise > 0) field_shown_B_ += magnetometer_.noise * normals(magnetometer_stream, y.tick);
  }
  y.field_B = field_shown_B_;
  if (!has_sun_sensor_) return;
  const Vec3<double> sun_B = q_BN * y.sun_N;
  y.sun_valid = scheduled(y.tick, sun_sensor_.every, sun_sensor_.phase) && !inside(sun_sensor_.blind, t) &&
                angle_between(sun_B, sun_sensor_.boresight_B) <= sun_sensor_.field_of_view && !orbit_->dark(t);
  if (y.sun_valid) {
    sun_shown_B_ = sun_B;
    if (sun_sensor_.noise > 0) sun_shown_B_ += sun_sensor_.noise * normals(sun_stream, y.tick);
    sun_shown_B_.normalize();
  }
  y.sun_B = sun_shown_B_;
}

Quat<double> Sensors::attitude(Tick tick, const Quat<double>& q_NB, const Vec3<double>& omega_BN_B) {
  if (has_tracker_) return tracked(tick, {q_NB, omega_BN_B.norm()});
  Quat<double> q = attitudes_.through(q_NB);
  attitude_fresh_ = attitudes_.full();
  if (attitude_.noise > 0) {
    const Vec3<double> error_B = attitude_.noise * normals(attitude_stream, tick);
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
  attitude_fresh_ = angles_.full();
  if (attitude_.noise > 0) shown += attitude_.noise * normals(attitude_stream, tick);
  for (double& angle : shown) angle = quantised(angle, attitude_.quantisation);
  return shown;
}

VecN<double> Sensors::momentum(Tick tick, const VecN<double>& h_w) {
  if (tachometer_.noise == 0 && tachometer_.quantisation == 0 && tachometer_.delay == 0) return h_w;
  VecN<double> shown = momenta_.through(h_w);
  Vec3<double> noise = Vec3<double>::Zero();
  for (Eigen::Index i = 0; i < shown.size(); ++i) {
    if (i % 3 == 0 && tachometer_.noise > 0)
      noise = tachometer_.noise * normals(tachometer_stream + static_cast<std::uint64_t>(i / 3), tick);
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
  y.q_NB = attitude(tick, q_NB, omega_BN_B);
  if (euler_) {
    y.euler.angles = euler(y.q_NB);
    y.euler.rates = euler_rates(y.euler.angles, y.omega_BN_B);
  }
  drop_out(y);
  see_sky(y, q_NB);
  return y;
}

}  // namespace gyrostat::truth
