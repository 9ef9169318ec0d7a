// SPDX-License-Identifier: MIT
// The attitude filter against reference rows, closed forms of its steady state, and its own statistics.
#include "gyrostat/flight/navigators/mekf.hpp"

#include <gtest/gtest.h>

#include <random>

#include "../algebra.hpp"
#include "../golden.hpp"
#include "alone.hpp"
#include "vehicles.hpp"

namespace gyrostat::test::test_mekf {
namespace {

using Params = Mekf<double>::Params;

/// Whose usable acceleration is 0.02 rad/s^2 about its axis of largest inertia.
template <class S>
gyrostat::Setup<S> slow_vehicle(S dt) {
  gyrostat::Setup<S> setup;
  setup.dt = dt;
  setup.vehicle = vehicle_with<S>(Mat3<S>::Identity() * S(10), Mat3N<S>(Mat3<S>::Identity()), S(0.2), dt).vehicle;
  return setup;
}

Quat<double> mounting() { return {0.8, 0.36, 0.48, 0.0}; }

TEST(Mekf, EqualsTheReferenceRows) {
  const Golden golden("navigation_mekf.csv");
  const auto setup = slow_vehicle(0.1);
  ASSERT_NEAR(usable_acceleration(setup.vehicle), 0.02, 1e-15);
  Params p(setup);
  p.angle_random_walk = 1e-5;
  p.rate_random_walk = 1e-7;
  p.attitude_noise = {2e-5, 2e-5, 1.2e-4};
  p.q_BS = mounting();
  p.latency = 2;
  Alone<Mekf<double>> filter(unchecked, setup, p);
  for (std::size_t k = 0; k < 20; ++k) {
    const auto v = [&](const char* name) { return golden.at(name, k); };
    Measurement<double> y;
    y.tick = k;
    y.omega_BN_B = {v("gyro_x"), v("gyro_y"), v("gyro_z")};
    y.rate_valid = v("rate_valid") != 0;
    y.q_NB = Quat<double>(v("st_w"), v("st_x"), v("st_y"), v("st_z"));
    y.attitude_valid = v("attitude_valid") != 0;
    const Measurement<double> out = k == 0 ? filter.start(y) : filter.step(y);
    EXPECT_EQ(static_cast<int>(filter.fix()), static_cast<int>(v("code"))) << k;
    EXPECT_EQ(out.attitude_valid, v("code") >= 0) << k;
    EXPECT_EQ(out.rate_valid, y.rate_valid) << k;
    if (v("code") < 0) continue;
    const Quat<double> wanted(v("q_w"), v("q_x"), v("q_y"), v("q_z"));
    EXPECT_LT((out.q_NB.coeffs() - wanted.coeffs()).norm(), 1e-12) << k;
    EXPECT_LT((out.omega_BN_B - Vec3<double>(v("w_x"), v("w_y"), v("w_z"))).norm(), 1e-13) << k;
    EXPECT_LT((filter.bias() - Vec3<double>(v("b_x"), v("b_y"), v("b_z"))).norm(), 1e-13) << k;
    if (v("code") >= 2) {
      EXPECT_NEAR(filter.nis(), v("nis"), 1e-9 * (1 + v("nis"))) << k;
    }
    const auto P = filter.covariance();
    for (int r = 0; r < 6; ++r) {
      for (int c = r; c < 6; ++c) {
        const std::string name = "P" + std::to_string(r) + std::to_string(c);
        EXPECT_LT(std::abs(P(r, c) - golden.at(name, k)) / std::sqrt(P(r, r) * P(c, c)), 1e-10) << k << name;
      }
    }
  }
}

/// A body that turns smoothly; a gyro with a bias that walks; a tracker every `every` samples, `latency` samples late.
template <class S>
struct Flight {
  explicit Flight(unsigned seed, double period = 0.05, int fix_every = 10, int late_by = 0)
      : random(seed), dt(period), every(fix_every), latency(late_by), history(static_cast<std::size_t>(late_by) + 1) {}

  double normal() { return gauss(random); }
  Vec3<double> normals() { return {normal(), normal(), normal()}; }

  /// One sample later.
  Measurement<S> next() {
    const auto rate = [&](double t) -> Vec3<double> {
      return Vec3<double>(0.02 * std::sin(0.11 * t), 0.015 * std::cos(0.07 * t), 0.01 * std::sin(0.05 * t + 1)) * moves;
    };
    if (k > 0) {
      const int pieces = 8;  // of the truth, in a sample
      for (int j = 0; j < pieces; ++j) {
        const double t = dt * (static_cast<double>(k - 1) + (j + 0.5) / pieces);
        q = (q * quat_exp<double>(dt / pieces * rate(t))).normalized();
      }
      bias += s_u * std::sqrt(dt) * normals();
    }
    omega = rate(dt * static_cast<double>(k));
    history[k % history.size()] = q;
    Measurement<S> y;
    y.tick = k;
    y.omega_BN_B = (omega + bias + s_v / std::sqrt(dt) * normals()).template cast<S>();
    const bool fix = k % static_cast<Tick>(every) == 3 && k >= static_cast<Tick>(latency) && !blind;
    const Vec3<double> noise = sigma.cwiseProduct(normals());
    y.attitude_valid = fix;
    y.q_NB = Quat<S>::Identity();
    if (fix) {
      const Quat<double> then = history[(k - static_cast<Tick>(latency)) % history.size()];
      Quat<double> shown = then * quat_exp<double>(Vec3<double>(dcm(mounting()).transpose() * noise));
      if (outlier) shown = shown * quat_exp<double>(Vec3<double>(0.017 * normals().normalized()));
      y.q_NB = shown.template cast<S>();
    }
    ++k;
    return y;
  }

  Params params() const {
    Params p(slow_vehicle(dt));
    p.angle_random_walk = s_v;
    p.rate_random_walk = s_u;
    p.attitude_noise = sigma;
    p.q_BS = mounting();
    p.latency = latency;
    return p;
  }
  Alone<Mekf<S>> filter() const {
    typename Mekf<S>::Params p(slow_vehicle<S>(static_cast<S>(dt)));
    p.angle_random_walk = static_cast<S>(s_v);
    p.rate_random_walk = static_cast<S>(s_u);
    p.attitude_noise = sigma.cast<S>();
    p.q_BS = mounting().cast<S>();
    p.latency = latency;
    return Alone<Mekf<S>>(unchecked, slow_vehicle<S>(static_cast<S>(dt)), p);
  }

  std::mt19937 random;
  std::normal_distribution<double> gauss;
  double dt, s_v = 1e-5, s_u = 1e-7, moves = 1;
  int every, latency;
  Vec3<double> sigma{2e-5, 2e-5, 1.2e-4};
  std::vector<Quat<double>> history;
  Quat<double> q = Quat<double>(0.8, 0.2, -0.4, 0.4);
  Vec3<double> omega = Vec3<double>::Zero(), bias = Vec3<double>::Zero();
  Tick k = 0;
  bool blind = false, outlier = false;
};

Vec3<double> attitude_error(const Quat<double>& estimate, const Quat<double>& truth) {
  return quat_log<double>(estimate.conjugate() * truth);
}

/// Farrenkopf's covariances after and before a fix, an axis without rotation.
struct Steady {
  double z, attitude, mixed, bias;
  Steady(double T, double sigma, double s_v, double s_u) {
    const double Sv = s_v * std::sqrt(T) / sigma, Su = s_u * std::pow(T, 1.5) / sigma;
    const double g = std::sqrt(1 + Sv * Sv / 4 + Su * Su / 48);
    z = g + Su / 4 + 0.5 * std::sqrt(2 * g * Su + Sv * Sv + Su * Su / 3);
    attitude = sigma * sigma * (1 - 1 / (z * z));
    mixed = -s_u * std::sqrt(T) * sigma / z;
    bias = s_u * sigma * (z - 1 / z) / std::sqrt(T) - s_u * s_u * T / 2;
  }
  /// Attitude variance `t` after a fix without another one.
  double outage(double t, double s_v, double s_u) const {
    return attitude - 2 * t * mixed + t * t * bias + s_v * s_v * t + s_u * s_u * t * t * t / 3;
  }
};

TEST(Mekf, SettlesToFarrenkopfsCovariance) {
  const Steady known(0.5, 2e-5, 1e-5, 1e-7);
  EXPECT_NEAR(known.z, 1.19524498506807, 1e-13);
  EXPECT_NEAR(known.attitude, 1.2000767235851446e-10, 1e-22);
  EXPECT_NEAR(known.bias, 1.0117638450978507e-12, 1e-24);
  EXPECT_NEAR(known.mixed, -1.1831997456927669e-12, 1e-24);
  Flight<double> flight(1);
  flight.moves = 0;
  flight.s_u = 1e-6;
  flight.sigma.setConstant(2e-5);
  auto filter = flight.filter();
  (void)filter.start(flight.next());
  while (flight.k < 5204) (void)filter.step(flight.next());  // 260 s, at a fix
  ASSERT_EQ(filter.fix(), Fix::used);
  const Steady steady(0.5, 2e-5, 1e-5, 1e-6);
  const auto P = filter.covariance();
  for (int i = 0; i < 3; ++i) {
    EXPECT_NEAR(P(i, i) / steady.attitude, 1, 1e-6);
    EXPECT_NEAR(P(3 + i, 3 + i) / steady.bias, 1, 1e-6);
    EXPECT_NEAR(P(i, 3 + i) / steady.mixed, 1, 1e-6);
  }
}

/// 50 runs with biases drawn as believed: normalised errors are chi square.
TEST(Mekf, ItsErrorsAreWhatItSaysTheyAre) {
  int nees_inside = 0, nis_inside = 0, samples = 0, fixes = 0;
  double nees_sum = 0, bias40 = 0, bias5 = 0, knowledge = 0;
  const int runs = 50, length = 2004;
  std::vector<double> nees(length), nis(length);
  for (unsigned run = 0; run < runs; ++run) {
    Flight<double> flight(100 + run, 0.05, 10, run % 2 == 0 ? 0 : 4);
    flight.bias = 2e-3 * flight.normals();
    auto filter = flight.filter();
    Measurement<double> out = filter.start(flight.next());
    for (int k = 1; k < length; ++k) {
      out = filter.step(flight.next());
      if (k < 200) {
        if (k == 104) bias5 += (flight.bias - filter.bias()).squaredNorm() / 3;
        continue;
      }
      Eigen::Matrix<double, 6, 1> error;
      error << attitude_error(out.q_NB, flight.q), flight.bias - filter.bias();
      nees[static_cast<std::size_t>(k)] += normalised_square(filter.covariance(), error) / runs;
      if (filter.fix() == Fix::used) nis[static_cast<std::size_t>(k)] += filter.nis() / runs;
      if (k > 800) knowledge += error.head<3>().squaredNorm() / (runs * (length - 801));
      if (k == 804) bias40 += (flight.bias - filter.bias()).squaredNorm() / 3;
    }
  }
  for (std::size_t k = 200; k < nees.size(); ++k) {
    ++samples;
    nees_sum += nees[k];
    nees_inside += nees[k] > 5.078 && nees[k] < 6.997 ? 1 : 0;  // 95 % of chi square (300) / 50
    if (nis[k] == 0) continue;
    ++fixes;
    nis_inside += nis[k] > 2.360 && nis[k] < 3.716 ? 1 : 0;  // of chi square (150) / 50
  }
  EXPECT_GT(nees_inside, 0.9 * samples);
  EXPECT_NEAR(nees_sum / samples, 6, 0.4);
  EXPECT_GT(fixes, 100);
  EXPECT_GT(nis_inside, 0.9 * fixes);
  EXPECT_LT(std::sqrt(bias5 / runs), 2.5e-5);
  EXPECT_LT(std::sqrt(bias40 / runs), 3e-6);
  EXPECT_LT(std::sqrt(knowledge) * 57.3, 0.003);
}

TEST(Mekf, GrowsWithAnOutageAsTheClosedFormSays) {
  const Steady steady(0.5, 2e-5, 1e-5, 1e-7);
  for (const double outage : {5.0, 10.0, 30.0}) {
    double across = 0;
    const int runs = 60;
    for (unsigned run = 0; run < runs; ++run) {
      Flight<double> flight(500 + run);
      flight.bias = 2e-3 * flight.normals();
      auto filter = flight.filter();
      Measurement<double> out = filter.start(flight.next());
      while (flight.k < 4004) out = filter.step(flight.next());
      flight.blind = true;
      for (int k = 0; k < outage / flight.dt; ++k) out = filter.step(flight.next());
      const Vec3<double> in_sensor = dcm(mounting()) * attitude_error(out.q_NB, flight.q);
      across += in_sensor.head<2>().squaredNorm() / (2 * runs);
    }
    EXPECT_NEAR(std::sqrt(across / steady.outage(outage, 1e-5, 1e-7)), 1, 0.2)
        << outage;  // 120 numbers: 6.5 %, 3 sigma
  }
}

TEST(Mekf, RejectsOutliersAndNothingElse) {
  int outliers = 0, rejected = 0, good = 0, lost = 0;
  std::vector<double> rms;  // rad, of an axis; without outliers and with
  for (const bool some : {false, true}) {
    Flight<double> flight(7, 0.05, 10, 2);
    flight.bias = {1e-3, -1e-3, 1e-3};
    auto filter = flight.filter();
    (void)filter.start(flight.next());
    double sum = 0;
    while (flight.k < 40000) {
      flight.outlier = some && flight.k > 200 && flight.random() % 20 == 0;
      const bool bad = flight.outlier;
      const Measurement<double> out = filter.step(flight.next());
      if (flight.k > 800) sum += attitude_error(out.q_NB, flight.q).squaredNorm() / (3 * 39200.0);
      if (filter.fix() == Fix::none || flight.k <= 200) continue;
      (bad ? outliers : good) += 1;
      (bad ? rejected : lost) += filter.fix() == Fix::rejected ? 1 : 0;
      EXPECT_NE(filter.fix(), Fix::restarted);
    }
    rms.push_back(std::sqrt(sum));
  }
  EXPECT_GT(outliers, 100);
  EXPECT_EQ(rejected, outliers);
  EXPECT_LE(lost, good / 1000 + 1);
  EXPECT_LT(rms[1], 1.05 * rms[0]);  // one fix in twenty fewer costs 2 %; two flights differ by 1 % beside
}

/// Codes of the fixes after something has jumped.
std::vector<Fix> fixes_after(const std::function<void(Flight<double>&)>& jump) {
  Flight<double> flight(11);
  auto filter = flight.filter();
  (void)filter.start(flight.next());
  while (flight.k < 1200) (void)filter.step(flight.next());
  jump(flight);
  std::vector<Fix> fixes;
  while (fixes.size() < 8 && flight.k < 1400) {
    (void)filter.step(flight.next());
    if (filter.fix() != Fix::none) fixes.push_back(filter.fix());
  }
  return fixes;
}

TEST(Mekf, FindsItsWayBackAfterAJump) {
  const std::vector<Fix> wanted{Fix::rejected,  Fix::rejected, Fix::rejected, Fix::rejected,
                                Fix::restarted, Fix::used,     Fix::used,     Fix::used};
  EXPECT_EQ(fixes_after([](auto& f) { f.bias += Vec3<double>::Constant(5e-3); }), wanted);
  EXPECT_EQ(fixes_after([](auto& f) { f.q = f.q * quat_exp<double>({0.1, 0, 0}); }), wanted);
}

/// 200 flights that begin 0.5 rad off about some axis: at the next fix they know as much as they say.
TEST(Mekf, ACoarseFirstAttitudeIsForgottenAtTheNextFix) {
  const int runs = 200;
  double nees = 0, square = 0;
  for (unsigned run = 0; run < runs; ++run) {
    Flight<double> flight(1300 + run);
    flight.bias = 2e-3 * flight.normals();
    Params p = flight.params();
    p.attitude0 = 0.5;
    Alone<Mekf<double>> filter(unchecked, slow_vehicle(flight.dt), p);
    Measurement<double> first = flight.next();
    first.attitude_valid = true;
    first.q_NB = flight.q * quat_exp<double>(Vec3<double>(0.5 * flight.normals().normalized()));
    (void)filter.start(first);
    Measurement<double> out;
    while (filter.fix() != Fix::used && flight.k < 100) out = filter.step(flight.next());
    Eigen::Matrix<double, 6, 1> error;
    error << attitude_error(out.q_NB, flight.q), flight.bias - filter.bias();
    nees += normalised_square(filter.covariance(), error) / runs;
    square += error.head<3>().squaredNorm() / (3 * runs);
  }
  EXPECT_LT(std::sqrt(square), 1e-4);
  EXPECT_NEAR(nees, 6, 1);  // of chi square: 6 +- 0.25
}

TEST(Mekf, FloatFollowsDouble) {
  for (const int latency : {0, 4}) {
    Flight<double> flight(17, 0.05, 10, latency);
    Flight<float> same(17, 0.05, 10, latency);
    flight.bias = same.bias = {1e-3, -5e-4, 2e-4};
    auto filter = flight.filter();
    auto single = same.filter();
    Measurement<double> out = filter.start(flight.next());
    Measurement<float> in_float = single.start(same.next());
    for (int k = 1; k < 6000; ++k) {
      out = filter.step(flight.next());
      in_float = single.step(same.next());
      ASSERT_EQ(filter.fix(), single.fix()) << k;
      if (!out.attitude_valid) continue;
      EXPECT_LT(attitude_error(in_float.q_NB.cast<double>(), out.q_NB).norm(), 1.5e-5) << k;
      EXPECT_LT((single.bias().cast<double>() - filter.bias()).norm(), 5e-7) << k;
      const Mekf<double>::Covariance P = single.covariance().cast<double>();
      const Eigen::Matrix<double, 6, 1> scale = P.diagonal().cwiseSqrt().cwiseInverse();
      const MatrixXd correlation = P.cwiseProduct(scale * scale.transpose());
      EXPECT_GT(symmetric_eigenvalues(correlation)[0], 1e-4) << k;
    }
    const auto P = filter.covariance();
    const Mekf<double>::Covariance diff = P - single.covariance().cast<double>();
    for (int i = 0; i < 6; ++i) EXPECT_LT(std::abs(diff(i, i)) / P(i, i), 5e-3);
  }
}

TEST(Mekf, SaysByHowMuchItsKnowledgeMovesTheRate) {
  Flight<double> flight(19);
  flight.bias = {1e-3, -1e-3, 1e-3};
  auto filter = flight.filter();
  Measurement<double> out = filter.start(flight.next());
  Vec3<double> sum = Vec3<double>::Zero();
  while (flight.k < 400) {
    out = filter.step(flight.next());
    sum -= out.rate_step;
    EXPECT_LT((sum - filter.bias()).norm(), 1e-17);
    if (filter.fix() == Fix::none) {
      EXPECT_TRUE(out.rate_step.isZero(0));
    }
  }
  EXPECT_GT(sum.norm(), 1e-3);
}

TEST(Mekf, CheckSaysWhatCannotBe) {
  const auto setup = slow_vehicle(0.1);
  Params p(setup);
  EXPECT_TRUE(Mekf<double>::check(setup, p).ok());
  p.q_BS = Quat<double>(1, 0.1, 0, 0);
  EXPECT_STREQ(Mekf<double>::check(setup, p).quantity, "| |q_BS| - 1 |");
}

}  // namespace
}  // namespace gyrostat::test::test_mekf
