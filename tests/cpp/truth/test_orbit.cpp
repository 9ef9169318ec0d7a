// SPDX-License-Identifier: MIT
// Orbit: closed forms of two bodies, field, shadow, each against another way to compute it.
#include "gyrostat/truth/orbit.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "support.hpp"

namespace gyrostat::truth::test_orbit {
namespace {

using V = Vec3<double>;

OrbitElements eccentric() {
  OrbitElements k = test::low_orbit();
  k.semi_major_axis = 20e6;
  k.eccentricity = 0.6;
  k.perigee = 2.1;
  k.sun_longitude = 0.8;
  return k;
}

double relative(const V& a, const V& b) { return (a - b).norm() / b.norm(); }

/// Derivative by central differences, of fourth order.
template <class F>
auto rate_of(const F& f, double t, double h) {
  return ((8 * (f(t + h) - f(t - h)) - (f(t + 2 * h) - f(t - 2 * h))) / (12 * h)).eval();
}

TEST(Orbit, PositionAndFieldOfAnIndependentComputation) {
  const Orbit orbit(test::low_orbit());
  EXPECT_NEAR(orbit.period(), 5668.39, 0.005);
  const V B{-2.0038585943986911e-05, -1.8488950049616697e-05, 1.2552216827201016e-05};
  EXPECT_LT(relative(orbit.field(0).B_N, B), 1e-14);
  const V r{-6.6313049317554537e+03, -1.1561861885407220e+06, 6.7732251522611132e+06};
  EXPECT_LT((orbit.r_N(1200) - r).norm(), 1e-8);
}

/// Energy, areas and Newton's law: r'' = -mu r / r^3.
TEST(Orbit, MovesAsTwoBodiesDo) {
  for (const OrbitElements& elements : {test::low_orbit(), eccentric()}) {
    const Orbit orbit(elements);
    const double a = elements.semi_major_axis, e = elements.eccentricity;
    for (double t = -3e4; t < 3e4; t += 1777) {
      const Orbit::Point p = orbit.at(t);
      EXPECT_NEAR(p.v_N.squaredNorm() / 2 - earth::mu / p.r_N.norm(), -earth::mu / (2 * a), 1e-12 * earth::mu / a) << t;
      EXPECT_NEAR(p.r_N.cross(p.v_N).norm(), std::sqrt(earth::mu * a * (1 - e * e)), 1e-3) << t;
      EXPECT_LT(relative(rate_of([&](double s) { return orbit.at(s).v_N; }, t, 5.0),
                         -earth::mu / std::pow(p.r_N.norm(), 3) * p.r_N),
                1e-9)
          << t;
      EXPECT_LT(relative(rate_of([&](double s) { return orbit.r_N(s); }, t, 5.0), p.v_N), 1e-9) << t;
    }
    EXPECT_LT(relative(orbit.r_N(100 + orbit.period()), orbit.r_N(100)), 1e-13);
  }
}

TEST(Orbit, StartsAtItsArgumentOfLatitude) {
  for (const OrbitElements& elements : {test::low_orbit(), eccentric()}) {
    const Orbit orbit(elements);
    EXPECT_NEAR(orbit.at(0).latitude, 0.35, 1e-15);
    EXPECT_NEAR(std::asin(orbit.r_N(0).normalized().z()), std::asin(std::sin(1.7) * std::sin(0.35)), 1e-15);
  }
}

TEST(Orbit, OrbitalFrameLooksDownAndTurnsAsItSays) {
  for (const OrbitElements& elements : {test::low_orbit(), eccentric()}) {
    const Orbit orbit(elements);
    Quat<double> before = orbit.q_NO(-40);
    for (double t = 0; t < 3 * orbit.period(); t += 40) {
      const Orbit::Point p = orbit.at(t);
      const Quat<double> q = orbit.q_NO(t);
      EXPECT_LT((q * V::UnitZ() + p.r_N.normalized()).norm(), 1e-14);
      EXPECT_LT((q * V::UnitY() + p.r_N.cross(p.v_N).normalized()).norm(), 1e-14);
      EXPECT_GT(q.dot(before), 0) << "the sign goes on at " << t;
      before = q;
      const auto angles = [&](double s) { return V(2 * (q.conjugate() * orbit.q_NO(s)).vec()); };
      EXPECT_LT((rate_of(angles, t, 0.5) - orbit.omega_ON_O(t)).norm(), 1e-10);
      EXPECT_LT((rate_of([&](double s) { return orbit.omega_ON_O(s); }, t, 0.5) - orbit.omegadot_ON_O(t)).norm(),
                1e-13);
    }
  }
}

TEST(Orbit, FieldPointsDownAtTheNorthPoleAndNorthOverTheEquator) {
  OrbitElements polar = test::low_orbit();
  polar.inclination = std::numbers::pi / 2;
  polar.argument_of_latitude = std::numbers::pi / 2;
  const double scale = std::pow(earth::field_radius / polar.semi_major_axis, 3);
  EXPECT_NEAR(Orbit(polar).field(0).B_N.z(), 2 * earth::g10 * scale, 1e-12);
  EXPECT_LT(earth::g10, 0);
  polar.inclination = 0;
  EXPECT_NEAR(Orbit(polar).field(0).B_N.z(), -earth::g10 * scale, 1e-12);
  const double day = full_turn / earth::rate;
  EXPECT_NEAR(day, 86164.1, 0.05);
  EXPECT_NEAR(Orbit(test::low_orbit()).earth_angle(day), 1.2 + full_turn, 1e-12);
}

TEST(Orbit, FieldChangesAsItSays) {
  for (const OrbitElements& elements : {test::low_orbit(), eccentric()}) {
    const Orbit orbit(elements);
    for (double t = 0; t < 2e4; t += 911) {
      const V rate = rate_of([&](double s) { return orbit.field(s).B_N; }, t, 5.0);
      EXPECT_LT(relative(orbit.field(t).rate_N, rate), 1e-7) << t;
    }
  }
}

/// Of the geometry itself, by bisection: is the line to the sun free?
double edge_near(const Orbit& orbit, double lo, double hi) {
  const bool inside = orbit.dark(lo);
  for (int k = 0; k < 100; ++k) (orbit.dark((lo + hi) / 2) == inside ? lo : hi) = (lo + hi) / 2;
  return hi;
}

TEST(Orbit, ShadowsEdgesAreWhereTheGeometryHasThem) {
  OrbitElements other_sun = test::low_orbit();
  other_sun.argument_of_latitude = 2.9;
  other_sun.sun_N = {0.48, -0.6, 0.64};
  EXPECT_NEAR(Orbit(other_sun).next_switch(0), 721.3355360244932, 1e-9);
  for (const OrbitElements& elements : {other_sun, eccentric()}) {
    const Orbit orbit(elements);
    double t = 0;
    bool dark = orbit.dark(t);
    for (int k = 0; k < 12; ++k) {
      const double next = orbit.next_switch(t);
      ASSERT_LT(next - t, orbit.period());
      for (int j = 1; j < 50; ++j) EXPECT_EQ(orbit.dark(t + (next - t) * j / 50), dark) << k;
      EXPECT_NEAR(edge_near(orbit, next - 1, next + 1), next, 1e-6) << k;
      t = next;
      dark = !dark;
    }
  }
}

TEST(Orbit, NoShadowWhereTheSunStandsOverThePlane) {
  OrbitElements k = test::low_orbit();
  k.sun_N = Orbit(k).r_N(0).cross(Orbit(k).at(0).v_N);
  EXPECT_EQ(Orbit(k).next_switch(0), std::numeric_limits<double>::infinity());
  for (double t = 0; t < 6000; t += 60) EXPECT_FALSE(Orbit(k).dark(t));
}

TEST(Orbit, RefusesTheGroundAndASunWithoutDirection) {
  OrbitElements k = test::low_orbit();
  k.eccentricity = 0.1;
  EXPECT_EQ(k.check(), "the orbit passes through the Earth: perigee at 6184080 m, must be > 6378137 m");
  EXPECT_THROW(Orbit{k}, std::invalid_argument);
  k = test::low_orbit();
  k.sun_N.setZero();
  EXPECT_EQ(k.check(), "sun_N has no direction");
}

}  // namespace
}  // namespace gyrostat::truth::test_orbit
