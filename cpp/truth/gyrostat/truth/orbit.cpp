// SPDX-License-Identifier: MIT
#include "gyrostat/truth/orbit.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <stdexcept>

#include "gyrostat/truth/cubic.hpp"

namespace gyrostat::truth {
namespace {

Quat<double> turn(const Vec3<double>& axis, double angle) noexcept {
  const Vec3<double> v = std::sin(angle / 2) * axis;
  return {std::cos(angle / 2), v.x(), v.y(), v.z()};
}

}  // namespace

std::string OrbitElements::check() const {
  const double lowest = semi_major_axis * (1 - eccentricity);
  if (!(lowest > earth::radius)) {
    std::array<char, 96> out{};
    std::snprintf(out.data(), out.size(), "the orbit passes through the Earth: perigee at %.0f m, must be > %.0f m",
                  lowest, earth::radius);
    return out.data();
  }
  if (!sun_N.hasNaN() && !(sun_N.norm() > 0)) return "sun_N has no direction";
  return {};
}

Orbit::Orbit(const OrbitElements& k)
    : a_(k.semi_major_axis),
      e_(k.eccentricity),
      n_(std::sqrt(earth::mu / (a_ * a_ * a_))),
      perigee_(k.perigee),
      latitude_(k.argument_of_latitude),
      M_(mean_anomaly(latitude_ - perigee_)),
      earth_angle_(k.earth_angle) {
  if (const std::string error = k.check(); !error.empty()) throw std::invalid_argument("orbit: " + error);
  const double cO = std::cos(k.raan), sO = std::sin(k.raan), ci = std::cos(k.inclination), si = std::sin(k.inclination);
  P_N_ = {cO, sO, 0};
  Q_N_ = {-sO * ci, cO * ci, si};
  q_plane_ = turn(Vec3<double>::UnitZ(), k.raan) * turn(Vec3<double>::UnitX(), k.inclination);
  const double l = k.sun_longitude;
  const Vec3<double> in_the_ecliptic{std::cos(l), std::cos(earth::obliquity) * std::sin(l),
                                     std::sin(earth::obliquity) * std::sin(l)};
  sun_N_ = k.sun_N.hasNaN() ? in_the_ecliptic : Vec3<double>(k.sun_N.normalized());
  sun_share_ = std::hypot(P_N_.dot(sun_N_), Q_N_.dot(sun_N_));
  sun_latitude_ = std::atan2(Q_N_.dot(sun_N_), P_N_.dot(sun_N_));
  find_shadow();
}

// ---- motion -------------------------------------------------------------------------------------------------------

/// Kepler's equation by Newton, which converges from E = M + e sin M for every e < 0.9.
double Orbit::eccentric_anomaly(double M) const noexcept {
  double E = M + e_ * std::sin(M);
  for (int k = 0; k < 50; ++k) {
    const double step = (E - e_ * std::sin(E) - M) / (1 - e_ * std::cos(E));
    E -= step;
    if (std::abs(step) <= 1e-15 * (1 + std::abs(E))) break;
  }
  return E;
}

/// Of a true one in any turn.
double Orbit::mean_anomaly(double true_anomaly) const noexcept {
  if (e_ == 0) return true_anomaly;
  const double b = e_ / (1 + std::sqrt(1 - e_ * e_));
  const double E = true_anomaly - 2 * std::atan2(b * std::sin(true_anomaly), 1 + b * std::cos(true_anomaly));
  return E - e_ * std::sin(E);
}

Orbit::Point Orbit::at(double t) const noexcept {
  Point p;
  double r = a_, r_rate = 0;
  p.latitude = latitude_ + n_ * t;
  p.rate = n_;
  if (e_ > 0) {
    const double E = eccentric_anomaly(M_ + n_ * t), b = e_ / (1 + std::sqrt(1 - e_ * e_));
    p.latitude = perigee_ + E + 2 * std::atan2(b * std::sin(E), 1 - b * std::cos(E));
    r = a_ * (1 - e_ * std::cos(E));
    r_rate = a_ * a_ * n_ * e_ * std::sin(E) / r;
    p.rate = a_ * a_ * n_ * std::sqrt(1 - e_ * e_) / (r * r);
    p.acceleration = -2 * r_rate * p.rate / r;
  }
  const double c = std::cos(p.latitude), s = std::sin(p.latitude);
  const Vec3<double> up = P_N_ * c + Q_N_ * s, on = Q_N_ * c - P_N_ * s;
  p.r_N = r * up;
  p.v_N = r * p.rate * on;
  if (e_ > 0) p.v_N += r_rate * up;
  return p;
}

Quat<double> Orbit::q_NO(double t) const noexcept {
  static const Quat<double> upright(0.5, -0.5, -0.5, 0.5);  // x_O a quarter turn on, y_O against the normal, z_O down
  return q_plane_ * turn(Vec3<double>::UnitZ(), at(t).latitude) * upright;
}

// ---- field ----------------------------------------------------------------------------------------------------------

Orbit::Field Orbit::field(double t) const noexcept {
  const Point p = at(t);
  const double theta = earth_angle(t), c = std::cos(theta), s = std::sin(theta);
  const Vec3<double> g{c * earth::g11 - s * earth::h11, s * earth::g11 + c * earth::h11, earth::g10};
  const Vec3<double> g_rate = earth::rate * Vec3<double>(-g.y(), g.x(), 0);
  const double r = p.r_N.norm(), r_rate = p.r_N.dot(p.v_N) / r, x = earth::field_radius / r, scale = x * x * x;
  const Vec3<double> e = p.r_N / r, e_rate = (p.v_N - r_rate * e) / r;
  Field f;
  f.B_N = scale * (3 * g.dot(e) * e - g);
  f.rate_N = scale * (3 * ((g_rate.dot(e) + g.dot(e_rate)) * e + g.dot(e) * e_rate) - g_rate);
  f.rate_N -= 3 * r_rate / r * f.B_N;
  return f;
}

// ---- shadow ---------------------------------------------------------------------------------------------------------

/// Positive in the shadow: how far the cosine of the angle to the sun is beyond that of the shadow's edge.
double Orbit::depth(double latitude) const noexcept {
  const double r = a_ * (1 - e_ * e_) / (1 + e_ * std::cos(latitude - perigee_)), sine = earth::radius / r;
  return -sun_share_ * std::cos(latitude - sun_latitude_) - std::sqrt(1 - sine * sine);
}

bool Orbit::dark(double t) const noexcept {
  const Vec3<double> r = r_N(t);
  const double along = r.dot(sun_N_);
  return along < 0 && (r - along * sun_N_).norm() < earth::radius;
}

/// Edges in closed form on a circle; else by bisection between 720 points of the turn: what is shorter than half a degree
/// of an eccentric orbit is not found.
void Orbit::find_shadow() {
  std::vector<double> latitudes;
  if (e_ == 0) {
    const double sine = earth::radius / a_, cosine = std::sqrt(1 - sine * sine);
    if (!(sun_share_ > cosine)) return;
    const double x = std::acos(-cosine / sun_share_);
    latitudes = {sun_latitude_ + x, sun_latitude_ + full_turn - x};
  } else {
    constexpr int points = 720;
    for (int k = 0; k < points; ++k) {
      const double lo = full_turn * k / points, hi = full_turn * (k + 1) / points;
      const bool inside = depth(lo) > 0;
      if ((depth(hi) > 0) == inside) continue;
      latitudes.push_back(bisect(lo, hi, 1e-15, [&](double u) { return (depth(u) > 0) != inside; }));
    }
  }
  for (const double latitude : latitudes) {
    const double t = (mean_anomaly(latitude - perigee_) - M_) / n_;
    edges_.push_back(t - period() * std::floor(t / period()));
  }
  std::sort(edges_.begin(), edges_.end());
}

double Orbit::next_switch(double t) const noexcept {
  double next = std::numeric_limits<double>::infinity();
  for (const double edge : edges_) {
    double turns = std::floor((t - edge) / period());
    while (!(edge + turns * period() > t)) ++turns;
    next = std::min(next, edge + turns * period());
  }
  return next;
}

}  // namespace gyrostat::truth
