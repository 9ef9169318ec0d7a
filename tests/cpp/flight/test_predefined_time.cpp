// SPDX-License-Identifier: MIT
#include "gyrostat/flight/controllers/predefined_time.hpp"

#include <gtest/gtest.h>

#include "../random.hpp"
#include "closed_loop.hpp"
#include "gyrostat/flight/controllers/finite_time.hpp"
#include "gyrostat/flight/controllers/mrp_feedback.hpp"
#include "gyrostat/flight/controllers/saturated_pd.hpp"
#include "gyrostat/flight/controllers/terminal_sliding_mode.hpp"
#include "telemetry_log.hpp"
#include "vehicles.hpp"

namespace gyrostat::test {
namespace {

Setup<double> satellite() {
  const Mat3<double> J = Vec3<double>(36, 17, 26).asDiagonal();
  return vehicle_with<double>(J, Mat3N<double>(Mat3<double>::Identity()), 20, 0.01);
}

PredefinedTime<double>::Params table1() {
  PredefinedTime<double>::Params p;
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
      Law law(setup, p);
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
  auto p = PredefinedTime<S>::Params::defaults(setup);
  asks_for_nothing_on_target<PredefinedTime<S>>(setup, p);
  asks_for_nothing_on_target<TerminalSlidingMode<S>>(setup, TerminalSlidingMode<S>::Params::defaults(setup));
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
    PredefinedTime<double> law(setup, p);
    const Quat<double> q = random.attitude<double>();
    const Vec3<double> w = random.vector<double>(0.5);
    if (mrp(short_way(q)).squaredNorm() / 2 < 4 * p.floor1) continue;
    const auto s_of = [&](const Quat<double>& attitude, const Vec3<double>& rate) {
      PredefinedTime<double> probe(setup, p);
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

TEST(ShadowSetDouble, TurnsRoundAtItsLimitAndNotBefore) {
  ShadowSet<double> set(1.2);
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

TEST(ShadowSetDouble, OneIsTheShortWayAndInfinityNeverSwitches) {
  Random random(11);
  ShadowSet<double> always(1.0), never(std::numeric_limits<double>::infinity());
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
  auto p = default_params<Law>(setup);
  Law short_law(setup, p);
  p.shadow_switch = std::numeric_limits<double>::infinity();
  Law long_law(setup, p);
  EXPECT_GT(short_law.start(x, det, {}).tau_B[0], 0);
  EXPECT_LT(long_law.start(x, det, {}).tau_B[0], 0);
}

TEST(ShadowSetDouble, EveryMrpLawHasTheOption) {
  flies_the_long_way_when_told<PredefinedTime<double>>();
  flies_the_long_way_when_told<TerminalSlidingMode<double>>();
  flies_the_long_way_when_told<MrpFeedback<double>>();
  flies_the_long_way_when_told<FiniteTime<double>>();
  flies_the_long_way_when_told<SaturatedPd<double>>();
}

}  // namespace
}  // namespace gyrostat::test
