// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include "../random.hpp"
#include "alone.hpp"
#include "closed_loop.hpp"
#include "gyrostat/flight/allocators/pseudo_inverse.hpp"
#include "gyrostat/flight/observers/adaptive_sliding_mode_effectiveness.hpp"
#include "gyrostat/flight/observers/learning_effectiveness.hpp"
#include "gyrostat/flight/observers/learning_effectiveness_printed.hpp"
#include "telemetry_log.hpp"
#include "vehicles.hpp"

namespace gyrostat::test::test_learning_observers {
namespace {

/// Steps `observer` along `body` under u(k), calls `look(k, estimate, last)`.
template <class Observer, class Command, class Look>
void watch(Observer& observer, Body& body, double dt, int samples, Command&& command, Look&& look) {
  using S = typename Observer::Scalar;
  Allocation<S> last = Allocation<S>::idle(static_cast<int>(body.D_B.cols()));
  (void)observer.start(body.measured<S>(0));
  for (int k = 1; k <= samples; ++k) {
    last.u = command(k - 1).template cast<S>();
    body.advance(last.u.template cast<double>(), dt);
    look(k, observer.step(body.measured<S>(static_cast<Tick>(k)), last), last);
  }
}

template <class S>
class LearningObservers : public testing::Test {};
using Scalars = testing::Types<float, double>;
TYPED_TEST_SUITE(LearningObservers, Scalars);

/// 0.15 N m a wheel, each with a sign pattern of its own, so that all four directions of command are visited.
VecN<double> exciting(int k) {
  VecN<double> u(4);
  for (int i = 0; i < 4; ++i) u[i] = ((k / (8 << i)) % 2 == 0) ? 0.15 : -0.15;
  return u;
}

TYPED_TEST(LearningObservers, FourWheelsAreToldApartOnceTheirCommandsVary) {
  using S = TypeParam;
  const Setup<S> setup = ftc_4rw<S>();
  Body body(setup.vehicle);
  body.effectiveness << 0.4, 1.0, 0.7, 0.05;
  auto observer = alone<LearningEffectivenessObserver<S>>(setup);
  Estimate<S> x;
  watch(observer, body, 0.01, 3000, exciting, [&](int, const Estimate<S>& now, const auto&) { x = now; });
  for (int i = 0; i < 4; ++i) {
    // Float resolves the rate to 1e-9 rad/s or so: 2e-6 N m of residual, far below the command.
    EXPECT_NEAR(static_cast<double>(x.effectiveness[i]), body.effectiveness[i], sizeof(S) == 8 ? 1e-3 : 5e-3) << i;
    EXPECT_TRUE(std::isfinite(x.effectiveness_bound[i])) << i;
    EXPECT_LE(std::abs(static_cast<double>(x.effectiveness[i]) - body.effectiveness[i]),
              static_cast<double>(x.effectiveness_bound[i] * x.effectiveness[i]))
        << i;
  }
}

TYPED_TEST(LearningObservers, AnActuatorThatIsNotCommandedIsHeldToTheBitAndUnknown) {
  using S = TypeParam;
  const Setup<S> setup = ftc_4rw<S>();
  Body body(setup.vehicle);
  body.effectiveness[3] = 0.5;
  auto observer = alone<LearningEffectivenessObserver<S>>(setup);
  watch(
      observer, body, 0.01, 500,
      [](int k) {
        VecN<double> u = exciting(k);
        u[3] = 1e-4;
        return u;
      },
      [](int, const Estimate<S>& x, const auto&) {
        EXPECT_EQ(x.effectiveness[3], S(1));
        EXPECT_TRUE(std::isinf(x.effectiveness_bound[3]));
      });
}

TYPED_TEST(LearningObservers, EstimatesStayInsideTheirRangeUnderAnyCommand) {
  using S = TypeParam;
  const Setup<S> setup = ftc_4rw<S>();
  const auto inside = [&]<class Observer>(std::type_identity<Observer>) {
    typename Observer::Params p(setup);
    p.e_min = S(1e-4);
    Alone<Observer> observer(unchecked, setup, p);
    Random random(3);
    Body body(setup.vehicle);
    body.effectiveness << 0.0, 0.3, 1.0, 0.6;
    body.omega_BN_B = {0.2, -0.1, 0.3};
    watch(
        observer, body, 0.01, 400,
        [&](int) {
          VecN<double> u(4);
          for (int i = 0; i < 4; ++i) u[i] = random.uniform(-0.2, 0.2);
          return u;
        },
        [&](int, const Estimate<S>& x, const auto&) {
          EXPECT_GE(x.effectiveness.minCoeff(), p.e_min);
          EXPECT_LE(x.effectiveness.maxCoeff(), S(1));
        });
  };
  inside(std::type_identity<LearningEffectivenessObserver<S>>{});
  inside(std::type_identity<LearningEffectivenessPrintedObserver<S>>{});
  inside(std::type_identity<AdaptiveSlidingModeEffectivenessObserver<S>>{});
}

/// What pseudo_inverse drops is not commanded, so nothing could ever be learned about it again.
TYPED_TEST(LearningObservers, NoDefaultEstimateIsSoSmallThatAllocatorsDropIt) {
  using S = TypeParam;
  const Setup<S> setup = ftc_4rw<S>();
  const S least = typename PseudoInverse<S>::Params(setup).e_min;
  EXPECT_GE(typename LearningEffectivenessObserver<S>::Params(setup).e_min, least);
  EXPECT_GE(typename LearningEffectivenessPrintedObserver<S>::Params(setup).e_min, least);
  EXPECT_GE(typename AdaptiveSlidingModeEffectivenessObserver<S>::Params(setup).e_min, least);
}

TEST(LearningEffectivenessDouble, IsTheSumAnAxisOnThreeOrthogonalWheels) {
  const Mat3<double> J = Vec3<double>(36, 17, 26).asDiagonal();
  const auto setup = vehicle_with<double>(J, Mat3N<double>(Mat3<double>::Identity()), 20, 0.01);
  LearningEffectivenessObserver<double>::Params p(setup);
  p.u0 = p.u_exc = p.torque_error = 0.3;
  p.memory = 30;
  p.M = {80, 50, 60};
  Alone<LearningEffectivenessObserver<double>> observer(unchecked, setup, p);
  Measurement<double> y;
  y.h_w = VecN<double>::Zero(3);
  (void)observer.start(y);
  Allocation<double> last = Allocation<double>::idle(3);
  last.u << 4, -3, 0.2;
  y.omega_BN_B = Vec3<double>(0.6 * 4 / 36, -0.8 * 3 / 17, 0) * 0.01;  // e = 0.6 and 0.8, no gyroscopic torque yet
  const auto x = observer.step(y, last);
  // residual u (e - 1) up to the gyroscopic torque of the prediction, 1e-5 N m
  EXPECT_NEAR(x.effectiveness[0], 1 - 0.4 * 0.03 * 16 / (16 + 0.09), 1e-6);
  EXPECT_NEAR(x.effectiveness[1], 1 - 0.2 * 0.03 * 9 / (9 + 0.09), 1e-6);
  EXPECT_EQ(x.effectiveness[2], 1.0);
}

TEST(LearningEffectivenessDouble, AFaultMakesItsWheelUnknownAtOnceAndLearningMakesItKnownAgain) {
  const Mat3<double> J = Vec3<double>(36, 17, 26).asDiagonal();
  const auto setup = vehicle_with<double>(J, Mat3N<double>(Mat3<double>::Identity()), 20, 0.01);
  LearningEffectivenessObserver<double>::Params p(setup);
  p.u0 = p.u_exc = 0.3;
  p.M.setConstant(50);
  p.memory = 30;
  p.torque_error = 0.02;
  Alone<LearningEffectivenessObserver<double>> observer(unchecked, setup, p);
  Body body(setup.vehicle);
  VecN<double> u(3);
  watch(
      observer, body, 0.01, 1000,
      [&](int k) {
        if (k == 500) body.effectiveness[1] = 0.5;
        u << 2, 2, 2;
        return VecN<double>((k / 50) % 2 == 0 ? u : VecN<double>(-u));
      },
      [&](int k, const Estimate<double>& x, const auto&) {
        if (k == 500) {
          EXPECT_TRUE(x.effectiveness_bound.allFinite());
        }
        if (k == 501) {
          EXPECT_TRUE(std::isinf(x.effectiveness_bound[1]));
          EXPECT_TRUE(std::isfinite(x.effectiveness_bound[0]));
        }
        if (k == 1000) {
          EXPECT_NEAR(x.effectiveness[1], 0.5, 1e-3);
          EXPECT_LT(x.effectiveness_bound[1], 0.3);
        }
      });
}

TEST(LearningEffectivenessDouble, WheelMomentumBelongsToTheModel) {
  auto setup = ftc_4rw<double>();
  auto observer = alone<LearningEffectivenessObserver<double>>(setup);
  const Mat3<double>& J = setup.vehicle.J_B;
  Measurement<double> y;
  y.h_w = VecN<double>(4);
  y.h_w << 5, -2.5, 1.25, 0.5;
  y.omega_BN_B = {0.01, -0.02, 0.03};
  Allocation<double> last = Allocation<double>::idle(4);
  (void)observer.start(y);
  for (int k = 0; k < 300; ++k) {
    last.u = exciting(k);
    for (int j = 0; j < 20; ++j) {  // midpoint rule, 20 steps a period
      const double h = setup.dt / 20;
      const auto rate = [&](const Vec3<double>& w, const VecN<double>& hw) {
        return Vec3<double>(J.inverse() * (setup.vehicle.D_B * last.u - w.cross(J * w + setup.vehicle.D_B * hw)));
      };
      const Vec3<double> middle = y.omega_BN_B + h / 2 * rate(y.omega_BN_B, y.h_w);
      y.omega_BN_B += h * rate(middle, y.h_w - h / 2 * last.u);
      y.h_w -= h * last.u;
    }
    const auto x = observer.step(y, last);
    EXPECT_GT(x.effectiveness.minCoeff(), 1 - 1e-5);  // w x D h_w is 0.1 N m, most of a command
  }
}

TEST(LearningEffectivenessPrintedDouble, EndsAtTheFixedPointThatTheLeakLeaves) {
  const Mat3<double> J = 26 * Mat3<double>::Identity();
  const auto setup = vehicle_with<double>(J, Mat3N<double>(Mat3<double>::Identity()), 20, 0.01);
  LearningEffectivenessPrintedObserver<double>::Params p(setup);
  p.l = 0.9;
  p.direction = LearningEffectivenessPrintedObserver<double>::Direction::none;
  p.H1 = {8, 15, 12};
  p.H2 = {20, 3, 8};
  p.M = {80, 50, 60};
  Alone<LearningEffectivenessPrintedObserver<double>> observer(unchecked, setup, p);
  Body body(setup.vehicle);
  body.effectiveness << 0.8, 0.6, 1.0;
  Estimate<double> x;
  watch(
      observer, body, 0.01, 2000, [](int) { return VecN<double>(VecN<double>::Constant(3, 5)); },
      [&](int, const Estimate<double>& now, const auto&) { x = now; });
  for (int i = 0; i < 3; ++i) {
    const double fixed = 5 * body.effectiveness[i] / (5 + p.M[i] * 0.1 / (p.H1[i] + p.H2[i]));
    EXPECT_NEAR(x.effectiveness[i], fixed, 1e-6) << i;  // n = 0: (u e) / (u + M (1 - l) / (H1 + H2))
  }
}

TEST(LearningEffectivenessPrintedDouble, RefusesADelayThatIsNoWholeNumberOfPeriods) {
  const auto setup = ftc_4rw<double>();
  LearningEffectivenessPrintedObserver<double>::Params p(setup);
  EXPECT_TRUE(LearningEffectivenessPrintedObserver<double>::check(setup, p).ok());
  p.delay = 0.015;
  EXPECT_FALSE(LearningEffectivenessPrintedObserver<double>::check(setup, p).ok());
  p.delay = 1.0;
  EXPECT_FALSE(LearningEffectivenessPrintedObserver<double>::check(setup, p).ok()) << "longer than the delay line";
}

TEST(AdaptiveSlidingModeDouble, IsUnstableUnderAnAlternatingCommandWhereItsCheckSaysSo) {
  const Mat3<double> J = 20 * Mat3<double>::Identity();
  const auto setup = vehicle_with<double>(J, Mat3N<double>(Mat3<double>::Identity()), 10, 0.01);
  AdaptiveSlidingModeEffectivenessObserver<double>::Params p(setup);
  p.L.setConstant(200);
  p.rho_max = 0;
  const auto spread = [&](double factor) {  // gamma as a multiple of the limit 2 L dt / J
    p.gamma = factor * 2 * (200 * 0.01 / 20) * 20 / (100 * 1e-4);
    EXPECT_EQ((AdaptiveSlidingModeEffectivenessObserver<double>::check(setup, p).ok()), factor < 1) << factor;
    Alone<AdaptiveSlidingModeEffectivenessObserver<double>> observer(unchecked, setup, p);
    Body body(setup.vehicle);
    body.effectiveness.setConstant(0.5);
    double late = 0;
    watch(
        observer, body, 0.01, 2000,
        [](int k) { return VecN<double>(VecN<double>::Constant(3, k % 2 == 0 ? 10.0 : -10.0)); },
        [&](int k, const Estimate<double>& x, const auto&) {
          if (k > 1500) late = std::max(late, (x.effectiveness - body.effectiveness).cwiseAbs().maxCoeff());
        });
    return late;
  };
  EXPECT_LT(spread(0.9), 1e-3);
  EXPECT_GT(spread(1.2), 0.1);
}

/// A ball that is held at a rate: what the observer predicts and corrects is then elementary.
struct Held {
  gyrostat::Setup<double> setup =
      vehicle_with<double>(20 * Mat3<double>::Identity(), Mat3<double>::Identity(), 10, 0.01);
  Measurement<double> y;
  Allocation<double> last = Allocation<double>::idle(3);
  Held() { y.h_w = VecN<double>::Zero(3); }
};

TEST(AdaptiveSlidingModeDouble, TheSwitchingGainGrowsBeyondTheDeadZoneAloneUpToItsCap) {
  Held at;
  AdaptiveSlidingModeEffectivenessObserver<double>::Params p(at.setup);
  p.gamma = 100;
  p.L.setZero();
  p.k_rho = 30;
  p.rho_max = 0.01;
  p.dead_zone = 2e-3;
  Alone<AdaptiveSlidingModeEffectivenessObserver<double>> observer(unchecked, at.setup, p);
  (void)observer.start(at.y);
  at.y.omega_BN_B = {1.9e-3, -2.1e-3, 5e-3};  // inside, just beyond, far beyond
  Vec3<double> rho = Vec3<double>::Zero(), omega_hat = Vec3<double>::Zero();
  for (int k = 0; k < 40; ++k) {
    const std::vector<double> before = telemetry_of(observer).at("rho");
    (void)observer.step(at.y, at.last);
    for (int i = 0; i < 3; ++i) {
      // The prediction moves by rho sgn(error) of the sample before; the ball feels no other torque.
      const double predicted = k == 0 ? 0 : 0.01 * rho[i] / 20;
      omega_hat[i] += std::copysign(predicted, at.y.omega_BN_B[i]);
      const double error = std::abs(at.y.omega_BN_B[i] - omega_hat[i]);
      if (error > p.dead_zone) rho[i] = std::min(rho[i] + 0.01 * p.k_rho * error, p.rho_max);
      EXPECT_NEAR(telemetry_of(observer).at("rho")[static_cast<std::size_t>(i)], rho[i], 1e-16) << k;
      EXPECT_NEAR(std::abs(telemetry_of(observer).at("rate_error")[static_cast<std::size_t>(i)]), error, 1e-16) << k;
    }
  }
  EXPECT_EQ(rho[0], 0);
  EXPECT_EQ(rho[2], p.rho_max);
  (void)observer.start(at.y);
  const std::vector<double> left = telemetry_of(observer).at("rho");
  for (const double rho_i : left) EXPECT_EQ(rho_i, 0);
}

/// A body lighter than known answers more than told: 1 is issued, the rest is a torque; or it is lost, as printed.
TEST(LearningEffectivenessDouble, WhatTheIssuedEffectivenessLeavesOverIsInTheDisturbance) {
  const auto setup = ftc_4rw<double>();
  for (const bool hand_on : {true, false}) {
    LearningEffectivenessObserver<double>::Params p(setup);
    p.hand_on = hand_on;
    Alone<LearningEffectivenessObserver<double>> observer(unchecked, setup, p);
    Body body(setup.vehicle);
    body.J_B /= 1.1;
    body.effectiveness[3] = 0.01;  // below what is issued
    Estimate<double> x;
    VecN<double> u;
    watch(observer, body, 0.01, 6000, exciting, [&](int, const Estimate<double>& now, const auto& last) {
      x = now;
      u = last.u;
    });
    const VecN<double> lost = x.effectiveness - VecN<double>::Ones(4);
    EXPECT_EQ(x.effectiveness.head(3), Vec3<double>::Ones());
    EXPECT_LT(x.effectiveness[3], p.e_min + 0.02);
    // J_known w' is 1.1 times what is delivered, less what was told.
    const Vec3<double> acts = 1.1 * (setup.vehicle.D_B * body.effectiveness.cwiseProduct(u)) - setup.vehicle.D_B * u;
    const double missed = (setup.vehicle.D_B * lost.cwiseProduct(u) + x.d_B - acts).norm();
    EXPECT_EQ(x.d_B.isZero(0), !hand_on);
    EXPECT_EQ(missed < 2e-3, hand_on) << missed;
    EXPECT_EQ(missed > 5e-3, !hand_on) << missed;
  }
}

TEST(AdaptiveSlidingModeDouble, AdaptsAlongTheSignOfTheCommandAndProjects) {
  Held at;
  AdaptiveSlidingModeEffectivenessObserver<double>::Params p(at.setup);
  p.gamma = 100;
  p.L.setZero();
  p.dead_zone = 1;
  Alone<AdaptiveSlidingModeEffectivenessObserver<double>> observer(unchecked, at.setup, p);
  (void)observer.start(at.y);
  at.last.u << 2, -2, 3;
  // A rate error of 1e-3 below what the commands make on axes 0 and 1 (of either sign), above it on axis 2.
  const double h = 0.01;
  at.y.omega_BN_B = Vec3<double>(2, -2, 3) * h / 20 + Vec3<double>(-1e-3, 1e-3, 1e-3);
  const Estimate<double> x = observer.step(at.y, at.last);
  EXPECT_NEAR(x.effectiveness[0], 1 - h * 100 * 2 * 1e-3, 1e-12);
  EXPECT_NEAR(x.effectiveness[1], 1 - h * 100 * 2 * 1e-3, 1e-12);
  EXPECT_EQ(x.effectiveness[2], 1.0) << "no better than healthy";
  EXPECT_NEAR(x.d_B[2], h * 100 * 3 * 1e-3 * 3, 1e-12) << "and the rest is a torque: D is one there";
  EXPECT_EQ(observer.start(at.y).effectiveness, VecN<double>::Ones(3));
}

TEST(AdaptiveSlidingModeDouble, RefusesACorrectionThatOvershoots) {
  Held at;
  AdaptiveSlidingModeEffectivenessObserver<double>::Params p(at.setup);
  p.gamma = 0;
  p.L.setConstant(1999);  // L dt / J = 0.9995
  EXPECT_TRUE(AdaptiveSlidingModeEffectivenessObserver<double>::check(at.setup, p).ok());
  p.L.setConstant(2001);
  EXPECT_EQ(AdaptiveSlidingModeEffectivenessObserver<double>::check(at.setup, p).code, Status<double>::Code::unstable);
}

TEST(LearningEffectivenessPrintedDouble, IsThePrintedRecursionWithItsPastError) {
  Held at;
  LearningEffectivenessPrintedObserver<double>::Params p(at.setup);
  p.l = 0.9;
  p.H1 = {3, 4, 5};
  p.H2 = {6, 7, 8};
  p.M.setZero();
  p.delay = 0.02;  // two samples
  for (const auto direction : {LearningEffectivenessPrintedObserver<double>::Direction::none,
                               LearningEffectivenessPrintedObserver<double>::Direction::command}) {
    p.direction = direction;
    const bool printed = direction == LearningEffectivenessPrintedObserver<double>::Direction::none;
    Alone<LearningEffectivenessPrintedObserver<double>> observer(unchecked, at.setup, p);
    for (int restart = 0; restart < 2; ++restart) {
      // Without correction, command and torque the predicted rate stays what it was at the start: zero.
      std::vector<Vec3<double>> e{Vec3<double>::Ones(), Vec3<double>::Ones()}, error(2, Vec3<double>::Zero());
      at.y.omega_BN_B.setZero();
      at.last.u.setZero();
      for (int k = 0; k < 40; ++k) {
        if (k > 0) at.y.omega_BN_B = 1e-2 * Vec3<double>(k % 3 - 1, 1, -1);
        if (k > 0) at.last.u << 1e-15, -1e-15, 1e-15;  // too small to turn the ball, large enough to have a sign
        const Estimate<double> x = k == 0 ? observer.start(at.y) : observer.step(at.y, at.last);
        const Vec3<double>&old_e = e[e.size() - 2], &old_error = error[error.size() - 2];
        Vec3<double> now;
        for (int i = 0; i < 3; ++i) {
          const double lesson = p.H1[i] * at.y.omega_BN_B[i] + p.H2[i] * old_error[i];
          now[i] = printed ? std::clamp(p.l * old_e[i] + lesson, p.e_min, 1.0) : old_e[i];
          if (!printed && k > 0) now[i] = std::clamp(p.l * old_e[i] + (i == 1 ? -lesson : lesson), p.e_min, 1.0);
        }
        EXPECT_LT((x.effectiveness - now).norm(), 1e-12) << k;
        e.push_back(now);
        error.push_back(at.y.omega_BN_B);
      }
    }
    p.u_exc = 0;
  }
}

/// The equations of the page with dense matrices; the sample before and everything that is carried from it.
struct WrittenOut {
  gyrostat::Setup<double> setup;
  LearningEffectivenessObserver<double>::Params p;
  Vec3<double> what = Vec3<double>::Zero(), error = Vec3<double>::Zero(), injection = Vec3<double>::Zero();
  VecN<double> h_w = VecN<double>::Zero(4), e = VecN<double>::Ones(4);
  Eigen::Matrix4d P = Eigen::Matrix4d::Identity();
  int doubts = 0;  ///< that left some actuator known

  void start(const Measurement<double>& y) {
    what = y.omega_BN_B;
    h_w = y.h_w;
    error.setZero();
    injection.setZero();
    e.setOnes();
    P.setIdentity();
  }
  void step(const Measurement<double>& y, const VecN<double>& u) {
    const Mat3<double>& J = setup.vehicle.J_B;
    const Mat3N<double>& D = setup.vehicle.D_B;
    const double dt = setup.dt;
    const Vec3<double> tau = D * u.cwiseProduct(e) + injection;
    const auto rate = [&](const Vec3<double>& w, const VecN<double>& h) -> Vec3<double> {
      return J.inverse() * (tau - w.cross(J * w + D * h));
    };
    const VecN<double> half = (h_w + y.h_w) / 2;
    const Vec3<double> k1 = rate(what, h_w), k2 = rate(what + dt / 2 * k1, half), k3 = rate(what + dt / 2 * k2, half);
    what += dt / 6 * (k1 + 2 * k2 + 2 * k3 + rate(what + dt * k3, y.h_w));
    h_w = y.h_w;
    const Vec3<double> before = error;
    error = y.omega_BN_B - what;
    const Vec3<double> r = J * (error - before) / dt + injection;
    for (int i = 0; i < 4; ++i) P(i, i) = std::min(P(i, i) + dt / p.memory, 1.0);
    Eigen::Matrix<double, 3, 4> V = D * u.asDiagonal();
    for (int i = 0; i < 4; ++i)
      if (std::abs(u[i]) <= p.u_exc) V.col(i).setZero();
    if (V.norm() > 0) {
      const Eigen::Matrix3d spread = V * P * V.transpose();
      for (int axis = 0; axis < 3; ++axis) {
        if (r[axis] * r[axis] <= 9 * (spread(axis, axis) + p.torque_error * p.torque_error)) continue;
        doubts += V.row(axis).cwiseAbs().minCoeff() <= 0.5 * V.row(axis).cwiseAbs().maxCoeff() ? 1 : 0;
        for (int i = 0; i < 4; ++i) {
          if (std::abs(V(axis, i)) <= 0.5 * V.row(axis).cwiseAbs().maxCoeff()) continue;
          P.row(i).setZero();
          P.col(i).setZero();
          P(i, i) = 1;
        }
      }
      const Eigen::Matrix3d normal = V * V.transpose() + p.u0 * p.u0 * Eigen::Matrix3d::Identity();
      const Eigen::Matrix<double, 4, 3> K = p.kappa * V.transpose() * normal.inverse();
      for (int i = 0; i < 4; ++i)
        if (std::abs(u[i]) > p.u_exc) e[i] = std::clamp(e[i] + K.row(i).dot(r), 0.0, 1.15);
      const Eigen::Matrix4d keep = Eigen::Matrix4d::Identity() - K * V;
      const double R = p.torque_error * p.torque_error * (2 - p.kappa) / p.kappa;
      P = keep * P * keep.transpose() + R * K * K.transpose();
    }
    for (int i = 0; i < 3; ++i) injection[i] = p.M[i] * error[i] + p.n * ((error[i] > 0) - (error[i] < 0));
  }
  VecN<double> issued() const { return e.cwiseMax(p.e_min).cwiseMin(1.0); }
  double bound(int i) const {
    const double half = std::sqrt(2 * std::max(P(i, i), 0.0));
    return half < p.unknown_above ? half / issued()[i] : std::numeric_limits<double>::infinity();
  }
};

TEST(LearningEffectivenessDouble, IsTheEquationsOfItsPageBoundIncluded) {
  const auto setup = ftc_4rw<double>();
  LearningEffectivenessObserver<double>::Params p(setup);
  p.kappa = 0.1;
  p.n = 0.02;
  p.torque_error = 0.005;  // a loss of actuators is beyond it: what was known is doubted
  p.memory = 3;
  Alone<LearningEffectivenessObserver<double>> observer(unchecked, setup, p);
  WrittenOut written{setup, p};
  Random random(9);
  int known = 0, weakest = 0, held = 0;
  for (int start = 0; start < 2; ++start) {
    Body body(setup.vehicle);
    body.omega_BN_B = {1.5, -1, 0.5};  // fast: the order of the prediction shows
    Measurement<double> y = body.measured<double>(0);
    Allocation<double> last = Allocation<double>::idle(4);
    (void)observer.start(y);
    written.start(y);
    for (int k = 1; k <= 600; ++k) {
      if (k == 150) body.effectiveness << 0.4, 1.0, 0.0, 0.8;
      if (k == 400) body.effectiveness[0] = 0.9;
      for (int i = 0; i < 4; ++i) last.u[i] = random.uniform(-0.2, 0.2) * (random.uniform(0, 1) < 0.2 ? 0.02 : 1);
      if (k > 450 && k < 520) last.u.setConstant(1e-3);  // nothing to learn from: it forgets
      body.advance(last.u, setup.dt);
      y = body.measured<double>(static_cast<Tick>(k));
      for (int i = 0; i < 4; ++i) y.h_w[i] = 0.02 * std::sin(0.05 * k + i);
      const Estimate<double> x = observer.step(y, last);
      written.step(y, last.u);
      const VecN<double> rest = (written.e - written.issued()).cwiseProduct(last.u);
      ASSERT_LT((x.d_B - setup.vehicle.D_B * rest).norm(), 1e-9) << k;
      for (int i = 0; i < 4; ++i) {
        ASSERT_NEAR(x.effectiveness[i], written.issued()[i], 1e-9) << k;
        if (std::abs(2 * written.P(i, i) - p.unknown_above * p.unknown_above) < 1e-9) continue;
        ASSERT_EQ(std::isinf(x.effectiveness_bound[i]), std::isinf(written.bound(i))) << k;
        if (std::isinf(written.bound(i))) continue;
        ASSERT_NEAR(x.effectiveness_bound[i], written.bound(i), 1e-8 * written.bound(i)) << k;
        ++known;
      }
      weakest += x.effectiveness.minCoeff() == p.e_min ? 1 : 0;
      held += x.effectiveness.maxCoeff() == 1 ? 1 : 0;
    }
  }
  EXPECT_GT(known, 500);
  EXPECT_GT(weakest, 50) << "both ends of the projection are reached";
  EXPECT_GT(held, 50);
  EXPECT_GT(written.doubts, 20) << "doubts that leave some actuator known";
}

}  // namespace
}  // namespace gyrostat::test::test_learning_observers
