// SPDX-License-Identifier: MIT
// References on an orbit against rows of 50-digit arithmetic, in which the attitude alone was differentiated.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <stdexcept>
#include <string>

#include "gyrostat/host/reference.hpp"

namespace gyrostat::host::test_pointing {
namespace {

using V3 = Vec3<double>;
using Direction = TwoVector::Direction;

struct Row {
  double t;
  Quat<double> q;
  V3 omega, omegadot;
};

/// Of the rows: an orbit of mean motion n about an Earth of their own.
constexpr double n = 0.0011, inclination = 0.9, raan = 0.4, u0 = 0.3, a = 6878137, radius = 6371000, W = 7.2921150e-5;

MovingVector turning(const V3& p, const V3& w) { return {p, w.cross(p), w.cross(w.cross(p))}; }

struct Orbiting {
  explicit Orbiting(double t) {
    const double c = std::cos(raan), s = std::sin(raan), ci = std::cos(inclination), si = std::sin(inclination);
    const V3 node(c, s, 0), ahead(-s * ci, c * ci, si);
    const double u = u0 + n * t;
    position = turning(a * (std::cos(u) * node + std::sin(u) * ahead), n * node.cross(ahead));
    velocity = turning(position.v, n * node.cross(ahead));
    const double angle = 1.2 + W * t + 0.15, up = 0.85;
    site =
        turning(radius * V3(std::cos(up) * std::cos(angle), std::cos(up) * std::sin(angle), std::sin(up)), {0, 0, W});
    const double l = 0.8 + 1.99106e-7 * t, eps = 0.4090928;
    sun = turning(V3(std::cos(l), std::sin(l) * std::cos(eps), std::sin(l) * std::sin(eps)),
                  1.99106e-7 * V3(0, -std::sin(eps), std::cos(eps)));
  }
  MovingVector position, velocity, site, sun;
};

/// Relative to the sizes of the numbers: 1e-12 of a rate and of an acceleration; a quaternion of either sign.
void expect_row(const Row& row, const Reference<double>& r) {
  const double sign = r.q_NR.dot(row.q) < 0 ? -1 : 1;
  EXPECT_LT((sign * r.q_NR.coeffs() - row.q.coeffs()).norm(), 1e-14) << row.t;
  EXPECT_LT((r.omega_RN_R - row.omega).norm(), 1e-12 * row.omega.norm()) << row.t;
  EXPECT_LE((r.omegadot_RN_R - row.omegadot).norm(), 1e-12 * row.omegadot.norm()) << row.t;
}

const Row target_rows[] = {{0,
                            {0.81295181077434264, -0.21827883767335612, -0.41164643062213224, 0.34930061342451735},
                            {-2.8432026496086322e-05, -0.00068286304241802018, 0.00018182210193480247},
                            {-3.0670053937613463e-08, -2.5304783616510355e-07, 3.7841541653203258e-07}},
                           {150,
                            {0.78377419200026255, -0.20801205056729707, -0.45134892185763903, 0.37244214787141189},
                            {-3.402814352661476e-05, -0.00073431949018383296, 0.00025342704559264503},
                            {-4.5242253682318788e-08, -4.6021855260254929e-07, 5.9097288838219688e-07}},
                           {600,
                            {0.61728442339185297, -0.16806772463383804, -0.60136524647778589, 0.47861573407369695},
                            {-8.4808207015236867e-05, -0.0018679094298278834, 0.0005750200454316209},
                            {-2.7824167421905693e-07, -1.0233732269624454e-05, -3.2048604169146499e-07}}};

const Row sun_rows[] = {{0,
                         {0.40781834488462637, -0.58293028955322235, -0.13235688911673416, -0.69018702465368098},
                         {1.9907698120402778e-07, -3.3992338388478154e-09, -0.0032407810230821936},
                         {1.1016172517956836e-11, 6.4516490281850377e-10, -3.5817557742920255e-05}},
                        {1234.5,
                         {0.55355075717036573, 0.030736050294063323, 0.59694833011970072, 0.57990477288580444},
                         {-1.6796907922508263e-07, 1.0690924964790426e-07, -0.00010679487216023957},
                         {-1.1417359648895073e-11, -1.7938236342715854e-11, 8.7767621593892145e-08}},
                        {4000,
                         {0.58286998616715591, -0.59673160600029729, 0.033572997289300903, -0.55049688780120998},
                         {1.6686716108581903e-07, -1.0862112956123835e-07, -0.00011682185200069165},
                         {1.2689321521750938e-11, 1.9493730796143122e-11, 1.2629862725862304e-07}}};

TEST(DirectionFrame, EqualsTheRowsOfASite) {
  for (const Row& row : target_rows) {
    const Orbiting at(row.t);
    expect_row(row, DirectionFrame({0, 0, 1}, {1, 0, 0}).frame(at.site - at.position, at.velocity));
  }
}

TEST(DirectionFrame, EqualsTheRowsOfTheSun) {
  for (const Row& row : sun_rows) {
    const Orbiting at(row.t);
    expect_row(row, DirectionFrame({0, 0, 1}, {0, 1, 0}).frame(at.sun, at.position));
  }
}

truth::OrbitElements elements() {
  truth::OrbitElements e;
  e.semi_major_axis = a;
  e.inclination = inclination;
  e.raan = raan;
  e.argument_of_latitude = u0;
  e.earth_angle = 1.2;
  e.sun_longitude = 0.8;
  return e;
}

truth::OrbitElements ellipse() {
  truth::OrbitElements e = elements();
  e.semi_major_axis = 8.5e6;
  e.eccentricity = 0.2;
  e.perigee = 0.7;
  return e;
}

Surroundings on(const truth::OrbitElements& e) { return {truth::Orbit(e), 0}; }

// The attitude depends on the latitude alone: the rows' times are scaled to this Earth's mean motion.
TEST(Nadir, EqualsTheRowsOfTheOrbitalFrame) {
  const truth::Orbit orbit(elements());
  const double scale = n / orbit.mean_motion();
  const Row rows[] = {
      {0, {0.49662762834946561, -0.040466471836782682, -0.78364974941955678, 0.37096702501938617}, {0, -n, 0}, {}},
      {1234.5, {0.10564468352818655, -0.20147400065391002, 0.92172942442322969, -0.31410554922694262}, {0, -n, 0}, {}},
      {4321, {0.9009742964458084, -0.28611040780403052, -0.22133966691338794, 0.23957233467339747}, {0, -n, 0}, {}}};
  for (const Row& row : rows) {
    if (row.t == 0) {
      ReferencePath path(Nadir{}, 1, on(elements()));
      EXPECT_LT((path.at(0).q_NR.coeffs() - row.q.coeffs()).norm(), 1e-14) << "its sign too";
    }
    ReferencePath path(Nadir{}, row.t == 0 ? 1 : row.t * scale, on(elements()));
    Reference<double> r = path.at(row.t == 0 ? 0 : 1);
    r.omega_RN_R *= scale;
    Row same = row;
    same.omegadot = V3::Zero();
    expect_row(same, r);
  }
}

TEST(Nadir, ComesBackAfterAnOrbitWithTheOtherSign) {
  const double period = truth::Orbit(elements()).period();
  ReferencePath path(Nadir{}, period, on(elements()));
  const Quat<double> first = path.at(0).q_NR;
  EXPECT_LT((path.at(1).q_NR.coeffs() + first.coeffs()).norm(), 1e-12);
}

TEST(Nadir, WithoutAnOrbitTurnsAtTheOrbitRateFromN) {
  const Quat<double> q_OR = quat_from_euler<double>({0.1, -0.2, 0.3});
  ReferencePath path(Nadir{q_OR}, 2, Surroundings{{}, 1e-3});
  EXPECT_LT((path.at(0).q_NR.coeffs() - q_OR.coeffs()).norm(), 1e-15);
  const Reference<double> r = path.at(100);
  EXPECT_LT(rotation_angle<double>(r.q_NR.conjugate() * (quat_exp<double>({0, -0.2, 0}) * q_OR)), 1e-14);
  EXPECT_LT((r.omega_RN_R - q_OR.conjugate() * V3(0, -1e-3, 0)).norm(), 1e-18);
}

TwoVector two(Direction first, Direction second) {
  TwoVector p;
  p.first = first;
  p.second = second;
  p.axis = {1, 1, 0};
  p.second_axis = {0, 1, -1};
  p.latitude = 0.85;
  p.longitude = 0.15;
  return p;
}

Target target() {
  Target p;
  p.latitude = 0.85;
  p.longitude = 0.15;
  return p;
}

// Every direction and the orbital frame, on a circle and on an ellipse. Differences over 0.2 s leave h^2/6 of a third derivative, at most
// 5e-5 rad/s^3 where the sun passes near zenith.
TEST(Pointing, RateAndAccelerationAreDerivatives) {
  for (const truth::OrbitElements& e : {elements(), ellipse()}) {
    for (const ReferenceSpec& spec :
         {ReferenceSpec(Nadir{quat_from_euler<double>({0.1, -0.2, 0.3})}), ReferenceSpec(target()),
          ReferenceSpec(SunPointing{}), ReferenceSpec(two(Direction::nadir, Direction::velocity)),
          ReferenceSpec(two(Direction::velocity, Direction::orbit_normal)),
          ReferenceSpec(two(Direction::site, Direction::sun)), ReferenceSpec(two(Direction::zenith, Direction::sun))}) {
      const double h = 0.1;
      ReferencePath path(spec, h, on(e));
      for (Tick k = 2001; k < 20000; k += 2000) {
        const Reference<double> before = path.at(k - 1), now = path.at(k), after = path.at(k + 1);
        const V3 rate = quat_log<double>(before.q_NR.conjugate() * after.q_NR) / (2 * h);
        EXPECT_LT((rate - now.omega_RN_R).norm(), 1e-7) << spec.index() << " tick " << k;
        const V3 acceleration = (after.omega_RN_R - before.omega_RN_R) / (2 * h);
        EXPECT_LT((acceleration - now.omegadot_RN_R).norm(), 1e-7) << spec.index() << " tick " << k;
        EXPECT_GT(before.q_NR.dot(now.q_NR), 0) << "the sign goes on";
      }
    }
  }
}

TEST(Pointing, PutsTheAxesWhereTheyBelong) {
  const truth::Orbit orbit(ellipse());
  ReferencePath path(target(), 10, on(ellipse()));
  TwoVector p = two(Direction::sun, Direction::orbit_normal);
  ReferencePath crooked(p, 10, on(ellipse()));
  for (Tick k = 0; k < 300; k += 7) {
    const double t = 10.0 * static_cast<double>(k), angle = orbit.earth_angle(t) + 0.15;
    const V3 site =
        truth::earth::radius * V3(std::cos(0.85) * std::cos(angle), std::cos(0.85) * std::sin(angle), std::sin(0.85));
    const Quat<double> q = path.at(k).q_NR;
    const V3 sight = (site - orbit.r_N(t)).normalized();
    EXPECT_LT((q * V3(0, 0, 1) - sight).norm(), 1e-14);
    EXPECT_LT(std::abs((q * V3(0, 1, 0)).dot(orbit.at(t).v_N.normalized())), 1e-14) << "x is in the plane of both";
    EXPECT_GT((q * V3(1, 0, 0)).dot(orbit.at(t).v_N), 0);
    const Quat<double> qc = crooked.at(k).q_NR;
    EXPECT_LT((qc * V3(1, 1, 0).normalized() - orbit.sun_N()).norm(), 1e-14);
  }
}

std::string refusal(const ReferenceSpec& spec, const Surroundings& around, Tick ticks = 0) {
  try {
    ReferencePath(spec, 1, around, "reference").survey(ticks);
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "accepted";
}

TEST(Pointing, RefusesInOneLineWhatCannotBe) {
  EXPECT_EQ(refusal(Nadir{}, {}), "reference: nadir needs an orbit, or the vehicle's orbit_rate");
  EXPECT_EQ(refusal(target(), {{}, 1e-3}), "reference: needs an orbit");
  EXPECT_EQ(refusal(SunPointing{}, {}), "reference: needs an orbit");
  EXPECT_EQ(refusal(Target{}, on(elements())), "reference: latitude and longitude of the site are missing");
  TwoVector p = two(Direction::nadir, Direction::sun);
  p.second_axis = -2 * p.axis;
  EXPECT_EQ(refusal(p, on(elements())), "reference: axis and second_axis are one direction; two belong here");
  p.axis.setZero();
  EXPECT_EQ(refusal(p, on(elements())), "reference: axis is zero and names no direction");
  const std::string line = refusal(two(Direction::nadir, Direction::zenith), on(elements()));
  EXPECT_EQ(line.rfind("reference: its two directions are 0.000000 deg from one line at t = 0.000000 s", 0), 0U)
      << line;
}

// The sun in the plane of the orbit passes through zenith once a turn: nothing at first, then a refusal with its time.
TEST(Pointing, SurveysTheFlightForDirectionsThatComeTogether) {
  truth::OrbitElements e = elements();
  const truth::Orbit orbit(e);
  e.sun_N = orbit.r_N(1000);
  EXPECT_EQ(refusal(SunPointing{}, on(e), 900), "accepted");
  const std::string line = refusal(SunPointing{}, on(e), 2000);
  EXPECT_NE(line.find("deg from one line at t = 98"), std::string::npos) << line;  // 1 deg is 16 s before
  ReferencePath path(SunPointing{}, 1, on(e));
  EXPECT_NO_THROW((void)path.at(900));
  EXPECT_THROW((void)path.at(1000), std::invalid_argument);
}

}  // namespace
}  // namespace gyrostat::host::test_pointing
