// SPDX-License-Identifier: MIT
// Attitude of two directions, and the filter that lives on them: against reference numbers and its own statistics.
#include "gyrostat/flight/navigators/parts/vector_attitude.hpp"

#include <gtest/gtest.h>

#include <random>

#include "../algebra.hpp"
#include "alone.hpp"
#include "gyrostat/flight/navigators/mekf.hpp"
#include "vehicles.hpp"

namespace gyrostat::test::test_vector_attitude {
namespace {

using V3 = Vec3<double>;
using Two = std::array<Sighting<double>, 2>;

/// Numbers of an independent computation.
Two known_pair() {
  return {{{{0.57099975083964816, -0.1921496645530561, -0.79814647211724721}, {0.6, 0.8, 0}, 1e-4},
           {{0.92253519885645618, -0.014387312980453985, 0.38564467077360365}, {0, 0.28, 0.96}, 1e-3}}};
}

TEST(VectorAttitude, EqualsTheReferenceNumbers) {
  const Two two = known_pair();
  const Quat<double> wanted(0.73962125388287936, 0.18276437318506733, -0.40923582949482767, 0.50207929708031873);
  EXPECT_LT((quest(two).coeffs() - wanted.coeffs()).norm(), 1e-14);
  const V3 row(0.16087172957034929, 0.59309589137179819, 0.78889641288507362);
  EXPECT_LT((dcm(triad(two[0], two[1])).row(0).transpose() - row).norm(), 1e-14);
  const std::array<Sighting<float>, 2> same{{{two[0].seen_B.cast<float>(), two[0].known_N.cast<float>(), 1e-4f},
                                             {two[1].seen_B.cast<float>(), two[1].known_N.cast<float>(), 1e-3f}}};
  // Rounding over the gap below the largest eigenvalue, which is 0.019 of it (1.0100e8 and 0.9910e8): 3e-6, and its direction.
  EXPECT_LT((quest(same).cast<double>().coeffs() - wanted.coeffs()).norm(), 1e-5);
}

struct Random {
  std::mt19937 engine{5};
  std::normal_distribution<double> gauss;
  V3 normals() { return {gauss(engine), gauss(engine), gauss(engine)}; }
  Quat<double> attitude() {
    const V3 v = normals();
    return Quat<double>(gauss(engine), v.x(), v.y(), v.z()).normalized();
  }
  Sighting<double> see(const Quat<double>& q_NB, const V3& known_N, double sigma) {
    return {(q_NB.conjugate() * known_N + sigma * normals()).normalized(), known_N, sigma};
  }
};

TEST(VectorAttitude, OfExactDirectionsIsExactWhateverTheTurn) {
  Random random;
  for (int i = 0; i < 200; ++i) {
    Quat<double> q = random.attitude();
    if (i % 10 == 0) q = Quat<double>(0, q.x(), q.y(), q.z()).normalized();  // half a turn
    const V3 n1 = random.normals().normalized(), n2 = random.normals().normalized();
    const Two two{{random.see(q, n1, 0), random.see(q, n2, 0)}};
    if (!name_an_attitude(two[0], two[1])) continue;
    Two weighed = two;
    weighed[0].sigma = 1e-3;
    weighed[1].sigma = 2e-2;
    // Rounding over the gap of the eigenvalues, 2 (1/400) sin^2 of the angle between the directions, which is 0.1 at least: 9e-12.
    EXPECT_LT(rotation_angle<double>(q.conjugate() * quest(weighed)), 2e-11);
    EXPECT_LT(rotation_angle<double>(q.conjugate() * triad(two[0], two[1])), 1e-12);
  }
}

// 4000 draws: the mean of a normalised square of three numbers has sigma sqrt(6 / 4000) = 0.039.
TEST(VectorAttitude, ItsErrorsAreAsLargeAsTheirCovariances) {
  Random random;
  double of_quest = 0, of_triad = 0;
  const int draws = 4000;
  for (int i = 0; i < draws; ++i) {
    const Quat<double> q = random.attitude();
    const Two two{{random.see(q, {0.6, 0.8, 0}, 2e-3), random.see(q, {0.1, 0.28, 0.955}, 5e-3)}};
    const V3 e = quat_log<double>(quest(two).conjugate() * q),
             f = quat_log<double>(triad(two[0], two[1]).conjugate() * q);
    of_quest += normalised_square(quest_covariance(two), e) / draws;
    of_triad += normalised_square(triad_covariance(two[0], two[1]), f) / draws;
  }
  EXPECT_NEAR(of_quest, 3, 0.2);
  EXPECT_NEAR(of_triad, 3, 0.2);
}

TEST(VectorAttitude, IsNoneOfDirectionsThatAreNearlyOne) {
  Random random;
  const Quat<double> q = random.attitude();
  EXPECT_FALSE(name_an_attitude(random.see(q, {1, 0, 0}, 0), random.see(q, V3(1, 0.09, 0).normalized(), 0)));
  EXPECT_FALSE(name_an_attitude(random.see(q, {1, 0, 0}, 0), random.see(q, {-1, 0, 0}, 0)));
  EXPECT_TRUE(name_an_attitude(random.see(q, {1, 0, 0}, 0), random.see(q, V3(1, 0.11, 0).normalized(), 0)));
}

// ---- the filter -------------------------------------------------------------------------------------------------------------

/// A body that turns, a biased gyro, sun and field; no tracker unless it is asked for.
template <class S>
struct Flight {
  explicit Flight(unsigned seed, int late = 0) : random{std::mt19937(seed), {}}, latency(late) {
    setup.dt = static_cast<S>(dt);
    setup.vehicle =
        vehicle_with<S>(Mat3<S>::Identity() * S(10), Mat3N<S>(Mat3<S>::Identity()), S(0.2), static_cast<S>(dt)).vehicle;
    q = random.attitude();
    bias = 2e-3 * random.normals();
  }

  typename Mekf<S>::Params params() const {
    typename Mekf<S>::Params p(setup);
    p.angle_random_walk = static_cast<S>(s_v);
    p.rate_random_walk = static_cast<S>(s_u);
    p.latency = latency;
    p.sun_noise = static_cast<S>(sun_sigma);
    p.field_noise = static_cast<S>(field_sigma * field);
    return p;
  }
  Alone<Mekf<S>> filter() const { return Alone<Mekf<S>>(unchecked, setup, params()); }

  Measurement<S> next() {
    const auto rate = [](double t) -> V3 {
      return {0.02 * std::sin(0.11 * t), 0.015 * std::cos(0.07 * t), 0.01 * std::sin(0.05 * t + 1)};
    };
    const double t = dt * static_cast<double>(k);
    if (k > 0) {
      for (int j = 0; j < 8; ++j) q = (q * quat_exp<double>(dt / 8 * rate(t - dt + (j + 0.5) / 8 * dt))).normalized();
      bias += s_u * std::sqrt(dt) * random.normals();
    }
    Measurement<S> y;
    y.tick = k++;
    y.attitude_valid = false;
    y.omega_BN_B = (rate(t) + bias + s_v / std::sqrt(dt) * random.normals()).template cast<S>();
    const V3 sun_N = V3(0.6, 0.8, 0), field_N = field * V3(std::cos(2e-3 * t), 0.1, std::sin(2e-3 * t)).normalized();
    const Sighting<double> sun = random.see(q, sun_N, sun_sigma);
    y.sun_valid = sees_sun;
    y.sun_B = (sun_lies ? V3(-sun.seen_B) : sun.seen_B).template cast<S>();
    y.sun_N = sun_N.template cast<S>();
    y.field_valid = true;
    y.field_B = (q.conjugate() * field_N + field_sigma * field * random.normals()).template cast<S>();
    y.field_N = field_N.template cast<S>();
    return y;
  }
  V3 error(const Measurement<S>& out) const {
    return quat_log<double>(out.q_NB.template cast<double>().conjugate() * q);
  }

  Random random;
  int latency;
  Setup<S> setup;
  double dt = 0.5, s_v = 1e-5, s_u = 1e-7, sun_sigma = 1e-2, field_sigma = 2e-2, field = 3e-5;
  Quat<double> q;
  V3 bias;
  Tick k = 0;
  bool sees_sun = true, sun_lies = false;
};

/// 100 runs with biases drawn as believed: normalised errors of six numbers, each mean of sigma sqrt(12 / 100) = 0.35.
TEST(MekfOnDirections, ItsErrorsAreWhatItSaysTheyAre) {
  for (const int latency : {0, 3}) {
    const int runs = 100, length = 600;
    double first = 0, last = 0, all = 0;
    for (unsigned run = 0; run < runs; ++run) {
      Flight<double> flight(200 + run, latency);
      Alone<Mekf<double>> filter = flight.filter();
      for (int k = 0; k < length; ++k) {
        const Measurement<double> y = flight.next(), out = k == 0 ? filter.start(y) : filter.step(y);
        EXPECT_TRUE(out.attitude_valid);
        Eigen::Matrix<double, 6, 1> e;
        e << flight.error(out), flight.bias - filter.bias();
        const double nees = normalised_square(filter.covariance(), e);
        if (k == 0) first += nees / runs;
        if (k == length - 1) last += nees / runs;
        if (k > 100) all += nees / (runs * (length - 101));
      }
      EXPECT_EQ(filter.vectors(), 2);
    }
    EXPECT_NEAR(first, 6, 1.2) << latency;
    EXPECT_NEAR(last, 6, 1.2) << latency;
    EXPECT_NEAR(all, 6, 0.6) << latency;
  }
}

/// A fixed attitude that is known to 0.02 rad and two directions, once: normalised errors of three numbers.
TEST(MekfOnDirections, OneLookIsWorthWhatItSays) {
  double nees = 0;
  const int draws = 2000;
  for (unsigned i = 0; i < draws; ++i) {
    Flight<double> flight(10000 + i);
    Mekf<double>::Params p = flight.params();
    p.attitude0 = 0.02;
    Alone<Mekf<double>> filter(unchecked, flight.setup, p);
    Measurement<double> y = flight.next();
    y.attitude_valid = true;
    y.q_NB = flight.q * quat_exp<double>(0.02 * flight.random.normals());
    y.sun_valid = y.field_valid = false;
    (void)filter.start(y);
    const Measurement<double> out = filter.step(flight.next());
    const V3 e = flight.error(out);
    nees += normalised_square(filter.covariance().topLeftCorner<3, 3>(), e) / draws;
  }
  EXPECT_NEAR(nees, 3, 0.17);  // three sigma of sqrt(6 / 2000)
}

TEST(MekfOnDirections, StartsWithTheFirstPairAndNotWithOneDirection) {
  for (const auto how : {Mekf<double>::Acquisition::quest, Mekf<double>::Acquisition::triad}) {
    Flight<double> flight(3);
    Mekf<double>::Params p = flight.params();
    p.acquisition = how;
    Alone<Mekf<double>> filter(unchecked, flight.setup, p);
    flight.sees_sun = false;
    EXPECT_FALSE(filter.start(flight.next()).attitude_valid);
    EXPECT_EQ(filter.fix(), Fix::not_started);
    flight.sees_sun = true;
    const Measurement<double> out = filter.step(flight.next());
    EXPECT_TRUE(out.attitude_valid);
    EXPECT_EQ(filter.fix(), Fix::first);
    EXPECT_LT(flight.error(out).norm(), 0.1);
    flight.sees_sun = false;
    (void)filter.step(flight.next());
    EXPECT_EQ(filter.vectors(), 1) << "one direction alone goes on helping";
  }
}

TEST(MekfOnDirections, IsDeafToThemUnlessItIsTold) {
  Flight<double> flight(4);
  Alone<Mekf<double>> filter(unchecked, flight.setup, Mekf<double>::Params(flight.setup));
  EXPECT_FALSE(filter.start(flight.next()).attitude_valid);
  EXPECT_FALSE(filter.step(flight.next()).attitude_valid);
  EXPECT_EQ(filter.vectors(), 0);
}

TEST(MekfOnDirections, RejectsASunThatCannotBeAndFindsBackAfterAJump) {
  Flight<double> flight(6);
  Alone<Mekf<double>> filter = flight.filter();
  (void)filter.start(flight.next());
  while (flight.k < 200) (void)filter.step(flight.next());
  flight.sun_lies = true;
  for (int i = 0; i < 20; ++i) {
    const Measurement<double> out = filter.step(flight.next());
    EXPECT_EQ(filter.vectors(), 1) << "the field goes on";
    EXPECT_LT(flight.error(out).norm(), 0.03);
  }
  flight.sun_lies = false;
  const Measurement<double> last = flight.next();
  (void)filter.step(last);
  const V3 bias = filter.bias();
  flight.q = flight.q * quat_exp<double>(0.7 * last.sun_B.cross(last.field_B).normalized());  // both directions move
  int restarted = 0, samples = 0;
  while (restarted == 0 && samples < 10) {
    (void)filter.step(flight.next());
    ++samples;
    restarted += filter.fix() == Fix::restarted ? 1 : 0;
  }
  EXPECT_EQ(samples, 3) << "five rejected directions";
  EXPECT_LT((filter.bias() - bias).norm(), 1e-12) << "the bias is kept";
  EXPECT_LT(flight.error(filter.step(flight.next())).norm(), 0.1);
}

TEST(MekfOnDirections, FloatFollowsDouble) {
  Flight<double> flight(17, 2);
  Flight<float> same(17, 2);
  Alone<Mekf<double>> filter = flight.filter();
  Alone<Mekf<float>> single = same.filter();
  for (int k = 0; k < 2000; ++k) {
    const Measurement<double> y = flight.next(), out = k == 0 ? filter.start(y) : filter.step(y);
    const Measurement<float> z = same.next(), in_float = k == 0 ? single.start(z) : single.step(z);
    ASSERT_EQ(filter.vectors(), single.vectors()) << k;
    EXPECT_LT(rotation_angle<double>(in_float.q_NB.cast<double>().conjugate() * out.q_NB), 2e-4) << k;
    EXPECT_LT((single.bias().cast<double>() - filter.bias()).norm(), 5e-6) << k;
  }
}

}  // namespace
}  // namespace gyrostat::test::test_vector_attitude
