// SPDX-License-Identifier: MIT
// Flight code on an embedded target: compiled without exceptions and RTTI, and not one allocation in a thousand samples.
// GYROSTAT_TEST_SCALAR is float or double, a file each. Components are compiled in any_estimation.cpp and any_actuation.cpp.
#pragma once
#include "contract/counted_eigen.hpp"  // first

#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <string_view>

#include "any_components.hpp"

namespace gyrostat::test {
namespace {

void for_every_stack(const auto& setup, auto&& with) { for_every_component(setup, {}, with); }

/// The stacks as a user writes them: none of them can throw.
template <class S, std::size_t... i>
constexpr bool no_stack_can_throw(std::index_sequence<i...>) {
  return (FlightStack<Observers::at<S, i>, Detectors::at<S, i>, Controllers::at<S, i>, Allocators::at<S, i>,
                      Navigators::at<S, i>>::cannot_throw &&
          ...);
}
static_assert(no_stack_can_throw<GYROSTAT_TEST_SCALAR>(std::make_index_sequence<Controllers::count>{}));

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
  for_every_stack(setup, [&](AnyStack<S> stack) {
    for (Tick k = 0; k < 1000; ++k) finite = finite && stack.step(wobble<S>(k, 4)).u.allFinite();
    stack.reset();
    stack.step(wobble<S>(0, 4));
    ++stacks;
  });
  Eigen::internal::set_is_malloc_allowed(true);
  EXPECT_EQ(allocations - before, 0);
  EXPECT_EQ(eigen_failures - failed, 0);
  EXPECT_EQ(stacks, static_cast<int>(Controllers::count)) << "the longest list";
  EXPECT_TRUE(finite);
}

/// A stack of components behind an interface is the stack of the components themselves, and these fly it without the heap.
TYPED_TEST(Embedded, StacksAreWhatTheyAreOfComponentsByType) {
  using S = TypeParam;
  using Stack = FlightStack<PassthroughObserver<S>, NoDetector<S>, MrpFeedback<S>, PseudoInverse<S>>;
  const gyrostat::Setup<S> setup = ftc_4rw<S>();
  const long before = allocations, failed = eigen_failures;
  Eigen::internal::set_is_malloc_allowed(false);
  auto stack = by_default<Stack>(setup);
  auto any = stack_of<PassthroughObserver<S>, NoDetector<S>, MrpFeedback<S>, PseudoInverse<S>>(setup);
  static_assert(noexcept(stack.step(std::declval<const Measurement<S>&>(), std::declval<const Reference<S>&>())));
  bool same = true;
  for (Tick k = 0; k < 1000; ++k) {
    Measurement<S> y = wobble<S>(k, 4);
    if (k % 7 == 1) y.omega_BN_B[0] = std::numeric_limits<S>::quiet_NaN();
    same = same && stack.step(y, {}).u == any.step(y).u && stack.last().status == any.last().status;
  }
  Eigen::internal::set_is_malloc_allowed(true);
  EXPECT_EQ(allocations - before, 0);
  EXPECT_EQ(eigen_failures - failed, 0);
  EXPECT_TRUE(same);
}

/// A simple stack behind a navigator.
template <class S>
AnyStack<S, AnyNavigator<S>> behind(Maker<NavigatorRole<S>> navigator, const gyrostat::Setup<S>& setup) {
  const std::array observer{Making<PassthroughObserver<S>>::maker()};
  const std::array detector{Making<NoDetector<S>>::maker()};
  const std::array controller{Making<MrpFeedback<S>>::maker()};
  const std::array allocator{Making<PseudoInverse<S>>::maker()};
  return Parts<S>{observer, detector, controller, allocator}.stack(0, setup, setup,
                                                                   AnyNavigator<S>(navigator, setup, setup));
}

/// Navigators see what others do not: samples of which nothing is valid.
TYPED_TEST(Embedded, NavigatorsAllocateNothingAndBearWhatComes) {
  using S = TypeParam;
  const gyrostat::Setup<S> setup = ftc_4rw<S>();
  const S nan = std::numeric_limits<S>::quiet_NaN();
  int stacks = 0;
  for (const auto& navigator : makers<NavigatorRole<S>>()) {
    auto stack = behind<S>(navigator, setup);
    const long before = allocations, failed = eigen_failures;
    Eigen::internal::set_is_malloc_allowed(false);
    bool finite = true;
    for (Tick k = 0; k < 1000; ++k) {
      Measurement<S> y = wobble<S>(k, 4);
      if (k % 7 == 1) y.q_NB.coeffs().setConstant(nan);
      if (k % 11 == 1) y.omega_BN_B[0] = nan;
      if (k % 300 > 280) y.attitude_valid = y.rate_valid = y.momentum_valid = false;
      if (k % 90 == 50) y.q_NB = Quat<S>(0, 0, 1, 0);
      finite = finite && stack.step(y).u.allFinite();
    }
    stack.reset();
    stack.step(wobble<S>(0, 4));
    Eigen::internal::set_is_malloc_allowed(true);
    EXPECT_EQ(allocations - before, 0);
    EXPECT_EQ(eigen_failures - failed, 0);
    EXPECT_TRUE(finite);
    ++stacks;
  }
  EXPECT_EQ(stacks, static_cast<int>(Navigators::count));
}

/// The attitude filter on sun and field alone: started, blinded, deceived, started again.
TYPED_TEST(Embedded, DirectionsAllocateNothingAndBearWhatComes) {
  using S = TypeParam;
  const gyrostat::Setup<S> setup = ftc_4rw<S>();
  const S nan = std::numeric_limits<S>::quiet_NaN();
  for (const auto how : {Mekf<S>::Acquisition::quest, Mekf<S>::Acquisition::triad}) {
    typename Mekf<S>::Params p(setup);
    p.sun_noise = S(1e-3);
    p.field_noise = S(1e-7);
    p.latency = 3;
    p.acquisition = how;
    auto stack = behind<S>(Making<Mekf<S>>::maker(), setup);
    stack.navigation.navigator.template as<Mekf<S>>() = Mekf<S>(unchecked, setup, p);
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
      finite = finite && stack.step(y).u.allFinite();
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
  for_every_stack(setup, [&](AnyStack<S> stack) {
    Tick k = 0;
    const auto inside = [&](const Measurement<S>& y, const Reference<S>& ref) {
      const VecN<S>& u = stack.step(y, ref).u;
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
  for_every_stack(ftc_4rw<S>(), [](AnyStack<S> stack) {
    stack.step(wobble<S>(0, 4));
    const long before = allocations;
    const long values = stack.estimator.observer.telemetry_values() + stack.estimator.detector.telemetry_values() +
                        stack.controller.telemetry_values() + stack.allocator.telemetry_values();
    EXPECT_EQ(allocations - before, 0);
    EXPECT_GT(values, 0);
  });
}

TYPED_TEST(Embedded, AResetIsAsConstructed) {
  using S = TypeParam;
  for_every_stack(ftc_4rw<S>(), [](AnyStack<S> stack) {
    auto used = stack;
    for (Tick k = 0; k < 20; ++k) used.step(wobble<S>(k, 4));
    used.reset();
    for (Tick k = 0; k < 5; ++k) EXPECT_EQ(used.step(wobble<S>(k, 4)).u, stack.step(wobble<S>(k, 4)).u);
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
