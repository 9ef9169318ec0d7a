// SPDX-License-Identifier: MIT
// What the stack passes on, in which order things start, and what is left when a component fails twice.
#include <gtest/gtest.h>

#include <string>

#include "gyrostat/flight/detectors/threshold.hpp"
#include "gyrostat/flight/observers/iterative_learning.hpp"
#include "stacks.hpp"

namespace gyrostat::test::test_stack {
namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();
constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr Tick trouble = 10;

template <class O = PassthroughObserver<double>, class D = NoDetector<double>, class C = MrpFeedback<double>,
          class A = PseudoInverse<double>>
AnyStack<double> flown(const gyrostat::Setup<double>& setup = ftc_4rw<double>()) {
  return stack_of<O, D, C, A>(setup);
}

/// Slow actuators: 2 mN m a sample.
gyrostat::Setup<double> slow() {
  gyrostat::Setup<double> setup = ftc_4rw<double>();
  setup.vehicle.u_rate.setConstant(0.2);
  return setup;
}

Measurement<double> spoilt(Tick tick) {
  Measurement<double> y = wobble<double>(tick, 4);
  y.omega_BN_B[0] = nan;
  return y;
}

Reference<double> bad_reference() {
  Reference<double> ref;
  ref.q_NR.x() = nan;
  return ref;
}

TEST(Stack, TellsItsComponentsTheSampleAlsoWhileItHoldsAnInput) {
  auto stack = flown();
  for (Tick k = 100; k < 110; ++k) {
    stack.step(k % 3 == 2 ? spoilt(k) : wobble<double>(k, 4), {});
    EXPECT_EQ(stack.estimate().tick, k);
  }
}

TEST(Stack, StartsOnlyOnceBothInputsWereValid) {
  const VecN<double> idle = VecN<double>::Zero(4);
  auto stack = flown(), other = stack;
  EXPECT_EQ(stack.step(wobble<double>(0, 4), bad_reference()).u, idle);
  EXPECT_TRUE(stack.last().status.has(Flag::input_held));
  EXPECT_EQ(stack.step(spoilt(1), {}).u, idle) << "nothing measured since the first valid reference";
  EXPECT_NE(stack.step(wobble<double>(2, 4), {}).u, idle);
  EXPECT_EQ(other.step(spoilt(0), {}).u, idle);
  EXPECT_NE(other.step(wobble<double>(1, 4), bad_reference()).u, idle) << "the reference of before is held";
}

TEST(Stack, ResetForgetsTheCommandThatRateLimitsCountFrom) {
  auto fresh = flown(slow()), used = fresh;
  for (Tick k = 0; k < 60; ++k) used.step(wobble<double>(k, 4), {});
  ASSERT_GT(used.last().u.cwiseAbs().maxCoeff(), 0.05);
  used.reset();
  for (Tick k = 0; k < 5; ++k) {
    fresh.step(wobble<double>(k, 4), {});
    used.step(wobble<double>(k, 4), {});
    EXPECT_EQ(used.last().u, fresh.last().u) << k;
    EXPECT_LE(used.last().u.cwiseAbs().maxCoeff(), 2e-3 * static_cast<double>(k + 1) * (1 + 1e-15));
  }
}

TEST(Stack, StartsItsAllocatorAnewWhateverItDidBefore) {
  auto fresh = flown(slow()), used = fresh;
  Demand<double> demand;
  demand.tau_B = {0.1, 0.1, 0.1};
  const Estimate<double> x = Estimate<double>::healthy(wobble<double>(0, 4));
  for (int k = 0; k < 50; ++k)
    (void)used.allocator.step(slow().vehicle, demand, x, Detection<double>::none(slow().vehicle));
  EXPECT_EQ(used.step(wobble<double>(0, 4), {}).u, fresh.step(wobble<double>(0, 4), {}).u);
}

TEST(Stack, ResetForgetsTheInputsThatItHeld) {
  auto stack = flown();
  for (Tick k = 0; k < 20; ++k) stack.step(wobble<double>(k, 4), {});
  stack.reset();
  EXPECT_EQ(stack.step(spoilt(20), {}).u, VecN<double>::Zero(4)) << "no measurement to hold";
  stack.reset();
  EXPECT_EQ(stack.step(wobble<double>(20, 4), bad_reference()).u, VecN<double>::Zero(4)) << "no reference to hold";
}

TEST(Stack, IsIdleInsideLimitsThatDoNotHoldZero) {
  gyrostat::Setup<double> setup = ftc_4rw<double>();
  setup.vehicle.u_lo << 0.05, -0.2, -0.2, -0.2;
  setup.vehicle.u_up << 0.2, 0.2, -0.1, 0.2;
  auto stack = flown(setup);
  VecN<double> nearest(4);
  nearest << 0.05, 0, -0.1, 0;
  EXPECT_EQ(stack.last().u, nearest);
  EXPECT_EQ(stack.step(spoilt(0), {}).u, nearest);
  for (Tick k = 1; k < 5; ++k) stack.step(wobble<double>(k, 4), {});
  stack.reset();
  EXPECT_EQ(stack.last().u, nearest);
}

// ---- what is refused before it flies -----------------------------------------------------------------------------

TEST(StackCheck, AsksEveryComponentAndWhetherObserverAndAllocatorFitEachOther) {
  using Stack = FlightStack<IterativeLearningObserver<double>, ThresholdDetector<double>, OpenLoop<double>,
                            PseudoInverse<double>>;
  static_assert(!std::is_constructible_v<Stack, const gyrostat::Setup<double>&, const Stack::Params&>);
  static_assert(!std::is_constructible_v<Stack, const gyrostat::Setup<double>&, IterativeLearningObserver<double>,
                                         ThresholdDetector<double>, OpenLoop<double>, PseudoInverse<double>>);
  const gyrostat::Setup<double> setup = ftc_4rw<double>();
  EXPECT_TRUE(Checked<Stack>(setup));
  const auto refused = [&](auto&& change) {
    Stack::Params p(setup);
    change(p);
    const Checked<Stack> stack(setup, p);
    EXPECT_FALSE(stack);
    return stack.status();
  };
  const Status<double> lost = refused([](Stack::Params& p) { p.observer.e_min = 0.04; });
  EXPECT_EQ(lost.code, Status<double>::Code::unstable) << "an actuator at 4 % would never be commanded again";
  EXPECT_EQ(lost.value, 0.04);
  EXPECT_EQ(lost.limit, 0.05);
  EXPECT_EQ(refused([](Stack::Params& p) { p.observer.k1 = 1e9; }).code, Status<double>::Code::unstable);
  EXPECT_EQ(std::string(refused([](Stack::Params& p) { p.detector.settle = 1e3; }).quantity), "settle");
  EXPECT_EQ(refused([](Stack::Params& p) { p.controller.command.resize(3); }).value, 3);
  Stack::Params both(setup);
  both.observer.e_min = both.allocator.e_min = 0.04;
  EXPECT_TRUE(Checked<Stack>(setup, both));
}

// ---- the second failure in a row ----------------------------------------------------------------------------------

/// From one sample on neither start nor step give anything of use.
struct LostController : MrpFeedback<double> {
  using MrpFeedback::MrpFeedback;
  Demand<double> start(const Vehicle<double>& vehicle, const Estimate<double>& x, const Detection<double>& det,
                       const Reference<double>& ref) noexcept {
    return broken(MrpFeedback::start(vehicle, x, det, ref), x.tick);
  }
  Demand<double> step(const Vehicle<double>& vehicle, const Estimate<double>& x, const Detection<double>& det,
                      const Reference<double>& ref, const Allocation<double>& last) noexcept {
    return broken(MrpFeedback::step(vehicle, x, det, ref, last), x.tick);
  }
  static Demand<double> broken(Demand<double> demand, Tick tick) noexcept {
    if (tick >= trouble) demand.tau_B[1] = nan;
    if (tick >= trouble) demand.u_pref = VecN<double>::Constant(4, 0.1);
    return demand;
  }
};

/// Passes on what `change` makes of every estimate.
template <auto change>
struct ChangedObserver : PassthroughObserver<double> {
  using PassthroughObserver::PassthroughObserver;
  Estimate<double> start(const Vehicle<double>& vehicle, const Measurement<double>& y) noexcept {
    return change(PassthroughObserver::start(vehicle, y));
  }
  Estimate<double> step(const Vehicle<double>& vehicle, const Measurement<double>& y,
                        const Allocation<double>& last) noexcept {
    return change(PassthroughObserver::step(vehicle, y, last));
  }
};

using LostObserver = ChangedObserver<[](Estimate<double> x) noexcept {
  if (x.tick >= trouble) x.effectiveness[2] = nan;
  return x;
}>;

struct LostDetector : NoDetector<double> {
  using NoDetector::NoDetector;
  Detection<double> start(const Vehicle<double>& vehicle, const Estimate<double>& x) noexcept {
    return broken(NoDetector::start(vehicle, x), x.tick);
  }
  Detection<double> step(const Vehicle<double>& vehicle, const Estimate<double>& x,
                         const Allocation<double>& last) noexcept {
    return broken(NoDetector::step(vehicle, x, last), x.tick);
  }
  static Detection<double> broken(Detection<double> det, Tick tick) noexcept {
    if (tick < trouble) return det;
    det.failed = Mask::all(4);
    det.u_probe = VecN<double>::Constant(4, infinity);
    return det;
  }
};

/// Steps until after the trouble; every sample of it must hold the command from before, and say so.
void expect_held_from_trouble_on(AnyStack<double>& stack) {
  for (Tick k = 0; k < trouble; ++k) stack.step(wobble<double>(k, 4), {});
  const VecN<double> previous = stack.last().u;
  EXPECT_FALSE(stack.last().status.has(Flag::component_reset));
  for (Tick k = trouble; k < trouble + 4; ++k) {
    stack.step(wobble<double>(k, 4), {});
    EXPECT_EQ(stack.last().u, previous) << k;
    EXPECT_TRUE(stack.last().status.has(Flag::component_reset)) << k;
    EXPECT_TRUE(stack.last().status.has(Flag::command_held)) << k;
  }
}

TEST(StackFailsTwice, AControllerLeavesNoDemand) {
  auto stack = flown<PassthroughObserver<double>, NoDetector<double>, LostController>();
  expect_held_from_trouble_on(stack);
  EXPECT_EQ(stack.demand().tau_B, Vec3<double>(Vec3<double>::Zero()));
  EXPECT_EQ(stack.last().demand_B, Vec3<double>(Vec3<double>::Zero()));
  EXPECT_TRUE(stack.demand().u_pref.isZero(0));
}

TEST(StackFailsTwice, AnObserverLeavesTheMeasuredStateAndHealthyActuators) {
  auto stack = flown<LostObserver>();
  expect_held_from_trouble_on(stack);
  EXPECT_EQ(stack.estimate().effectiveness, VecN<double>::Ones(4));
  EXPECT_EQ(stack.estimate().omega_BN_B, wobble<double>(trouble + 3, 4).omega_BN_B);
}

TEST(StackFailsTwice, ADetectorLeavesNothingDetected) {
  auto stack = flown<PassthroughObserver<double>, LostDetector>();
  expect_held_from_trouble_on(stack);
  EXPECT_FALSE(stack.detection().failed.any());
  EXPECT_EQ(stack.detection().enabled, Mask::all(4));
  EXPECT_EQ(stack.detection().u_probe.size(), 0);
}

TEST(StackFailsAtStart, AnObserverAndADetectorLeaveTheMeasuredState) {
  auto observer = flown<LostObserver>();
  observer.step(wobble<double>(trouble, 4), {});
  EXPECT_EQ(observer.estimate().effectiveness, VecN<double>::Ones(4));
  EXPECT_TRUE(observer.last().status.has(Flag::component_reset));
  EXPECT_EQ(observer.last().u, VecN<double>::Zero(4)) << "held: there was no command yet";
  auto detector = flown<PassthroughObserver<double>, LostDetector>();
  detector.step(wobble<double>(trouble, 4), {});
  EXPECT_FALSE(detector.detection().failed.any());
  EXPECT_TRUE(detector.last().u.allFinite());
  EXPECT_EQ(detector.last().u, flown().step(wobble<double>(trouble, 4), {}).u);
}

// ---- what is told of a command that was held or clipped ----------------------------------------------------------

/// Knows that wheel 1 gives half, and flags what it is asked to.
using KnowingObserver = ChangedObserver<[](Estimate<double> x) noexcept {
  x.effectiveness[1] = 0.5;
  if (x.tick == 3) x.status.set(Flag::singular);
  return x;
}>;

/// A command that is not finite at one sample, far outside of every limit around it, of either sign.
struct WildAllocator : PseudoInverse<double> {
  using PseudoInverse::PseudoInverse;
  Allocation<double> step(const Vehicle<double>& vehicle, const Demand<double>& demand, const Estimate<double>& x,
                          const Detection<double>& det) noexcept {
    Allocation<double> out = PseudoInverse::step(vehicle, demand, x, det);
    if (x.tick == trouble) out.achieved_B[2] = nan;
    if (x.tick > trouble) out.u << 7, -7, 7, -7;
    return out;
  }
};

TEST(StackTells, WhatAnObserverReports) {
  auto stack = flown<KnowingObserver>();
  for (Tick k = 0; k < 6; ++k) EXPECT_EQ(stack.step(wobble<double>(k, 4), {}).status.has(Flag::singular), k == 3) << k;
}

TEST(StackTells, OfAHeldCommandTheDemandOfThisSampleAndTheTorqueOfTheWeakActuators) {
  auto stack = flown<KnowingObserver, NoDetector<double>, MrpFeedback<double>, WildAllocator>();
  for (Tick k = 0; k < trouble; ++k) stack.step(wobble<double>(k, 4), {});
  const VecN<double> previous = stack.last().u;
  const Allocation<double>& held = stack.step(wobble<double>(trouble, 4), {});
  EXPECT_EQ(held.u, previous);
  EXPECT_EQ(held.demand_B, stack.demand().tau_B);
  VecN<double> delivered = previous;
  delivered[1] *= 0.5;
  EXPECT_LT((held.achieved_B - torque<double>(ftc_4rw<double>().vehicle.D_B, delivered)).norm(), 1e-16);
}

TEST(StackTells, OfAClippedCommandItsTorqueAndWhichActuatorsEachWay) {
  const gyrostat::Setup<double> setup = slow();
  auto stack = flown<KnowingObserver, NoDetector<double>, MrpFeedback<double>, WildAllocator>(setup);
  for (Tick k = 0; k <= trouble; ++k) stack.step(wobble<double>(k, 4), {});
  VecN<double> expected = stack.last().u;
  for (Tick k = trouble + 1; k < trouble + 150; ++k) {
    for (int i = 0; i < 4; ++i) expected[i] = std::clamp(expected[i] + (i % 2 == 0 ? 2e-3 : -2e-3), -0.2, 0.2);
    const Allocation<double>& out = stack.step(wobble<double>(k, 4), {});
    ASSERT_LT((out.u - expected).cwiseAbs().maxCoeff(), 1e-15) << k;
    expected = out.u;
    EXPECT_EQ(out.saturated, Mask::all(4));
    VecN<double> delivered = out.u;
    delivered[1] *= 0.5;
    EXPECT_LT((out.achieved_B - torque<double>(setup.vehicle.D_B, delivered)).norm(), 1e-15);
  }
  EXPECT_EQ(expected.cwiseAbs(), VecN<double>::Constant(4, 0.2));
}

// ---- what is looked at -------------------------------------------------------------------------------------------

TEST(GuardLooksAt, EveryNumberOfEverySignal) {
  const gyrostat::Guard<double> guard(ftc_4rw<double>());
  const Measurement<double> y = wobble<double>(0, 4);
  for (const double bad : {nan, infinity, -infinity}) {
    const auto expect = [&](auto good, auto... numbers) {
      EXPECT_TRUE(guard.possible(good));
      (..., [&] {
        auto spoilt_signal = good;
        numbers(spoilt_signal) = bad;
        EXPECT_FALSE(guard.possible(spoilt_signal)) << "of " << sizeof...(numbers) << " numbers, " << bad;
      }());
    };
    expect(
        Reference<double>{}, [](auto& r) -> double& { return r.q_NR.w(); },
        [](auto& r) -> double& { return r.omega_RN_R[0]; }, [](auto& r) -> double& { return r.omegadot_RN_R[1]; });
    expect(
        Estimate<double>::healthy(y), [](auto& x) -> double& { return x.q_NB.y(); },
        [](auto& x) -> double& { return x.omega_BN_B[1]; }, [](auto& x) -> double& { return x.h_w[0]; },
        [](auto& x) -> double& { return x.effectiveness[3]; }, [](auto& x) -> double& { return x.d_B[2]; });
    Detection<double> det;
    det.u_probe = VecN<double>::Zero(4);
    expect(det, [](auto& d) -> double& { return d.u_probe[3]; });
    Demand<double> demand;
    demand.u_pref = VecN<double>::Zero(4);
    expect(demand, [](auto& d) -> double& { return d.tau_B[1]; }, [](auto& d) -> double& { return d.u_pref[2]; });
    expect(
        Allocation<double>::idle(4), [](auto& a) -> double& { return a.u[1]; },
        [](auto& a) -> double& { return a.achieved_B[0]; });
  }
  Estimate<double> x = Estimate<double>::healthy(y);
  x.effectiveness_bound[2] = infinity;
  EXPECT_TRUE(guard.possible(x)) << "never excited";
  x.effectiveness_bound[2] = nan;
  EXPECT_FALSE(guard.possible(x));
}

}  // namespace
}  // namespace gyrostat::test::test_stack
