// SPDX-License-Identifier: MIT
#include "gyrostat/flight/controllers/predefined_time.hpp"

#include <gtest/gtest.h>

#include "../random.hpp"
#include "alone.hpp"
#include "closed_loop.hpp"
#include "gyrostat/flight/controllers/finite_time.hpp"
#include "gyrostat/flight/controllers/mrp_feedback.hpp"
#include "gyrostat/flight/controllers/saturated_pd.hpp"
#include "gyrostat/flight/controllers/terminal_sliding_mode.hpp"
#include "telemetry_log.hpp"
#include "vehicles.hpp"

namespace gyrostat::test::test_predefined_time {
namespace {

Setup<double> satellite() {
  const Mat3<double> J = Vec3<double>(36, 17, 26).asDiagonal();
  return vehicle_with<double>(J, Mat3N<double>(Mat3<double>::Identity()), 20, 0.01);
}

PredefinedTime<double>::Params table1() {
  PredefinedTime<double>::Params p(satellite());
  p.h1 = 0.5;
  p.T1 = p.T2 = 10;
  p.h2 = 0.3;
  p.k_s = 5;
  p.phi = 0;
  p.floor1 = 1.25e-3;
  p.floor2 = 1e-12;
  return p;
}

template <class S>
Estimate<S> at(const Quat<S>& q_NB, const Vec3<S>& omega_BN_B, int n) {
  Measurement<S> y;
  y.q_NB = q_NB;
  y.omega_BN_B = omega_BN_B;
  y.h_w = VecN<S>::Zero(n);
  return Estimate<S>::healthy(y);
}

template <class S>
class PredefinedTimeLaw : public testing::Test {};
using Scalars = testing::Types<float, double>;
TYPED_TEST_SUITE(PredefinedTimeLaw, Scalars);

template <class Law>
void asks_for_nothing_on_target(const Setup<typename Law::Scalar>& setup, const typename Law::Params& params) {
  using S = typename Law::Scalar;
  auto p = params;
  for (const S phi : {S(0), S(1e-3)}) {
    for (const auto direction : {SwitchingDirection::surface, SwitchingDirection::matched}) {
      p.phi = phi;
      p.direction = direction;
      Alone<Law> law(unchecked, setup, p);
      const Detection<S> det = Detection<S>::none(setup.vehicle);
      EXPECT_EQ(law.start(at<S>(Quat<S>::Identity(), Vec3<S>::Zero(), setup.vehicle.actuators()), det, {}).tau_B,
                Vec3<S>(Vec3<S>::Zero()));
      // s = 0 off the target, and the target passed at a rate
      const Vec3<S> tiny = Vec3<S>::Constant(S(1e-19));
      for (const Vec3<S>& w : {Vec3<S>(Vec3<S>::UnitX()), tiny})
        EXPECT_TRUE(law.start(at<S>(quat_exp<S>(tiny), w, setup.vehicle.actuators()), det, {}).tau_B.allFinite());
    }
  }
}

TYPED_TEST(PredefinedTimeLaw, AsksForNothingOnTargetAndIsFiniteThere) {
  using S = TypeParam;
  const Setup<S> setup = ftc_4rw<S>();
  typename PredefinedTime<S>::Params p(setup);
  asks_for_nothing_on_target<PredefinedTime<S>>(setup, p);
  asks_for_nothing_on_target<TerminalSlidingMode<S>>(setup, typename TerminalSlidingMode<S>::Params(setup));
  p.h1 = S(0.5);
  p.floor1 = p.floor2 = S(1e-30);  // as printed
  asks_for_nothing_on_target<PredefinedTime<S>>(setup, p);
}

/// The way to the surface and along it is the printed law: s' = -psi(V2) s - (switching) on the nominal plant.
TEST(PredefinedTimeDouble, TheSlidingVariableFollowsTheLemmaOnTheNominalPlant) {
  const auto setup = satellite();
  const Mat3<double>& J = setup.vehicle.J_B;
  auto p = table1();
  p.k_s = 0;
  const Detection<double> det = Detection<double>::none(setup.vehicle);
  Random random(5);
  for (int trial = 0; trial < 200; ++trial) {
    Alone<PredefinedTime<double>> law(unchecked, setup, p);
    const Quat<double> q = random.attitude<double>();
    const Vec3<double> w = random.vector<double>(0.5);
    if (mrp(short_way(q)).squaredNorm() / 2 < 4 * p.floor1) continue;
    const auto s_of = [&](const Quat<double>& attitude, const Vec3<double>& rate) {
      Alone<PredefinedTime<double>> probe(unchecked, setup, p);
      (void)probe.start(at<double>(attitude, rate, 3), det, {});
      const auto values = telemetry_of(probe).at("s");
      return Vec3<double>(values[0], values[1], values[2]);
    };
    const Vec3<double> tau_B = law.start(at<double>(q, w, 3), det, {}).tau_B;
    const Vec3<double> s = s_of(q, w);
    const Vec3<double> wdot = J.inverse() * (tau_B - w.cross(J * w));
    const double h = 1e-5;
    const auto ahead = [&](double t) {
      const Vec3<double> mean = w + t / 2 * wdot;
      return s_of(q * quat_exp<double>(Vec3<double>(t * mean)), Vec3<double>(w + t * wdot));
    };
    const Vec3<double> difference = (ahead(h) - ahead(-h)) / (2 * h);
    const Vec3<double> expected = -predefined_time_gain(0.5 * s.squaredNorm(), p.h2, p.T2, p.floor2) * s;
    // Central differences of a smooth function: h^2 times its third derivative, and rounding over h.
    EXPECT_LT((difference - expected).norm(), 1e-5 * (1 + expected.norm() + difference.norm())) << trial;
  }
}

TEST(PredefinedTimeDouble, TheLemmaEndsAtItsClosedFormWithinAPercentAndBeforeT) {
  for (const double h : {0.2, 0.3, 0.5, 0.8}) {
    for (const double V0 : {1e-3, 1e-2, 0.1, 1.0, 10.0}) {
      const double T = 10, expected = T * (1 - std::exp(-std::pow(V0, h)));
      double t = 0,
             V = V0;  // dV/dt = -2 V gain(V): steps of a thousandth of V's own time, to where the rest is nothing
      while (V > 1e-40 * V0 && t < 2 * T) {
        const auto rate = [&](double x) { return -2 * x * predefined_time_gain(x, h, T, 1e-300); };
        const double step = -1e-3 * V / rate(V);
        const double middle = rate(V + step / 2 * rate(V));
        V += step * middle;
        t += step;
      }
      EXPECT_NEAR(t, expected, 0.01 * expected) << h << " " << V0;
      EXPECT_LT(t, T);
    }
  }
}

TEST(PredefinedTimeDouble, OnlyTheMatchedSwitchingTorqueAlwaysOpposesS) {
  const auto setup = satellite();
  const Mat3<double> J_inv = setup.vehicle.J_B.inverse();
  Random random(7);
  int against = 0, trials = 0;
  for (int i = 0; i < 2000; ++i) {
    const Vec3<double> sigma = random.vector<double>(1), s = random.vector<double>(1);
    if (sigma.norm() > 1) continue;
    ++trials;
    const Mat3<double> G = mrp_rate_matrix(sigma);
    if (s.dot(G * J_inv * sgn(s)) < 0) ++against;
    const Vec3<double> matched = J_inv * (G.transpose() * s);
    EXPECT_GE(s.dot(G * J_inv * sgn(matched)), 0);
  }
  EXPECT_GT(against, trials / 100);
}

TEST(PredefinedTimeDouble, RefusesSlopesThatTheSamplePeriodCannotHold) {
  const auto setup = satellite();
  auto p = table1();
  EXPECT_TRUE(PredefinedTime<double>::check(setup, p).ok());
  p.floor1 = 1e-30;  // h1 = 1/2: xi jumps at the target
  EXPECT_EQ(PredefinedTime<double>::check(setup, p).code, Status<double>::Code::unstable);
  p.h1 = 0.05;
  EXPECT_TRUE(PredefinedTime<double>::check(setup, p).ok());
}

// ---- shadow set ---------------------------------------------------------------------------------------------------

/// Rotation about x by an angle, continuous in sign: w < 0 beyond half a turn.
Quat<double> turned(double angle) { return {std::cos(angle / 2), std::sin(angle / 2), 0, 0}; }

TEST(MrpSwitchingDouble, TurnsRoundAtItsLimitAndNotBefore) {
  MrpSwitching<double> set(1.2);
  const double limit = 4 * std::atan(1.2);
  int switches = 0;
  double before = 0;
  for (int k = 0; k <= 4000; ++k) {  // up to 250 deg and back, twice
    const double angle = 250 / 57.29577951308232 * std::abs(std::sin(k * 1e-3 * 3.14159265358979 / 2));
    const double sigma = mrp(set(turned(angle)))[0];
    EXPECT_LE(std::abs(sigma), 1.2 + 1e-3);
    if (k > 0 && sigma * before < 0 && std::abs(sigma - before) > 0.5) {
      ++switches;
      // out: beyond 4 atan(1.2); back: where the other set exceeds it, 4 atan(1 / 1.2)
      const double from = std::abs(angle - limit), to = std::abs(angle - (2 * 3.14159265358979 - limit));
      EXPECT_LT(std::min(from, to), 0.02);
    }
    before = sigma;
  }
  EXPECT_EQ(switches, 4);
}

TEST(MrpSwitchingDouble, OneIsTheShortWayAndInfinityNeverSwitches) {
  Random random(11);
  MrpSwitching<double> always(1.0), never(std::numeric_limits<double>::infinity());
  for (int i = 0; i < 200; ++i) {
    const Quat<double> q = random.attitude<double>();
    EXPECT_EQ(always(q).coeffs(), short_way(q).coeffs());
    EXPECT_EQ(never(q).coeffs(), q.coeffs());
  }
}

/// Every MRP law: its torque follows the set it is told to.
template <class Law>
void flies_the_long_way_when_told() {
  const auto setup = satellite();
  const Detection<double> det = Detection<double>::none(setup.vehicle);
  const Estimate<double> x = at<double>(turned(4.0), Vec3<double>::Zero(), 3);  // 229 deg
  typename Law::Params p(setup);
  Alone<Law> short_law(unchecked, setup, p);
  p.shadow_switch = std::numeric_limits<double>::infinity();
  Alone<Law> long_law(unchecked, setup, p);
  EXPECT_GT(short_law.start(x, det, {}).tau_B[0], 0);
  EXPECT_LT(long_law.start(x, det, {}).tau_B[0], 0);
}

TEST(MrpSwitchingDouble, EveryMrpLawHasTheOption) {
  flies_the_long_way_when_told<PredefinedTime<double>>();
  flies_the_long_way_when_told<TerminalSlidingMode<double>>();
  flies_the_long_way_when_told<MrpFeedback<double>>();
  flies_the_long_way_when_told<FiniteTime<double>>();
  flies_the_long_way_when_told<SaturatedPd<double>>();
}

/// Once the law follows the far set, a start at the same attitude is the short way again.
template <class Law>
void chooses_anew_at_a_start() {
  const auto setup = satellite();
  const Detection<double> det = Detection<double>::none(setup.vehicle);
  typename Law::Params p(setup);
  p.shadow_switch = 2;
  Alone<Law> law(unchecked, setup, p), fresh = law;
  const auto beyond = at<double>(turned(3.6), Vec3<double>::Zero(), 3);  // 206 deg: |sigma| = 1.25
  (void)law.start(at<double>(turned(3.0), Vec3<double>::Zero(), 3), det, {});
  EXPECT_LT(law.step(beyond, det, {}, Allocation<double>::idle(3)).tau_B[0], 0) << "goes on with its set";
  const Vec3<double> tau_B = law.start(beyond, det, {}).tau_B;
  EXPECT_GT(tau_B[0], 0);
  EXPECT_EQ(tau_B, fresh.start(beyond, det, {}).tau_B);
}

TEST(MrpSwitchingDouble, AStartChoosesTheShortWayWhateverWasFollowedBefore) {
  chooses_anew_at_a_start<PredefinedTime<double>>();
  chooses_anew_at_a_start<TerminalSlidingMode<double>>();
  chooses_anew_at_a_start<MrpFeedback<double>>();
  chooses_anew_at_a_start<FiniteTime<double>>();
  chooses_anew_at_a_start<SaturatedPd<double>>();
}

/// The switching torque is what k_s adds: k_s sat(s / phi), or along J^-1 G's, in a unit that makes it s for small angles.
template <class Law>
void switches_along_what_it_is_told(const typename Law::Params& params) {
  const auto setup = satellite();
  const Mat3<double>& J = setup.vehicle.J_B;
  Random random(21);
  for (int trial = 0; trial < 40; ++trial) {
    auto p = params;
    p.k_s = 0;
    Alone<Law> without(unchecked, setup, p);
    p.k_s = 3;
    p.phi = trial % 2 == 0 ? 0.0 : 0.2;
    p.direction = trial % 4 < 2 ? SwitchingDirection::surface : SwitchingDirection::matched;
    Alone<Law> with(unchecked, setup, p);
    Estimate<double> x = at<double>(random.attitude<double>(), random.vector<double>(0.3), 3);
    x.d_B = random.vector<double>(1);
    const Vec3<double> difference = without.start(x, {}, {}).tau_B - with.start(x, {}, {}).tau_B;
    const std::vector<double> s_values = telemetry_of(with).at("s");
    Vec3<double> along(s_values[0], s_values[1], s_values[2]);
    if (p.direction == SwitchingDirection::matched) {
      const Mat3<double> G = mrp_rate_matrix(mrp(short_way(x.q_NB)));
      along = 4 * J.trace() / 3 * (J.inverse() * (G.transpose() * along));
    }
    for (int i = 0; i < 3; ++i) {
      const double shape = p.phi > 0 ? std::clamp(along[i] / p.phi, -1.0, 1.0) : (along[i] > 0 ? 1 : -1);
      EXPECT_NEAR(difference[i], 3 * shape, 1e-11) << trial;  // differences of torques of some 100 N m
    }
  }
}

TEST(PredefinedTimeDouble, SwitchesAlongTheSurfaceOrMatchedToThePlant) {
  switches_along_what_it_is_told<PredefinedTime<double>>(table1());
  switches_along_what_it_is_told<TerminalSlidingMode<double>>(TerminalSlidingMode<double>::Params(satellite()));
}

/// s some time later on the nominal plant, the torque held.
template <class Law>
Vec3<double> s_ahead(const typename Law::Params& p, const Quat<double>& q, const Vec3<double>& w,
                     const Vec3<double>& tau_B, double t) {
  const auto setup = satellite();
  const Mat3<double>& J = setup.vehicle.J_B;
  const Vec3<double> wdot = J.inverse() * (tau_B - w.cross(J * w));
  Alone<Law> probe(unchecked, setup, p);
  const Quat<double> later = q * quat_exp<double>(Vec3<double>(t * (w + t / 2 * wdot)));
  (void)probe.start(at<double>(later, w + t * wdot, 3), {}, {});
  const std::vector<double> s = telemetry_of(probe).at("s");
  return {s[0], s[1], s[2]};
}

TEST(PredefinedTimeDouble, BothTimesAndPowersStandWhereTheyBelong) {
  auto p = table1();
  p.k_s = 0;
  p.T1 = 7;
  p.T2 = 13;
  Random random(22);
  for (int trial = 0; trial < 50; ++trial) {
    const Quat<double> q = random.attitude<double>();
    const Vec3<double> w = random.vector<double>(0.5);
    const Vec3<double> sigma = mrp(short_way(q)), sigma_rate = mrp_rate_matrix(sigma) * w;
    if (sigma.squaredNorm() / 2 < 4 * p.floor1) continue;
    Alone<PredefinedTime<double>> law(unchecked, satellite(), p);
    const Vec3<double> tau_B = law.start(at<double>(q, w, 3), {}, {}).tau_B;
    const Vec3<double> s = s_ahead<PredefinedTime<double>>(p, q, w, tau_B, 0);
    const double V1 = sigma.squaredNorm() / 2, V2 = s.squaredNorm() / 2;
    const double gain = std::exp(std::sqrt(V1)) / (std::sqrt(V1) * 2 * 0.5 * 7);
    EXPECT_LT((s - (sigma_rate + gain * sigma)).norm(), 1e-13) << trial;
    const double reach = std::exp(std::pow(V2, 0.3)) / (std::pow(V2, 0.3) * 2 * 0.3 * 13);
    const double h = 1e-5;
    const Vec3<double> rate =
        (s_ahead<PredefinedTime<double>>(p, q, w, tau_B, h) - s_ahead<PredefinedTime<double>>(p, q, w, tau_B, -h)) /
        (2 * h);
    EXPECT_LT((rate + reach * s).norm(), 1e-5 * (1 + rate.norm())) << trial;
  }
}

TEST(TerminalSlidingModeDouble, ReachesItsSurfaceAsItSays) {
  TerminalSlidingMode<double>::Params p(satellite());
  p.k_s = 0;
  p.a = 0.6;
  p.b = 0.3;
  p.eta = 0.01;
  p.k1 = 0.8;
  p.k2 = 0.3;
  p.g2 = 0.7;
  Random random(23);
  for (int trial = 0; trial < 50; ++trial) {
    const Quat<double> q = random.attitude<double>();
    const Vec3<double> w = random.vector<double>(0.5);
    const Vec3<double> sigma = mrp(short_way(q)), sigma_rate = mrp_rate_matrix(sigma) * w;
    if (sigma.cwiseAbs().minCoeff() < 3 * p.eta || sigma.norm() > 0.95) continue;  // curvature of the core, other set
    Alone<TerminalSlidingMode<double>> law(unchecked, satellite(), p);
    const Vec3<double> tau_B = law.start(at<double>(q, w, 3), {}, {}).tau_B;
    const Vec3<double> s = s_ahead<TerminalSlidingMode<double>>(p, q, w, tau_B, 0);
    const double h = 1e-6;
    const Vec3<double> rate = (s_ahead<TerminalSlidingMode<double>>(p, q, w, tau_B, h) -
                               s_ahead<TerminalSlidingMode<double>>(p, q, w, tau_B, -h)) /
                              (2 * h);
    for (int i = 0; i < 3; ++i) {
      const double power = std::copysign(std::pow(std::abs(sigma[i]), 0.6), sigma[i]);
      EXPECT_NEAR(s[i], sigma_rate[i] + 0.6 * sigma[i] + 0.3 * power, 1e-13);
      const double reach = 0.8 * s[i] + 0.3 * std::copysign(std::pow(std::abs(s[i]), 0.7), s[i]);
      EXPECT_NEAR(rate[i], -reach, 1e-5 * (1 + rate.norm())) << trial;
    }
  }
}

TEST(PredefinedTimeDouble, CountsTheSlopeOfItsLayerForStability) {
  const auto setup = satellite();
  PredefinedTime<double>::Params p(setup);
  // k_s / (4 J phi) dt = 2 about the smallest inertia, 17, at phi = 3.68e-4 for k_s = 5
  p.k_s = 5;
  p.phi = 3e-4;
  EXPECT_EQ(PredefinedTime<double>::check(setup, p).code, Status<double>::Code::unstable);
  p.phi = 5e-4;
  EXPECT_TRUE(PredefinedTime<double>::check(setup, p).ok());
}

}  // namespace
}  // namespace gyrostat::test::test_predefined_time
