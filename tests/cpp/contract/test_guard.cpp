// SPDX-License-Identifier: MIT
// The stack's guard: what a bad input, a bad component and a command outside its limits end in.
#include "contract/counted_eigen.hpp"  // first

#include <gtest/gtest.h>

#include <array>
#include <string_view>

#include "../flight/closed_loop.hpp"
#include "../random.hpp"
#include "any_components.hpp"

namespace gyrostat::test::test_guard {
namespace {

template <class S>
S nan_of() {
  return std::numeric_limits<S>::quiet_NaN();
}

template <class S>
class Guard : public testing::Test {};
using Scalars = testing::Types<float, double>;
TYPED_TEST_SUITE(Guard, Scalars);

/// Every observer and detector, and a few laws. (What holds for every law and allocator is in embedded.hpp.)
template <class S>
void for_every_observer(const gyrostat::Setup<S>& setup, auto&& with) {
  const std::array laws{Making<MrpFeedback<S>>::maker(), Making<IntegralSlidingMode<S>>::maker(),
                        Making<PrescribedPerformance<S>>::maker(), Making<OpenLoop<S>>::maker(),
                        Making<FiniteTime<S>>::maker()};
  const std::array allocator{Making<PseudoInverse<S>>::maker()};
  for_every_component<S>(setup, {.controllers = laws, .allocators = allocator}, with);
}

/// Flies two copies of every stack over one body, whose measurements `spoil` may change for either; after `samples`.
template <class S>
void fly_twice(int samples, const auto& spoil, const auto& compare) {
  const auto setup = ftc_4rw<S>();
  for_every_observer<S>(setup, [&](auto stack) {
    auto other = stack;
    Body body(setup.vehicle);
    body.omega_BN_B = {0.02, -0.03, 0.01};
    for (int k = 0; k < samples; ++k) {
      Measurement<S> y = body.measured<S>(static_cast<Tick>(k)), z = y;
      spoil(k, y, z);
      compare(k, stack.step(y, {}), other.step(z, {}), stack, other);
      body.advance(stack.last().u.template cast<double>(), 0.01);
    }
  });
}

/// Spoilt, or said to be invalid: the same, and the numbers beside a cleared bit are not looked at.
TYPED_TEST(Guard, WhatIsNotFiniteIsWhatWasNotMeasured) {
  using S = TypeParam;
  const auto fails = [](int k) { return k >= 20 && k < 25; };
  for (const int part : {0, 1, 2}) {
    fly_twice<S>(
        50,
        [&](int k, Measurement<S>& y, Measurement<S>& z) {
          if (!fails(k)) return;
          if (part == 0) y.q_NB.z() = nan_of<S>();
          if (part == 1) y.omega_BN_B[1] = nan_of<S>();
          if (part == 2) y.h_w[3] = nan_of<S>();
          z.attitude_valid = part != 0;
          z.rate_valid = part != 1;
          z.momentum_valid = part != 2;
          if (k == 22 && part == 0) z.q_NB.coeffs().setZero();
          if (k == 22 && part == 1) z.omega_BN_B.setConstant(S(1e30));
          if (k == 22 && part == 2) z.h_w.resize(0);
        },
        [&](int k, const Allocation<S>& a, const Allocation<S>& b, const auto& stack, const auto&) {
          EXPECT_EQ(a.u, b.u) << k;
          EXPECT_EQ(a.status.has(Flag::input_held), fails(k)) << k;
          EXPECT_EQ(b.status.has(Flag::input_held), fails(k)) << k;
          EXPECT_EQ(stack.measurement().attitude_valid, part != 0 || !fails(k));
          EXPECT_EQ(stack.measurement().rate_valid, part != 1 || !fails(k));
          EXPECT_EQ(stack.measurement().momentum_valid, part != 2 || !fails(k));
          EXPECT_EQ(stack.measurement().tick, static_cast<Tick>(k)) << "the tick is that of the sample";
        });
  }
}

/// Every input, spoilt in every way that is one: flagged, and what it touches is replaced, nothing else.
TYPED_TEST(Guard, EveryInputIsJudgedForItself) {
  using S = TypeParam;
  const Measurement<S> good = wobble<S>(1, 4);
  const auto did = [](const Measurement<S>& y, const Reference<S>& ref) {
    auto stack = stack_of<PassthroughObserver<S>, NoDetector<S>, MrpFeedback<S>, PseudoInverse<S>>(ftc_4rw<S>());
    stack.step(wobble<S>(0, 4), {});
    const Flags status = stack.step(y, ref).status;
    const GuardActions& a = stack.actions();
    EXPECT_EQ(status.has(Flag::input_held), a.measurement() || a.reference);
    EXPECT_TRUE(stack.last().u.allFinite());
    EXPECT_EQ(stack.estimate().h_w.size(), 4);
    return std::array{a.attitude, a.rate, a.momentum, a.reference};
  };
  using Did = std::array<bool, 4>;
  EXPECT_EQ(did(good, {}), (Did{false, false, false, false}));
  const S huge = std::numeric_limits<S>::max() / S(1e8);
  for (const S bad : {nan_of<S>(), std::numeric_limits<S>::infinity(), huge, -huge}) {
    Measurement<S> y = good;
    y.q_NB.w() = bad;
    EXPECT_EQ(did(y, {}), (Did{true, false, false, false}));
    y = good;
    y.omega_BN_B[2] = bad;
    EXPECT_EQ(did(y, {}), (Did{false, true, false, false}));
    y = good;
    y.h_w[2] = bad;
    EXPECT_EQ(did(y, {}), (Did{false, false, true, false}));
    Reference<S> ref;
    ref.q_NR.z() = bad;
    EXPECT_EQ(did(good, ref), (Did{false, false, false, true}));
    ref = {};
    ref.omega_RN_R[0] = bad;
    EXPECT_EQ(did(good, ref), (Did{false, false, false, true}));
    ref = {};
    ref.omegadot_RN_R[2] = bad;
    EXPECT_EQ(did(good, ref), (Did{false, false, false, true}));
    y = good;  // a body's Euler angles are for the curious, who may record them at the pole
    y.euler.rates[0] = bad;
    EXPECT_EQ(did(y, {}), (Did{false, false, false, false}));
  }
  for (const int n : {0, 1, 3, 5, 16}) {
    Measurement<S> y = good;
    y.h_w.setZero(n);
    EXPECT_EQ(did(y, {}), (Did{false, false, true, false})) << n << " wheels instead of 4";
  }
  for (const S length : {S(0), S(0.5), S(1.2), S(1e3)}) {
    Measurement<S> y = good;
    y.q_NB.coeffs() *= length;
    EXPECT_EQ(did(y, {}), (Did{true, false, false, false})) << length;
  }
  Measurement<S> y = good;
  y.attitude_valid = false;
  EXPECT_EQ(did(y, {}), (Did{true, false, false, false}));
  y = good;
  y.momentum_valid = false;
  EXPECT_EQ(did(y, {}), (Did{false, false, true, false}));
  y = wobble<S>(0, 4);
  y.tick = 7;  // not the tick of the sample before: renewed
  EXPECT_EQ(did(y, {}), (Did{false, false, false, false}));
}

TYPED_TEST(Guard, EulerAnglesAreJudgedWhereTheyAreTheState) {
  using S = TypeParam;
  auto setup = ftc_4rw<S>();
  setup.vehicle.coordinates = Coordinates::euler_angles;
  auto stack = stack_of<PassthroughObserver<S>, NoDetector<S>, OpenLoop<S>, PseudoInverse<S>>(setup);
  const auto sample = [](Tick k) {
    Measurement<S> y = wobble<S>(k, 4);
    y.euler.angles = euler(y.q_NB);
    return y;
  };
  stack.step(sample(0), {});
  Measurement<S> y = sample(1);
  y.euler.angles[1] = nan_of<S>();
  stack.step(y, {});
  EXPECT_TRUE(stack.actions().attitude);
  EXPECT_FALSE(stack.actions().rate);
  EXPECT_TRUE(stack.measurement().euler.angles.allFinite());
  Reference<S> ref;
  ref.euler_accelerations[0] = nan_of<S>();
  stack.step(sample(2), ref);
  EXPECT_TRUE(stack.actions().reference);
  EXPECT_FALSE(stack.actions().measurement());
}

TYPED_TEST(Guard, ASampleThatWasNotRenewedIsNotMeasured) {
  using S = TypeParam;
  auto stack = stack_of<PassthroughObserver<S>, NoDetector<S>, MrpFeedback<S>, PseudoInverse<S>>(ftc_4rw<S>());
  for (Tick k = 1; k < 4; ++k) EXPECT_FALSE(stack.step(wobble<S>(k, 4), {}).status.has(Flag::input_held));
  EXPECT_TRUE(stack.step(wobble<S>(3, 4), {}).status.has(Flag::input_held));
  EXPECT_FALSE(stack.measurement().attitude_valid || stack.measurement().rate_valid);
  EXPECT_FALSE(stack.step(wobble<S>(4, 4), {}).status.has(Flag::input_held));
  stack.reset();
  for (int k = 0; k < 3; ++k)  // a caller that does not count
    EXPECT_FALSE(stack.step(wobble<S>(0, 4), {}).status.has(Flag::input_held));
}

// ---- what is carried on --------------------------------------------------------------------------------------------

TYPED_TEST(Guard, AnInvalidAttitudeIsCarriedOnByTheMeasuredRate) {
  using S = TypeParam;
  const auto setup = ftc_4rw<S>();
  auto stack = stack_of<PassthroughObserver<S>, NoDetector<S>, MrpFeedback<S>, PseudoInverse<S>>(setup);
  Body body(setup.vehicle);
  body.omega_BN_B = {0.1, -0.2, 0.15};
  for (int k = 0; k < 300; ++k) {
    Measurement<S> y = body.measured<S>(static_cast<Tick>(k));
    if (k >= 100) {
      y.attitude_valid = false;
      y.q_NB = Quat<S>::Identity();
    }
    stack.step(y, {});
    const Quat<double> error = stack.measurement().q_NB.template cast<double>().conjugate() * body.q_NB;
    // The trapezoid of the rates errs by h^2 / 12 of the change of acceleration, float by its rounding at every sample; the
    // rate at the beginning of each interval alone would be off by 1e-3.
    EXPECT_LT(rotation_angle(error), 5e-5) << k;
    body.advance(stack.last().u.template cast<double>(), 0.01);
  }
  EXPECT_GT(rotation_angle(body.q_NB), 0.3) << "it turned";
}

TYPED_TEST(Guard, AnInvalidRateIsCarriedOnByTheModel) {
  using S = TypeParam;
  const auto setup = ftc_4rw<S>();
  auto stack =
      stack_of<FiniteTimeDisturbanceObserver<S>, NoDetector<S>, IntegralSlidingMode<S>, PseudoInverse<S>>(setup);
  Body body(setup.vehicle);
  body.omega_BN_B = {0.1, -0.2, 0.15};
  body.d_B = {0.02, -0.01, 0.03};  // the observer knows it by then
  double held = 0;
  Vec3<double> before = Vec3<double>::Zero();
  for (int k = 0; k < 400; ++k) {
    Measurement<S> y = body.measured<S>(static_cast<Tick>(k));
    if (k == 200) before = body.omega_BN_B;
    if (k >= 200) {
      y.rate_valid = false;
      y.omega_BN_B.setConstant(nan_of<S>());
      held = std::max(held, (body.omega_BN_B - before).norm());
      EXPECT_LT((stack.measurement().omega_BN_B.template cast<double>() - body.omega_BN_B).norm(), 3e-3) << k;
    }
    stack.step(y, {});
    body.advance(stack.last().u.template cast<double>(), 0.01);
  }
  EXPECT_GT(held, 0.03) << "the last rate would have been wrong by so much";
}

/// Knows that wheel 1 gives half; of the torque that is left, more than any actuator has.
template <class S>
struct Knowing : PassthroughObserver<S> {
  using PassthroughObserver<S>::PassthroughObserver;
  S d_B = S(0);
  Estimate<S> start(const Vehicle<S>& vehicle, const Measurement<S>& y) noexcept {
    return known(PassthroughObserver<S>::start(vehicle, y));
  }
  Estimate<S> step(const Vehicle<S>& vehicle, const Measurement<S>& y, const Allocation<S>& last) noexcept {
    return known(PassthroughObserver<S>::step(vehicle, y, last));
  }
  Estimate<S> known(Estimate<S> x) const noexcept {
    x.effectiveness[1] = S(0.5);
    x.d_B[2] = d_B;
    return x;
  }
};

TYPED_TEST(Guard, ATorqueThatNoActuatorCouldMakeGoodForCarriesNothingOn) {
  using S = TypeParam;
  auto setup = ftc_4rw<S>();
  setup.vehicle.J_B = S(2) * Mat3<S>::Identity();
  S T = S(0);
  for (int i = 0; i < 4; ++i) T += S(0.2) * setup.vehicle.D_B.col(i).norm();
  for (const S share : {S(0.9), S(1), S(500)}) {
    auto stack = stack_of<Knowing<S>, NoDetector<S>, OpenLoop<S>, PseudoInverse<S>>(setup);
    stack.estimator.observer.template as<Knowing<S>>().d_B = share * T;
    Measurement<S> y = wobble<S>(0, 4);
    y.omega_BN_B.setZero();
    stack.step(y, {});
    y.tick = 1;
    y.rate_valid = false;
    stack.step(y, {});
    EXPECT_NEAR(stack.measurement().omega_BN_B[2], S(0.01) * std::min(share, S(1)) * T / S(2), S(1e-6) * T) << share;
  }
}

TYPED_TEST(Guard, UnmeasuredWheelsAreCarriedOnByTheirCommands) {
  using S = TypeParam;
  auto setup = ftc_4rw<S>();
  setup.vehicle.wheels = Mask::all(4);
  setup.vehicle.wheels.set(3, false);  // an ideal torquer
  auto stack = stack_of<Knowing<S>, NoDetector<S>, MrpFeedback<S>, PseudoInverse<S>>(setup);
  VecN<S> h_w = VecN<S>::Constant(4, S(0.3));
  for (Tick k = 0; k < 100; ++k) {
    Measurement<S> y = wobble<S>(k, 4);
    y.h_w = h_w;
    if (k >= 20) y.h_w.resize(0);
    stack.step(y, {});
    EXPECT_LT((stack.measurement().h_w - h_w).norm(), S(1e-5)) << k;
    for (const int i : {0, 1, 2}) h_w[i] -= S(0.01) * (i == 1 ? S(0.5) : S(1)) * stack.last().u[i];
  }
  EXPECT_GT((h_w - VecN<S>::Constant(4, S(0.3))).template head<3>().cwiseAbs().minCoeff(), S(1e-3)) << "they turned";
}

TYPED_TEST(Guard, WheelsThatWereNeverMeasuredStandStill) {
  using S = TypeParam;
  auto stack = stack_of<PassthroughObserver<S>, NoDetector<S>, MrpFeedback<S>, PseudoInverse<S>>(ftc_4rw<S>());
  Measurement<S> y = wobble<S>(0, 4);
  y.h_w.resize(0);  // as a default-constructed measurement has it
  EXPECT_TRUE(stack.step(y, {}).status.has(Flag::input_held));
  EXPECT_FALSE(stack.last().status.has(Flag::rank_lost));
  EXPECT_EQ(stack.measurement().h_w, VecN<S>::Zero(4));
  auto measured = stack_of<PassthroughObserver<S>, NoDetector<S>, MrpFeedback<S>, PseudoInverse<S>>(ftc_4rw<S>());
  EXPECT_EQ(stack.last().u, measured.step(wobble<S>(0, 4), {}).u);
}

/// What an observer knew stays: the same bits of effectiveness and d_B. One that issues less effectiveness than it believes hands
/// the rest c u on in d_B: then d_B moves with the command alone, D diag(c) (u - u before), with one c for all samples.
template <class S>
class Known {
 public:
  using Stack = AnyStack<S>;
  void learned(const Stack& stack, const VecN<S>& u) {
    x_ = stack.estimate();
    u_ = u.template cast<double>();
  }
  /// @param u  what acted over the interval just ended
  void stays(const Stack& stack, const VecN<S>& u) {
    const Estimate<S>& x = stack.estimate();
    EXPECT_EQ(x.effectiveness, x_.effectiveness) << x.tick;
    if (!stack.estimator.observer.traits().estimates.effectiveness) {  // it hands nothing on
      EXPECT_EQ(x.d_B, x_.d_B) << x.tick;
      return;
    }
    const Mat3N<double> D = stack.estimator.guard().vehicle().D_B.template cast<double>();
    const Eigen::Index at = moved_.size(), n = D.cols();
    moved_.conservativeResize(at + 3);
    by_.conservativeResize(at + 3, n);
    moved_.tail<3>() = (x.d_B - x_.d_B).template cast<double>();
    by_.bottomRows<3>() = D * (u.template cast<double>() - u_).asDiagonal();
  }
  /// Of all samples since it was learned.
  void expect_only_the_command_moved_it() {
    if (moved_.size() == 0) return;
    const Eigen::VectorXd c = by_.colPivHouseholderQr().solve(moved_);
    const double rounding = 100 * static_cast<double>(std::numeric_limits<S>::epsilon());
    EXPECT_LE((by_ * c - moved_).cwiseAbs().maxCoeff(), rounding);
    EXPECT_LE(c.cwiseAbs().maxCoeff(), 0.15 + 1e-3) << "no more than is believed beyond what is issued";
    moved_.resize(0);
    by_.resize(0, 0);
  }

 private:
  Estimate<S> x_;
  Eigen::VectorXd u_, moved_;
  Eigen::MatrixXd by_;
};

/// What an observer knows, while nothing is measured: the same bits, and no jump where measurements come back.
TYPED_TEST(Guard, ObserversDoNotLearnFromWhatWasNotMeasured) {
  using S = TypeParam;
  const auto setup = ftc_4rw<S>();
  for_every_observer<S>(setup, [&](auto stack) {
    Body body(setup.vehicle);
    body.omega_BN_B = {0.05, -0.04, 0.03};
    body.d_B = {0.01, -0.005, 0.02};
    body.effectiveness[2] = 0.6;
    Known<S> known;
    for (int k = 0; k < 500; ++k) {
      Measurement<S> y = body.measured<S>(static_cast<Tick>(k));
      const bool blind = (k >= 300 && k < 340) || (k >= 400 && k < 404);
      if (blind) y.omega_BN_B = {S(0.3), S(0.2), S(-0.1)};
      if (k >= 300 && k < 340) y.rate_valid = false;
      if (k >= 400 && k < 404) y.tick = 399;  // not renewed
      const VecN<S> acted = stack.last().u;
      stack.step(y, {});
      if (k == 299 || k == 399) known.learned(stack, acted);
      if (k == 341 || k == 405) known.expect_only_the_command_moved_it();
      // joint_kalman predicts across the gap: what comes back is compared with that, and teaches.
      const bool predicts = stack.estimator.observer.name() == std::string_view("joint_kalman");
      if (blind || (!predicts && (k == 340 || k == 404))) {
        known.stays(stack, acted);
        EXPECT_FALSE(stack.last().status.has(Flag::component_reset)) << k;
      }
      body.advance(stack.last().u.template cast<double>(), 0.01);
    }
  });
}

TYPED_TEST(Guard, WheelMomentumThatIsNotMeasuredTeachesNothingEither) {
  using S = TypeParam;
  const auto setup = ftc_4rw<S>();
  auto stack = stack_of<FiniteTimeDisturbanceObserver<S>, NoDetector<S>, MrpFeedback<S>, PseudoInverse<S>>(setup);
  for (Tick k = 0; k < 30; ++k) {
    const Vec3<S> d_B = stack.estimate().d_B;
    Measurement<S> y = wobble<S>(k, 4);
    if (k >= 10 && k < 20) y.h_w[0] = nan_of<S>();
    stack.step(y, {});
    EXPECT_EQ(stack.estimate().d_B == d_B, k == 0 || (k >= 10 && k <= 20)) << k;
  }
}

TYPED_TEST(Guard, AnAttitudeThatIsNotMeasuredKeepsNobodyFromLearning) {
  using S = TypeParam;
  const auto setup = ftc_4rw<S>();
  auto stack = stack_of<FiniteTimeDisturbanceObserver<S>, NoDetector<S>, MrpFeedback<S>, PseudoInverse<S>>(setup);
  Body body(setup.vehicle);
  for (int k = 0; k < 2000; ++k) {
    if (k == 100) body.d_B = {0.02, -0.01, 0.03};
    Measurement<S> y = body.measured<S>(static_cast<Tick>(k));
    y.attitude_valid = k < 100;
    stack.step(y, {});
    body.advance(stack.last().u.template cast<double>(), 0.01);
  }
  EXPECT_LT((stack.estimate().d_B.template cast<double>() - body.d_B).norm(), 2e-3) << "a twentieth of it";
}

/// An observer without `skip` is stepped with what was carried on, and can see that it was.
TEST(GuardSkips, AnObserverWithoutSkipSeesTheBits) {
  struct Counting : PassthroughObserver<double> {
    using PassthroughObserver::PassthroughObserver;
    int unmeasured = 0;
    Estimate<double> step(const Vehicle<double>& vehicle, const Measurement<double>& y,
                          const Allocation<double>& last) noexcept {
      unmeasured += !y.rate_valid;
      return PassthroughObserver::step(vehicle, y, last);
    }
  };
  auto stack = stack_of<Counting, NoDetector<double>, MrpFeedback<double>, PseudoInverse<double>>(ftc_4rw<double>());
  for (Tick k = 0; k < 20; ++k) {
    Measurement<double> y = wobble<double>(k, 4);
    y.rate_valid = k < 5 || k >= 12;
    stack.step(y, {});
  }
  EXPECT_EQ(stack.estimator.observer.as<Counting>().unmeasured, 7);
}

// ---- scales --------------------------------------------------------------------------------------------------------

/// As docs/flight_software.md tables them: a hundredth below is flown, a hundredth above cannot be.
TYPED_TEST(Guard, PartsGarbageFromFlightAtItsScales) {
  using S = TypeParam;
  for (const double dt : {0.01, 0.5}) {
    for (const double size : {1.0, 1e-4}) {
      auto setup = ftc_4rw<S>();
      setup.dt = static_cast<S>(dt);
      setup.vehicle.J_B =
          Vec3<S>(static_cast<S>(size), static_cast<S>(2 * size), static_cast<S>(3 * size)).asDiagonal();
      const gyrostat::Guard<S> guard(setup);
      const double J = 3 * size;
      double T = 0;
      for (int i = 0; i < 4; ++i) T += 0.2 * static_cast<double>(setup.vehicle.D_B.col(i).norm());
      T = std::max(T, 0.04 * J);
      const auto edge = [](double at, const auto& possible, const char* what) {
        EXPECT_TRUE(possible(static_cast<S>(0.99 * at))) << what;
        EXPECT_TRUE(possible(static_cast<S>(-0.99 * at))) << what;
        EXPECT_FALSE(possible(static_cast<S>(1.01 * at))) << what;
        EXPECT_FALSE(possible(static_cast<S>(-1.01 * at))) << what;
      };
      const auto in = [](auto signal, const auto& number) {
        return [signal, number](S x) {
          auto spoilt = signal;
          number(spoilt) = x;
          return spoilt;
        };
      };
      const Measurement<S> y = wobble<S>(0, 4);
      const Estimate<S> x = Estimate<S>::healthy(y);
      const auto possible = [&guard](const auto& make) {
        return [&guard, make](S n) { return guard.possible(make(n)); };
      };
      edge(100 / dt, [&](S w) { return guard.rate_possible(Vec3<S>(0, w, 0)); }, "measured rate");
      edge(100 / dt, possible(in(x, [](auto& e) -> S& { return e.omega_BN_B[2]; })), "estimated rate");
      edge(1000 * J / dt, [&](S h) { return guard.momentum_possible(VecN<S>::Constant(4, h)); }, "wheel momentum");
      edge(1 / dt, possible(in(Reference<S>{}, [](auto& r) -> S& { return r.omega_RN_R[1]; })), "reference rate");
      edge(std::max(1000 * T / J, 0.2 / dt),
           possible(in(Reference<S>{}, [](auto& r) -> S& { return r.omegadot_RN_R[0]; })), "reference acceleration");
      edge(1e6 * J / dt / dt, possible(in(Demand<S>{}, [](auto& d) -> S& { return d.tau_B[2]; })), "demand");
      edge(1000 * T, possible(in(x, [](auto& e) -> S& { return e.d_B[1]; })), "d_B");
      edge(1000, possible(in(x, [](auto& e) -> S& { return e.effectiveness[3]; })), "effectiveness");
      for (const double length : {0.89, 0.91, 1.09, 1.11}) {
        Measurement<S> z = y;
        z.q_NB.coeffs() *= static_cast<S>(length);
        EXPECT_EQ(guard.attitude_possible(z), length > 0.9 && length < 1.1) << length;
      }
      setup.vehicle.u_up[2] = std::numeric_limits<S>::infinity();
      const gyrostat::Guard<S> unlimited(setup);
      edge(
          1e6 * J / dt / dt, [&](S d) { return unlimited.possible(in(x, [](auto& e) -> S& { return e.d_B[1]; })(d)); },
          "d_B without limits");
    }
  }
}

TYPED_TEST(Guard, AJumpBeginsAtItsScales) {
  using S = TypeParam;
  auto setup = ftc_4rw<S>();
  setup.vehicle.J_B = Vec3<S>(S(1), S(2), S(3)).asDiagonal();
  const gyrostat::Guard<S> guard(setup);
  double T = 0, pushed = 0;
  for (int i = 0; i < 4; ++i) T += 0.2 * static_cast<double>(setup.vehicle.D_B.col(i).norm());
  for (int i = 0; i < 4; ++i) pushed += 50 * static_cast<double>(setup.vehicle.D_B.col(i).norm());
  const VecN<S> nothing = VecN<S>::Zero(4), push = VecN<S>::Constant(4, S(-50));
  const auto edge = [&](double at, const VecN<S>& u, const Vec3<S>& rate, const auto& change, const char* what) {
    Measurement<S> from;
    from.h_w.setZero(4);
    from.omega_BN_B = rate;
    const Motion<S> motion{from.q_NB, from.omega_BN_B, from.h_w};
    Measurement<S> below = from, above = from;
    change(below, static_cast<S>(0.99 * at));
    change(above, static_cast<S>(1.01 * at));
    EXPECT_FALSE(guard.jumps(motion, from.axes, below, u)) << what;
    EXPECT_TRUE(guard.jumps(motion, from.axes, above, u)) << what;
  };
  const auto rate = [](Measurement<S>& y, S x) { y.omega_BN_B[1] += x; };
  const auto momentum = [](Measurement<S>& y, S x) { y.h_w[2] -= x; };
  const auto attitude = [](Measurement<S>& y, S x) { y.q_NB = quat_exp<S>({0, x, 0}); };
  const Vec3<S> rest = Vec3<S>::Zero(), turning{S(4), 0, 0};
  edge(0.01 * 100 * T / 3, nothing, rest, rate, "rate at rest");
  edge(0.01 * (100 * T / 3 + 2 * pushed / 1), push, rest, rate, "rate under a command");
  edge(0.01 * (100 * T / 3 + 2 * 16), nothing, turning, rate, "rate of a vehicle that turns");
  edge(0.01 * 100 * T, nothing, rest, momentum, "wheel momentum");
  edge(0.01 * (100 * T + 2 * 50), push, rest, momentum, "wheel momentum under a command");
  edge(0.2003, nothing, rest, attitude, "attitude");  // twice asin 0.1
  edge(0.2 + 2 * 0.01 * 4, nothing, turning, attitude, "attitude of a vehicle that turns");
  setup.dt = S(0.0001);  // quick enough for the least change that is one
  for (const double size : {0.99, 1.01}) {
    Measurement<S> from, to;
    from.h_w.setZero(4);
    to = from;
    const Motion<S> motion{from.q_NB, from.omega_BN_B, from.h_w};
    to.omega_BN_B[0] = static_cast<S>(size * std::max(0.02, 0.0001 * 100 * T / 3));
    EXPECT_EQ(gyrostat::Guard<S>(setup).jumps(motion, from.axes, to, nothing), size > 1);
  }
}

// ---- jumps ---------------------------------------------------------------------------------------------------------

TYPED_TEST(Guard, ASpikeIsGarbageAndALevelThatStaysIsWhereTheVehicleIs) {
  using S = TypeParam;
  const auto setup = ftc_4rw<S>();
  for (const int field : {0, 1, 2}) {
    auto stack = stack_of<PassthroughObserver<S>, NoDetector<S>, MrpFeedback<S>, PseudoInverse<S>>(setup);
    const auto sample = [&](Tick k, bool elsewhere) {
      Measurement<S> y = wobble<S>(k, 4);
      if (elsewhere && field == 0) y.omega_BN_B[1] += S(2);
      if (elsewhere && field == 1) y.q_NB = y.q_NB * quat_exp<S>({S(1), S(0), S(0)});
      if (elsewhere && field == 2) y.h_w[1] += S(10);
      stack.step(y, {});
      return !stack.last().status.has(Flag::input_held);
    };
    for (Tick k = 0; k < 10; ++k) EXPECT_TRUE(sample(k, false));
    EXPECT_FALSE(sample(10, true));
    EXPECT_LT((stack.measurement().omega_BN_B - wobble<S>(10, 4).omega_BN_B).norm(), S(0.01)) << "carried on";
    EXPECT_TRUE(sample(11, false));
    EXPECT_EQ(stack.estimate().event, 0u) << "a spike is no jump";
    EXPECT_FALSE(sample(12, true));
    EXPECT_TRUE(sample(13, true)) << "borne out";
    EXPECT_EQ(stack.estimate().event, 1u);
    EXPECT_TRUE(sample(14, true));
    EXPECT_EQ(stack.estimate().event, 1u);
  }
}

/// A kick: nothing that an actuator or a torque did, and what an observer knows stays, to the bit.
TYPED_TEST(Guard, AJumpTeachesNothing) {
  using S = TypeParam;
  const auto setup = ftc_4rw<S>();
  for_every_observer<S>(setup, [&](auto stack) {
    Body body(setup.vehicle);
    body.omega_BN_B = {0.05, -0.04, 0.03};
    body.d_B = {0.01, -0.005, 0.02};
    body.effectiveness[2] = 0.6;
    Known<S> known;
    for (int k = 0; k < 303; ++k) {
      if (k == 300) body.omega_BN_B += Vec3<double>(0.5, -0.2, 0.1);
      const VecN<S> acted = stack.last().u;
      stack.step(body.measured<S>(static_cast<Tick>(k)), {});
      if (k == 299) known.learned(stack, acted);
      if (k == 302) known.expect_only_the_command_moved_it();
      if (k == 300 || k == 301) {
        EXPECT_EQ(stack.last().status.has(Flag::input_held), k == 300) << "doubted, then borne out";
        known.stays(stack, acted);
      }
      body.advance(stack.last().u.template cast<double>(), 0.01);
    }
    EXPECT_EQ(stack.estimate().event, 1u);
  });
}

TEST(GuardJumps, ASensorThatGoesOnJumpingIsFlownAsItIsAndTeachesNothing) {
  const auto setup = ftc_4rw<double>();
  struct Taught : PassthroughObserver<double> {
    using PassthroughObserver::PassthroughObserver;
    int steps = 0, skips = 0;
    Estimate<double> step(const Vehicle<double>& vehicle, const Measurement<double>& y,
                          const Allocation<double>& last) noexcept {
      ++steps;
      return PassthroughObserver::step(vehicle, y, last);
    }
    Estimate<double> skip(const Vehicle<double>& vehicle, const Measurement<double>& y,
                          const Allocation<double>& last) noexcept {
      ++skips;
      return PassthroughObserver::step(vehicle, y, last);
    }
  };
  auto stack = stack_of<Taught, NoDetector<double>, MrpFeedback<double>, PseudoInverse<double>>(setup);
  Random random(3);
  int held = 0;
  for (Tick k = 0; k < 1000; ++k) {
    Measurement<double> y = wobble<double>(k, 4);
    if (k > 0) y.omega_BN_B += random.vector<double>(2.0);
    stack.step(y, {});
    held += stack.last().status.has(Flag::input_held);
  }
  EXPECT_EQ(held, 10) << "ten samples in a row, then it is believed";
  EXPECT_EQ(stack.estimator.observer.as<Taught>().steps, 0);
  EXPECT_EQ(stack.estimator.observer.as<Taught>().skips, 999);
  EXPECT_EQ(stack.estimate().event, 989u);
}

TEST(GuardJumps, WhatCommandAndRateExplainIsNone) {
  auto setup = ftc_4rw<double>();
  setup.vehicle.u_up.setConstant(std::numeric_limits<double>::infinity());
  setup.vehicle.u_lo = -setup.vehicle.u_up;
  setup.vehicle.J_B = satellite_inertia<double>();
  struct Thrown : OpenLoop<double> {  // 2000 N m for a moment: 100 rad/s^2 that flight has asked for itself
    using OpenLoop::OpenLoop;
    Demand<double> step(const Vehicle<double>& vehicle, const Estimate<double>& x, const Detection<double>& det,
                        const Reference<double>& ref, const Allocation<double>& last) noexcept {
      Demand<double> out = OpenLoop::step(vehicle, x, det, ref, last);
      if (x.tick >= 10 && x.tick < 20) out.tau_B = {2000, -2000, 1000};
      return out;
    }
  };
  auto stack = stack_of<PassthroughObserver<double>, NoDetector<double>, Thrown, PseudoInverse<double>>(setup);
  Body body(setup.vehicle);
  for (int k = 0; k < 200; ++k) {  // then it tumbles at 15 rad/s
    stack.step(body.measured<double>(static_cast<Tick>(k)), {});
    EXPECT_FALSE(stack.last().status.has(Flag::input_held)) << k;
    body.advance(stack.last().u, 0.01);
  }
  EXPECT_GT(body.omega_BN_B.norm(), 10);
}

// ---- before and after ----------------------------------------------------------------------------------------------

TYPED_TEST(Guard, NothingStartsBeforeAValidInput) {
  using S = TypeParam;
  for_every_observer<S>(ftc_4rw<S>(), [](auto stack) {
    auto later = stack;
    for (int k = 0; k < 3; ++k) {
      Measurement<S> bad = wobble<S>(0, 4);
      if (k == 0) bad.q_NB.x() = nan_of<S>();
      bad.attitude_valid = k != 1;
      bad.rate_valid = k != 2;
      const Allocation<S>& out = later.step(bad, {});
      EXPECT_EQ(out.u, VecN<S>::Zero(4));
      EXPECT_TRUE(out.status.has(Flag::input_held));
    }
    const VecN<S> u = later.step(wobble<S>(0, 4), {}).u;
    EXPECT_EQ(u, stack.step(wobble<S>(0, 4), {}).u);
  });
}

TYPED_TEST(Guard, ResetIsAsConstructed) {
  using S = TypeParam;
  for_every_observer<S>(ftc_4rw<S>(), [](auto stack) {
    auto used = stack;
    for (Tick k = 0; k < 20; ++k) used.step(wobble<S>(k, 4), {});
    used.reset();
    EXPECT_EQ(used.last().u, VecN<S>::Zero(4));
    for (Tick k = 0; k < 5; ++k) {
      stack.step(wobble<S>(k, 4), {});
      used.step(wobble<S>(k, 4), {});
      EXPECT_EQ(used.last().u, stack.last().u);
    }
  });
}

// ---- components that go wrong at one sample ------------------------------------------------------------------------

constexpr Tick trouble = 10;

struct BadObserver : PassthroughObserver<double> {
  using PassthroughObserver::PassthroughObserver;
  int starts = 0;
  Estimate<double> start(const Vehicle<double>& vehicle, const Measurement<double>& y) noexcept {
    ++starts;
    return PassthroughObserver::start(vehicle, y);
  }
  Estimate<double> step(const Vehicle<double>& vehicle, const Measurement<double>& y,
                        const Allocation<double>& last) noexcept {
    Estimate<double> x = PassthroughObserver::step(vehicle, y, last);
    if (y.tick == trouble) x.d_B[0] = nan_of<double>();
    return x;
  }
};

struct BadDetector : NoDetector<double> {
  using NoDetector::NoDetector;
  int starts = 0;
  Detection<double> start(const Vehicle<double>& vehicle, const Estimate<double>& x) noexcept {
    ++starts;
    return NoDetector::start(vehicle, x);
  }
  Detection<double> step(const Vehicle<double>& vehicle, const Estimate<double>& x,
                         const Allocation<double>& last) noexcept {
    Detection<double> det = NoDetector::step(vehicle, x, last);
    if (x.tick == trouble) det.u_probe = VecN<double>::Constant(4, nan_of<double>());
    return det;
  }
};

struct BadController : MrpFeedback<double> {
  using MrpFeedback::MrpFeedback;
  int starts = 0;
  Demand<double> start(const Vehicle<double>& vehicle, const Estimate<double>& x, const Detection<double>& det,
                       const Reference<double>& ref) noexcept {
    ++starts;
    return MrpFeedback::start(vehicle, x, det, ref);
  }
  Demand<double> step(const Vehicle<double>& vehicle, const Estimate<double>& x, const Detection<double>& det,
                      const Reference<double>& ref, const Allocation<double>& last) noexcept {
    Demand<double> demand = MrpFeedback::step(vehicle, x, det, ref, last);
    if (x.tick == trouble) demand.tau_B[2] = std::numeric_limits<double>::infinity();
    return demand;
  }
};

struct BadAllocator : PseudoInverse<double> {
  using PseudoInverse::PseudoInverse;
  int starts = -1;  // the stack resets it once before the first sample
  void reset(const Vehicle<double>& vehicle) noexcept {
    ++starts;
    PseudoInverse::reset(vehicle);
  }
  Allocation<double> step(const Vehicle<double>& vehicle, const Demand<double>& demand, const Estimate<double>& x,
                          const Detection<double>& det) noexcept {
    Allocation<double> out = PseudoInverse::step(vehicle, demand, x, det);
    if (x.tick == trouble) out.u[1] = nan_of<double>();
    if (x.tick > trouble + 5) out.u.setConstant(7);  // far outside of its box
    return out;
  }
};

/// How often a component was started, if it counts.
template <class T>
int starts_of(const auto& component) {
  if constexpr (requires(const T& t) { t.starts; }) return component.template as<T>().starts;
  return 0;
}

void expect_restart(AnyStack<double> stack, int (*starts)(const AnyStack<double>&)) {
  for (Tick k = 0; k < trouble; ++k) stack.step(wobble<double>(k, 4), {});
  const int before = starts(stack);
  const VecN<double> previous = stack.last().u;
  EXPECT_EQ(stack.last().status.bits() & static_cast<unsigned>(Flag::component_reset), 0u);
  stack.step(wobble<double>(trouble, 4), {});
  EXPECT_EQ(stack.last().u, previous);
  EXPECT_TRUE(stack.last().status.has(Flag::component_reset));
  EXPECT_TRUE(stack.last().status.has(Flag::command_held));
  EXPECT_EQ(starts(stack), before + 1);
  stack.step(wobble<double>(trouble + 1, 4), {});
  EXPECT_TRUE(stack.last().u.allFinite());
  EXPECT_NE(stack.last().u, previous);
  EXPECT_FALSE(stack.last().status.has(Flag::command_held));
}
template <class O, class D, class C, class A>
void expect_restart() {
  expect_restart(stack_of<O, D, C, A>(ftc_4rw<double>()), [](const AnyStack<double>& stack) {
    return starts_of<O>(stack.estimator.observer) + starts_of<D>(stack.estimator.detector) +
           starts_of<C>(stack.controller) + starts_of<A>(stack.allocator);
  });
}

TEST(GuardRestarts, AnObserver) {
  expect_restart<BadObserver, NoDetector<double>, MrpFeedback<double>, PseudoInverse<double>>();
}
TEST(GuardRestarts, AnObserverWhoseTorqueNothingCouldMake) {
  struct Carried : BadObserver {  // finite, and there to stay
    using BadObserver::BadObserver;
    Estimate<double> step(const Vehicle<double>& vehicle, const Measurement<double>& y,
                          const Allocation<double>& last) noexcept {
      Estimate<double> x = PassthroughObserver::step(vehicle, y, last);
      const double all = std::max(4 * 0.2, 0.04 * largest_inertia(satellite_inertia<double>()));
      if (y.tick == trouble) x.d_B[2] = -1001 * all;
      if (y.tick == trouble - 1) x.d_B[1] = 999 * all;  // absurd, but believed
      return x;
    }
  };
  expect_restart<Carried, NoDetector<double>, MrpFeedback<double>, PseudoInverse<double>>();
}
TEST(GuardRestarts, NoObserverOfAVehicleWithAnIdleColumnAndNoLimits) {
  gyrostat::Setup<double> setup = ftc_4rw<double>();
  setup.vehicle.D_B.leftCols<3>() = Mat3<double>::Identity();
  setup.vehicle.D_B.col(3).setZero();
  setup.vehicle.u_up.setConstant(std::numeric_limits<double>::infinity());
  setup.vehicle.u_lo = -setup.vehicle.u_up;
  auto stack =
      stack_of<PassthroughObserver<double>, NoDetector<double>, MrpFeedback<double>, PseudoInverse<double>>(setup);
  for (Tick k = 0; k < 10; ++k) {
    stack.step(wobble<double>(k, 4), {});
    EXPECT_FALSE(stack.last().status.has(Flag::component_reset)) << k;
  }
}
TEST(GuardRestarts, ADetector) {
  expect_restart<PassthroughObserver<double>, BadDetector, MrpFeedback<double>, PseudoInverse<double>>();
}
TEST(GuardRestarts, AController) {
  expect_restart<PassthroughObserver<double>, NoDetector<double>, BadController, PseudoInverse<double>>();
}
TEST(GuardRestarts, AnAllocator) {
  expect_restart<PassthroughObserver<double>, NoDetector<double>, MrpFeedback<double>, BadAllocator>();
}

/// Of any component, an output of the wrong size is an impossible one.
template <int n>
struct WrongEstimate : BadObserver {
  using BadObserver::BadObserver;
  Estimate<double> step(const Vehicle<double>& vehicle, const Measurement<double>& y,
                        const Allocation<double>& last) noexcept {
    Estimate<double> x = PassthroughObserver::step(vehicle, y, last);
    if (y.tick == trouble && n == 0) x.h_w.resize(0);
    if (y.tick == trouble && n == 1) x.effectiveness.setOnes(3);
    if (y.tick == trouble && n == 2) x.effectiveness_bound.setOnes(16);
    if (y.tick == trouble && n == 3) x.effectiveness_bound[1] = -1;
    if (y.tick == trouble && n == 4) x.q_NB.coeffs() *= 2;
    return x;
  }
};
TEST(GuardRestarts, AnObserverWithAnEstimateOfTheWrongSizeOrSign) {
  using N = NoDetector<double>;
  using C = MrpFeedback<double>;
  using P = PseudoInverse<double>;
  expect_restart<WrongEstimate<0>, N, C, P>();
  expect_restart<WrongEstimate<1>, N, C, P>();
  expect_restart<WrongEstimate<2>, N, C, P>();
  expect_restart<WrongEstimate<3>, N, C, P>();
  expect_restart<WrongEstimate<4>, N, C, P>();
}
TEST(GuardRestarts, ADetectorWithAProbeOfTheWrongSize) {
  struct Wrong : BadDetector {
    using BadDetector::BadDetector;
    Detection<double> step(const Vehicle<double>& vehicle, const Estimate<double>& x,
                           const Allocation<double>& last) noexcept {
      Detection<double> det = NoDetector::step(vehicle, x, last);
      if (x.tick == trouble) det.u_probe = VecN<double>::Constant(3, 0.01);
      return det;
    }
  };
  expect_restart<PassthroughObserver<double>, Wrong, MrpFeedback<double>, PseudoInverse<double>>();
}
TEST(GuardRestarts, AControllerWithAPreferenceOfTheWrongSizeOrADemandBeyondSense) {
  struct Wrong : BadController {
    using BadController::BadController;
    Demand<double> step(const Vehicle<double>& vehicle, const Estimate<double>& x, const Detection<double>& det,
                        const Reference<double>& ref, const Allocation<double>& last) noexcept {
      Demand<double> demand = MrpFeedback::step(vehicle, x, det, ref, last);
      if (x.tick == trouble) demand.u_pref.setZero(5);
      return demand;
    }
  };
  struct Huge : BadController {
    using BadController::BadController;
    Demand<double> step(const Vehicle<double>& vehicle, const Estimate<double>& x, const Detection<double>& det,
                        const Reference<double>& ref, const Allocation<double>& last) noexcept {
      Demand<double> demand = MrpFeedback::step(vehicle, x, det, ref, last);
      if (x.tick == trouble) demand.tau_B[1] = 1e20;
      return demand;
    }
  };
  expect_restart<PassthroughObserver<double>, NoDetector<double>, Wrong, PseudoInverse<double>>();
  expect_restart<PassthroughObserver<double>, NoDetector<double>, Huge, PseudoInverse<double>>();
}
TEST(GuardRestarts, AnAllocatorWithACommandOfTheWrongSize) {
  struct Wrong : BadAllocator {
    using BadAllocator::BadAllocator;
    Allocation<double> step(const Vehicle<double>& vehicle, const Demand<double>& demand, const Estimate<double>& x,
                            const Detection<double>& det) noexcept {
      Allocation<double> out = PseudoInverse::step(vehicle, demand, x, det);
      if (x.tick == trouble) out.u.resize(2);
      return out;
    }
  };
  expect_restart<PassthroughObserver<double>, NoDetector<double>, MrpFeedback<double>, Wrong>();
}

/// On a vehicle without limits a command beyond sense is issued, once: it is not held, and nothing is learned from it.
TEST(GuardHolds, ACommandOnlyWhenItIsSane) {
  for (const double scale : {1.0, 1e-4}) {
    auto setup = ftc_4rw<double>();
    setup.vehicle.J_B *= scale;
    setup.vehicle.u_up.setConstant(std::numeric_limits<double>::infinity());
    setup.vehicle.u_lo = -setup.vehicle.u_up;
    setup.vehicle.u_lo[1] = 0;  // one-sided
    setup.vehicle.u_up[2] = 0.2 * scale;
    setup.vehicle.u_lo[2] = -0.1 * scale;
    const gyrostat::Guard<double> guard(setup);
    const double most = 1000 * largest_inertia(setup.vehicle.J_B) / (0.01 * 0.01);  // a thousand radians a sample^2
    EXPECT_TRUE(guard.sane(VecN<double>::Constant(4, 0.999 * most)));
    EXPECT_FALSE(guard.sane(VecN<double>::Constant(4, -1.001 * most)));
    struct Far : PseudoInverse<double> {  // a command beyond sense, and then nothing at all
      using PseudoInverse::PseudoInverse;
      double wish = -0.1;
      Allocation<double> step(const Vehicle<double>& vehicle, const Demand<double>& demand, const Estimate<double>& x,
                              const Detection<double>& det) noexcept {
        Allocation<double> out = PseudoInverse::step(vehicle, demand, x, det);
        out.u.setConstant(x.tick == trouble ? wish : nan_of<double>());
        return out;
      }
    };
    for (const bool sane : {true, false}) {
      auto stack =
          stack_of<AdaptiveSlidingModeEffectivenessObserver<double>, NoDetector<double>, MrpFeedback<double>, Far>(
              setup);
      double& wish = stack.allocator.as<Far>().wish;
      wish = -(sane ? 0.5 : 2) * most;
      VecN<double> issued;
      for (Tick k = trouble; k < trouble + 3; ++k) {
        stack.step(wobble<double>(k, 4), {});
        if (k == trouble) {
          issued = stack.last().u;
          EXPECT_EQ(issued[0], wish);
          EXPECT_EQ(issued[1], 0) << "what flight knows is kept";
          EXPECT_EQ(issued[2], -0.1 * scale);
        } else {
          EXPECT_EQ(stack.last().u, sane ? issued : VecN<double>(VecN<double>::Zero(4)));
        }
      }
      EXPECT_EQ(stack.estimate().effectiveness == VecN<double>::Ones(4), !sane);
    }
  }
}

TEST(GuardClips, ACommandOutsideItsBoxAndItsRate) {
  auto setup = ftc_4rw<double>();
  setup.vehicle.u_rate.setConstant(2.0);  // 0.02 N m a sample
  auto stack = stack_of<PassthroughObserver<double>, NoDetector<double>, MrpFeedback<double>, BadAllocator>(setup);
  VecN<double> before = VecN<double>::Zero(4);
  for (Tick k = 0; k < 60; ++k) {
    stack.step(wobble<double>(k, 4), {});
    EXPECT_LE(stack.last().u.maxCoeff(), 0.2);
    EXPECT_LE((stack.last().u - before).cwiseAbs().maxCoeff(), 0.02 + 1e-16) << k;
    before = stack.last().u;
  }
  EXPECT_EQ(stack.last().u, VecN<double>::Constant(4, 0.2));
  EXPECT_EQ(stack.last().saturated, Mask::all(4));
  EXPECT_LT((stack.last().achieved_B - torque<double>(setup.vehicle.D_B, before)).norm(), 1e-16);
}

/// Sets its flag at one sample, and returns a finite command all the same.
template <Flag flag>
struct FlaggingAllocator : PseudoInverse<double> {
  using PseudoInverse::PseudoInverse;
  Allocation<double> step(const Vehicle<double>& vehicle, const Demand<double>& demand, const Estimate<double>& x,
                          const Detection<double>& det) noexcept {
    Allocation<double> out = PseudoInverse::step(vehicle, demand, x, det);
    if (x.tick == trouble) out.status.set(flag);
    return out;
  }
};

struct FlaggingController : MrpFeedback<double> {
  using MrpFeedback::MrpFeedback;
  Demand<double> step(const Vehicle<double>& vehicle, const Estimate<double>& x, const Detection<double>& det,
                      const Reference<double>& ref, const Allocation<double>& last) noexcept {
    Demand<double> demand = MrpFeedback::step(vehicle, x, det, ref, last);
    if (x.tick == trouble) demand.status.set(Flag::breach);
    return demand;
  }
};

template <Flag flag, class C, class A>
void expect_passed_on() {
  auto stack = stack_of<PassthroughObserver<double>, NoDetector<double>, C, A>(ftc_4rw<double>());
  auto plain = stack_of<PassthroughObserver<double>, NoDetector<double>, MrpFeedback<double>, PseudoInverse<double>>(
      ftc_4rw<double>());
  for (Tick k = 0; k < 2 * trouble; ++k) {
    const Allocation<double>& out = stack.step(wobble<double>(k, 4), {});
    EXPECT_EQ(out.status.has(flag), k == trouble) << k;
    EXPECT_EQ(out.u, plain.step(wobble<double>(k, 4), {}).u) << "a flag changes no command, sample " << k;
  }
}

TEST(GuardFlags, WhatAnAllocatorReportsIsPassedOn) {
  using C = MrpFeedback<double>;
  expect_passed_on<Flag::bad_input, C, FlaggingAllocator<Flag::bad_input>>();
  expect_passed_on<Flag::cap_reached, C, FlaggingAllocator<Flag::cap_reached>>();
  expect_passed_on<Flag::rank_lost, C, FlaggingAllocator<Flag::rank_lost>>();
}

TEST(GuardFlags, WhatAControllerReportsIsPassedOn) {
  expect_passed_on<Flag::breach, FlaggingController, PseudoInverse<double>>();
}

TEST(GuardProbe, IsAddedToThePreference) {
  struct Probing : NoDetector<double> {
    using NoDetector::NoDetector;
    Detection<double> step(const Vehicle<double>& vehicle, const Estimate<double>& x,
                           const Allocation<double>& last) noexcept {
      Detection<double> det = NoDetector::step(vehicle, x, last);
      det.u_probe = VecN<double>::Constant(4, 0.01);
      return det;
    }
  };
  auto stack =
      stack_of<PassthroughObserver<double>, Probing, MrpFeedback<double>, PseudoInverse<double>>(ftc_4rw<double>());
  for (Tick k = 0; k < 3; ++k) stack.step(wobble<double>(k, 4), {});
  EXPECT_EQ(stack.demand().u_pref, VecN<double>::Constant(4, 0.01));
}

}  // namespace
}  // namespace gyrostat::test::test_guard
