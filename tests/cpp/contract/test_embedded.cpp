// SPDX-License-Identifier: MIT
// Flight code on an embedded target: compiled without exceptions and RTTI, for float and double, and not one allocation in a
// thousand samples. Eigen allocates past operator new, so it is asked to assert that it does not.
#include <atomic>
#include <cstdlib>
#include <new>

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

#include "every_component.hpp"

namespace gyrostat::test {
namespace {

#ifdef __cpp_exceptions
#error "this test is meant to be compiled with -fno-exceptions"
#endif
#ifdef __cpp_rtti
#error "this test is meant to be compiled with -fno-rtti"
#endif

template <class S>
class Embedded : public testing::Test {};
using Scalars = testing::Types<float, double>;
TYPED_TEST_SUITE(Embedded, Scalars);

TYPED_TEST(Embedded, NoAllocationFromConstructionOn) {
  using S = TypeParam;
  const gyrostat::Setup<S> setup = ftc_4rw<S>();
  const long before = allocations, failed = eigen_failures;
  Eigen::internal::set_is_malloc_allowed(false);
  int stacks = 0;
  bool finite = true;
  for_every_component<S>(setup, [&](auto stack) {
    static_assert(decltype(stack)::cannot_throw);
    static_assert(noexcept(stack.step(std::declval<const Measurement<S>&>(), std::declval<const Reference<S>&>())));
    for (Tick k = 0; k < 1000; ++k) finite = finite && stack.step(wobble<S>(k, 4), {}).u.allFinite();
    stack.reset();
    stack.step(wobble<S>(0, 4), {});
    ++stacks;
  });
  Eigen::internal::set_is_malloc_allowed(true);
  EXPECT_EQ(allocations - before, 0);
  EXPECT_EQ(eigen_failures - failed, 0);
  EXPECT_EQ(stacks, 13);
  EXPECT_TRUE(finite);
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
  for_every_component<S>(setup, [&](auto stack) {
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
  for_every_component<S>(ftc_4rw<S>(), [](auto stack) {
    stack.step(wobble<S>(0, 4), {});
    const long before = allocations;
    long values = 0;
    stack.controller.telemetry([&values](auto, const auto&) { ++values; });
    stack.allocator.telemetry([&values](auto, const auto&) { ++values; });
    EXPECT_EQ(allocations - before, 0);
    EXPECT_GT(values, 0);
  });
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

TEST(Signals, StaySmall) {
  EXPECT_LE(sizeof(Estimate<double>), 640u);
  EXPECT_LE(sizeof(Allocation<double>), 384u);
}

}  // namespace
}  // namespace gyrostat::test
