// SPDX-License-Identifier: MIT
// Funnel, transformed error, and the law that keeps the attitude inside; the terminal law that it is compared with.
#include <gtest/gtest.h>

#include <random>

#include "alone.hpp"
#include "gyrostat/flight/controllers/fast_terminal_sliding_mode.hpp"
#include "gyrostat/flight/controllers/prescribed_performance.hpp"
#include "telemetry_log.hpp"
#include "vehicles.hpp"

namespace gyrostat::test::test_prescribed_performance {
namespace {

template <class S>
class PrescribedPerformanceLaw : public ::testing::Test {};
using Scalars = ::testing::Types<float, double>;
TYPED_TEST_SUITE(PrescribedPerformanceLaw, Scalars);

template <class S>
constexpr FunnelShape<S> shape(S power = S(0.5)) {
  return {power, S(0.005), S(1), S(1)};
}

TYPED_TEST(PrescribedPerformanceLaw, TheErrorStartsInsideItsFunnelWhichClosesSmoothly) {
  using S = TypeParam;
  for (const S power : {S(0.3), S(0.5), S(0.8)}) {
    for (const S q : {S(0.2), S(-0.03), S(0.005), S(0.001), S(0)}) {
      const Funnel<S> f = Funnel<S>::armed(q, S(1.05), S(0.005), S(8));
      const FunnelBounds<S> at_once = funnel_bounds(f, shape(power), S(0));
      EXPECT_LT(at_once.lower, q);
      EXPECT_LT(q, at_once.upper);
      const S z = normalise(at_once, q, S(0), S(0.99)).z;
      EXPECT_LT(std::abs(z), f.side == S(0) ? S(1 / 1.05) : S(0.05 / 1.05)) << q;
      for (int k = 0; k < 1000; ++k) {
        const FunnelBounds<S> b = funnel_bounds(f, shape(power), S(0.01) * static_cast<S>(k));
        EXPECT_LT(b.lower, b.upper);
      }
      const S dt = S(1e-3);  // before t_f: rho - rho_inf = rho_0 (dt / t_f)^(1/p), below 3e-5 rho_0 for p = 0.8
      const FunnelBounds<S> before = funnel_bounds(f, shape(power), S(8) - dt),
                            after = funnel_bounds(f, shape(power), S(8));
      EXPECT_NEAR(before.upper, after.upper, 1e-4 * f.rho_0 + 1e-8);
      EXPECT_NEAR(before.upper_dot, 0, 0.06 * f.rho_0) << "slope 1/(p t_f) (dt/t_f)^(1/p - 1): 0.017 for p = 0.8";
      EXPECT_EQ(after.upper_dot, S(0));
    }
  }
}

TEST(Funnel, OpensByWhatItWasArmedWith) {
  const Funnel<double> f = Funnel<double>::armed(-0.2, 1.05, 0.005, 8);
  const FunnelBounds<double> b = funnel_bounds(f, shape<double>(), 0.0);
  EXPECT_NEAR(b.lower, -2 * (1.05 * 0.2 + 0.005) + 0.005,
              1e-15);  // (side - delta_1) rho - rho_inf side, rho(0) = rho_0 + rho_inf
  EXPECT_NEAR(b.upper, 0.005, 1e-15);
}

TEST(TransformedError, IsThePrintedOneAndItsDerivative) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> unit(0, 1);
  for (int k = 0; k < 500; ++k) {
    const Funnel<double> f = Funnel<double>::armed(unit(random) - 0.5, 1.05, 0.005, 8);
    const double t = 9 * unit(random), share = 0.01 + 0.98 * unit(random), rate = 0.02 * (unit(random) - 0.5);
    const FunnelBounds<double> b = funnel_bounds(f, shape<double>(), t);
    const double q = b.lower + share * (b.upper - b.lower);
    const Normalised<double> n = normalise(b, q, rate, 0.99);
    // Equations (13) and (14): ln((q - rho1) / (rho2 - q)) and its derivative term by term.
    const double eps = std::log((q - b.lower) / (b.upper - q));
    const double eps_dot = (rate - b.lower_dot) / (q - b.lower) + (rate - b.upper_dot) / (b.upper - q);
    EXPECT_NEAR(n.eps, eps, 1e-10);
    EXPECT_NEAR(n.eps_dot, eps_dot, 1e-10 * (1 + std::abs(eps_dot)));
    const double dt = 1e-6;
    const auto eps_at = [&](double s) {
      return normalise(funnel_bounds(f, shape<double>(), t + s), q + rate * s, rate, 0.99).eps;
    };
    // Central difference: third derivative times dt^2, and rounding of eps over dt.
    if (std::abs(t - 8) > 1e-3) {
      EXPECT_NEAR(n.eps_dot, (eps_at(dt) - eps_at(-dt)) / (2 * dt), 1e-6 * (1 + std::abs(n.eps_dot)));
    }
  }
}

TYPED_TEST(PrescribedPerformanceLaw, OutsideTheFunnelTheTransformationGoesOnAlongItsTangent) {
  using S = TypeParam;
  const FunnelBounds<S> b = funnel_bounds(Funnel<S>::armed(S(0.2), S(1.05), S(0.005), S(8)), shape<S>(), S(1));
  const S width = b.upper - b.lower, middle = (b.upper + b.lower) / 2;
  const auto eps_at = [&](S z) { return normalise(b, middle + z * width / 2, S(0), S(0.9)).eps; };
  const S slope = S(2) / (S(1) - S(0.81));
  EXPECT_NEAR(eps_at(S(0.9)), std::log(1.9 / 0.1), 1e-4);
  EXPECT_NEAR(eps_at(S(1)) - eps_at(S(0.95)), slope * S(0.05), 1e-4);
  EXPECT_NEAR(eps_at(S(-50)), -std::log(1.9 / 0.1) - slope * S(49.1), 1e-1);
}

template <class S>
Setup<S> orthogonal() {
  return vehicle_with<S>(satellite_inertia<S>(), Mat3<S>::Identity(), S(0.2), S(0.01));
}

template <class S>
Estimate<S> turned_by(const Vec3<S>& euler_angles, S sign = S(1)) {
  Measurement<S> y;
  const Quat<S> q = quat_from_euler(euler_angles);
  y.q_NB = Quat<S>(sign * q.w(), sign * q.x(), sign * q.y(), sign * q.z());
  y.h_w = VecN<S>::Zero(3);
  return Estimate<S>::healthy(y);
}

TYPED_TEST(PrescribedPerformanceLaw, ArmsAtTheStartAtJumpsAndAtDetectedFaults) {
  using S = TypeParam;
  using C = PrescribedPerformance<S>;
  const gyrostat::Setup<S> setup = orthogonal<S>();
  for (const auto arming : {C::Arming::adaptive, C::Arming::fixed}) {
    typename C::Params p(setup);
    p.arming = arming;
    Alone<C> law(unchecked, setup, p);
    const bool adaptive = arming == C::Arming::adaptive;
    Estimate<S> x = turned_by<S>({S(0.3), S(-0.2), S(0)});
    Detection<S> det;
    Reference<S> ref;
    const auto count = [&](const char* name) { return telemetry_of(law).at(name)[0]; };
    (void)law.start(x, det, ref);
    EXPECT_EQ(count("arms"), 1);
    for (int k = 0; k < 100; ++k) (void)law.step(x, det, ref, {});
    EXPECT_EQ(count("arms"), 1);
    det.event = 1;
    (void)law.step(x, det, ref, {});
    EXPECT_EQ(count("arms"), adaptive ? 2 : 1);
    ref.q_NR = quat_from_euler<S>({S(-0.5), S(0.4), S(0.6)});
    ref.event = 1;
    const Demand<S> demand = law.step(x, det, ref, {});
    EXPECT_EQ(count("arms"), adaptive ? 3 : 1);
    EXPECT_EQ(count("breaches"), adaptive ? 0 : 1);
    EXPECT_EQ(demand.status.has(Flag::breach), !adaptive);
    EXPECT_EQ(count("margin") > 0, adaptive);
    EXPECT_TRUE(demand.tau_B.allFinite());
    (void)law.step(x, det, ref, {});
    EXPECT_EQ(count("breaches"), adaptive ? 0 : 1) << "counted when it is left, not while it is outside";
    EXPECT_LE(count("lowest_margin"), count("margin"));
  }
}

TYPED_TEST(PrescribedPerformanceLaw, ClosesInTheTimeThatTheTorqueAtHandNeeds) {
  using S = TypeParam;
  using C = PrescribedPerformance<S>;
  const gyrostat::Setup<S> setup = orthogonal<S>();
  auto law = alone<C>(setup);
  Estimate<S> x = turned_by<S>({S(0.5), S(0), S(0)});
  x.effectiveness[0] = S(0.25);
  (void)law.start(x, {}, {});
  // sqrt(4 kappa angle J / (u_max e)), twice that of the healthy actuator
  EXPECT_NEAR(telemetry_of(law).at("closing_time")[0], std::sqrt(4 * 2 * 0.5 * 20 / (0.2 * 0.25)), 1e-3);
}

TYPED_TEST(PrescribedPerformanceLaw, BothSignsOfTheQuaternionStartTheShortWay) {
  using S = TypeParam;
  const gyrostat::Setup<S> setup = orthogonal<S>();
  Alone<PrescribedPerformance<S>> one(unchecked, setup, typename PrescribedPerformance<S>::Params(setup)), other(one);
  Alone<FastTerminalSlidingMode<S>> slide(unchecked, setup, typename FastTerminalSlidingMode<S>::Params(setup)),
      glide(slide);
  const Vec3<S> angles{S(0.3), S(-0.2), S(0.1)};
  const Estimate<S> plus = turned_by<S>(angles), minus = turned_by<S>(angles, S(-1));
  EXPECT_EQ(one.start(plus, {}, {}).tau_B, other.start(minus, {}, {}).tau_B);
  const Vec3<S> tau = slide.start(plus, {}, {}).tau_B;
  EXPECT_EQ(tau, glide.start(minus, {}, {}).tau_B);
  EXPECT_LT(tau[0], S(0)) << "against the roll angle";
}

TYPED_TEST(PrescribedPerformanceLaw, TheTerminalLawIsTheClosedFormAtRest) {
  using S = TypeParam;
  using C = FastTerminalSlidingMode<S>;
  const gyrostat::Setup<S> setup = orthogonal<S>();
  typename C::Params p(setup);
  p.b1 = S(0.2), p.b2 = S(0.01), p.b3 = S(15), p.b4 = S(0.05), p.s_core = S(1e-3);
  Alone<C> law(unchecked, setup, p);
  const Demand<S> demand = law.start(turned_by<S>({S(0.3), S(0), S(0)}), {}, {});
  const double q = std::sin(0.15), s = 0.2 * q + 0.01 * std::pow(q, 0.6);
  EXPECT_NEAR(demand.tau_B[0], -15 * s - 0.05 * std::pow(s, 0.6), 1e-5);
  EXPECT_EQ(demand.tau_B[1], S(0));
}

TEST(PrescribedPerformance, RefusesWhatCannotWork) {
  using C = PrescribedPerformance<double>;
  const gyrostat::Setup<double> setup = orthogonal<double>();
  typename C::Params p(setup);
  EXPECT_TRUE(C::check(setup, p).ok());
  p.eta = 1;  // the error would start on the funnel
  EXPECT_EQ(C::check(setup, p).code, Status<double>::Code::refused);
  p = typename C::Params(setup);
  p.z_max = 0.999;  // slope 1000: faster than the sample
  EXPECT_EQ(C::check(setup, p).code, Status<double>::Code::unstable);
  p = typename C::Params(setup);
  p.b3 = 1e4;
  EXPECT_EQ(C::check(setup, p).code, Status<double>::Code::unstable);
}

/// Half a turn and a little more about x: the short way is negative.
template <class S>
Estimate<S> beyond_half_a_turn(S by) {
  Measurement<S> y;
  const S half = S(1.57079632679489662) + by / S(2);
  y.q_NB = Quat<S>(std::cos(half), std::sin(half), S(0), S(0));
  y.h_w = VecN<S>::Zero(3);
  return Estimate<S>::healthy(y);
}

TYPED_TEST(PrescribedPerformanceLaw, TakesTheShortWayAtAJumpAndKeepsItBetweenJumps) {
  using S = TypeParam;
  const gyrostat::Setup<S> setup = orthogonal<S>();
  const auto expect = [&](auto law) {
    auto fresh = law;
    const auto q_error = [](const auto& l) { return telemetry_of(l).at("q_error")[0]; };
    Reference<S> ref;
    Detection<S> det;
    (void)law.start(beyond_half_a_turn(S(-0.02)), det, ref);
    EXPECT_NEAR(q_error(law), 1, 1e-3);
    // The body turns past half a turn: no jump of the reference, so the law does not change its mind, a fault or not.
    for (const std::uint32_t event : {0u, 1u}) {
      det.event = event;
      (void)law.step(beyond_half_a_turn(S(0.02)), det, ref, {});
      EXPECT_NEAR(q_error(law), 1, 1e-3) << event;
    }
    ref.event = 1;
    const Vec3<S> tau_B = law.step(beyond_half_a_turn(S(0.02)), det, ref, {}).tau_B;
    EXPECT_NEAR(q_error(law), -1, 1e-3);
    EXPECT_EQ(tau_B, fresh.start(beyond_half_a_turn(S(0.02)), det, ref).tau_B) << "as one that starts there";
    EXPECT_NEAR(q_error(fresh), -1, 1e-3);
  };
  expect(alone<PrescribedPerformance<S>>(setup));
  expect(alone<FastTerminalSlidingMode<S>>(setup));
}

TEST(PrescribedPerformance, AJumpOfTheStateArmsAnewOnTheShortWay) {
  using C = PrescribedPerformance<double>;
  const gyrostat::Setup<double> setup = orthogonal<double>();
  auto law = alone<C>(setup), fresh = law;
  Estimate<double> x = beyond_half_a_turn(-0.02);
  (void)law.start(x, {}, {});
  for (int k = 0; k < 100; ++k) (void)law.step(x, {}, {}, {});
  x = beyond_half_a_turn(0.02);
  x.event = 1;
  const Vec3<double> tau_B = law.step(x, {}, {}, {}).tau_B;
  EXPECT_EQ(tau_B, fresh.start(x, {}, {}).tau_B) << "as one that starts there";
  EXPECT_EQ(telemetry_of(law).at("arms")[0], 2);
  (void)law.step(x, {}, {}, {});
  EXPECT_EQ(telemetry_of(law).at("arms")[0], 2) << "once";
}

TEST(PrescribedPerformance, AnArmBeginsTheFunnelAnewAndAStartForgetsTheBreaches) {
  using C = PrescribedPerformance<double>;
  const gyrostat::Setup<double> setup = orthogonal<double>();
  Alone<C> law(unchecked, setup, typename C::Params(setup)), fresh = law;
  const Estimate<double> far = turned_by<double>({0.3, -0.2, 0.1}), near = turned_by<double>({0.01, 0.02, 0.4});
  Detection<double> det;
  (void)law.start(far, det, {});
  for (int k = 0; k < 3000; ++k) (void)law.step(far, det, {}, {});  // the funnel closes on an error that does not move
  EXPECT_EQ(telemetry_of(law).at("breaches")[0], 1);
  det.event = 1;
  const Vec3<double> tau_B = law.step(near, det, {}, {}).tau_B;
  EXPECT_EQ(tau_B, fresh.start(near, det, {}).tau_B) << "the time of the old funnel is over";
  (void)law.start(far, det, {});
  EXPECT_EQ(telemetry_of(law).at("breaches")[0], 0);
  EXPECT_EQ(telemetry_of(law).at("arms")[0], 1);
  EXPECT_GT(telemetry_of(law).at("lowest_margin")[0], 0);
}

TEST(PrescribedPerformance, CountsTheTorqueOfRegularActuatorsOnTheirWeakerSide) {
  using C = PrescribedPerformance<double>;
  gyrostat::Setup<double> setup =
      vehicle_with<double>(satellite_inertia<double>(), Mat3N<double>(pyramid<double>()), 0.2, 0.01);
  setup.vehicle.spare.set(3);
  setup.vehicle.u_lo[1] = -0.1;
  auto law = alone<C>(setup);
  Measurement<double> y;
  y.q_NB = quat_from_euler<double>({0.5, 0, 0});
  y.h_w = VecN<double>::Zero(4);
  (void)law.start(Estimate<double>::healthy(y), {}, {});
  const double torque = (0.2 + 0.1 + 0.2) / std::sqrt(3.0);
  EXPECT_NEAR(telemetry_of(law).at("closing_time")[0], std::sqrt(4 * 2 * 0.5 * 20 / torque), 1e-12);
}

TEST(PrescribedPerformance, SubtractsTheEstimatedTorqueOnce) {
  const gyrostat::Setup<double> setup = orthogonal<double>();
  const auto expect = [&](auto law) {
    Estimate<double> x = turned_by<double>({0.3, -0.2, 0.1});
    const Vec3<double> without = law.start(x, {}, {}).tau_B;
    x.d_B = {0.1, -0.2, 0.3};
    EXPECT_LT((without - law.start(x, {}, {}).tau_B - x.d_B).norm(), 1e-15);
  };
  expect(alone<PrescribedPerformance<double>>(setup));
  expect(alone<FastTerminalSlidingMode<double>>(setup));
}

TEST(PrescribedPerformance, AsPrintedTheGyroscopicTorqueHasTheOtherSignAndTheReferenceNoMotion) {
  using C = PrescribedPerformance<double>;
  const gyrostat::Setup<double> setup = orthogonal<double>();
  typename C::Params p(setup);
  Alone<C> law(unchecked, setup, p);
  p.as_printed = true;
  Alone<C> printed(unchecked, setup, p);
  Estimate<double> x = turned_by<double>({0.3, -0.2, 0.1});
  x.omega_BN_B = {0.1, -0.2, 0.05};
  x.h_w << 1, -2, 3;
  const Vec3<double> gyroscopic = x.omega_BN_B.cross(setup.vehicle.J_B * x.omega_BN_B + x.h_w);
  const Vec3<double> difference = law.start(x, {}, {}).tau_B - printed.start(x, {}, {}).tau_B;
  EXPECT_LT((difference - 2 * gyroscopic).norm(), 1e-14) << "a reference at rest";
  Reference<double> moving;
  moving.omegadot_RN_R = {0.01, 0.02, -0.01};
  EXPECT_EQ(printed.start(x, {}, moving).tau_B, printed.start(x, {}, {}).tau_B);
}

TEST(Funnel, AroundAnErrorOfNothingOpensByItsFloor) {
  for (const double q : {0.0, 0.004, -0.004}) {
    const Funnel<double> f = Funnel<double>::armed(q, 1.05, 0.005, 8);
    const FunnelBounds<double> b = funnel_bounds(f, shape<double>(), 0.0);
    EXPECT_NEAR(b.upper, 1.05 * 0.005 + 0.005, 1e-17);
    EXPECT_NEAR(b.lower, -(1.05 * 0.005 + 0.005), 1e-17);
  }
}

TEST(PrescribedPerformance, CountsTheSteepestSlopeOfItsTerminalPartForStability) {
  using C = PrescribedPerformance<double>;
  const gyrostat::Setup<double> setup = orthogonal<double>();
  typename C::Params p(setup);
  p.b4 = 1;
  // (2 - r) s_core^(r-1) dt < 2 J of the smallest inertia, 14.8, at s_core = (1.4 / 2968)^(1 / 0.4) = 4.8e-9
  p.b3 = 0;
  p.s_core = 3e-9;
  EXPECT_EQ(C::check(setup, p).code, Status<double>::Code::unstable);
  p.s_core = 7e-9;
  EXPECT_TRUE(C::check(setup, p).ok());
}

}  // namespace
}  // namespace gyrostat::test::test_prescribed_performance
