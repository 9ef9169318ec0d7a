// SPDX-License-Identifier: MIT
#include "gyrostat/host/reference.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "gyrostat/flight/parts/euler_model.hpp"

namespace gyrostat::host {
namespace {

[[noreturn]] void refuse(const std::string& where, const std::string& what) {
  throw std::invalid_argument(where + ": " + what);
}

Vec3<double> wave(const Vec3<double>& offset, const Vec3<double>& amplitude, const Vec3<double>& frequency,
                  const Vec3<double>& phase, double t, int derivative) {
  Vec3<double> out;
  for (int i = 0; i < 3; ++i) {
    const double angle = frequency[i] * t + phase[i];
    switch (derivative) {
      case 0:
        out[i] = offset[i] + amplitude[i] * std::sin(angle);
        break;
      case 1:
        out[i] = amplitude[i] * frequency[i] * std::cos(angle);
        break;
      default:
        out[i] = -amplitude[i] * frequency[i] * frequency[i] * std::sin(angle);
    }
  }
  return out;
}

void evaluate_mrp(const MrpSine& p, double t, Reference<double>& r) {
  const Vec3<double> s = wave(p.offset, p.amplitude, p.frequency, p.phase, t, 0);
  const Vec3<double> sdot = wave(p.offset, p.amplitude, p.frequency, p.phase, t, 1);
  const Vec3<double> sddot = wave(p.offset, p.amplitude, p.frequency, p.phase, t, 2);
  const Mat3<double> G_inv = mrp_rate_matrix_inverse(s);
  r.q_NR = quat_from_mrp(s);
  r.omega_RN_R = G_inv * sdot;
  r.omegadot_RN_R = G_inv * (sddot - mrp_rate_matrix_rate(s, sdot) * r.omega_RN_R);
  r = with_euler(r);
}

void evaluate_euler(const EulerSine& p, double t, Reference<double>& r) {
  r.euler.angles = wave(p.offset, p.amplitude, p.frequency, p.phase, t, 0);
  r.euler.rates = wave(p.offset, p.amplitude, p.frequency, p.phase, t, 1);
  r.euler_accelerations = wave(p.offset, p.amplitude, p.frequency, p.phase, t, 2);
  const Mat3<double> E = euler_rate_matrix(r.euler.angles);
  r.q_NR = quat_from_euler(r.euler.angles);
  r.omega_RN_R = E * r.euler.rates;
  r.omegadot_RN_R = E * r.euler_accelerations + euler_rate_matrix_rate(r.euler.angles, r.euler.rates) * r.euler.rates;
}

void evaluate_slew(const Slew& p, double t, Reference<double>& r) {
  const Quat<double> from = quat_from_euler(p.from);
  const Vec3<double> turn = quat_log<double>(from.conjugate() * quat_from_euler(p.to));  // constant axis in R
  const double x = std::clamp((t - p.start) / p.duration, 0.0, 1.0);
  const double angle = x * x * x * (10 + x * (-15 + 6 * x));
  const double rate = x * x * (30 + x * (-60 + 30 * x)) / p.duration;
  const double acceleration = x * (60 + x * (-180 + 120 * x)) / (p.duration * p.duration);
  r.q_NR = from * quat_exp<double>(angle * turn);
  r.omega_RN_R = rate * turn;
  r.omegadot_RN_R = acceleration * turn;
  r = with_euler(r);
}

/// The acceleration at a sample is that of the interval ahead.
void evaluate_bang_bang(const BangBang& p, double t, Reference<double>& r) {
  const double c = p.acceleration_max, ramp = std::min(p.rate_max / c, std::sqrt(p.angle / c));
  const double coast = p.angle / (c * ramp) - ramp, end = 2 * ramp + coast;
  const double s = t - p.start, at = 1e-9;  // s; a switch within that of a sample happens at it
  double angle = 0, rate = 0, acceleration = 0;
  if (s >= end - at) {
    angle = p.angle;
  } else if (s >= ramp + coast - at) {
    angle = p.angle - c * (end - s) * (end - s) / 2;
    rate = c * (end - s);
    acceleration = -c;
  } else if (s >= ramp - at) {
    angle = c * ramp * (s - ramp / 2);
    rate = c * ramp;
  } else if (s >= -at) {
    angle = c * s * s / 2;
    rate = c * s;
    acceleration = c;
  }
  const Vec3<double> axis = p.axis.normalized();
  r.q_NR = quat_from_euler(p.from) * quat_exp<double>(angle * axis);
  r.omega_RN_R = rate * axis;
  r.omegadot_RN_R = acceleration * axis;
  r = with_euler(r);
}

std::vector<Vec3<double>> rates_of(const AttitudeTable& p, const std::string& where) {
  if (!p.omega_RN_R.empty() && p.omega_RN_R.size() != p.times.size()) {
    refuse(where, std::to_string(p.times.size()) + " times and " + std::to_string(p.omega_RN_R.size()) +
                      " rates; one a time belongs here, or none");
  }
  std::vector<Vec3<double>> out;
  for (const std::vector<double>& row : p.omega_RN_R) {
    if (row.size() != 3) refuse(where, "a rate has " + std::to_string(row.size()) + " numbers; 3 belong here");
    out.emplace_back(row[0], row[1], row[2]);
  }
  return out;
}

AttitudeSpline spline_of(const AttitudeTable& p, const std::string& where) {
  if (p.times.size() < 2 || p.q_NR.size() != p.times.size()) {
    refuse(where, std::to_string(p.times.size()) + " times and " + std::to_string(p.q_NR.size()) +
                      " attitudes; one a time belongs here, at least two");
  }
  std::vector<Quat<double>> rows;
  for (std::size_t i = 0; i < p.times.size(); ++i) {
    const std::vector<double>& q = p.q_NR[i];
    const std::string row = "row " + std::to_string(i);
    if (q.size() != 4) refuse(where, row + " of q_NR has " + std::to_string(q.size()) + " numbers; 4 belong here");
    if (i > 0 && p.times[i] <= p.times[i - 1]) refuse(where, "times must increase");
    rows.emplace_back(q[0], q[1], q[2], q[3]);
    const double norm = rows.back().norm();
    if (std::abs(norm - 1) > 1e-3)
      refuse(where, row + " of q_NR has norm " + std::to_string(norm) + "; a unit quaternion belongs here");
    rows.back().normalize();
  }
  AttitudeSpline spline(p.times, std::move(rows), rates_of(p, where));
  for (std::size_t i = 0; i + 1 < p.times.size(); ++i) {
    if (spline.turn(i) > AttitudeSpline::largest_turn) {
      refuse(where, "from row " + std::to_string(i) + " to the next q_NR turns " + std::to_string(spline.turn(i)) +
                        " rad; at most 2.5 rad, so that the way is clear");
    }
  }
  return spline;
}

}  // namespace

ReferencePath::ReferencePath(ReferenceSpec spec, double dt, Surroundings around, const std::string& where)
    : spec_(std::move(spec)), dt_(dt), around_(std::move(around)), where_(where) {
  if (const Hold* p = std::get_if<Hold>(&spec_)) {
    const bool has_mrp = !p->mrp.hasNaN(), has_euler = !p->euler.hasNaN();
    const bool has_q = p->q_NR.w() != 1.0;
    if (int{has_mrp} + int{has_euler} + int{has_q} > 1) refuse(where, "give one of q_NR, mrp and euler");
    now_.q_NR = has_mrp ? quat_from_mrp(p->mrp) : has_euler ? quat_from_euler(p->euler) : p->q_NR;
    now_ = with_euler(now_);
    if (has_euler) now_.euler.angles = p->euler;
  } else if (const Steps* steps = std::get_if<Steps>(&spec_)) {
    const bool use_mrp = !steps->mrp.empty();
    const std::vector<std::vector<double>>& rows = use_mrp ? steps->mrp : steps->euler;
    if (use_mrp && !steps->euler.empty()) refuse(where, "give one of euler and mrp");
    if (steps->times.empty() || rows.size() != steps->times.size()) {
      refuse(where, std::to_string(steps->times.size()) + " times and " + std::to_string(rows.size()) +
                        " attitudes; one a time belongs here");
    }
    for (std::size_t i = 0; i < rows.size(); ++i) {
      if (rows[i].size() != 3)
        refuse(where, "an attitude has " + std::to_string(rows[i].size()) + " numbers; 3 belong here");
      if (i > 0 && steps->times[i] <= steps->times[i - 1]) refuse(where, "times must increase");
      const Vec3<double> row(rows[i][0], rows[i][1], rows[i][2]);
      stops_.push_back(use_mrp ? quat_from_mrp(row) : quat_from_euler(row));
    }
  } else if (const RateSine* sine = std::get_if<RateSine>(&spec_)) {
    now_.q_NR = quat_from_euler(sine->euler);
  } else if (const AttitudeTable* table = std::get_if<AttitudeTable>(&spec_)) {
    spline_ = spline_of(*table, where);
  } else if (const BangBang* bang = std::get_if<BangBang>(&spec_)) {
    if (!(bang->axis.norm() > 1e-9)) refuse(where, "axis is zero and names no direction");
  } else if (std::holds_alternative<Nadir>(spec_)) {
    if (!around_.orbit && around_.orbit_rate == 0) refuse(where, "nadir needs an orbit, or the vehicle's orbit_rate");
  } else if (const Target* target = std::get_if<Target>(&spec_)) {
    TwoVector directions;
    static_cast<Site&>(directions) = *target;
    static_cast<PointingAxes&>(directions) = *target;
    directions.first = TwoVector::Direction::site;
    point(directions);
  } else if (const SunPointing* sun = std::get_if<SunPointing>(&spec_)) {
    TwoVector directions;
    static_cast<PointingAxes&>(directions) = *sun;
    directions.first = TwoVector::Direction::sun;
    directions.second = TwoVector::Direction::zenith;
    point(directions);
  } else if (const TwoVector* directions = std::get_if<TwoVector>(&spec_)) {
    point(*directions);
  }
}

// ---- pointing on an orbit -------------------------------------------------------------------------------------------

void ReferencePath::point(const TwoVector& p) {
  using D = TwoVector::Direction;
  if (!around_.orbit) refuse(where_, "needs an orbit");
  if (!(p.axis.norm() > 1e-9)) refuse(where_, "axis is zero and names no direction");
  if (!(p.axis.normalized().cross(p.second_axis).norm() > 1e-3 * p.second_axis.norm()))  // NaN and zero too
    refuse(where_, "axis and second_axis are one direction; two belong here");
  if ((p.first == D::site || p.second == D::site) && !p.given())
    refuse(where_, "latitude and longitude of the site are missing");
  two_vector_ = p;
}

/// A vector along it, with its derivatives.
MovingVector ReferencePath::direction(TwoVector::Direction which, double t) const {
  using D = TwoVector::Direction;
  const truth::Orbit& orbit = *around_.orbit;
  const truth::Orbit::Point at = orbit.at(t);
  const double r = at.r_N.norm(), pull = -truth::earth::mu / (r * r * r);
  const MovingVector position{at.r_N, at.v_N, pull * at.r_N};
  switch (which) {
    case D::nadir:
      return -position;
    case D::zenith:
      return position;
    case D::velocity:
      return {position.v, position.a, pull * (at.v_N - 3 * at.r_N.dot(at.v_N) / (r * r) * at.r_N)};
    case D::orbit_normal:
      return {at.r_N.cross(at.v_N), Vec3<double>::Zero(), Vec3<double>::Zero()};
    case D::sun:
      return {orbit.sun_N(), Vec3<double>::Zero(), Vec3<double>::Zero()};
    default: {
      const double angle = orbit.earth_angle(t) + two_vector_->longitude, up = two_vector_->latitude;
      const Vec3<double> e{std::cos(up) * std::cos(angle), std::cos(up) * std::sin(angle), std::sin(up)};
      const Vec3<double> W{0, 0, truth::earth::rate}, site = (truth::earth::radius + two_vector_->altitude) * e;
      return MovingVector{site, W.cross(site), W.cross(W.cross(site))} - position;
    }
  }
}

Reference<double> ReferencePath::pointed(double t) const {
  const MovingVector first = direction(two_vector_->first, t), second = direction(two_vector_->second, t);
  constexpr double least = 0.0174524064372835;  // of 1 deg
  if (const double apart = DirectionFrame::apart(first, second); !(apart > least)) {
    refuse(where_, "its two directions are " + std::to_string(std::asin(apart) * 57.295779513082320877) +
                       " deg from one line at t = " + std::to_string(t) + " s; at least 1 deg belongs there");
  }
  return DirectionFrame(two_vector_->axis, two_vector_->second_axis).frame(first, second);
}

void ReferencePath::survey(Tick ticks) const {
  if (!two_vector_) return;
  const Tick stride = std::max<Tick>({1, static_cast<Tick>(0.25 / dt_), ticks / 200000});
  for (Tick k = 0; k <= ticks; k += stride) (void)pointed(static_cast<double>(k) * dt_);
}

Reference<double> ReferencePath::over_the_ground(const Nadir& p, double t) const {
  Reference<double> r;
  const Quat<double> q_RO = p.q_OR.conjugate();
  if (around_.orbit) {
    r.q_NR = around_.orbit->q_NO(t) * p.q_OR;
    r.omega_RN_R = q_RO * around_.orbit->omega_ON_O(t);
    r.omegadot_RN_R = q_RO * around_.orbit->omegadot_ON_O(t);
  } else {
    const Vec3<double> omega_ON_O{0, -around_.orbit_rate, 0};
    const double half = around_.orbit_rate * t / 2;
    r.q_NR = Quat<double>(std::cos(half), 0, -std::sin(half), 0) * p.q_OR;
    r.omega_RN_R = q_RO * omega_ON_O;
  }
  return r;
}

const Reference<double>& ReferencePath::at(Tick tick) {
  if (tick >= next_) {
    evaluate(tick);
    next_ = tick + 1;
  }
  return now_;
}

void ReferencePath::evaluate(Tick tick) {
  const double t = static_cast<double>(tick) * dt_;
  if (outside_) {
    now_ = with_euler(outside_(tick, t));
    return;
  }
  if (two_vector_) {
    Reference<double> r = pointed(t);
    if (tick > 0 && r.q_NR.dot(now_.q_NR) < 0) r.q_NR.coeffs() = -r.q_NR.coeffs();
    now_ = with_euler(r);
    return;
  }
  if (std::holds_alternative<Hold>(spec_)) return;
  if (const Steps* steps = std::get_if<Steps>(&spec_)) {
    std::uint32_t reached = 0;  // a step within 1e-9 s of a sample happens at it
    while (reached < steps->times.size() && steps->times[reached] <= t + 1e-9) ++reached;
    const std::uint32_t current = reached == 0 ? 0 : reached - 1;
    if (tick == 0 || current != now_.event) {
      now_.q_NR = stops_[current];
      now_.event = current;
      now_ = with_euler(now_);
    }
  } else if (const Slew* slew = std::get_if<Slew>(&spec_)) {
    evaluate_slew(*slew, t, now_);
  } else if (const BangBang* bang = std::get_if<BangBang>(&spec_)) {
    evaluate_bang_bang(*bang, t, now_);
  } else if (const Nadir* nadir = std::get_if<Nadir>(&spec_)) {
    now_ = with_euler(over_the_ground(*nadir, t));
  } else if (std::holds_alternative<AttitudeTable>(spec_)) {
    now_ = with_euler(spline_.at(t));
  } else if (const MrpSine* p = std::get_if<MrpSine>(&spec_)) {
    evaluate_mrp(*p, t, now_);
  } else if (const EulerSine* e = std::get_if<EulerSine>(&spec_)) {
    evaluate_euler(*e, t, now_);
  } else if (const RateSine* s = std::get_if<RateSine>(&spec_)) {
    const auto omega = [&](double time, int d) {
      return wave(Vec3<double>::Zero(), s->amplitude, s->frequency, s->phase, time, d);
    };
    for (Tick k = next_; k <= tick; ++k) {  // fourth-order Magnus step with two Gauss points: exact to O(dt^5)
      if (k == 0) continue;
      const double t0 = static_cast<double>(k - 1) * dt_, mid = t0 + dt_ / 2, offset = dt_ * std::sqrt(3.0) / 6;
      const Vec3<double> a = omega(mid - offset, 0), b = omega(mid + offset, 0);
      now_.q_NR =
          (now_.q_NR * quat_exp<double>(dt_ / 2 * (a + b) + dt_ * dt_ * std::sqrt(3.0) / 12 * a.cross(b))).normalized();
    }
    now_.omega_RN_R = omega(t, 0);
    now_.omegadot_RN_R = omega(t, 1);
    now_ = with_euler(now_);
  }
}

}  // namespace gyrostat::host
