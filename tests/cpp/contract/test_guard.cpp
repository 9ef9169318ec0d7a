// SPDX-License-Identifier: MIT
// The stack's guard: what a bad input, a bad component and a command outside its limits end in.
#include <gtest/gtest.h>

#include "stacks.hpp"

namespace gyrostat::test {
namespace {

template <class S>
S nan_of() {
  return std::numeric_limits<S>::quiet_NaN();
}

template <class S>
class Guard : public testing::Test {};
using Scalars = testing::Types<float, double>;
TYPED_TEST_SUITE(Guard, Scalars);

TYPED_TEST(Guard, NonFiniteInputHoldsTheLastValidOneAndRecovers) {
  using S = TypeParam;
  for_every_stack<S>(ftc_4rw<S>(), [](auto stack) {
    auto spoilt = stack;
    for (Tick k = 0; k < 50; ++k) {
      const Measurement<S> good = wobble<S>(k, 4);
      Measurement<S> bad = good, held = wobble<S>(19, 4);
      bad.omega_BN_B[1] = nan_of<S>();
      held.tick = k;
      const bool fails = k >= 20 && k < 25;
      stack.step(fails ? held : good, {});
      spoilt.step(fails ? bad : good, {});
      EXPECT_EQ(spoilt.last().u, stack.last().u) << "a hold, sample " << k;
      EXPECT_EQ(spoilt.last().status.has(Flag::input_held), fails) << k;
    }
    EXPECT_TRUE(spoilt.last().u.allFinite());
  });
}

TYPED_TEST(Guard, EveryKindOfInputIsChecked) {
  using S = TypeParam;
  const auto flagged = [](const Measurement<S>& y, const Reference<S>& ref) {
    auto stack = stack_of<Passthrough<S>, NoDetector<S>, MrpFeedback<S>, PseudoInverse<S>>(ftc_4rw<S>());
    stack.step(wobble<S>(0, 4), {});
    return stack.step(y, ref).status.has(Flag::input_held);
  };
  const Measurement<S> good = wobble<S>(1, 4);
  EXPECT_FALSE(flagged(good, {}));
  for (const S bad : {nan_of<S>(), std::numeric_limits<S>::infinity()}) {
    Measurement<S> y = good;
    y.q_NB.w() = bad;
    EXPECT_TRUE(flagged(y, {}));
    y = good;
    y.h_w[2] = bad;
    EXPECT_TRUE(flagged(y, {}));
    y = good;
    y.euler.rates[0] = bad;
    EXPECT_TRUE(flagged(y, {}));
    Reference<S> ref;
    ref.omegadot_RN_R[2] = bad;
    EXPECT_TRUE(flagged(good, ref));
  }
}

TYPED_TEST(Guard, NothingStartsBeforeAValidInput) {
  using S = TypeParam;
  for_every_stack<S>(ftc_4rw<S>(), [](auto stack) {
    auto later = stack;
    Measurement<S> bad = wobble<S>(0, 4);
    bad.q_NB.x() = nan_of<S>();
    for (int k = 0; k < 3; ++k) {
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
  for_every_stack<S>(ftc_4rw<S>(), [](auto stack) {
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

struct BadObserver : Passthrough<double> {
  using Passthrough::Passthrough;
  int starts = 0;
  Estimate<double> start(const Measurement<double>& y) noexcept {
    ++starts;
    return Passthrough::start(y);
  }
  Estimate<double> step(const Measurement<double>& y, const Allocation<double>& last) noexcept {
    Estimate<double> x = Passthrough::step(y, last);
    if (y.tick == trouble) x.d_B[0] = nan_of<double>();
    return x;
  }
};

struct BadDetector : NoDetector<double> {
  using NoDetector::NoDetector;
  int starts = 0;
  Detection<double> start(const Estimate<double>& x) noexcept {
    ++starts;
    return NoDetector::start(x);
  }
  Detection<double> step(const Estimate<double>& x, const Allocation<double>& last) noexcept {
    Detection<double> det = NoDetector::step(x, last);
    if (x.tick == trouble) det.u_probe = VecN<double>::Constant(4, nan_of<double>());
    return det;
  }
};

struct BadController : MrpFeedback<double> {
  using MrpFeedback::MrpFeedback;
  int starts = 0;
  Demand<double> start(const Estimate<double>& x, const Detection<double>& det, const Reference<double>& ref) noexcept {
    ++starts;
    return MrpFeedback::start(x, det, ref);
  }
  Demand<double> step(const Estimate<double>& x, const Detection<double>& det, const Reference<double>& ref,
                      const Allocation<double>& last) noexcept {
    Demand<double> demand = MrpFeedback::step(x, det, ref, last);
    if (x.tick == trouble) demand.tau_B[2] = std::numeric_limits<double>::infinity();
    return demand;
  }
};

struct BadAllocator : PseudoInverse<double> {
  using PseudoInverse::PseudoInverse;
  int starts = -1;  // the stack resets it once before the first sample
  void reset() noexcept {
    ++starts;
    PseudoInverse::reset();
  }
  Allocation<double> step(const Demand<double>& demand, const Estimate<double>& x,
                          const Detection<double>& det) noexcept {
    Allocation<double> out = PseudoInverse::step(demand, x, det);
    if (x.tick == trouble) out.u[1] = nan_of<double>();
    if (x.tick > trouble + 5) out.u.setConstant(7);  // far outside of its box
    return out;
  }
};

template <class O, class D, class C, class A>
void expect_restart(const auto& starts) {
  const auto setup = ftc_4rw<double>();
  auto stack = stack_of<O, D, C, A>(setup);
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

TEST(GuardRestarts, AnObserver) {
  expect_restart<BadObserver, NoDetector<double>, MrpFeedback<double>, PseudoInverse<double>>(
      [](const auto& stack) { return stack.estimator.observer.starts; });
}
TEST(GuardRestarts, AnObserverWhoseTorqueNothingCouldMake) {
  struct Carried : BadObserver {  // finite, and there to stay
    using BadObserver::BadObserver;
    Estimate<double> step(const Measurement<double>& y, const Allocation<double>& last) noexcept {
      Estimate<double> x = Passthrough::step(y, last);
      if (y.tick == trouble) x.d_B[2] = -1001 * 4 * 0.2;
      if (y.tick == trouble - 1) x.d_B[1] = 999 * 4 * 0.2;  // absurd, but believed
      return x;
    }
  };
  expect_restart<Carried, NoDetector<double>, MrpFeedback<double>, PseudoInverse<double>>(
      [](const auto& stack) { return stack.estimator.observer.starts; });
}
TEST(GuardRestarts, NoObserverOfAVehicleWithAnIdleColumnAndNoLimits) {
  gyrostat::Setup<double> setup = ftc_4rw<double>();
  setup.vehicle.D_B.leftCols<3>() = Mat3<double>::Identity();
  setup.vehicle.D_B.col(3).setZero();
  setup.vehicle.u_up.setConstant(std::numeric_limits<double>::infinity());
  setup.vehicle.u_lo = -setup.vehicle.u_up;
  auto stack = stack_of<Passthrough<double>, NoDetector<double>, MrpFeedback<double>, PseudoInverse<double>>(setup);
  for (Tick k = 0; k < 10; ++k) {
    stack.step(wobble<double>(k, 4), {});
    EXPECT_FALSE(stack.last().status.has(Flag::component_reset)) << k;
  }
}
TEST(GuardRestarts, ADetector) {
  expect_restart<Passthrough<double>, BadDetector, MrpFeedback<double>, PseudoInverse<double>>(
      [](const auto& stack) { return stack.estimator.detector.starts; });
}
TEST(GuardRestarts, AController) {
  expect_restart<Passthrough<double>, NoDetector<double>, BadController, PseudoInverse<double>>(
      [](const auto& stack) { return stack.controller.starts; });
}
TEST(GuardRestarts, AnAllocator) {
  expect_restart<Passthrough<double>, NoDetector<double>, MrpFeedback<double>, BadAllocator>(
      [](const auto& stack) { return stack.allocator.starts; });
}

TEST(GuardClips, ACommandOutsideItsBoxAndItsRate) {
  auto setup = ftc_4rw<double>();
  setup.vehicle.u_rate.setConstant(2.0);  // 0.02 N m a sample
  auto stack = stack_of<Passthrough<double>, NoDetector<double>, MrpFeedback<double>, BadAllocator>(setup);
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
  Allocation<double> step(const Demand<double>& demand, const Estimate<double>& x,
                          const Detection<double>& det) noexcept {
    Allocation<double> out = PseudoInverse::step(demand, x, det);
    if (x.tick == trouble) out.status.set(flag);
    return out;
  }
};

struct FlaggingController : MrpFeedback<double> {
  using MrpFeedback::MrpFeedback;
  Demand<double> step(const Estimate<double>& x, const Detection<double>& det, const Reference<double>& ref,
                      const Allocation<double>& last) noexcept {
    Demand<double> demand = MrpFeedback::step(x, det, ref, last);
    if (x.tick == trouble) demand.status.set(Flag::breach);
    return demand;
  }
};

template <Flag flag, class C, class A>
void expect_passed_on() {
  auto stack = stack_of<Passthrough<double>, NoDetector<double>, C, A>(ftc_4rw<double>());
  auto plain =
      stack_of<Passthrough<double>, NoDetector<double>, MrpFeedback<double>, PseudoInverse<double>>(ftc_4rw<double>());
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
    Detection<double> step(const Estimate<double>& x, const Allocation<double>& last) noexcept {
      Detection<double> det = NoDetector::step(x, last);
      det.u_probe = VecN<double>::Constant(4, 0.01);
      return det;
    }
  };
  auto stack = stack_of<Passthrough<double>, Probing, MrpFeedback<double>, PseudoInverse<double>>(ftc_4rw<double>());
  for (Tick k = 0; k < 3; ++k) stack.step(wobble<double>(k, 4), {});
  EXPECT_EQ(stack.demand().u_pref, VecN<double>::Constant(4, 0.01));
}

}  // namespace
}  // namespace gyrostat::test
