// SPDX-License-Identifier: MIT
// Learning observers of effectiveness, the regression behind them, the threshold detector and its probe.
#include <gtest/gtest.h>

#include <random>

#include "alone.hpp"
#include "closed_loop.hpp"
#include "gyrostat/flight/detectors/threshold.hpp"
#include "gyrostat/flight/observers/adaptive_iterative_learning.hpp"
#include "gyrostat/flight/observers/iterative_learning.hpp"
#include "telemetry_log.hpp"
#include "vehicles.hpp"

namespace gyrostat::test::test_learning_detection {
namespace {

template <class S>
class LearningDetection : public ::testing::Test {};
using Scalars = ::testing::Types<float, double>;
TYPED_TEST_SUITE(LearningDetection, Scalars);

/// Three axes and a skew spare.
template <class S>
Setup<S> with_spare() {
  Mat3<S> J;
  J << S(43), S(0.3), S(1.2), S(0.3), S(52), S(-0.5), S(1.2), S(-0.5), S(40);
  Mat3N<S> D(3, 4);
  const S s = S(1) / std::sqrt(S(3));
  D << S(1), S(0), S(0), s, S(0), S(1), S(0), s, S(0), S(0), S(1), s;
  Setup<S> setup = vehicle_with<S>(J, D, S(0.25), S(0.01));
  setup.vehicle.spare.set(3);
  return setup;
}

template <class S>
Allocation<S> issued(std::initializer_list<double> u) {
  Allocation<S> a = Allocation<S>::idle(static_cast<int>(u.size()));
  Eigen::Index i = 0;
  for (const double x : u) a.u[i++] = static_cast<S>(x);
  return a;
}

template <class S>
Measurement<S> at_rest(int n = 4) {
  Measurement<S> y;
  y.h_w = VecN<S>::Zero(n);
  return y;
}

/// Largest |state| of the recursion that the stability test is about, run from a unit error for many samples.
double grown(double a, double h, double k3, double k4, double k5, int L, int samples) {
  std::vector<double> w(static_cast<std::size_t>(samples + L + 1), 0.0), g(w);
  const auto at = [&](int k) { return static_cast<std::size_t>(k + L); };
  g[at(0)] = 1;
  double largest = 0;
  for (int k = 0; k < samples; ++k) {
    w[at(k + 1)] = a * w[at(k)] + h * g[at(k)];
    g[at(k + 1)] = k3 * g[at(k + 1 - L)] - k4 * w[at(k + 1)] - k5 * w[at(k + 1 - L)];
    if (k > samples - 100) largest = std::max({largest, std::abs(w[at(k)]) / h, std::abs(g[at(k)])});
    if (!(std::abs(g[at(k + 1)]) < 1e9)) return 1e9;
  }
  return largest;
}

TEST(LearningLoop, TheStabilityTestAgreesWithTheRecursionItself) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> unit(0, 1);
  const double h = 0.01;
  int stable = 0, unstable = 0;
  for (int trial = 0; trial < 2000; ++trial) {
    const int L = 1 + trial % 6;
    const double k1 = 250 * unit(random), k3 = 0.7 + 0.3 * unit(random), k4 = 150 * unit(random) * unit(random),
                 k5 = 30 * unit(random);
    const double end = grown(1 - h * k1, h, k3, k4, k5, L, 6000);
    if (end > 1e-6 && end < 1e6) continue;  // a root so near the circle that 6000 samples do not tell
    const bool is_stable = effectiveness_loop_is_stable(h, k1, k3, k4, k5, L);
    EXPECT_EQ(is_stable, end < 1) << "k1 " << k1 << " k3 " << k3 << " k4 " << k4 << " k5 " << k5 << " L " << L;
    (is_stable ? stable : unstable) += 1;
  }
  EXPECT_GT(stable, 300);
  EXPECT_GT(unstable, 300);
}

TYPED_TEST(LearningDetection, ARegressionOnOneColumnIsTheQuotient) {
  using S = TypeParam;
  const gyrostat::Setup<S> setup = with_spare<S>();
  const Allocation<S> last = issued<S>({0.2, 0.01, 0.1, 0});
  Mask first;
  first.set(0);
  const Vec3<S> tau{S(-0.06), S(0.02), S(0.01)};
  const VecN<S> change = explaining_change<S>(setup.vehicle.D_B, last.u, first, S(0.02), tau);
  EXPECT_NEAR(change[0], -0.06 * 0.2 / (0.2 * 0.2 + 0.02 * 0.02), 1e-5);
  EXPECT_EQ(change[1], S(0));
  EXPECT_EQ(change[3], S(0));
  const Mask heard = excited<S>(setup.vehicle.D_B, last.u, S(0.05));
  EXPECT_TRUE(heard.test(0) && heard.test(2));
  EXPECT_FALSE(heard.test(1) || heard.test(3));
}

/// A body that turns exactly as the observer's own midpoint step, with this effectiveness.
template <class S>
Vec3<S> turned(const gyrostat::Setup<S>& setup, const Vec3<S>& w, const VecN<S>& e, const VecN<S>& u) {
  const Mat3<S> J_inv = setup.vehicle.J_B.inverse();
  const Vec3<S> tau = setup.vehicle.D_B * e.cwiseProduct(u);
  const auto rate = [&](const Vec3<S>& x) -> Vec3<S> { return J_inv * (tau - x.cross(setup.vehicle.J_B * x)); };
  return w + setup.dt * rate(w + setup.dt / 2 * rate(w));
}

TEST(IterativeLearning, DeadBeatGainsFindAFaultInTwoSamples) {
  const gyrostat::Setup<double> setup = with_spare<double>();
  IterativeLearningObserver<double>::Params p(setup);
  p.u_gate = 0.05;
  p.k1 = p.k4 = 100;  // 1 / dt
  p.u_reg = 1e-9;
  p.frozen.set(3);
  Alone<IterativeLearningObserver<double>> observer(unchecked, setup, p);
  const Allocation<double> last = issued<double>({0.2, -0.2, 0.2, 0});
  VecN<double> e(4);
  e << 0.6, 0.5, 0.9, 1;
  Measurement<double> y = at_rest<double>();
  (void)observer.start(y);
  Estimate<double> x;
  for (int k = 0; k < 3; ++k) {
    y.omega_BN_B = turned<double>(setup, y.omega_BN_B, e, last.u);
    x = observer.step(y, last);
  }
  EXPECT_LT((x.effectiveness - e).cwiseAbs().maxCoeff(), 1e-9);  // gyroscopic coupling of the two is 1e-12
  EXPECT_EQ(x.effectiveness_bound[0], 0.1);
  EXPECT_TRUE(std::isinf(x.effectiveness_bound[3])) << "never excited";
}

TYPED_TEST(LearningDetection, WithoutAnErrorNothingMoves) {
  using S = TypeParam;
  const gyrostat::Setup<S> setup = with_spare<S>();
  auto observer = alone<AdaptiveIterativeLearningObserver<S>>(setup);
  const Allocation<S> last = issued<S>({0.2, -0.2, 0.2, 0});
  Measurement<S> y = at_rest<S>();
  (void)observer.start(y);
  for (int k = 0; k < 200; ++k) {
    y.omega_BN_B = turned<S>(setup, y.omega_BN_B, VecN<S>::Ones(4), last.u);
    const Estimate<S> x = observer.step(y, last);
    // The rate differs from the observer's by the rounding of 0.2 rad/s at most: a few epsilon a sample over h u / J.
    EXPECT_LT((x.effectiveness - VecN<S>::Ones(4)).cwiseAbs().maxCoeff(), S(2e4) * Eigen::NumTraits<S>::epsilon());
  }
}

TYPED_TEST(LearningDetection, GatedAndFrozenActuatorsKeepTheirValueAndGainsTheirCaps) {
  using S = TypeParam;
  const gyrostat::Setup<S> setup = with_spare<S>();
  using O = AdaptiveIterativeLearningObserver<S>;
  const typename O::Params p(setup);
  Alone<O> observer(unchecked, setup, p);
  std::mt19937 random(3);
  std::uniform_real_distribution<double> unit(-1, 1);
  Measurement<S> y = at_rest<S>();
  (void)observer.start(y);
  VecN<S> before = VecN<S>::Ones(4);
  int moved = 0;
  for (int k = 0; k < 2000; ++k) {
    for (int i = 0; i < 3; ++i) y.omega_BN_B[i] = static_cast<S>(1e-3 * unit(random));
    const Allocation<S> last = issued<S>({0.2 * unit(random), 0.2 * unit(random), 0.2 * unit(random), 0.2});
    const Estimate<S> x = observer.step(y, last);
    for (int i = 0; i < 4; ++i) {
      if (i == 3 || std::abs(last.u[i]) < p.u_gate * S(0.999)) {
        EXPECT_EQ(x.effectiveness[i], before[i]);
      }
      moved += x.effectiveness[i] != before[i] ? 1 : 0;
      EXPECT_TRUE(x.effectiveness[i] >= p.e_min && x.effectiveness[i] <= p.e_max);
    }
    before = x.effectiveness;
    const auto gains = telemetry_of(observer).at("gains");
    EXPECT_TRUE(gains[0] >= 0 && gains[0] <= p.k1_max && gains[1] >= 0 && gains[1] <= p.k2_max && gains[2] >= 0 &&
                gains[2] <= p.k4_max);
  }
  EXPECT_GT(moved, 1000);
}

TEST(AdaptiveIterativeLearning, RefusesGainsThatAreUnstableWhenSampled) {
  const gyrostat::Setup<double> setup = with_spare<double>();
  using O = AdaptiveIterativeLearningObserver<double>;
  typename O::Params p(setup);
  EXPECT_TRUE(O::check(setup, p).ok());
  p.k1_max = 2.1 / setup.dt;
  EXPECT_EQ(O::check(setup, p).code, Status<double>::Code::unstable);
  p = typename O::Params(setup);
  p.k2_max = 200;  // its layer is a gain of k2 / (layer J)
  EXPECT_EQ(O::check(setup, p).code, Status<double>::Code::unstable);
}

/// A detector of two samples' persistence with three of hold-off.
template <class S>
Alone<ThresholdDetector<S>> quick(const gyrostat::Setup<S>& setup, S dither = S(0), int settle = 0) {
  typename ThresholdDetector<S>::Params p(setup);
  p.persistence = S(2) * setup.dt;
  p.hold_off = S(3) * setup.dt;
  p.settle = S(settle) * setup.dt;
  p.dither = dither;
  return Alone<ThresholdDetector<S>>(unchecked, setup, p);
}

template <class S>
Estimate<S> estimated(std::initializer_list<double> e) {
  Estimate<S> x = Estimate<S>::healthy(at_rest<S>(static_cast<int>(e.size())));
  Eigen::Index i = 0;
  for (const double v : e) x.effectiveness[i++] = static_cast<S>(v);
  return x;
}

TYPED_TEST(LearningDetection, StartingTwiceIsStartingOnce) {
  using S = TypeParam;
  using O = AdaptiveIterativeLearningObserver<S>;
  const gyrostat::Setup<S> setup = with_spare<S>();
  Alone<O> used(unchecked, setup, typename O::Params(setup)), fresh(used);
  auto tired = quick<S>(setup, S(0.15)), rested = tired;
  Measurement<S> y = at_rest<S>();
  const Allocation<S> last = issued<S>({0.2, -0.2, 0.2, 0});
  (void)tired.start(used.start(y));
  for (int k = 0; k < 50; ++k) {
    y.omega_BN_B[0] = static_cast<S>(1e-4 * k);
    (void)tired.step(used.step(y, last), last);
  }
  y = at_rest<S>();
  Estimate<S> a = used.start(y), b = fresh.start(y);
  Detection<S> da = tired.start(a), db = rested.start(b);
  for (int k = 0; k < 50; ++k) {
    EXPECT_EQ(a.effectiveness, b.effectiveness);
    EXPECT_EQ(a.effectiveness_bound, b.effectiveness_bound);
    EXPECT_EQ(da.event, db.event);
    EXPECT_EQ(da.u_probe, db.u_probe);
    y.omega_BN_B[1] = static_cast<S>(-1e-4 * k);
    a = used.step(y, last), b = fresh.step(y, last);
    da = tired.step(a, last), db = rested.step(b, last);
  }
  EXPECT_GT(da.event, 0u) << "it was put to work";
}

TYPED_TEST(LearningDetection, AChangeIsDeclaredAfterItsPersistenceWithoutAGap) {
  using S = TypeParam;
  auto detector = quick<S>(with_spare<S>());
  const Allocation<S> loud = issued<S>({0.2, 0.2, 0.2, 0}), quiet = issued<S>({0.01, 0.2, 0.2, 0});
  const Estimate<S> weak = estimated<S>({0.5, 1, 1, 1});
  EXPECT_FALSE(detector.start(weak).enabled.test(3));
  EXPECT_EQ(detector.step(weak, loud).event, 0u);
  EXPECT_EQ(detector.step(weak, quiet).event, 0u) << "a gap";
  EXPECT_EQ(detector.step(weak, loud).event, 0u);
  const Detection<S> det = detector.step(weak, loud);
  EXPECT_EQ(det.event, 1u);
  EXPECT_EQ(det.changed.bits(), 1u);
  EXPECT_TRUE(det.enabled.test(3)) << "the spare is on from now on";
  EXPECT_FALSE(det.failed.any());
  const Estimate<S> dead = estimated<S>({0.05, 1, 1, 1});
  for (int k = 0; k < 4; ++k)
    EXPECT_EQ(detector.step(dead, loud).event, 1u) << "hold-off of three, then the first of two";
  const Detection<S> last = detector.step(dead, loud);
  EXPECT_EQ(last.event, 2u);
  EXPECT_TRUE(last.failed.test(0));
  EXPECT_TRUE(detector.start(weak).enabled == Mask::all(3)) << "started anew";
}

TYPED_TEST(LearningDetection, AnEstimateThatIsStillOnItsWayIsNoSecondChange) {
  using S = TypeParam;
  const Allocation<S> loud = issued<S>({0.2, 0.2, 0.2, 0});
  for (const int settle : {0, 3}) {
    auto detector = quick<S>(with_spare<S>(), S(0), settle);
    Detection<S> det = detector.start(estimated<S>({1, 1, 1, 1}));
    for (int k = 1; k <= 40; ++k) det = detector.step(estimated<S>({std::max(1 - 0.15 * k, 0.2), 1, 1, 1}), loud);
    EXPECT_EQ(det.event, settle == 0 ? 2u : 1u);
  }
}

TYPED_TEST(LearningDetection, ALumpedTorqueReadsAsTheEffectivenessThatExplainsIt) {
  using S = TypeParam;
  auto detector = quick<S>(with_spare<S>());
  const Allocation<S> loud = issued<S>({0.2, -0.2, 0.2, 0});
  Estimate<S> x = estimated<S>({1, 1, 1, 1});
  x.d_B = {S(0), S(0.08), S(0)};  // -0.2 N m lost 40 %
  (void)detector.start(x);
  (void)detector.step(x, loud);
  EXPECT_EQ(detector.step(x, loud).changed.bits(), 2u);
  EXPECT_NEAR(telemetry_of(detector).at("effectiveness")[1], 0.6, 1e-5);
}

TYPED_TEST(LearningDetection, TheProbeMakesNoTorqueAndStaysInsideItsAmplitude) {
  using S = TypeParam;
  for (const gyrostat::Setup<S>& setup : {with_spare<S>(), ftc_4rw<S>()}) {
    auto detector = quick<S>(setup, S(0.15));
    const Estimate<S> x = estimated<S>({1, 1, 1, 1});
    Detection<S> det = detector.start(x);
    VecN<S> largest = VecN<S>::Zero(4);
    for (int k = 0; k < 2000; ++k) {
      const Vec3<S> net = setup.vehicle.D_B * det.u_probe;
      EXPECT_LE(net.norm(), (std::is_same_v<S, double> ? S(1e-12) : S(2e-7)));
      EXPECT_LE(det.u_probe.cwiseAbs().maxCoeff(), S(0.15) * (S(1) + S(1e-6)));
      largest = largest.cwiseMax(det.u_probe.cwiseAbs());
      det = detector.step(x, issued<S>({0, 0, 0, 0}));
    }
    EXPECT_GT(largest.minCoeff(), S(0.08)) << "every actuator is heard";
    EXPECT_TRUE(det.enabled == Mask::all(4));
  }
}

TEST(ThresholdDetector, RefusesAProbeWithoutRedundancyOrRoom) {
  using D = ThresholdDetector<double>;
  const gyrostat::Setup<double> three =
      vehicle_with<double>(satellite_inertia<double>(), Mat3<double>::Identity(), 0.2, 0.01);
  typename D::Params p(three);
  EXPECT_TRUE(D::check(three, p).ok());
  p.dither = 0.1;
  EXPECT_EQ(D::check(three, p).code, Status<double>::Code::refused);
  EXPECT_TRUE(D::check(ftc_4rw<double>(), p).ok());
  p.dither = 0.2;
  EXPECT_FALSE(D::check(ftc_4rw<double>(), p).ok());
}

/// Rate observer, gains and learning step of the page; midpoint rule, as the page says.
struct LearningWrittenOut {
  gyrostat::Setup<double> setup;
  AdaptiveIterativeLearningObserver<double>::Params p;
  Vec3<double> what = Vec3<double>::Zero();
  VecN<double> h_w = VecN<double>::Zero(4);
  double k1 = 0, k2 = 0, k4 = 0;
  std::vector<Vec3<double>> error{};
  std::vector<VecN<double>> e{};
  Mask seen{};

  void start(const Measurement<double>& y) {
    what = y.omega_BN_B;
    h_w = y.h_w;
    k1 = p.k1_0;
    k2 = p.k2_0;
    k4 = p.k4_0;
    error.assign(static_cast<std::size_t>(p.delay) + 1, Vec3<double>::Zero());
    e.assign(static_cast<std::size_t>(p.delay) + 1, VecN<double>::Ones(4));
    seen = Mask{};
  }
  void step(const Measurement<double>& y, const VecN<double>& u) {
    const Mat3<double>& J = setup.vehicle.J_B;
    const Mat3N<double>& D = setup.vehicle.D_B;
    Vec3<double> tau = D * e.back().cwiseProduct(u) + k1 * (J * error.back());
    for (int i = 0; i < 3; ++i) tau[i] += k2 * std::clamp(error.back()[i] / p.layer, -1.0, 1.0);
    const Vec3<double> h_w_B = D * (h_w + y.h_w) / 2;
    const auto rate = [&](const Vec3<double>& w) -> Vec3<double> {
      return J.inverse() * (tau - w.cross(J * w + h_w_B));
    };
    what += setup.dt * rate(what + setup.dt / 2 * rate(what));
    h_w = y.h_w;
    error.push_back(y.omega_BN_B - what);
    const double m = error.back().norm();
    const bool grow = m > p.deadzone;
    k1 = std::min(k1 + setup.dt * (grow ? p.mu1 * m : -p.leak * (k1 - p.k1_0)), p.k1_max);
    k4 = std::min(k4 + setup.dt * (grow ? p.mu4 * m : -p.leak * (k4 - p.k4_0)), p.k4_max);
    const double sign = m > p.chi ? 1 : -1;
    k2 = std::clamp(k2 + setup.dt * (k2 > p.k2_0 ? p.mu2 * m * sign : p.gamma), 0.0, p.k2_max);
    const std::size_t before = error.size() - 1 - static_cast<std::size_t>(p.delay);
    const Vec3<double> lesson = J * (k4 * error.back() + p.k5 * error[before]);
    Eigen::Matrix<double, 3, 4> Phi = D * u.asDiagonal();
    Mask informative;
    for (int i = 0; i < 4; ++i) {
      informative.set(i, Phi.col(i).norm() >= p.u_gate && !p.frozen.test(i));
      if (!informative.test(i)) Phi.col(i).setZero();
    }
    const Eigen::Matrix3d normal = Phi * Phi.transpose() + p.u_reg * p.u_reg * Eigen::Matrix3d::Identity();
    const Eigen::Vector4d change = Phi.transpose() * normal.inverse() * lesson;
    VecN<double> now = e.back();
    for (int i = 0; i < 4; ++i)
      if (informative.test(i))
        now[i] = std::clamp(p.k3 * e[before][i] + change[i], 0.0, p.e_max + effectiveness_headroom<double>);
    e.push_back(now);
    seen = seen | informative;
  }
};

TEST(AdaptiveIterativeLearning, IsTheEquationsOfItsPageGainsIncluded) {
  const gyrostat::Setup<double> setup = with_spare<double>();
  using O = AdaptiveIterativeLearningObserver<double>;
  typename O::Params p(setup);
  p.k3 = 0.99;
  p.k5 = 0.1;
  p.delay = 3;
  p.k4_0 = 0.3;
  p.k4_max = 0.9;
  p.leak = 3;
  p.chi = 1.2 * p.deadzone;
  ASSERT_TRUE(O::check(setup, p).ok());
  Alone<O> observer(unchecked, setup, p);
  LearningWrittenOut written{setup, p};
  std::mt19937 random(11);
  std::uniform_real_distribution<double> unit(-1, 1);
  int capped = 0, returning = 0, handed_on = 0;
  for (int start = 0; start < 2; ++start) {
    Body body(setup.vehicle);
    body.omega_BN_B = {0.3, -0.2, 0.1};
    Measurement<double> y = body.measured<double>(0);
    (void)observer.start(y);
    written.start(y);
    for (int k = 1; k <= 900; ++k) {
      if (k == 200) body.effectiveness << 0.5, 1, 0.0, 1;
      // The last hundred samples push one actuator alone: what was learnt of the others stays known.
      const Allocation<double> last =
          k > 800 ? issued<double>({0.2, 0, 0, 0})
                  : issued<double>({0.2 * (k % 60 < 30 ? 1 : -1), 0.2 * unit(random), k % 90 < 45 ? 0.15 : -0.15, 0.1});
      body.advance(last.u, setup.dt);
      y = body.measured<double>(static_cast<Tick>(k));
      for (int i = 0; i < 4; ++i) y.h_w[i] = 0.1 * std::sin(0.02 * k + i);
      if (k < 100) y.omega_BN_B += Vec3<double>(unit(random), unit(random), unit(random)) * 2 * p.deadzone;
      const Estimate<double> x = observer.step(y, last);
      written.step(y, last.u);
      const std::vector<double> gains = telemetry_of(observer).at("gains");
      ASSERT_NEAR(gains[0], written.k1, 1e-9 * p.k1_max) << k;
      ASSERT_NEAR(gains[1], written.k2, 1e-9 * p.k2_max) << k;
      ASSERT_NEAR(gains[2], written.k4, 1e-9 * p.k4_max) << k;
      const VecN<double> issued_e = written.e.back().cwiseMax(p.e_min).cwiseMin(p.e_max);
      const VecN<double> rest = (written.e.back() - issued_e).cwiseProduct(last.u);
      handed_on += rest.cwiseAbs().maxCoeff() > 1e-3 ? 1 : 0;
      ASSERT_LT((x.effectiveness - issued_e).cwiseAbs().maxCoeff(), 1e-9) << k;
      ASSERT_LT((x.d_B - setup.vehicle.D_B * rest).norm(), 1e-9) << k;
      for (int i = 0; i < 4; ++i) EXPECT_EQ(std::isfinite(x.effectiveness_bound[i]), written.seen.test(i)) << k;
      capped += written.k1 == p.k1_max ? 1 : 0;
      returning += written.k1 < p.k1_max && written.error.back().norm() <= p.deadzone ? 1 : 0;
    }
  }
  EXPECT_GT(capped, 20);
  EXPECT_GT(returning, 100);
  EXPECT_GT(handed_on, 100);
}

TEST(AdaptiveIterativeLearning, RefusesBothEndsOfItsGainsWhereTheyAreUnstable) {
  const gyrostat::Setup<double> setup = with_spare<double>();
  using O = AdaptiveIterativeLearningObserver<double>;
  typename O::Params p(setup);
  p.k1_0 = 0;  // without correction the slow end rings for ever
  EXPECT_EQ(O::check(setup, p).code, Status<double>::Code::unstable);
  EXPECT_NE(std::string(O::check(setup, p).quantity).find("k1_0"), std::string::npos);
  p = typename O::Params(setup);
  p.k4_max = 350;
  EXPECT_NE(std::string(O::check(setup, p).quantity).find("k1_max"), std::string::npos);
}

TEST(IterativeLearning, RefusesWhatRingsWhenSampled) {
  const gyrostat::Setup<double> setup = with_spare<double>();
  using O = IterativeLearningObserver<double>;
  typename O::Params p(setup);
  EXPECT_TRUE(O::check(setup, p).ok());
  p.k1 = 2.01 / setup.dt;
  EXPECT_EQ(O::check(setup, p).code, Status<double>::Code::unstable);
}

}  // namespace
}  // namespace gyrostat::test::test_learning_detection
