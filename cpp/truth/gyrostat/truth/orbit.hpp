// SPDX-License-Identifier: MIT
/// @file  An Earth orbit and what is seen from it: position, orbital frame, magnetic field, sun and shadow.
///
/// Two bodies. With an orbit the inertial frame N is the Earth's equatorial one: z to the north pole, x to the equinox. The
/// field is the dipole of IGRF-14 at 2025.0 and turns with the Earth; the sun stands still; the shadow is a cylinder.
/// Page: docs/orbit.md
#pragma once
#include <limits>
#include <numbers>
#include <string>
#include <vector>

#include "gyrostat/core/params.hpp"

namespace gyrostat::truth {

namespace earth {
inline constexpr double mu = 3.986004418e14;     ///< m^3/s^2
inline constexpr double radius = 6378137;        ///< m, equatorial: of the shadow and the ground
inline constexpr double rate = 7.292115e-5;      ///< rad/s, against the stars
inline constexpr double obliquity = 0.4090926;   ///< rad, of the ecliptic
inline constexpr double field_radius = 6371200;  ///< m, at which the coefficients hold
inline constexpr double g10 = -29350.0e-9;       ///< T
inline constexpr double g11 = -1410.3e-9, h11 = 4545.5e-9;
}  // namespace earth

/// As a scenario states it; angles at t = 0.
struct OrbitElements {
  static constexpr const char* name = "orbit";
  static constexpr double none = std::numeric_limits<double>::quiet_NaN();
  double semi_major_axis = none, inclination = none;
  double raan = 0, argument_of_latitude = 0, eccentricity = 0, perigee = 0;
  double earth_angle = 0, sun_longitude = 0;
  Vec3<double> sun_N = Vec3<double>::Constant(none);

  static constexpr void describe(auto& p, auto&& field) {
    field(p.semi_major_axis, Field{"semi_major_axis", "m", earth::radius, 1e9, "from the centre of the Earth"});
    field(p.inclination, Field{"inclination", "rad", 0, std::numbers::pi, "to the equator", "degrees"});
    field(p.raan, Field{"raan", "rad", -full_turn, full_turn, "right ascension of the ascending node", "degrees"});
    field(p.argument_of_latitude, Field{"argument_of_latitude", "rad", -full_turn, full_turn,
                                        "angle from the ascending node at t = 0", "degrees"});
    field(p.eccentricity, Field{"eccentricity", "", 0, 0.9, "0: a circle"});
    field(p.perigee,
          Field{"perigee", "rad", -full_turn, full_turn, "from the ascending node to the perigee", "degrees"});
    field(p.earth_angle, Field{"earth_angle", "rad", -full_turn, full_turn,
                               "from x_N to the meridian of Greenwich at t = 0", "degrees"});
    field(p.sun_longitude, Field{"sun_longitude", "rad", -full_turn, full_turn,
                                 "of the sun in the ecliptic, from the equinox", "degrees"});
    field(p.sun_N, Field{"sun_N", "", -1e12, 1e12, "direction of the sun, instead of sun_longitude"});
  }
  /// "" or one line that says what is wrong.
  std::string check() const;
};

class Orbit {
 public:
  /// On the orbit at a time.
  struct Point {
    Vec3<double> r_N, v_N;              ///< m, m/s
    double latitude = 0;                ///< rad, from the ascending node, not wrapped
    double rate = 0, acceleration = 0;  ///< rad/s, rad/s^2, of that
  };

  /// @throws std::invalid_argument with what `check` says
  explicit Orbit(const OrbitElements& elements);

  double mean_motion() const noexcept { return n_; }         ///< rad/s
  double period() const noexcept { return full_turn / n_; }  ///< s

  Point at(double t) const noexcept;
  Vec3<double> r_N(double t) const noexcept { return at(t).r_N; }  ///< m

  /// Attitude of the orbital frame O: z to nadir, y against the orbit's normal, x completes (along track on a circle).
  /// Of continuous sign.
  Quat<double> q_NO(double t) const noexcept;
  Vec3<double> omega_ON_O(double t) const noexcept { return {0, -at(t).rate, 0}; }             ///< rad/s
  Vec3<double> omegadot_ON_O(double t) const noexcept { return {0, -at(t).acceleration, 0}; }  ///< rad/s^2

  /// rad, from x_N to the meridian of Greenwich.
  double earth_angle(double t) const noexcept { return earth_angle_ + earth::rate * t; }

  /// The magnetic field at the vehicle and how it changes there.
  struct Field {
    Vec3<double> B_N = Vec3<double>::Zero(), rate_N = Vec3<double>::Zero();  ///< T, T/s
  };
  Field field(double t) const noexcept;

  const Vec3<double>& sun_N() const noexcept { return sun_N_; }  ///< unit
  bool dark(double t) const noexcept;
  /// First time after t at which the vehicle enters or leaves the shadow; infinite when it never does.
  double next_switch(double t) const noexcept;

 private:
  double eccentric_anomaly(double M) const noexcept;
  double mean_anomaly(double true_anomaly) const noexcept;
  double depth(double latitude) const noexcept;
  void find_shadow();

  double a_, e_, n_, perigee_, latitude_, M_;  ///< latitude_ and mean anomaly M_ at t = 0
  double earth_angle_;
  Vec3<double> P_N_, Q_N_;  ///< to the ascending node, and a quarter turn on
  Vec3<double> sun_N_;
  Quat<double> q_plane_;
  double sun_latitude_ = 0, sun_share_ = 0;  ///< of the sun's projection into the plane
  std::vector<double> edges_;                ///< s, of the shadow in the first turn, from 0 to the period
};

}  // namespace gyrostat::truth
