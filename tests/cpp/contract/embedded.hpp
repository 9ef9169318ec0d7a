// SPDX-License-Identifier: MIT
// Flight code on an embedded target: compiled without exceptions and RTTI, and not one allocation in a thousand samples. Eigen
// allocates past operator new, so it is asked to assert that it does not. GYROSTAT_TEST_SCALAR is float or double, a file each:
// they take long to compile.
#pragma once
#include <algorithm>
#include <atomic>
#include <cstdlib>
#include <cstring>
#include <new>
#include <string_view>

namespace {
std::atomic<long> allocations{0};
std::atomic<long> eigen_failures{0};
}  // namespace

#define EIGEN_RUNTIME_NO_MALLOC
#define eigen_assert(condition)         \
  do {                                  \
    if (!(condition)) ++eigen_failures; \
  } while (false)

void* operator new(std::size_t size) {
  ++allocations;
  if (void* p = std::malloc(size)) return p;
  std::abort();
}
void operator delete(void* p) noexcept { std::free(p); }
void operator delete(void* p, std::size_t) noexcept { std::free(p); }

#include <gtest/gtest.h>

#include <Eigen/Dense>

#include "gyrostat/flight/allocators.hpp"
#include "gyrostat/flight/navigators.hpp"
#include "stacks.hpp"

namespace gyrostat::test {
namespace {

#ifdef __cpp_exceptions
#error "this test is meant to be compiled with -fno-exceptions"
#endif
#ifdef __cpp_rtti
#error "this test is meant to be compiled with -fno-rtti"
#endif

template <class S>
void for_every_stack(const gyrostat::Setup<S>& setup, auto&& with) {
  for_every_component<S, Observers, Detectors, Controllers, Allocators>(setup, with);
}

/// Out of line, so that each stack is compiled once.
template <class Stack, class S = typename Stack::Scalar>
[[gnu::noinline]] const Allocation<S>& step(Stack& stack, const Measurement<S>& y, const Reference<S>& ref = {}) {
  return stack.step(y, ref);
}

template <class S>
class Embedded : public testing::Test {};
using Scalars = testing::Types<GYROSTAT_TEST_SCALAR>;
TYPED_TEST_SUITE(Embedded, Scalars);

TYPED_TEST(Embedded, NoAllocationFromConstructionOn) {
  using S = TypeParam;
  const gyrostat::Setup<S> setup = ftc_4rw<S>();
  const long before = allocations, failed = eigen_failures;
  Eigen::internal::set_is_malloc_allowed(false);
  int stacks = 0;
  bool finite = true;
  for_every_stack<S>(setup, [&](auto stack) {
    static_assert(decltype(stack)::cannot_throw);
    static_assert(noexcept(stack.step(std::declval<const Measurement<S>&>(), std::declval<const Reference<S>&>())));
    for (Tick k = 0; k < 1000; ++k) finite = finite && step(stack, wobble<S>(k, 4)).u.allFinite();
    stack.reset();
    step(stack, wobble<S>(0, 4));
    ++stacks;
  });
  Eigen::internal::set_is_malloc_allowed(true);
  EXPECT_EQ(allocations - before, 0);
  EXPECT_EQ(eigen_failures - failed, 0);
  EXPECT_EQ(stacks, static_cast<int>(Controllers::count)) << "the longest list";
  EXPECT_TRUE(finite);
}

/// Navigators see what others do not: samples of which nothing is valid.
TYPED_TEST(Embedded, NavigatorsAllocateNothingAndBearWhatComes) {
  using S = TypeParam;
  const gyrostat::Setup<S> setup = ftc_4rw<S>();
  const S nan = std::numeric_limits<S>::quiet_NaN();
  int stacks = 0;
  for_every_component<S, Components<PassthroughObserver>, Components<NoDetector>, Components<MrpFeedback>,
                      Components<PseudoInverse>, Navigators>(setup, [&](auto stack) {
    static_assert(decltype(stack)::cannot_throw);
    const long before = allocations, failed = eigen_failures;
    Eigen::internal::set_is_malloc_allowed(false);
    bool finite = true;
    for (Tick k = 0; k < 1000; ++k) {
      Measurement<S> y = wobble<S>(k, 4);
      if (k % 7 == 1) y.q_NB.coeffs().setConstant(nan);
      if (k % 11 == 1) y.omega_BN_B[0] = nan;
      if (k % 300 > 280) y.attitude_valid = y.rate_valid = y.momentum_valid = false;
      if (k % 90 == 50) y.q_NB = Quat<S>(0, 0, 1, 0);
      finite = finite && step(stack, y).u.allFinite();
    }
    stack.reset();
    step(stack, wobble<S>(0, 4));
    Eigen::internal::set_is_malloc_allowed(true);
    EXPECT_EQ(allocations - before, 0);
    EXPECT_EQ(eigen_failures - failed, 0);
    EXPECT_TRUE(finite);
    ++stacks;
  });
  EXPECT_EQ(stacks, static_cast<int>(Navigators::count));
}

/// The attitude filter on sun and field alone: started, blinded, deceived, started again.
TYPED_TEST(Embedded, DirectionsAllocateNothingAndBearWhatComes) {
  using S = TypeParam;
  using Stack = FlightStack<PassthroughObserver<S>, NoDetector<S>, MrpFeedback<S>, PseudoInverse<S>, Mekf<S>>;
  const gyrostat::Setup<S> setup = ftc_4rw<S>();
  const S nan = std::numeric_limits<S>::quiet_NaN();
  for (const auto how : {Mekf<S>::Acquisition::quest, Mekf<S>::Acquisition::triad}) {
    typename Stack::Params p(setup);
    p.navigator.sun_noise = S(1e-3);
    p.navigator.field_noise = S(1e-7);
    p.navigator.latency = 3;
    p.navigator.acquisition = how;
    Stack stack(unchecked, setup, p);
    const long before = allocations, failed = eigen_failures;
    Eigen::internal::set_is_malloc_allowed(false);
    bool finite = true;
    for (Tick k = 0; k < 1000; ++k) {
      Measurement<S> y = wobble<S>(k, 4);
      y.sun_N = {S(0.6), S(0.8), S(0)};
      y.field_N = {S(0), S(1e-5), S(2e-5)};
      y.sun_B = y.q_NB.conjugate() * y.sun_N;
      y.field_B = y.q_NB.conjugate() * y.field_N;
      y.sun_valid = k % 50 > 5;
      y.field_valid = k % 70 > 5;
      y.attitude_valid = false;
      if (k % 7 == 1) y.sun_B[0] = nan;
      if (k % 11 == 1) y.field_N.setZero();
      if (k % 13 == 1) y.field_B.setConstant(S(1));
      if (k % 300 > 250) y.sun_B = -y.sun_B;
      finite = finite && step(stack, y).u.allFinite();
    }
    Eigen::internal::set_is_malloc_allowed(true);
    EXPECT_EQ(allocations - before, 0);
    EXPECT_EQ(eigen_failures - failed, 0);
    EXPECT_TRUE(finite);
    EXPECT_TRUE(stack.started());
  }
}

/// NaN, infinite, huge, tiny and zero numbers in every field: the command stays finite and inside its limits, and the flags
/// of a spoilt input are gone with the first sane ones.
TYPED_TEST(Embedded, CommandsStayInsideTheirLimitsWhateverComesIn) {
  using S = TypeParam;
  using Limits = std::numeric_limits<S>;
  const S spoils[] = {Limits::quiet_NaN(),
                      Limits::infinity(),
                      -Limits::infinity(),
                      Limits::max(),
                      -Limits::max(),
                      Limits::min(),
                      Limits::denorm_min(),
                      S(0),
                      S(1e6)};
  const gyrostat::Setup<S> setup = ftc_4rw<S>();
  // Four equal numbers of any size here are no quaternion; a rate or momentum of 1e6 is beyond any motion of this vehicle.
  const auto impossible = [](int field, S spoil) { return field == 1 || field == 5 || !(std::abs(spoil) < S(1e6)); };
  int stacks = 0;
  for_every_stack<S>(setup, [&](auto stack) {
    Tick k = 0;
    const auto inside = [&](const Measurement<S>& y, const Reference<S>& ref) {
      const VecN<S>& u = step(stack, y, ref).u;
      return u.allFinite() && (u.array() >= setup.vehicle.u_lo.array()).all() &&
             (u.array() <= setup.vehicle.u_up.array()).all();
    };
    for (const S spoil : spoils) {
      for (int field = 0; field < 6; ++field) {
        Measurement<S> y = wobble<S>(++k, 4);
        Reference<S> ref;
        if (field == 0) y.omega_BN_B[1] = spoil;
        if (field == 1) y.q_NB.coeffs().setConstant(spoil);
        if (field == 2) y.h_w[3] = spoil;
        if (field == 3) ref.omega_RN_R[0] = spoil;
        if (field == 4) ref.omegadot_RN_R[2] = spoil;
        if (field == 5) ref.q_NR.coeffs().setConstant(spoil);
        EXPECT_TRUE(inside(y, ref)) << "field " << field << " = " << spoil;
        EXPECT_EQ(stack.last().status.has(Flag::input_held), impossible(field, spoil)) << field << ", " << spoil;
        // A number that is huge and finite goes in; what it left behind is restarted within three samples, and stays so.
        int calm = 0;
        for (int n = 0; n < 6 && calm < 3; ++n) {
          EXPECT_TRUE(inside(wobble<S>(++k, 4), {})) << "after field " << field << " = " << spoil;
          EXPECT_FALSE(stack.last().status.has(Flag::input_held));
          calm = stack.last().status.has(Flag::component_reset) ? 0 : calm + 1;
        }
        EXPECT_EQ(calm, 3) << "after field " << field << " = " << spoil << ", stack " << stacks;
      }
    }
    ++stacks;
  });
}

TYPED_TEST(Embedded, TelemetryAllocatesNothingEither) {
  using S = TypeParam;
  for_every_stack<S>(ftc_4rw<S>(), [](auto stack) {
    step(stack, wobble<S>(0, 4));
    const long before = allocations;
    long values = 0;
    stack.estimator.observer.telemetry([&values](auto, const auto&) { ++values; });
    stack.estimator.detector.telemetry([&values](auto, const auto&) { ++values; });
    stack.controller.telemetry([&values](auto, const auto&) { ++values; });
    stack.allocator.telemetry([&values](auto, const auto&) { ++values; });
    EXPECT_EQ(allocations - before, 0);
    EXPECT_GT(values, 0);
  });
}

TYPED_TEST(Embedded, AResetIsAsConstructed) {
  using S = TypeParam;
  for_every_stack<S>(ftc_4rw<S>(), [](auto stack) {
    auto used = stack;
    for (Tick k = 0; k < 20; ++k) step(used, wobble<S>(k, 4));
    used.reset();
    for (Tick k = 0; k < 5; ++k) EXPECT_EQ(step(used, wobble<S>(k, 4)).u, step(stack, wobble<S>(k, 4)).u);
  });
}

// ---- the parameters ------------------------------------------------------------------------------------------------

/// Whether every number is inside the range of its Field: none was forgotten by the constructor.
struct InRange {
  const char* component;
  void operator()(const auto& member, const Field& f) const {
    if constexpr (requires { member.allFinite(); }) {
      for (Eigen::Index i = 0; i < member.size(); ++i) (*this)(member.data()[i], f);
    } else if constexpr (std::is_arithmetic_v<std::remove_cvref_t<decltype(member)>>) {
      EXPECT_TRUE(member >= f.lo && member <= f.hi) << component << "." << f.name << " = " << double(member);
    }
  }
  void operator()(const auto& member, const Choice& c) const {
    const std::string_view options = c.options;
    EXPECT_LE(static_cast<std::ptrdiff_t>(member), std::count(options.begin(), options.end(), '|')) << component;
  }
  void operator()(const bool&, const Switch&) const {}
};

/// Made in memory that holds no number, so that one that is left out shows; the barriers keep the compiler from knowing better.
TYPED_TEST(Embedded, EveryParameterHasADefaultInsideItsRange) {
  using S = TypeParam;
  const auto look = []<class T>() {
    using Params = typename T::Params;
    alignas(Params) static unsigned char memory[sizeof(Params)];
    std::memset(memory, 0xFF, sizeof memory);
    asm volatile("" : : "r"(memory) : "memory");
    const Params* p = new (memory) Params(ftc_4rw<S>());
    asm volatile("" : : "r"(memory) : "memory");
    Params::describe(*p, InRange{T::name});
  };
  Observers::each<S>(look);
  Detectors::each<S>(look);
  Controllers::each<S>(look);
  Allocators::each<S>(look);
}

TEST(EmbeddedCounters, NoticeAnAllocation) {  // the test above can fail
  const long before = allocations, failed = eigen_failures;
  int* volatile heap_int = new int(3);  // volatile: the compiler may drop an unused allocation
  delete heap_int;
  Eigen::internal::set_is_malloc_allowed(false);
  {
    const Eigen::MatrixXd heap = Eigen::MatrixXd::Zero(20, 20);
  }
  Eigen::internal::set_is_malloc_allowed(true);
  EXPECT_EQ(allocations - before, 1);
  EXPECT_GT(eigen_failures - failed, 0);
}

}  // namespace
}  // namespace gyrostat::test
