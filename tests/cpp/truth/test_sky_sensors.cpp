// SPDX-License-Identifier: MIT
// Sensors that look at the sun, the Earth and its field: what they show, and when they show nothing.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <string>

#include "gyrostat/core/attitude.hpp"
#include "gyrostat/truth/sensors.hpp"

namespace gyrostat::truth::test_sky_sensors {
namespace {

using V3 = Vec3<double>;
const VecN<double> no_wheels = VecN<double>::Zero(4);

Orbit orbit() {
  OrbitElements e;
  e.semi_major_axis = 6.9e6;
  e.inclination = 0.5;
  e.sun_longitude = 1.0;
  return Orbit(e);
}

double angle(const V3& u, const V3& v) { return std::atan2(u.cross(v).norm(), u.dot(v)); }

/// A body that tumbles, at 1 s for a turn and a half.
struct Tumbling {
  explicit Tumbling(std::vector<Sensor> which, std::uint64_t run = 0)
      : sensors(which, 7, run, false, dt, Mask::all(max_actuators), orbit()) {}
  Measurement<double> next() {
    t = dt * static_cast<double>(k);
    q = quat_exp<double>({0.013 * t, 0, 0}) * quat_exp<double>({0, 0.021 * t, 0});
    past.push_back(q);
    return sensors.measure(k++, q, V3::Zero(), no_wheels);
  }
  static constexpr double dt = 1.0;
  static constexpr Tick samples = 9000;
  Sensors sensors;
  Tick k = 0;
  double t = 0;
  Quat<double> q;
  std::vector<Quat<double>> past;
};

TEST(Magnetometer, ShowsTheFieldWithOffsetAndNoiseAtItsTicks) {
  const V3 offset(1e-7, -2e-7, 3e-7);
  Tumbling body({Magnetometer{.noise = 1e-7, .offset = offset, .every = 5, .phase = 2, .blind = {{100, 200}}}});
  const Orbit where = orbit();
  double sum = 0, squares = 0;
  int shown = 0;
  Measurement<double> before;
  while (body.k < 6000) {
    const Tick k = body.k;
    const Measurement<double> y = body.next();
    EXPECT_EQ(y.field_valid, k >= 2 && (k - 2) % 5 == 0 && !(body.t >= 100 && body.t < 200)) << k;
    EXPECT_EQ(y.field_N, where.field(body.t).B_N);
    if (y.field_valid) {
      const V3 error = (y.field_B - offset - body.q.conjugate() * y.field_N) / 1e-7;
      sum += error.sum();
      squares += error.squaredNorm();
      shown += 3;
    } else if (k > 0) {
      EXPECT_EQ(y.field_B, before.field_B);
    }
    before = y;
  }
  EXPECT_NEAR(sum / shown, 0, 5 / std::sqrt(shown));
  EXPECT_NEAR(squares / shown, 1, 5 * std::sqrt(2.0 / shown));
}

TEST(Magnetometer, IsPerfectOnAnOrbitWhereThereIsNone) {
  Tumbling body({});
  for (int i = 0; i < 10; ++i) {
    const Measurement<double> y = body.next();
    EXPECT_TRUE(y.field_valid);
    EXPECT_FALSE(y.sun_valid);
    EXPECT_LT((y.field_B - body.q.conjugate() * y.field_N).norm(), 1e-19);
  }
  const Measurement<double> nowhere = Sensors({}, 1, 0).measure(0, Quat<double>::Identity(), V3::Zero(), no_wheels);
  EXPECT_FALSE(nowhere.field_valid);
}

TEST(SunSensor, SeesTheSunInItsFieldOfViewWhereItShines) {
  const V3 boresight(1, -1, 2);
  Tumbling body({SunSensor{.noise = 1e-3, .boresight_B = boresight, .field_of_view = 1.2, .blind = {{50, 90}}}});
  const Orbit where = orbit();
  int seen = 0, dark = 0, outside = 0;
  double squares = 0;
  while (body.k < Tumbling::samples) {
    const Measurement<double> y = body.next();
    const V3 sun_B = body.q.conjugate() * where.sun_N();
    const bool in_view = angle(sun_B, boresight) <= 1.2, shines = !where.dark(body.t);
    const bool blind = body.t >= 50 && body.t < 90;
    EXPECT_EQ(y.sun_valid, in_view && shines && !blind) << body.t;
    dark += shines ? 0 : 1;
    outside += in_view ? 0 : 1;
    if (!y.sun_valid) continue;
    EXPECT_NEAR(y.sun_B.norm(), 1, 1e-15);
    EXPECT_EQ(y.sun_N, where.sun_N());
    squares += (y.sun_B - sun_B).squaredNorm();
    ++seen;
  }
  EXPECT_GT(seen, 1000);
  EXPECT_GT(dark, 1000);
  EXPECT_GT(outside, 1000);
  // Across the direction there are two axes of noise; along it nothing is left.
  EXPECT_NEAR(squares / seen / 2e-6, 1, 5 * std::sqrt(1.0 / seen));
}

TEST(SkySensors, HaveDeviatesOfTheirOwn) {
  Tumbling both({SunSensor{.noise = 1e-3}, Magnetometer{.noise = 1e-7}}), sun({SunSensor{.noise = 1e-3}}),
      other({SunSensor{.noise = 1e-3}}, 1);
  for (int i = 0; i < 20; ++i) {
    const Measurement<double> y = both.next(), alone = sun.next(), again = other.next();
    EXPECT_EQ(y.sun_B, alone.sun_B);
    EXPECT_NE(y.sun_B, again.sun_B);
  }
}

TEST(StarTracker, SeesNoStarsNearSunAndEarthWhenItExposes) {
  const Quat<double> q_BS = quat_from_euler<double>({0.4, -1.1, 2.0});
  const StarTracker tracker{.q_BS = q_BS, .latency = 3, .every = 2, .sun_keepout = 0.6, .earth_keepout = 0.3};
  Tumbling body({tracker});
  const Orbit where = orbit();
  int sun = 0, earth = 0, fixes = 0;
  while (body.k < 6000) {
    const Tick k = body.k;
    const Measurement<double> y = body.next();
    if (k < 3 || k % 2 != 0) {
      EXPECT_FALSE(y.attitude_valid);
      continue;
    }
    const V3 boresight = body.past[k - 3] * q_BS * V3(0, 0, 1), r = where.r_N(body.t - 3);
    const bool sunny = angle(boresight, where.sun_N()) < 0.6;
    const bool earthy = angle(boresight, -r) < std::asin(earth::radius / r.norm()) + 0.3;
    EXPECT_EQ(y.attitude_valid, !sunny && !earthy) << k;
    sun += sunny ? 1 : 0;
    earth += earthy ? 1 : 0;
    fixes += y.attitude_valid ? 1 : 0;
  }
  EXPECT_GT(sun, 50);
  EXPECT_GT(earth, 500);
  EXPECT_GT(fixes, 500);
}

TEST(SkySensors, RefuseInOneLineWhatCannotBe) {
  const auto refusal = [](const std::vector<Sensor>& sensors, bool flies = true, double dt = 1) -> std::string {
    try {
      Sensors(sensors, 7, 0, false, dt, Mask::all(4), flies ? std::optional<Orbit>(orbit()) : std::nullopt);
    } catch (const std::invalid_argument& error) {
      return error.what();
    }
    return "accepted";
  };
  EXPECT_EQ(refusal({SunSensor{}}, false), "sensor sun_sensor needs an orbit");
  EXPECT_EQ(refusal({Magnetometer{}}, false), "sensor magnetometer needs an orbit");
  EXPECT_EQ(refusal({StarTracker{.sun_keepout = 0.5}}, false), "sensor star_tracker: sun_keepout needs an orbit");
  EXPECT_EQ(refusal({StarTracker{.earth_keepout = 0.5}}, false), "sensor star_tracker: earth_keepout needs an orbit");
  EXPECT_EQ(refusal({SunSensor{}}, true, 0), "sensor sun_sensor needs the sample period");
  EXPECT_EQ(refusal({SunSensor{.boresight_B = {0, 0, 0}}}),
            "sensor sun_sensor: boresight_B is zero and names no direction");
  EXPECT_EQ(refusal({SunSensor{.field_of_view = 4}}), "sensor sun_sensor: field_of_view must be in [0, pi]");
  EXPECT_EQ(refusal({StarTracker{.sun_keepout = -1}}),
            "sensor star_tracker: sun_keepout and earth_keepout must be in [0, pi]");
  EXPECT_EQ(refusal({Magnetometer{.every = 0}}), "sensor magnetometer: every must be at least 1, phase at least 0");
  EXPECT_NE(refusal({SunSensor{}, SunSensor{}}).find("one sun_sensor"), std::string::npos);
  EXPECT_EQ(refusal({SunSensor{}, Magnetometer{}, StarTracker{.sun_keepout = 0.5}}), "accepted");
}

}  // namespace
}  // namespace gyrostat::truth::test_sky_sensors
