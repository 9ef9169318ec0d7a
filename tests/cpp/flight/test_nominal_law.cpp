// SPDX-License-Identifier: MIT
#include "gyrostat/flight/controllers/parts/nominal_law.hpp"

#include <gtest/gtest.h>

#include "../random.hpp"
#include "alone.hpp"
#include "closed_loop.hpp"
#include "gyrostat/flight/allocators/pseudo_inverse.hpp"
#include "gyrostat/flight/controllers/finite_time.hpp"
#include "gyrostat/flight/detectors/none.hpp"
#include "gyrostat/flight/observers/passthrough.hpp"
#include "gyrostat/flight/stack.hpp"
#include "li2018.hpp"

namespace gyrostat::test::test_nominal_law {
namespace {

template <class S>
using Stack = FlightStack<PassthroughObserver<S>, NoDetector<S>, FiniteTime<S>, PseudoInverse<S>>;

template <class S>
Stack<S> nominal_stack(const gyrostat::Setup<S>& s, const typename NominalLaw<S>::Params& p) {
  typename Stack<S>::Params all(s);
  all.controller = p;
  return Stack<S>(unchecked, s, all);
}

gyrostat::Setup<double> unlimited(double dt) { return li2018::setup(std::numeric_limits<double>::infinity(), dt); }

Demand<double> ask(Alone<FiniteTime<double>>& law, const Quat<double>& q, const Vec3<double>& omega,
                   const Vec3<double>& d_B = Vec3<double>::Zero()) {
  Measurement<double> y;
  y.q_NB = q;
  y.omega_BN_B = omega;
  y.h_w = VecN<double>::Zero(4);
  Estimate<double> x = Estimate<double>::healthy(y);
  x.d_B = d_B;
  return law.start(x, {}, {});
}

TEST(NominalLaw, IsThePublishedFormulaWrittenOut) {
  const auto setup = unlimited(0.001);
  Alone<FiniteTime<double>> law(unchecked, setup, li2018::controller<double>().nominal);
  Random random(11);
  for (int trial = 0; trial < 100; ++trial) {
    const Vec3<double> rho = 0.5 * random.vector<double>(1), omega = random.vector<double>(1.5);
    const double r2 = rho.squaredNorm(), b1 = 0.9, b2 = 1.8 / 1.9;
    Vec3<double> powered;
    for (int i = 0; i < 3; ++i) powered[i] = std::copysign(std::pow(std::abs(rho[i]), b1), rho[i]);
    Mat3<double> cross;
    cross << 0, -rho[2], rho[1], rho[2], 0, -rho[0], -rho[1], rho[0], 0;
    const Mat3<double> G = 0.5 * ((1 - r2) / 2 * Mat3<double>::Identity() + cross + rho * rho.transpose());
    Vec3<double> tau = -4.9 * G.transpose() * powered;
    for (int i = 0; i < 3; ++i) {
      const double a = std::abs(omega[i]);
      tau[i] -= 3 * (omega[i] < 0 ? -1 : 1) * (a <= 1 ? std::pow(a, b2) : 1);
    }
    EXPECT_LT((ask(law, quat_from_mrp(rho), omega).tau_B - tau).norm(), 1e-14);  // some tens of roundings of 5 N m
  }
}

TEST(NominalLaw, AsksForNothingAtRestOnTarget) {
  Alone<FiniteTime<double>> law(unchecked, unlimited(0.001), li2018::controller<double>().nominal);
  EXPECT_EQ(ask(law, Quat<double>::Identity(), Vec3<double>::Zero()).tau_B.norm(), 0);
}

TEST(NominalLaw, BothSignsOfTheQuaternionAreOneAttitude) {
  Alone<FiniteTime<double>> law(unchecked, unlimited(0.001), li2018::controller<double>().nominal);
  Random random(12);
  for (int trial = 0; trial < 50; ++trial) {
    const Quat<double> q = random.attitude<double>();
    const Vec3<double> omega = random.vector<double>(0.1);
    EXPECT_EQ(ask(law, q, omega).tau_B, ask(law, Quat<double>(-q.coeffs()), omega).tau_B);
  }
}

TEST(NominalLaw, FiniteTimeSubtractsTheEstimatedTorque) {
  Alone<FiniteTime<double>> law(unchecked, unlimited(0.001), li2018::controller<double>().nominal);
  const Vec3<double> d_B{0.01, -0.02, 0.03};
  EXPECT_EQ(ask(law, Quat<double>::Identity(), Vec3<double>::Zero(), d_B).tau_B, Vec3<double>(-d_B));
}

TEST(NominalLaw, PublishedLyapunovFunctionDoesNotGrow) {  // Li et al. 2018, eq. (21)
  const auto setup = unlimited(0.001);
  const auto p = li2018::controller<double>().nominal;
  auto stack = nominal_stack<double>(setup, p);
  Body body(setup.vehicle);
  body.q_NB = quat_from_mrp<double>({-0.1579, 0.1368, 0.0947});
  double before = std::numeric_limits<double>::infinity(), growth = 0;
  fly(stack, body, setup.dt, 100000, nullptr, [&](int) {
    const Vec3<double> rho = mrp(body.q_NB);
    double V = 0.5 * body.omega_BN_B.dot(body.J_B * body.omega_BN_B);
    for (int i = 0; i < 3; ++i) V += p.k1 / (1 + p.beta1) * std::pow(std::abs(rho[i]), 1 + p.beta1);
    growth = std::max(growth, V - before);
    before = V;
  });
  EXPECT_LT(growth, 1e-15);  // V starts at 0.1 and is computed to a few roundings of what is left of it
  EXPECT_LT(mrp(body.q_NB).norm(), 1e-4);
}

TEST(NominalLaw, SettlesAsMeasuredInTheStudy) {
  // Theorem 2 alone, no fault, no disturbance: 65.9 s to 1e-4 (reference implementation of the li2018 study).
  const auto setup = unlimited(0.01);
  auto stack = nominal_stack<double>(setup, li2018::controller<double>().nominal);
  Body body(setup.vehicle);
  body.q_NB = quat_from_mrp<double>({-0.1579, 0.1368, 0.0947});
  double last_outside = 0;
  fly(stack, body, setup.dt, 10000, nullptr, [&](int k) {
    if (mrp(body.q_NB).cwiseAbs().maxCoeff() > 1e-4) last_outside = k * setup.dt;
  });
  EXPECT_NEAR(last_outside, 65.9, 0.1);
}

TEST(NominalLaw, FollowsAnAcceleratingReference) {
  const auto setup = unlimited(0.01);
  auto stack = nominal_stack<double>(setup, NominalLaw<double>::Params(ftc_4rw<double>()));
  Body body(setup.vehicle);
  Reference<double> ref;
  const Vec3<double> axis = Vec3<double>(1, -2, 2) / 3;
  const double rate = 0.05, f = 0.1;  // a turn about a fixed axis, at the rate 0.05 sin(0.1 t)
  fly(
      stack, body, setup.dt, 12000,
      [&](int k) {
        const double t = k * setup.dt;
        ref.q_NR = quat_exp<double>(rate / f * (1 - std::cos(f * t)) * axis);
        ref.omega_RN_R = rate * std::sin(f * t) * axis;
        ref.omegadot_RN_R = rate * f * std::cos(f * t) * axis;
      },
      nullptr, &ref);
  // The hold delays the feed-forward by half a period: 0.005 s of 5e-4 rad/s^3 * 20 kg m^2 = 5e-5 N m against a stiffness of
  // 1.6 N m per MRP. Without feed-forward the error would be 0.1 N m / 1.6 N m.
  EXPECT_LT(rotation_angle<double>(ref.q_NR.conjugate() * body.q_NB), 1e-3);
}

TEST(NominalLaw, DefaultsAskForTheAuthorityAtFortyFiveDegrees) {
  const auto setup = ftc_4rw<double>();
  auto law = alone<FiniteTime<double>>(setup);
  const Quat<double> q = quat_exp<double>({0, 0, 3.14159265358979323846 / 4});
  EXPECT_NEAR(ask(law, q, Vec3<double>::Zero()).tau_B.norm(), torque_authority(setup.vehicle), 1e-12);
}

TEST(NominalLawCheck, RefusesADampingThatTheSampleCannotCarry) {
  const auto setup = ftc_4rw<double>();
  auto p = li2018::controller<double>().nominal;
  EXPECT_TRUE(FiniteTime<double>::check(setup, p).ok());
  p.k2 = 3001;  // k2 dt > 2 * 14.9 kg m^2
  EXPECT_EQ(FiniteTime<double>::check(setup, p).code, Status<double>::Code::unstable);
  auto euler = setup;
  euler.vehicle.coordinates = Coordinates::euler_angles;
  EXPECT_EQ(FiniteTime<double>::check(euler, p).code, Status<double>::Code::wrong_chart);
}

}  // namespace
}  // namespace gyrostat::test::test_nominal_law
